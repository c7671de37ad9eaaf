//! Schoen's gyroid.

use std::f64::consts::PI;

use glam::DVec3;

use super::formula::value_and_gradient;
use super::number::Number;
use super::{About, ScalarField};
use crate::VoxelType;

pub(super) const NAME: &str = "gyroid";

/// `sin x cos y + sin y cos z + sin z cos x` on [-1, 1]^3, with `x = pi periods` times the coordinate and y and z alike.
/// Its zero level is close to the gyroid (A. Schoen 1970): two mazes of tunnels, one the mirror image of the other, and
/// a wall between them that light reaches only in many turns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gyroid {
    /// Periods across the box; 3 by default. From 1 on all values are found in it.
    pub periods: f64,
}

impl Default for Gyroid {
    fn default() -> Self {
        Self { periods: 3.0 }
    }
}

impl Gyroid {
    fn formula<N: Number>(&self, p: [N; 3]) -> N {
        let [x, y, z] = p.map(|x| x * (PI * self.periods));
        x.sin() * y.cos() + y.sin() * z.cos() + z.sin() * x.cos()
    }
}

impl ScalarField for Gyroid {
    value_and_gradient!();

    fn bounds(&self) -> (DVec3, DVec3) {
        (DVec3::NEG_ONE, DVec3::ONE)
    }

    fn range(&self) -> (f64, f64) {
        // Highest where all three are an eighth of a period: there each product is 1/2.
        (-1.5, 1.5)
    }

    fn about(&self) -> About {
        About {
            name: NAME,
            description: "two mazes of tunnels and the wall between them: the gyroid is level 0",
            dims: [97; 3],
            voxel_type: VoxelType::F32,
            value_unit: None,
            length_unit: None,
            whole_units: false,
        }
    }
}
