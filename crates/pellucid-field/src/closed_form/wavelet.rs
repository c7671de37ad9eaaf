//! VTK's wavelet source.

use glam::DVec3;

use super::formula::value_and_gradient;
use super::number::Number;
use super::{About, ScalarField};
use crate::VoxelType;

pub(super) const NAME: &str = "wavelet";

/// The field of VTK's `vtkRTAnalyticSource` (ParaView's "Wavelet") with its default settings, so
/// that pictures and numbers can be compared: on [-10, 10]^3, with `u = -p / 20`,
///
/// `255 exp(-|u|^2 / (2 * 0.5^2)) + 10 sin(60 u.x) + 18 sin(30 u.y) + 5 cos(40 u.z)`.
///
/// The divisor is the extent of the box and the minus sign is VTK's (it takes centre minus
/// index). 21 samples per axis hit VTK's own points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wavelet;

const EXTENT: f64 = 20.0;
const MAXIMUM: f64 = 255.0;
const DEVIATION: f64 = 0.5;
const FREQUENCY: DVec3 = DVec3::new(60.0, 30.0, 40.0);
const MAGNITUDE: DVec3 = DVec3::new(10.0, 18.0, 5.0);

impl Wavelet {
    fn formula<N: Number>(&self, p: [N; 3]) -> N {
        let [x, y, z] = p.map(|x| x * (-1.0 / EXTENT));
        let bell = ((x.square() + y.square() + z.square()) * (-0.5 / (DEVIATION * DEVIATION))).exp() * MAXIMUM;
        bell + (x * FREQUENCY.x).sin() * MAGNITUDE.x
            + (y * FREQUENCY.y).sin() * MAGNITUDE.y
            + (z * FREQUENCY.z).cos() * MAGNITUDE.z
    }
}

impl ScalarField for Wavelet {
    value_and_gradient!();

    fn bounds(&self) -> (DVec3, DVec3) {
        (DVec3::splat(-10.0), DVec3::splat(10.0))
    }

    /// Bounds: the bell at the centre and at the corners, with every wave at its crest there.
    fn range(&self) -> (f64, f64) {
        let waves = MAGNITUDE.element_sum();
        let corner = (3.0 * 0.25 * -0.5 / (DEVIATION * DEVIATION)).exp() * MAXIMUM;
        (corner - waves, MAXIMUM + waves)
    }

    fn about(&self) -> About {
        About {
            name: NAME,
            description: "VTK's wavelet source with its default settings: a bell with waves along each axis",
            dims: [21; 3],
            voxel_type: VoxelType::F32,
            value_unit: None,
            length_unit: None,
            whole_units: false,
        }
    }
}
