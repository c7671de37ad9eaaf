//! The large shape of a cloud: ellipsoids that blend into each other (K-25, MOD-09).

use glam::DVec3;
use pellucid_field::VoxelType;
use pellucid_field::closed_form::{About, ScalarField};

/// Density of blended implicit ellipsoids on a box of 2 x 2 x 1.2, 0 to 1: the sum of one bump for each (Wyvill
/// et al. 1986, as Ebert models clouds), no more than 1. Smooth, for noise to give it detail. Up is z.
#[derive(Clone, Debug, PartialEq)]
pub struct Clouds {
    ellipsoids: Vec<Ellipsoid>,
}

/// A bump of 1 in the middle that is 0 from its radii on.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Ellipsoid {
    center: DVec3,
    radii: DVec3,
}

const LOW: DVec3 = DVec3::new(-1.0, -1.0, -0.6);
const HIGH: DVec3 = DVec3::new(1.0, 1.0, 0.6);

impl Clouds {
    /// A cloud of at most 256 ellipsoids, the same for a seed on every machine: wide ones below, smaller ones
    /// heaped on their middle, all inside the box.
    pub fn new(seed: u64, ellipsoids: usize) -> Self {
        let count = ellipsoids.min(256);
        let ellipsoid = |k: usize| {
            let number = |n: usize| random(seed, (8 * k + n) as u64);
            let height = number(0).powi(2);
            // A heap: the higher, the narrower, and the smaller its parts.
            let (angle, out) = (std::f64::consts::TAU * number(1), number(2).sqrt() * (1.0 - 0.7 * height));
            let size = (0.22 + 0.2 * number(3)) * (1.0 - 0.4 * height);
            let radii = DVec3::new(size, size * (0.8 + 0.4 * number(4)), size * (0.6 + 0.2 * number(5)));
            let center = DVec3::new(0.5 * out * angle.cos(), 0.45 * out * angle.sin(), -0.25 + 0.5 * height);
            Ellipsoid { center: center.clamp(LOW + radii, HIGH - radii), radii }
        };
        Self { ellipsoids: (0..count).map(ellipsoid).collect() }
    }

    /// The sum of all bumps, and its gradient.
    fn sum(&self, p: DVec3) -> (f64, DVec3) {
        let mut sum = (0.0, DVec3::ZERO);
        for Ellipsoid { center, radii } in &self.ellipsoids {
            let scaled = (p - center) / radii;
            let q = scaled.length_squared();
            if q < 1.0 {
                // 1 - 22/9 q + 17/9 q^2 - 4/9 q^3: 1 at 0, 1/2 at q = 1/4, 0 with its slope at 1.
                sum.0 += 1.0 + q * (-22.0 + q * (17.0 - 4.0 * q)) / 9.0;
                sum.1 += scaled / radii * (2.0 * (-22.0 + q * (34.0 - 12.0 * q)) / 9.0);
            }
        }
        sum
    }
}

impl ScalarField for Clouds {
    fn value(&self, p: DVec3) -> f64 {
        self.sum(p).0.min(1.0)
    }

    fn gradient(&self, p: DVec3) -> DVec3 {
        let (sum, gradient) = self.sum(p);
        if sum < 1.0 { gradient } else { DVec3::ZERO }
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        (LOW, HIGH)
    }

    fn range(&self) -> (f64, f64) {
        (0.0, 1.0)
    }

    fn about(&self) -> About {
        About {
            name: "clouds",
            description: "the large shape of a cloud: blended ellipsoids",
            dims: [64; 3],
            voxel_type: VoxelType::U8,
            value_unit: None,
            length_unit: None,
            whole_units: false,
        }
    }
}

/// A number from 0 to 1 (SplitMix64).
fn random(seed: u64, i: u64) -> f64 {
    let mut z = seed.wrapping_mul(0xD134_2543_DE82_EF95).wrapping_add((i + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15));
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}
