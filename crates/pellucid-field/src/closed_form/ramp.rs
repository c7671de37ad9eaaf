//! A linear function.

use glam::DVec3;

use super::formula::value_and_gradient;
use super::number::Number;
use super::{About, ScalarField};
use crate::VoxelType;

pub(super) const NAME: &str = "ramp";

/// `offset + slope . p` on [-1, 1]^3: every filter that reproduces linear functions must return
/// it exactly, and so must every seam between bricks and levels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ramp {
    /// The constant gradient; (1/2, 0, 0) by default.
    pub slope: DVec3,
    /// Value at the origin; 1/2 by default.
    pub offset: f64,
}

impl Default for Ramp {
    fn default() -> Self {
        Self { slope: DVec3::new(0.5, 0.0, 0.0), offset: 0.5 }
    }
}

impl Ramp {
    fn formula<N: Number>(&self, [x, y, z]: [N; 3]) -> N {
        x * self.slope.x + y * self.slope.y + z * self.slope.z + self.offset
    }
}

impl ScalarField for Ramp {
    value_and_gradient!();

    fn bounds(&self) -> (DVec3, DVec3) {
        (DVec3::NEG_ONE, DVec3::ONE)
    }

    fn range(&self) -> (f64, f64) {
        let rise = self.slope.abs().element_sum();
        (self.offset - rise, self.offset + rise)
    }

    fn about(&self) -> About {
        About {
            name: NAME,
            description: "a linear function: constant gradient, exact under any good filter",
            dims: [32; 3],
            voxel_type: VoxelType::F32,
            value_unit: None,
            length_unit: None,
            whole_units: false,
        }
    }
}
