//! A product of sines.

use std::f64::consts::TAU;

use glam::DVec3;

use super::formula::value_and_gradient;
use super::number::Number;
use super::{About, ScalarField};
use crate::VoxelType;

pub(super) const NAME: &str = "sines";

/// `sin(2 pi f x) sin(2 pi f y) sin(2 pi f z)` on [-1, 1]^3: one frequency, so that the response
/// of a filter and the onset of aliasing can be read off (1.5-5).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sines {
    /// Waves per unit length, f; 2 by default (four waves across the box).
    pub frequency: f64,
}

impl Default for Sines {
    fn default() -> Self {
        Self { frequency: 2.0 }
    }
}

impl Sines {
    fn formula<N: Number>(&self, p: [N; 3]) -> N {
        let [x, y, z] = p.map(|x| (x * (TAU * self.frequency)).sin());
        x * y * z
    }
}

impl ScalarField for Sines {
    value_and_gradient!();

    fn bounds(&self) -> (DVec3, DVec3) {
        (DVec3::NEG_ONE, DVec3::ONE)
    }

    fn range(&self) -> (f64, f64) {
        // Less than a quarter of a wave on either side does not reach a crest.
        let crest = (TAU * self.frequency.abs().min(0.25)).sin().powi(3);
        (-crest, crest)
    }

    fn about(&self) -> About {
        About {
            name: NAME,
            description: "a product of sines: one frequency along each axis",
            dims: [64; 3],
            voxel_type: VoxelType::F32,
            value_unit: None,
            length_unit: None,
            whole_units: false,
        }
    }
}
