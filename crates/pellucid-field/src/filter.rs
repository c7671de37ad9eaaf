//! Reconstruction filters: kernels and their one-dimensional weights (9.2).

use std::f64::consts::PI;
use std::ops::Deref;

use crate::FieldError;

/// Largest half width of a [`Filter::Sinc`], in voxels.
pub const MAX_HALF_WIDTH: u8 = 8;

/// Shape parameter of the Kaiser window: a stop band of 63 dB by Kaiser's design formula.
const KAISER_BETA: f64 = 6.0;

/// How a continuous field is made of samples (1.5-8, 9.2-1). In three dimensions every filter is
/// the tensor product of its one-dimensional kernel (1.5-9).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case", deny_unknown_fields))]
pub enum Filter {
    /// Box: the value of the nearest voxel (halfway, of the one with the larger index).
    Nearest,
    /// Tent: trilinear interpolation.
    #[default]
    Linear,
    /// Cubic B-spline, twice continuously differentiable.
    BSpline {
        /// `false`: the voxels are the coefficients, and the field is a smoothed version of them.
        /// `true`: coefficients are computed first ([`spline_coefficients`](crate::spline_coefficients))
        /// so that the field interpolates the voxels.
        prefilter: bool,
    },
    /// The cubics of Mitchell and Netravali. Affine fields are reproduced where `b + 2 c = 1`.
    Bc {
        /// Their B: 0 interpolates, 1 (with `c = 0`) is the B-spline.
        b: f64,
        /// Their C: the strength of the negative lobes.
        c: f64,
    },
    /// Windowed sinc, its weights normalised to sum 1.
    Sinc {
        /// What brings the kernel to zero at `half_width`.
        window: SincWindow,
        /// Support on either side of a sample point in voxels, 2 to [`MAX_HALF_WIDTH`].
        half_width: u8,
    },
}

/// The window of a [`Filter::Sinc`], over `x = t / half_width` in `[-1, 1]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case", deny_unknown_fields))]
pub enum SincWindow {
    /// The main lobe of a sinc.
    #[default]
    Lanczos,
    /// `1/2 + 1/2 cos(pi x)`.
    Hann,
    /// `0.42 + 0.5 cos(pi x) + 0.08 cos(2 pi x)`.
    Blackman,
    /// `I0(6 sqrt(1 - x^2)) / I0(6)`.
    Kaiser,
}

impl Filter {
    /// Interpolating cubic, once continuously differentiable, with overshoots (9.2-6).
    pub const CATMULL_ROM: Self = Self::Bc { b: 0.0, c: 0.5 };
    /// Mitchell and Netravali's recommended compromise of blur and ringing.
    pub const MITCHELL: Self = Self::Bc { b: 1.0 / 3.0, c: 1.0 / 3.0 };

    /// Checks the parameters.
    ///
    /// # Errors
    /// [`FieldError::Parameter`] if `b` or `c` is not finite or a sinc is too narrow or too wide.
    pub fn validate(&self) -> Result<(), FieldError> {
        match *self {
            Self::Bc { b, c } if !(b.is_finite() && c.is_finite()) => {
                let found = if b.is_finite() { c } else { b };
                Err(FieldError::Parameter { name: "cubic filter parameter", found, expected: "b and c must be finite" })
            }
            Self::Sinc { half_width, .. } if !(2..=MAX_HALF_WIDTH).contains(&half_width) => {
                let expected = "a windowed sinc has a half width of 2 to 8 voxels";
                Err(FieldError::Parameter { name: "sinc half width", found: half_width.into(), expected })
            }
            _ => Ok(()),
        }
    }

    /// Half width m of the support in voxels: a sample between voxels 0 and 1 is made of the `2 m`
    /// voxels `1 - m ..= m` (9.2-4).
    pub fn half_width(&self) -> usize {
        match *self {
            Self::Nearest | Self::Linear => 1,
            Self::BSpline { .. } | Self::Bc { .. } => 2,
            Self::Sinc { half_width, .. } => half_width.clamp(2, MAX_HALF_WIDTH).into(),
        }
    }

