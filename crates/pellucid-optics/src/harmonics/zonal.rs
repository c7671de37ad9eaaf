//! Functions around an axis, by one number a band.

use std::f64::consts::PI;

use glam::DVec3;

use super::bands::{Bands, MOST_BANDS, MOST_COEFFICIENTS};
use super::basis::spherical_harmonics_f64;

/// A function around an axis: what it makes of each band of a function that it is convolved with (Funk and Hecke).
/// Coefficients of the function itself are these factors times the harmonics of its axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Zonal([f64; MOST_BANDS]);

/// Against ringing: weights that fall from band to band, so that a sharp light has a softer image without waves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Window {
    /// `(1 + cos(pi l / n)) / 2` for degree l of n bands: strong.
    Hanning,
    /// `sin(pi l / n) / (pi l / n)`: gentle.
    Lanczos,
}

impl Zonal {
    /// The cosine above the horizon of a normal, 0 below: what an unoccluded surface gathers. `2 pi` times the integral
    /// of the cosine times Legendre's polynomial (R. Ramamoorthi and P. Hanrahan 2001; Wyman et al. 2006, eq. 6).
    pub const CLAMPED_COSINE: Self = Self([PI, 2.0 * PI / 3.0, PI / 4.0, 0.0, -PI / 24.0, 0.0]);

    /// Even light from a disc, by the squared sine of the angle from its middle to its edge, which brings an irradiance
    /// of 1 to a surface that faces it. Of size 0 it is a single direction, with a factor of 1 in every band.
    pub fn cap(sine_squared: f64) -> Self {
        let sine_squared = sine_squared.clamp(0.0, 1.0);
        let z = (1.0 - sine_squared).sqrt();
        // The integral of Legendre's polynomial from z to 1 is (1 - z^2) P'(z) / (l (l + 1)), and the radiance
        // 1 / (pi (1 - z^2)): in their product no small difference is left.
        let mut factors = [2.0 / (1.0 + z); MOST_BANDS];
        let (mut before, mut legendre, mut slope) = (1.0, z, 1.0);
        for l in 1..MOST_BANDS {
            let degree = l as f64;
            factors[l] = 2.0 * slope / (degree * (degree + 1.0));
            (before, legendre, slope) = (
                legendre,
                ((2.0 * degree + 1.0) * z * legendre - degree * before) / (degree + 1.0),
                z * slope + (degree + 1.0) * legendre,
            );
        }
        Self(factors)
    }

    /// The weights of a window over that many bands.
    pub fn window(window: Window, bands: Bands) -> Self {
        let weight = |l: usize| {
            let angle = PI * l as f64 / bands.count() as f64;
            match window {
                _ if l >= bands.count() => 0.0,
                _ if l == 0 => 1.0,
                Window::Hanning => 0.5 + 0.5 * angle.cos(),
                Window::Lanczos => angle.sin() / angle,
            }
        };
        Self(std::array::from_fn(weight))
    }

    /// The factor of each band.
    pub fn factors(&self) -> [f64; MOST_BANDS] {
        self.0
    }

    /// The coefficients of the function around an axis, a unit vector; 0 beyond the bands.
    pub fn around(&self, axis: DVec3, bands: Bands) -> [f64; MOST_COEFFICIENTS] {
        let basis = spherical_harmonics_f64(bands, axis);
        std::array::from_fn(|i| self.0[i.isqrt()] * basis[i])
    }
}
