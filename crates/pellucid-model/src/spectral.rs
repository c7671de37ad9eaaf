//! Smoke from sums of sines (MOD-06, Listing 12.4).

use glam::DVec3;
use pellucid_field::VoxelType;
use pellucid_field::closed_form::{About, ScalarField};

/// The magnitude of a sum of products of sines on [0, 1]^3: five octaves, each twice as fine and half as strong,
/// `|sum of 0.5 / 2^i sin(3 2^i x + a) sin(3 2^i y + b) sin(3 2^i z + c)|`, at most 0.96875.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spectral {
    /// The phases a, b and c of every octave, in radians; 0 by default.
    pub phases: [[f64; 3]; 5],
}

impl Spectral {
    /// The sum before its sign is taken off, and its gradient.
    fn sum(&self, p: DVec3) -> (f64, DVec3) {
        let mut sum = (0.0, DVec3::ZERO);
        let (mut frequency, mut amplitude) = (3.0, 0.5);
        for phase in &self.phases {
            let turned = p * frequency + DVec3::from_array(*phase);
            let [sin, cos] = [turned.map(f64::sin), turned.map(f64::cos)];
            sum.0 += amplitude * sin.element_product();
            let slope = DVec3::new(cos.x * sin.y * sin.z, sin.x * cos.y * sin.z, sin.x * sin.y * cos.z);
            sum.1 += slope * (amplitude * frequency);
            frequency *= 2.0;
            amplitude *= 0.5;
        }
        sum
    }
}

impl ScalarField for Spectral {
    fn value(&self, p: DVec3) -> f64 {
        self.sum(p).0.abs()
    }

    fn gradient(&self, p: DVec3) -> DVec3 {
        let (sum, gradient) = self.sum(p);
        if sum == 0.0 { DVec3::ZERO } else { gradient * sum.signum() }
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        (DVec3::ZERO, DVec3::ONE)
    }

    fn range(&self) -> (f64, f64) {
        (0.0, 0.968_75)
    }

    fn about(&self) -> About {
        About {
            name: "spectral",
            description: "smoke: the magnitude of a sum of sines",
            dims: [128; 3],
            voxel_type: VoxelType::F32,
            value_unit: None,
            length_unit: None,
            whole_units: false,
        }
    }
}
