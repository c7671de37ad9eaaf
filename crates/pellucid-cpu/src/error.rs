//! Why a frame was not drawn.

use pellucid_field::FieldError;
use pellucid_optics::OpticsError;

/// Why a frame was not drawn.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The caller cancelled.
    #[error("cancelled")]
    Cancelled,
    /// The backend draws one volume at a time.
    #[error("the scene holds {found} volumes and the CPU ray caster draws 1: keep one of them")]
    Volumes {
        /// Volumes in the scene.
        found: usize,
    },
    /// The transfer function cannot be tabulated over the data.
    #[error(transparent)]
    Optics(#[from] OpticsError),
    /// The field cannot be reconstructed as asked.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// The thread pool could not be made.
    #[error("cannot start {threads} threads: {reason}")]
    Threads {
        /// Threads asked for.
        threads: usize,
        /// The system's reason.
        reason: String,
    },
}
