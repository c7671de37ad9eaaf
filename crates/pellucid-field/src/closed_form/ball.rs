//! A soft ball.

use glam::DVec3;

use super::footprint::{Footprint, inside};
use super::formula::value_and_gradient;
use super::number::Number;
use super::shape::length;
use super::{About, ScalarField};
use crate::VoxelType;

pub(super) const NAME: &str = "ball";

/// A density that falls from 1 inside to 0 outside across a soft edge, on [-1, 1]^3. Isosurfaces
/// are spheres, the one of value 1/2 has the ball's radius, and gradients point to the centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Radius where the density is 1/2; above 0, 0.6 by default.
    pub radius: f64,
    /// Radial width over which it falls from 1 to 0; above 0, 0.6 by default.
    pub edge: f64,
}

impl Default for Ball {
    fn default() -> Self {
        Self { radius: 0.6, edge: 0.6 }
    }
}

impl Ball {
    fn formula<N: Number>(&self, p: [N; 3], seen: Footprint) -> N {
        inside(length(p) - self.radius, seen.smooth_edge(self.edge))
    }
}

impl ScalarField for Ball {
    value_and_gradient!(edges);

    fn bounds(&self) -> (DVec3, DVec3) {
        (DVec3::NEG_ONE, DVec3::ONE)
    }

    fn range(&self) -> (f64, f64) {
        // Values fall with the distance from the centre: the corners have the lowest.
        (self.value(DVec3::ONE), self.value(DVec3::ZERO))
    }

    fn about(&self) -> About {
        About {
            name: NAME,
            description: "a ball with a soft edge: every isosurface is a sphere",
            dims: [64; 3],
            voxel_type: VoxelType::U8,
            value_unit: None,
            length_unit: None,
            whole_units: false,
        }
    }
}
