//! Why a file cannot be read or written.

use std::io;
use std::path::{Path, PathBuf};

use pellucid_field::FieldError;
use pellucid_field::memory::OutOfMemory;

/// Why a file cannot be read or written. Every message is one line that names the file, the field
/// concerned, what was found and what was expected.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IoError {
    /// The operating system refused.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Its reason.
        source: io::Error,
    },
    /// A header field, or a part of the data, is not what the format allows.
    #[error("{}: field '{field}' is '{found}', expected {expected}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Name of the field in the format's own words.
        field: String,
        /// Its text or value.
        found: String,
        /// What is allowed.
        expected: String,
    },
    /// A field that the format requires is not there.
    #[error("{}: field '{field}' is missing, expected {expected}", path.display())]
    Missing {
        /// The file.
        path: PathBuf,
        /// Name of the field in the format's own words.
        field: &'static str,
        /// What it should hold.
        expected: &'static str,
    },
    /// The file is valid, or the volume is, but this combination is not supported.
    #[error("{}: {what} {found} is not supported: {advice}", path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// The feature.
        what: &'static str,
        /// Its value.
        found: String,
        /// What is supported, or what to do.
        advice: String,
    },
    /// There are fewer bytes than the header promises.
    #[error("{}: {what} has {found} bytes, expected {expected}", path.display())]
    Truncated {
        /// The file.
        path: PathBuf,
        /// The part that is too short.
        what: &'static str,
        /// Bytes there are. For compressed data that cannot possibly suffice, the most they could
        /// decompress to.
        found: u64,
        /// Bytes needed.
        expected: u64,
    },
    /// Compressed or text data that cannot be decoded.
    #[error("{}: the {encoding} data are damaged: {reason}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Name of the encoding.
        encoding: &'static str,
        /// What the decoder found.
        reason: String,
    },
    /// The values do not fit into memory.
    #[error("{}: {bytes} bytes of values do not fit into memory", path.display())]
    Memory {
        /// The file.
        path: PathBuf,
        /// Bytes asked for.
        bytes: u64,
    },
    /// The file would cost more than the reader may spend.
    #[error("{}: {found}{} exceed limits.{setting}, {allowed}", path.display(), counted(setting))]
    Limit {
        /// The file.
        path: PathBuf,
        /// The field of [`Limits`](crate::Limits) that stops it.
        setting: &'static str,
        /// Bytes or files that it takes.
        found: u64,
        /// The most there may be.
        allowed: u64,
    },
    /// A document names a file that it may not, see [`locate`](crate::locate).
    #[error("{} is outside of '{}', the folder of the file that names it", path.display(), folder.display())]
    Outside {
        /// The file that is named.
        path: PathBuf,
        /// The folder that it would have to be in.
        folder: PathBuf,
    },
    /// The file describes an impossible grid or volume.
    #[error("{}: {source}", path.display())]
    Field {
        /// The file.
        path: PathBuf,
        /// What is impossible.
        source: FieldError,
    },
    /// A picture's pixels do not match its size.
    #[error("{}: {found} values for a picture that needs {expected} ({width} x {height} x {channels})", path.display())]
    PictureSize {
        /// The file.
        path: PathBuf,
        /// Values found.
        found: usize,
        /// Values expected.
        expected: usize,
        /// Pixels per row.
        width: u32,
        /// Rows.
        height: u32,
        /// Values per pixel.
        channels: usize,
    },
}

impl IoError {
    pub(crate) fn io(path: &Path) -> impl FnOnce(io::Error) -> Self {
        move |source| Self::Io { path: path.to_owned(), source }
    }

    /// That there is not so much memory for a file.
    pub fn memory(path: &Path, refused: OutOfMemory) -> Self {
        Self::Memory { path: path.to_owned(), bytes: refused.bytes }
    }

    pub(crate) fn field(path: &Path) -> impl FnOnce(FieldError) -> Self {
        move |source| Self::Field { path: path.to_owned(), source }
    }

    /// Sizes whose product no machine can count.
    pub(crate) fn too_large(path: &Path) -> Self {
        Self::malformed(path, "sizes", "2^63 bytes or more", "fewer than 2^63 bytes of values")
    }

    pub(crate) fn malformed(path: &Path, field: &str, found: impl ToString, expected: impl Into<String>) -> Self {
        Self::Malformed {
            path: path.to_owned(),
            field: field.to_owned(),
            found: shorten(&found.to_string()),
            expected: expected.into(),
        }
    }

    pub(crate) fn unsupported(
        path: &Path,
        what: &'static str,
        found: impl ToString,
        advice: impl Into<String>,
    ) -> Self {
        Self::Unsupported { path: path.to_owned(), what, found: shorten(&found.to_string()), advice: advice.into() }
    }
}

/// What a limit counts.
fn counted(setting: &str) -> &'static str {
    match setting {
        "files" => " files of values",
        "text" => " bytes of text",
        _ => " bytes, once decoded,",
    }
}

/// Keeps a hostile header's megabyte-long field out of a one-line message.
fn shorten(text: &str) -> String {
    const LONGEST: usize = 120;
    let mut line: String = text.chars().take(LONGEST).map(|c| if c.is_control() { '?' } else { c }).collect();
    if text.chars().nth(LONGEST).is_some() {
        line.push_str("...");
    }
    line
}
