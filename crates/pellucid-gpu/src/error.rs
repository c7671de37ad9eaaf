//! What can go wrong on a graphics processor.

use pellucid_field::FieldError;
use pellucid_field::memory::OutOfMemory;
use pellucid_optics::OpticsError;
use pellucid_plan::TableError;
use pellucid_plan::half_angle::LightError;

/// Why a device was not opened or a frame was not drawn.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// The caller cancelled.
    #[error("cancelled")]
    Cancelled,
    /// No graphics processor answers to what was asked for.
    #[error("no graphics adapter {wanted}; found: {found}")]
    Adapter {
        /// What was asked for.
        wanted: String,
        /// The adapters that are there.
        found: String,
    },
    /// The driver refused to open the adapter.
    #[error("cannot open {adapter}: {reason}")]
    Device {
        /// The adapter.
        adapter: String,
        /// The driver's reason.
        reason: String,
    },
    /// The device is gone: it was removed, reset by the driver or destroyed. A new renderer may work.
    #[error("the graphics device was lost ({reason}); make a new renderer")]
    Lost {
        /// The driver's reason.
        reason: String,
    },
    /// The device has no memory left.
    #[error("the graphics device is out of memory: {reason}")]
    Memory {
        /// The driver's reason.
        reason: String,
    },
    /// The picture does not fit into the memory of this machine.
    #[error("the picture: {0}")]
    Host(#[from] OutOfMemory),
    /// What would have to be in memory at the same time exceeds the budget.
    #[error("{what} needs {needed} bytes on the graphics device and {budget} are allowed: {advice}")]
    Budget {
        /// What is too large.
        what: String,
        /// Bytes needed.
        needed: u64,
        /// Bytes allowed.
        budget: u64,
        /// What to do.
        advice: &'static str,
    },
    /// A part of a volume that is not in it.
    #[error("voxels {low:?} to {high:?} are not a part of a volume of {dims:?}: the part's end is one beyond its last")]
    Part {
        /// First voxel.
        low: [usize; 3],
        /// One beyond the last.
        high: [usize; 3],
        /// Voxels of the volume.
        dims: [usize; 3],
    },
    /// The device rejected a command: a bug of this program or its driver.
    #[error("the graphics device rejected a command: {reason}")]
    Rejected {
        /// The validation's message.
        reason: String,
    },
    /// A shader does not compile: a bug of this program.
    #[error("shader {variant} does not compile:\n{message}")]
    Shader {
        /// Which one.
        variant: String,
        /// The compiler's message.
        message: String,
    },
    /// More volumes than can be in one picture, or none.
    #[error("the scene holds {found} volumes and the graphics device takes 1 to {most} at a time: use --backend cpu")]
    Volumes {
        /// Volumes in the scene.
        found: usize,
        /// The most that a pass can be given.
        most: usize,
    },
    /// A setting that this backend does not have.
    #[error("the GPU backend has no {what}: {advice}")]
    Unsupported {
        /// The setting.
        what: String,
        /// What else draws it.
        advice: &'static str,
    },
    /// Half-angle slices cannot follow a light.
    #[error(transparent)]
    Light(#[from] LightError),
    /// Rays would have more samples than can be numbered.
    #[error("a ray through the volume has {found:.0} steps, and {limit} are possible: take a longer step")]
    Steps {
        /// Steps of the longest ray.
        found: f64,
        /// The most there may be.
        limit: u32,
    },
    /// The transfer function cannot be tabulated over the data.
    #[error(transparent)]
    Optics(#[from] OpticsError),
    /// The field cannot be reconstructed as asked.
    #[error(transparent)]
    Field(#[from] FieldError),
}

impl From<TableError> for GpuError {
    fn from(error: TableError) -> Self {
        match error {
            TableError::Optics(error) => Self::Optics(error),
            TableError::Field(error) => Self::Field(error),
        }
    }
}
