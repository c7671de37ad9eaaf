//! What may be wrong with light that was saved.

use std::path::PathBuf;

use pellucid_field::memory::OutOfMemory;

/// Why light that was saved is not drawn with, or light is not saved.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SavedLightError {
    /// The scene names a file, and nobody has read it.
    #[error("{}: the light in it has not been read", file.display())]
    Unread {
        /// The file.
        file: PathBuf,
    },
    /// A file holds something else.
    #[error(
        "{}: this is not light that was saved by 'pellucid bake' (found {found}): bake it again, or leave \
         technique.ray_cast.mode.isosurface.illumination.global.file out",
        file.display()
    )]
    Foreign {
        /// The file.
        file: PathBuf,
        /// What it holds.
        found: String,
    },
    /// The light is not that of the scene.
    #[error(
        "{}: this is the light of other data, other settings or other lights (its mark is {found:016x}, and the scene's is \
         {expected:016x}): bake it again with 'pellucid bake', or leave \
         technique.ray_cast.mode.isosurface.illumination.global.file out",
        file.display()
    )]
    Other {
        /// The file.
        file: PathBuf,
        /// What the light belongs to.
        found: u64,
        /// What is drawn.
        expected: u64,
    },
    /// The light does not fit into memory once more, as a volume.
    #[error("the light of surfaces: {0}")]
    Memory(#[from] OutOfMemory),
}
