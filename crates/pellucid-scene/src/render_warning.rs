//! What is said of a picture beside it.

use std::fmt;

use crate::FrameStatistics;

/// Something a user should hear of although the picture was drawn.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum RenderWarning {
    /// Nothing of the volume is in the picture.
    Empty {
        /// Why, as far as known.
        reason: String,
    },
    /// Memory was short, and the picture was drawn with less of it.
    Memory {
        /// What was short, and what was done.
        reason: String,
    },
    /// Light was left out of the picture on purpose.
    Bias {
        /// What was left out, and how much of it.
        reason: String,
    },
    /// Something was asked for that could not be had, and something else stands for it.
    Fallback {
        /// What was missing, and what was done.
        reason: String,
    },
    /// Matter is so dense that paths are scattered very often and get nowhere, which takes very long.
    Dense {
        /// The volume, by its number.
        volume: usize,
        /// World distance that its opacities hold for.
        unit_distance: f64,
        /// Largest optical depth in a voxel.
        in_voxel: f64,
        /// The same over the diagonal of its box.
        across: f64,
        /// Mean spacing of its voxels in world units.
        voxel: f64,
    },
}

impl RenderWarning {
    /// A firefly clamp held light back, if these totals say so.
    pub fn clamped(statistics: &FrameStatistics) -> Option<Self> {
        let [brought, held_back] = statistics.light;
        (held_back > 0.0).then(|| {
            let share = 100.0 * held_back / brought;
            let reason = format!("the firefly clamp held back {share:.2} % of the light that paths brought");
            Self::Bias { reason }
        })
    }
}

impl fmt::Display for RenderWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty { reason } => write!(f, "the picture is empty: {reason}"),
            Self::Memory { reason } | Self::Bias { reason } | Self::Fallback { reason } => f.write_str(reason),
            Self::Dense { volume, unit_distance, in_voxel, across, voxel } => write!(
                f,
                "volumes[{volume}] has an optical depth of up to {in_voxel:.0} in a voxel and of {across:.3e} across: \
                 paths are scattered very often, and take long; its transfer function's unit_distance is \
                 {unit_distance:e}, a voxel {voxel:e}: opacities mostly hold for a voxel or more"
            ),
        }
    }
}