    /// Whether the field passes through the voxels: exactly, or for a prefiltered B-spline up to
    /// the rounding of its `f32` coefficients.
    pub fn is_interpolating(&self) -> bool {
        match *self {
            Self::Nearest | Self::Linear | Self::Sinc { .. } => true,
            Self::BSpline { prefilter } => prefilter,
            Self::Bc { b, .. } => b == 0.0,
        }
    }

    /// Whether a sample always lies within the range of the voxels of its support, because no
    /// weight is ever negative. A prefiltered B-spline overshoots and is not positive.
    pub fn is_positive(&self) -> bool {
        match *self {
            Self::Nearest | Self::Linear => true,
            Self::BSpline { prefilter } => !prefilter,
            Self::Bc { b, c } => c == 0.0 && (0.0..=3.0).contains(&b),
            Self::Sinc { .. } => false,
        }
    }

    /// The kernel h(t), t in voxels; a windowed sinc before its normalisation.
    pub fn kernel(&self, t: f64) -> f64 {
        match *self {
            Self::Nearest => f64::from((-0.5..0.5).contains(&t)),
            Self::Linear => (1.0 - t.abs()).max(0.0),
            Self::BSpline { .. } => Cubic::BSPLINE.kernel(t),
            Self::Bc { b, c } => Cubic { b, c }.kernel(t),
            Self::Sinc { window, .. } => {
                let x = t / self.half_width() as f64;
                if x.abs() < 1.0 { sinc(t) * window.at(x) } else { 0.0 }
            }
        }
    }

    /// How far a sample may lie beyond the range of the numbers it weighs (voxels, or a prefiltered
    /// B-spline's coefficients), in shares of that range: 0 if no weight is negative. Weights that sum
    /// to 1, and their magnitudes to L along each axis, leave the middle of the range by no more than
    /// L^3 halves of it.
    pub fn overshoot(&self) -> f64 {
        const PARTS: u32 = 256;
        if self.is_positive() {
            return 0.0;
        }
        let magnitude = |i: u32| self.weights(f64::from(i) / f64::from(PARTS)).iter().map(|w| w.abs()).sum::<f64>();
        let largest = (0..PARTS).map(magnitude).fold(1.0, f64::max);
        // The largest sum may lie between the parts.
        1.001 * 0.5 * (largest.powi(3) - 1.0)
    }

    /// Weights of the voxels `1 - m ..= m` for a sample at fraction `u` in `[0, 1)` of the way from
    /// voxel 0 to voxel 1. They sum to 1; at `u = 0` an interpolating filter has exactly one that
    /// is not zero.
    pub fn weights(&self, u: f64) -> Weights {
        let taps = 2 * self.half_width();
        let mut values = [0.0; 2 * MAX_HALF_WIDTH as usize];
        match self.cubic() {
            Some(cubic) => values[..4].copy_from_slice(&cubic.weights(u)),
            None => {
                let first = 1.0 - self.half_width() as f64;
                for (i, value) in values[..taps].iter_mut().enumerate() {
                    *value = self.kernel(u - (first + i as f64));
                }
                let sum: f64 = values[..taps].iter().sum();
                values[..taps].iter_mut().for_each(|value| *value /= sum);
            }
        }
        Weights { values, taps }
    }

    /// The four-tap polynomial of a cubic filter.
    pub(crate) fn cubic(&self) -> Option<Cubic> {
        match *self {
            Self::BSpline { .. } => Some(Cubic::BSPLINE),
            Self::Bc { b, c } => Some(Cubic { b, c }),
            _ => None,
        }
    }
}

