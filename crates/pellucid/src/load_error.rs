//! Why what a scene needs from elsewhere cannot be had.

use std::path::PathBuf;

use pellucid_field::{FieldError, closed_form, nearest};
use pellucid_io::IoError;
use pellucid_optics::OpticsError;

/// Why the volumes of a scene cannot be loaded.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LoadError {
    /// A file cannot be read.
    #[error(transparent)]
    Io(#[from] IoError),
    /// There is no built-in field of that name.
    #[error("volumes[{volume}].source.sample.name is '{found}'{}; the built-in fields are {known}", pointer(found))]
    UnknownSample {
        /// Position in the list of volumes.
        volume: usize,
        /// The name.
        found: String,
        /// The names there are.
        known: String,
    },
    /// A built-in field, or a model, cannot be sampled so.
    #[error("volumes[{volume}].source: {source}")]
    Sample {
        /// Position in the list of volumes.
        volume: usize,
        /// What is impossible.
        source: FieldError,
    },
    /// A built-in field, or a model, does not fit into memory at this resolution.
    #[error("volumes[{volume}].source: {bytes} bytes of voxels do not fit into memory: choose smaller dims")]
    Memory {
        /// Position in the list of volumes.
        volume: usize,
        /// Bytes needed.
        bytes: usize,
    },
    /// A file holds what optics cannot be made of.
    #[error("{}: {error}", path.display())]
    Optics {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        error: OpticsError,
    },
    /// A line of a file cannot be used.
    #[error("{}, line {line}: {problem}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong with it and what is expected.
        problem: String,
    },
    /// The scene expects a program to bring the voxels.
    #[error("volumes[{volume}].source is 'memory': only a program that holds the voxels can draw this scene")]
    Absent {
        /// Position in the list of volumes.
        volume: usize,
    },
}

/// The question after a name that no built-in field has.
fn pointer(found: &str) -> String {
    nearest(found, closed_form::names()).map_or_else(String::new, |name| format!(" (did you mean {name}?)"))
}
