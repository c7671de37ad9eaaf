//! The Marschner-Lobb test signal.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::DVec3;

use super::formula::value_and_gradient;
use super::number::Number;
use super::{About, ScalarField};
use crate::VoxelType;

pub(super) const NAME: &str = "marschner-lobb";

/// The test signal of S. Marschner and R. Lobb, "An Evaluation of Reconstruction Filters for
/// Volume Rendering", IEEE Visualization 1994:
///
/// `(1 - sin(pi z / 2) + alpha (1 + cos(2 pi f cos(pi r / 2)))) / (2 (1 + alpha))`, `r = |(x, y)|`,
///
/// on [-1, 1]^3. With the defaults almost all of its spectrum lies just under the Nyquist
/// frequency of 40 samples per axis, so that filters show what they are worth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MarschnerLobb {
    /// Height of the ripples; 0.25.
    pub alpha: f64,
    /// Their frequency, f_M; 6.
    pub frequency: f64,
}

impl Default for MarschnerLobb {
    fn default() -> Self {
        Self { alpha: 0.25, frequency: 6.0 }
    }
}

impl MarschnerLobb {
    fn formula<N: Number>(&self, [x, y, z]: [N; 3]) -> N {
        let r = (x.square() + y.square()).sqrt();
        let ripples = ((r * FRAC_PI_2).cos() * (TAU * self.frequency)).cos();
        (-(z * FRAC_PI_2).sin() + 1.0 + (ripples + 1.0) * self.alpha) * (0.5 / (1.0 + self.alpha))
    }
}

impl ScalarField for MarschnerLobb {
    value_and_gradient!();

    fn bounds(&self) -> (DVec3, DVec3) {
        (DVec3::NEG_ONE, DVec3::ONE)
    }

    fn range(&self) -> (f64, f64) {
        (0.0, 1.0)
    }

    fn about(&self) -> About {
        About {
            name: NAME,
            description: "ripples near the Nyquist frequency of 40 samples per axis: shows what a filter is worth",
            dims: [41; 3],
            voxel_type: VoxelType::F32,
            value_unit: None,
            length_unit: None,
            whole_units: false,
        }
    }
}
