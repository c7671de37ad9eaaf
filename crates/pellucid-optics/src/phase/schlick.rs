//! Schlick's phase function, `(1 - k^2) / (4 pi (1 - k mu)^2)`, with `k = 1.55 g - 0.55 g^3` (Blasi,
//! Le Saec and Schlick 1993, Pharr and Humphreys 2004): about Henyey and Greenstein's lobe of mean
//! cosine `g`, cheaper. Near 1 the polynomial exceeds 1: from |g| = 0.925 on lobes get no narrower.

use std::f32::consts::PI;

#[inline]
fn parameter(g: f32) -> f32 {
    (g * (1.55 - 0.55 * g * g)).clamp(-0.998, 0.998)
}

/// Share per steradian.
#[inline]
pub(super) fn eval(g: f32, mu: f32) -> f32 {
    let k = parameter(g);
    (1.0 - k * k) / (4.0 * PI * (1.0 - k * mu).powi(2))
}

/// The inverse of the distribution of `mu`.
#[inline]
pub(super) fn sample(g: f32, u: f32) -> f32 {
    let (k, t) = (parameter(g), 2.0 * u - 1.0);
    (t + k) / (1.0 + k * t)
}

/// `1/k - (1 - k^2) / 2k^2 ln((1 + k) / (1 - k))`.
pub(super) fn mean_cosine(g: f32) -> f32 {
    let k = f64::from(parameter(g));
    let squared = k * k;
    let mean = if k.abs() < 0.03 {
        // The formula cancels; its series does not.
        2.0 * k * (1.0 / 3.0 + squared * (1.0 / 15.0 + squared / 35.0))
    } else {
        k.recip() - (1.0 - squared) / squared * k.atanh()
    };
    mean as f32
}
