//! The phase function of Henyey and Greenstein (Eq. 6.1). All formulas are exact at `g = 0` and lose
//! no digits near the peak, where `1 + g^2 - 2 g mu` would.

use std::f32::consts::PI;

/// Share per steradian.
#[inline]
pub(super) fn eval(g: f32, mu: f32) -> f32 {
    let squared = (1.0 - g.abs()).powi(2) + 2.0 * (g.abs() - g * mu);
    (1.0 - g * g) / (4.0 * PI * squared * squared.sqrt())
}

/// The inverse of the distribution of `mu`, `(1 + g^2 - ((1 - g^2) / (1 + g t))^2) / 2g` with `t = 2u - 1`,
/// multiplied out.
#[inline]
pub(super) fn sample(g: f32, u: f32) -> f32 {
    let t = 2.0 * u - 1.0;
    let numerator = 2.0 * t + g * (3.0 + t * t + g * (2.0 * t + g * (t * t - 1.0)));
    numerator / (2.0 * (1.0 + g * t).powi(2))
}

/// The largest share, straight forward or straight back.
#[inline]
pub(super) fn peak(g: f32) -> f32 {
    let g = g.abs();
    (1.0 + g) / (4.0 * PI * (1.0 - g).powi(2))
}
