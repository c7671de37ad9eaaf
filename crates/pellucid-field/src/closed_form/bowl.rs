//! A bowl.

use glam::DVec3;

use super::footprint::Footprint;
use super::formula::value_and_gradient;
use super::number::Number;
use super::shape::{cuboid, length};
use super::{About, ScalarField};
use crate::VoxelType;

pub(super) const NAME: &str = "bowl";

/// The block: half as wide as this along x and y, and so deep under the plane z = 0.
const HALF: f64 = 0.85;
const EDGE: f64 = 0.1;

/// A hemispherical hollow in a block, open upwards at the plane z = 0, in a box of 2 x 2 x 1.2. The isosurface of value
/// 1/2 is the surface of the block: in the hollow a sphere around the origin. Values rise evenly across the surface from
/// 0 outside to 1 inside, so that trilinear interpolation keeps it smooth.
///
/// Under an even sky every place in the hollow receives as much: of albedo a, `0.5 / (1 - 0.5 a)` times what an open
/// surface does, as half of the light that its wall sends out meets it again. What finds light by many bounces is held
/// to that.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bowl {
    /// Radius of the hollow; above 0 and below 0.8, 0.6 by default.
    pub radius: f64,
}

impl Default for Bowl {
    fn default() -> Self {
        Self { radius: 0.6 }
    }
}

impl Bowl {
    fn formula<N: Number>(&self, p: [N; 3], seen: Footprint) -> N {
        let block = cuboid(p, DVec3::new(0.0, 0.0, -HALF / 2.0), DVec3::new(HALF, HALF, HALF / 2.0));
        let hollow = length(p) - self.radius;
        // A ramp, not a step: curved values would bend what is interpolated between voxels.
        (block.max(-hollow) * -seen.smooth_edge(EDGE).recip() + 0.5).clamp(0.0, 1.0)
    }
}

impl ScalarField for Bowl {
    value_and_gradient!(edges);

    fn bounds(&self) -> (DVec3, DVec3) {
        (DVec3::NEG_ONE, DVec3::new(1.0, 1.0, 0.2))
    }

    fn range(&self) -> (f64, f64) {
        (0.0, 1.0)
    }

    fn about(&self) -> About {
        About {
            name: NAME,
            description: "a hemispherical hollow in a block, level 0.5: every place in it gets as much light",
            dims: [81, 81, 49],
            voxel_type: VoxelType::F32,
            value_unit: None,
            length_unit: None,
            whole_units: false,
        }
    }
}
