//! What a scanner of tracers sees in the head phantom.

use glam::DVec3;

use super::formula::value_and_gradient;
use super::number::Number;
use super::shape::{ellipsoid, length, relative};
use super::{About, ScalarField};
use crate::VoxelType;

pub(super) const NAME: &str = "uptake";

/// Places that take up much, x, y, z, their radius and their uptake: deep grey matter of both sides, the rim of the
/// haemorrhage, and two nodes of the neck.
const PLACES: [[f64; 5]; 8] = [
    [12.5, -16.0, 24.0, 8.0, 3.5],
    [-12.5, -16.0, 24.0, 8.0, 3.5],
    [24.0, -4.0, 15.0, 10.0, 3.5],
    [-24.0, -4.0, 15.0, 10.0, 3.5],
    [0.0, 10.0, 17.0, 11.0, 3.0],
    [-37.0, 34.0, 50.0, 12.0, 9.0],
    [38.0, 6.0, -84.0, 8.0, 8.0],
    [33.0, 2.0, -104.0, 7.0, 6.0],
];

/// Uptake of sugar in the head phantom, in standardised values, as positron emission shows it: blurred, in the same
/// place in the world. Grey matter under the vault takes up most.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Uptake;

impl Uptake {
    fn formula<N: Number>(&self, p: [N; 3]) -> N {
        let vault = ellipsoid(p, DVec3::new(0.0, 10.0, 26.0), DVec3::new(65.0, 84.0, 68.0));
        // A bark 9 mm under the wall, and half of it within.
        let bark = ((vault + 9.0) * (1.0 / 8.0)).square() * -1.0;
        let floor = (p[2] * (1.0 / 24.0) + 0.6).smoothstep();
        let mut sum = bark.exp() * 5.0 * floor + ((vault + 6.0) * (-1.0 / 12.0)).smoothstep() * 1.6 * floor;
        for [x, y, z, radius, uptake] in PLACES {
            let away = length(relative(p, DVec3::new(x, y, z))) * radius.recip();
            sum = sum + (away.square() * -1.0).exp() * uptake;
        }
        sum
    }
}

impl ScalarField for Uptake {
    value_and_gradient!();

    fn bounds(&self) -> (DVec3, DVec3) {
        (DVec3::new(-90.0, -100.0, -130.0), DVec3::new(90.0, 112.0, 110.0))
    }

    fn range(&self) -> (f64, f64) {
        // The hottest place lies in the bark.
        (0.0, 12.584)
    }

    fn about(&self) -> About {
        About {
            name: NAME,
            description: "uptake of a tracer in the head phantom, to be drawn with it: values in 4 mm voxels",
            dims: [46, 54, 61],
            voxel_type: VoxelType::F32,
            value_unit: Some("SUV"),
            length_unit: Some("mm"),
            whole_units: false,
        }
    }
}
