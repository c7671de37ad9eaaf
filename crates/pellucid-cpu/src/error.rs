//! Why a frame was not drawn.

use pellucid_field::memory::OutOfMemory;
use pellucid_field::{FieldError, ThreadsError};
use pellucid_optics::OpticsError;
use pellucid_plan::TableError;
use pellucid_plan::half_angle::LightError;

use crate::InstructionSet;
use crate::illumination::SavedLightError;

/// Why a frame was not drawn.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The caller cancelled.
    #[error("cancelled")]
    Cancelled,
    /// More volumes than the technique draws, or none.
    #[error(
        "the scene holds {found} volumes, and {technique} draws 1 on the processor: keep one of them, or cast rays"
    )]
    Volumes {
        /// Volumes in the scene.
        found: usize,
        /// Its name.
        technique: &'static str,
    },
    /// A technique of graphics processors.
    #[error("the CPU backend does not draw by {technique}: use --backend gpu, or another technique")]
    Technique {
        /// Its name.
        technique: &'static str,
    },
    /// Half-angle slices cannot follow a light.
    #[error(transparent)]
    Light(#[from] LightError),
    /// The transfer function cannot be tabulated over the data.
    #[error(transparent)]
    Optics(#[from] OpticsError),
    /// The field cannot be reconstructed as asked.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// This machine's processor lacks the instructions asked for.
    #[error("this processor has no {set} instructions: choose auto")]
    Instructions {
        /// What was asked for.
        set: InstructionSet,
    },
    /// Rays would have more samples than can be numbered.
    #[error("a ray through the volume has {found:.0} steps, and {limit} are possible: take a longer step")]
    Steps {
        /// Steps of the longest ray.
        found: f64,
        /// The most there may be.
        limit: u32,
    },
    /// The threads could not be started.
    #[error(transparent)]
    Threads(#[from] ThreadsError),
    /// Light that was saved cannot be used, or light not be saved.
    #[error(transparent)]
    SavedLight(#[from] SavedLightError),
    /// The picture does not fit into memory.
    #[error("the picture: {0}")]
    Memory(#[from] OutOfMemory),
}

impl From<TableError> for RenderError {
    fn from(error: TableError) -> Self {
        match error {
            TableError::Optics(error) => Self::Optics(error),
            TableError::Field(error) => Self::Field(error),
        }
    }
}
