//! Rayleigh scattering, `3 (1 + mu^2) / 16 pi`.

use std::f32::consts::PI;

/// Share per steradian.
#[inline]
pub(super) fn eval(mu: f32) -> f32 {
    3.0 / (16.0 * PI) * (1.0 + mu * mu)
}

/// The real root of `mu^3 + 3 mu = 8 u - 4` (Cardano).
#[inline]
pub(super) fn sample(u: f32) -> f32 {
    let half = 4.0 * u - 2.0;
    // By the side that does not cancel.
    let root = (half.abs() + half.hypot(1.0)).cbrt();
    (root - root.recip()).copysign(half)
}