impl SincWindow {
    fn at(self, x: f64) -> f64 {
        match self {
            Self::Lanczos => sinc(x),
            Self::Hann => 0.5 + 0.5 * (PI * x).cos(),
            Self::Blackman => 0.42 + 0.5 * (PI * x).cos() + 0.08 * (2.0 * PI * x).cos(),
            Self::Kaiser => bessel_i0(KAISER_BETA * (1.0 - x * x).max(0.0).sqrt()) / bessel_i0(KAISER_BETA),
        }
    }
}

/// Up to 16 weights, read as a slice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    values: [f64; 2 * MAX_HALF_WIDTH as usize],
    taps: usize,
}

impl Weights {
    /// The weights followed by zeros.
    pub(crate) fn padded(&self) -> [f64; 2 * MAX_HALF_WIDTH as usize] {
        self.values
    }
}

impl Deref for Weights {
    type Target = [f64];
    fn deref(&self) -> &[f64] {
        &self.values[..self.taps]
    }
}

/// A cubic of the Mitchell-Netravali family.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cubic {
    b: f64,
    c: f64,
}

impl Cubic {
    pub(crate) const BSPLINE: Self = Self { b: 1.0, c: 0.0 };

    /// The kernel for |t| = `t` in `[0, 1]`.
    #[inline(always)]
    fn inner(self, t: f64) -> f64 {
        let (b, c) = (self.b, self.c);
        ((2.0 - 1.5 * b - c) * t + (2.0 * b + c - 3.0)) * t * t + (1.0 - b / 3.0)
    }

    /// The kernel for |t| = 2 - `s` in `[1, 2]`.
    #[inline(always)]
    fn outer(self, s: f64) -> f64 {
        ((self.b / 6.0 + self.c) * s - self.c) * s * s
    }

    fn kernel(self, t: f64) -> f64 {
        match t.abs() {
            t if t < 1.0 => self.inner(t),
            t if t < 2.0 => self.outer(2.0 - t),
            _ => 0.0,
        }
    }

    /// Weights of voxels -1, 0, 1, 2. The third is what the others leave, so that the sum is 1
    /// and an interpolating cubic is exact at `u = 0` whatever its rounding errors.
    #[inline(always)]
    pub(crate) fn weights(self, u: f64) -> [f64; 4] {
        let (w, x, z) = (self.outer(1.0 - u), self.inner(u), self.outer(u));
        [w, x, 1.0 - (w + x + z), z]
    }
}

/// Weights of voxels -1, 0, 1, 2 for the cubic B-spline at fraction `u` in `[0, 1)` (9.2-6).
#[inline(always)]
pub fn bspline_weights(u: f64) -> [f64; 4] {
    Cubic::BSPLINE.weights(u)
}

/// Weights for the first derivative of the cubic B-spline, per voxel (9.2-11).
#[inline(always)]
pub fn bspline_derivative_weights(u: f64) -> [f64; 4] {
    let v = 1.0 - u;
    [-0.5 * v * v, (1.5 * u - 2.0) * u, (1.0 - 1.5 * u) * u + 0.5, 0.5 * u * u]
}

/// Weights for the second derivative of the cubic B-spline, per voxel squared (9.2-12).
#[inline(always)]
pub fn bspline_second_derivative_weights(u: f64) -> [f64; 4] {
    [1.0 - u, 3.0 * u - 2.0, 1.0 - 3.0 * u, u]
}

/// `sin(pi t) / (pi t)`, exactly 0 at integers so that a windowed sinc interpolates (the form
/// without pi in Eq. 4.1 does not, 1.5-6).
fn sinc(t: f64) -> f64 {
    if t == 0.0 {
        1.0
    } else if t == t.trunc() {
        0.0
    } else {
        (PI * t).sin() / (PI * t)
    }
}

/// Modified Bessel function of the first kind and order 0, by its power series.
fn bessel_i0(x: f64) -> f64 {
    let quarter = 0.25 * x * x;
    let mut term = 1.0;
    let mut sum = 1.0;
    for k in 1..40 {
        term *= quarter / f64::from(k * k);
        sum += term;
    }
    sum
}
