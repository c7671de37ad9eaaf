//! The sky in harmonics.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use pellucid_field::parallel;
use rayon::prelude::*;

use super::bands::{Bands, MOST_BANDS, MOST_COEFFICIENTS};
use super::basis::spherical_harmonics_f64;
use super::rotation::Rotation;
use crate::{Sky, SkyMap};

/// Linear RGB by coefficient.
type Coefficients = [[f64; 3]; MOST_COEFFICIENTS];

/// The integral of a sky's radiance times each harmonic (Wyman et al. 2006, eq. 7).
pub(super) fn project(sky: &Sky) -> Coefficients {
    match sky {
        Sky::Gradient { top, bottom, .. } => gradient(top.map(f64::from), bottom.map(f64::from)),
        Sky::Image { map, turn, intensity } => {
            let turned = Rotation::new(turn.as_dquat());
            turned.rotate(&picture(map)).map(|rgb| rgb.map(|v| v * f64::from(*intensity)))
        }
    }
}

/// The mean is a constant, and what is left is along z.
fn gradient(top: [f64; 3], bottom: [f64; 3]) -> Coefficients {
    let mut coefficients = [[0.0; 3]; MOST_COEFFICIENTS];
    for channel in 0..3 {
        coefficients[0][channel] = PI.sqrt() * (top[channel] + bottom[channel]);
        coefficients[2][channel] = (PI / 3.0).sqrt() * (top[channel] - bottom[channel]);
    }
    coefficients
}

/// The integral over every texel of its radiance times each harmonic, which is a function of the height times one of
/// the azimuth.
fn picture(map: &SkyMap) -> Coefficients {
    let [width, height] = map.size();
    let around: Vec<Around> = (0..width).map(|column| azimuth(column, width)).collect();
    let row = |(number, texels): (usize, &[[f32; 3]])| {
        // The row's light by order.
        let mut sums = [[0.0; 3]; ORDERS];
        for (texel, factors) in texels.iter().zip(&around) {
            for (sum, factor) in sums.iter_mut().zip(factors) {
                *sum = std::array::from_fn(|channel| sum[channel] + factor * f64::from(texel[channel]));
            }
        }
        (polar(number, height), sums)
    };
    let rows: Vec<_> = parallel(|| map.texels().par_chunks(width).enumerate().map(row).collect());
    let mut coefficients = [[0.0; 3]; MOST_COEFFICIENTS];
    for (down, sums) in rows {
        for (i, coefficient) in coefficients.iter_mut().enumerate() {
            let l = i.isqrt();
            // Orders count from the middle of the band.
            let order = i + MOST_BANDS - 1 - l * (l + 1);
            let m = order.abs_diff(MOST_BANDS - 1);
            *coefficient =
                std::array::from_fn(|channel| coefficient[channel] + down[l * (l + 1) + m] * sums[order][channel]);
        }
    }
    coefficients
}

/// Orders of all bands.
const ORDERS: usize = 2 * MOST_BANDS - 1;

/// By order, from the lowest on.
type Around = [f64; ORDERS];

/// The integral over a column of the cosine of m times the azimuth, and of the sine for negative orders. The azimuth
/// goes from +x towards +y, columns from -y over -x and +y.
fn azimuth(column: usize, width: usize) -> Around {
    let [to, from] = [column, column + 1].map(|side| 0.75 * TAU - TAU * side as f64 / width as f64);
    std::array::from_fn(|order| {
        let m = order.abs_diff(MOST_BANDS - 1) as f64;
        match order.cmp(&(MOST_BANDS - 1)) {
            std::cmp::Ordering::Less => ((m * from).cos() - (m * to).cos()) / m,
            std::cmp::Ordering::Equal => to - from,
            std::cmp::Ordering::Greater => ((m * to).sin() - (m * from).sin()) / m,
        }
    })
}

/// The integral over a row of each harmonic of azimuth 0, along the meridian, by Gauss's five points in pieces of a
/// tenth of a radian and less: exact to the last digits.
fn polar(row: usize, height: usize) -> [f64; MOST_COEFFICIENTS] {
    const OUTER: (f64, f64) = (0.906_179_845_938_664, 0.236_926_885_056_189_1);
    const INNER: (f64, f64) = (0.538_469_310_105_683_1, 0.478_628_670_499_366_5);
    const GAUSS: [(f64, f64); 5] = [(-OUTER.0, OUTER.1), (-INNER.0, INNER.1), (0.0, 128.0 / 225.0), INNER, OUTER];
    let last = Bands::ALL[MOST_BANDS - 1];
    let pieces = 32usize.div_ceil(height);
    let half = 0.5 * PI / (height * pieces) as f64;
    let mut sums = [0.0; MOST_COEFFICIENTS];
    for piece in 0..pieces {
        let middle = (2 * (row * pieces + piece) + 1) as f64 * half;
        for (place, weight) in GAUSS {
            let (sine, cosine) = (middle + half * place).sin_cos();
            let values = spherical_harmonics_f64(last, DVec3::new(sine, 0.0, cosine));
            for (sum, value) in sums.iter_mut().zip(values) {
                *sum += half * weight * sine * value;
            }
        }
    }
    sums
}
