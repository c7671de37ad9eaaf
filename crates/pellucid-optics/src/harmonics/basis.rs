//! The functions that light is made of.

use std::f64::consts::PI;
use std::ops::{Add, Mul, Sub};

use glam::{DVec3, Vec3};

use super::bands::{Bands, MOST_BANDS, MOST_COEFFICIENTS};

/// The real spherical harmonics of the first bands in a direction, a unit vector (Wyman et al. 2006, eq. 12, with the
/// absolute value of m throughout); 0 beyond those.
#[inline]
pub fn spherical_harmonics(bands: Bands, direction: Vec3) -> [f32; MOST_COEFFICIENTS] {
    values(bands, direction.to_array())
}

/// [`spherical_harmonics`] in double precision.
pub fn spherical_harmonics_f64(bands: Bands, direction: DVec3) -> [f64; MOST_COEFFICIENTS] {
    values(bands, direction.to_array())
}

/// What they are computed in.
trait Real: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    fn real(number: f64) -> Self;
}

impl Real for f32 {
    #[inline(always)]
    fn real(number: f64) -> Self {
        number as f32
    }
}

impl Real for f64 {
    #[inline(always)]
    fn real(number: f64) -> Self {
        number
    }
}

#[inline]
fn values<T: Real>(bands: Bands, direction: [T; 3]) -> [T; MOST_COEFFICIENTS] {
    // Loops of known length are unrolled, and the factors become part of the program.
    match bands.count() {
        1 => unrolled::<T, 1>(direction),
        2 => unrolled::<T, 2>(direction),
        3 => unrolled::<T, 3>(direction),
        4 => unrolled::<T, 4>(direction),
        5 => unrolled::<T, 5>(direction),
        _ => unrolled::<T, MOST_BANDS>(direction),
    }
}

#[inline(always)]
fn unrolled<T: Real, const BANDS: usize>([x, y, z]: [T; 3]) -> [T; MOST_COEFFICIENTS] {
    let mut values = [T::real(0.0); MOST_COEFFICIENTS];
    // Cosine and sine of m times the azimuth, times the m-th power of the sine of the polar angle.
    let (mut cosine, mut sine) = (T::real(1.0), T::real(0.0));
    for m in 0..BANDS {
        let (mut before, mut legendre) = (T::real(0.0), T::real(FIRST[m]));
        for l in m..BANDS {
            if l > m {
                let [rise, fall] = FACTORS[l][m];
                (before, legendre) = (legendre, T::real(rise) * z * legendre - T::real(fall) * before);
            }
            values[l * (l + 1) + m] = legendre * cosine;
            if m > 0 {
                values[l * (l + 1) - m] = legendre * sine;
            }
        }
        (cosine, sine) = (x * cosine - y * sine, x * sine + y * cosine);
    }
    values
}

/// The associated Legendre function of degree and order m over the m-th power of the sine, normalised: that of the
/// order before times `sqrt((2m + 1) / (2m))`, and from order 1 on with the square root of 2 that cosine and sine bring.
const FIRST: [f64; MOST_BANDS] = {
    let mut first = [root(1.0 / (4.0 * PI)); MOST_BANDS];
    first[1] = root(3.0 / (4.0 * PI));
    let mut m = 2;
    while m < MOST_BANDS {
        first[m] = first[m - 1] * root((2 * m + 1) as f64 / (2 * m) as f64);
        m += 1;
    }
    first
};

/// By degree and order, of the recurrence in the degree: what the last degree times z counts, and the one before it.
const FACTORS: [[[f64; 2]; MOST_BANDS]; MOST_BANDS] = {
    let mut factors = [[[0.0; 2]; MOST_BANDS]; MOST_BANDS];
    let mut m = 0;
    while m < MOST_BANDS {
        let mut l = m + 1;
        while l < MOST_BANDS {
            let rise = root((4 * l * l - 1) as f64 / (l * l - m * m) as f64);
            let fall = if l > m + 1 { rise / factors[l - 1][m][0] } else { 0.0 };
            factors[l][m] = [rise, fall];
            l += 1;
        }
        m += 1;
    }
    factors
};

/// The square root by Newton's method, which constants can be computed with.
const fn root(number: f64) -> f64 {
    let mut root = 1.0;
    let mut step = 0;
    while step < 12 {
        root = 0.5 * (root + number / root);
        step += 1;
    }
    root
}
