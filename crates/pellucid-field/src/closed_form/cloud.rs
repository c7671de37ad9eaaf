//! A cumulus cloud.

use glam::DVec3;

use super::footprint::{Footprint, inside};
use super::formula::value_and_gradient;
use super::noise::{WAVES, noise};
use super::number::Number;
use super::shape::{common, ellipsoid, join};
use super::{About, ScalarField};
use crate::VoxelType;

pub(super) const NAME: &str = "cloud";

/// Heaped ellipsoids, x, y, z and radii.
const HEAPS: [[f64; 6]; 16] = [
    [0.00, 0.00, -0.20, 0.55, 0.48, 0.26],
    [-0.50, 0.10, -0.27, 0.30, 0.30, 0.18],
    [0.52, -0.06, -0.25, 0.32, 0.28, 0.20],
    [0.12, 0.04, 0.12, 0.34, 0.32, 0.30],
    [-0.24, -0.06, 0.02, 0.27, 0.26, 0.24],
    [0.22, -0.08, 0.40, 0.22, 0.21, 0.20],
    [0.44, 0.16, 0.02, 0.21, 0.20, 0.18],
    [-0.06, 0.20, 0.26, 0.20, 0.19, 0.18],
    [-0.10, -0.34, -0.24, 0.30, 0.26, 0.18],
    [0.08, 0.02, 0.52, 0.15, 0.15, 0.14],
    [0.34, -0.20, -0.02, 0.18, 0.17, 0.16],
    [-0.42, -0.12, -0.10, 0.19, 0.18, 0.16],
    [0.72, 0.08, -0.28, 0.16, 0.16, 0.13],
    [-0.74, 0.02, -0.31, 0.14, 0.14, 0.11],
    [0.20, 0.34, -0.18, 0.24, 0.20, 0.18],
    [0.02, -0.24, 0.10, 0.19, 0.18, 0.17],
];
/// Height of the flat base, where the air is just moist enough.
const BASE: f64 = -0.38;
/// How far billows move the surface, and over which width density falls.
const BILLOWS: f64 = 0.20;
const EDGE: f64 = 0.08;
/// Billows per unit length of the coarsest octave, and the number of octaves.
const FREQUENCY: f64 = 4.2;
const OCTAVES: u32 = 5;
/// What the folded noise of an octave is in the mean.
const MEAN_FOLD: f64 = 0.2;

/// Density of a cumulus cloud, 0 to 1, on a box of 2 x 2 x 1.4: ellipsoids heaped over a flat base,
/// their surface billowed by fractal gradient noise. Up is z.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cloud;

impl Cloud {
    fn formula<N: Number>(&self, p: [N; 3], seen: Footprint) -> N {
        let edge = seen.edge(EDGE);
        let heaps = HEAPS.iter().fold(N::constant(f64::INFINITY), |cloud, &[x, y, z, a, b, c]| {
            let heap = ellipsoid(p, DVec3::new(x, y, z), DVec3::new(a, b, c));
            if cloud.value().is_finite() { join(cloud, heap, 0.06) } else { heap }
        });
        // Billows only swell the cloud, and by no more than they can.
        if heaps.value() > BILLOWS + edge {
            return N::constant(0.0);
        }
        if heaps.value() < -0.06 - edge / 2.0 && p[2].value() > BASE + 0.16 + edge / 2.0 {
            return N::constant(1.0);
        }
        let body = heaps - billows(p, seen) * BILLOWS;
        // High above the base only the body counts.
        if p[2].value() > BASE + 0.26 + edge / 2.0 {
            return inside(body, edge);
        }
        let wisps = billows([p[1] * 1.7, p[2] * 1.7, p[0] * 1.7], seen) * 0.05;
        inside(common(body, -p[2] + BASE + wisps, 0.12), edge)
    }
}

/// Round heads with creases between them, in [0, 1]: what is left of 1 by noise folded up at 0,
/// summed over octaves.
fn billows<N: Number>(p: [N; 3], seen: Footprint) -> N {
    let mut sum = N::constant(0.0);
    let (mut frequency, mut share) = (FREQUENCY, 0.6);
    for _ in 0..OCTAVES {
        let detail = seen.detail(frequency * WAVES);
        let n = noise(p.map(|x| x * frequency + frequency));
        // A rounded |n|: zero where the noise is, differentiable there.
        let folded = (n.square() + 0.003).sqrt() - 0.003f64.sqrt();
        sum = sum + folded * (share * detail) + MEAN_FOLD * share * (1.0 - detail);
        frequency *= 2.03;
        share *= 0.4;
    }
    sum
}

impl ScalarField for Cloud {
    value_and_gradient!(edges);

    fn bounds(&self) -> (DVec3, DVec3) {
        (DVec3::new(-1.0, -1.0, -0.6), DVec3::new(1.0, 1.0, 0.8))
    }

    fn range(&self) -> (f64, f64) {
        (0.0, 1.0)
    }

    fn about(&self) -> About {
        About {
            name: NAME,
            description: "density of a cumulus cloud",
            dims: [201, 201, 141],
            voxel_type: VoxelType::U8,
            value_unit: None,
            length_unit: None,
            whole_units: false,
        }
    }
}
