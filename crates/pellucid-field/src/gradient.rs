//! Gradients of a field from samples one voxel apart, or from the cubic B-spline of its voxels
//! (5.3).

use glam::{DMat3, DVec3};

use crate::filter::{bspline_derivative_weights, bspline_second_derivative_weights, bspline_weights};
use crate::{FieldError, Grid};

/// How a gradient is estimated. All stencils are normalised to be exact on affine fields.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case", deny_unknown_fields))]
pub enum Gradient {
    /// `f(x + 1) - f(x)`: 3 taps, first order (5.3-2).
    Forward,
    /// `f(x) - f(x - 1)`: 3 taps, first order (5.3-3).
    Backward,
    /// `(f(x + 1) - f(x - 1)) / 2`: 6 taps, second order (5.3-4).
    #[default]
    Central,
    /// 3x3x3 with 1-2-1 smoothing: 26 taps (5.3-7).
    Sobel,
    /// 3x3x3 with 3-10-3 smoothing, the most isotropic: 26 taps (5.3-8).
    SobelIsotropic,
    /// 3x3x3 with 1-1-1 smoothing: 26 taps (5.3-9).
    Prewitt,
    /// Derivative of a Gaussian, cut off at 3 sigma: 124 taps and more (5.3-10).
    Gaussian {
        /// Standard deviation in voxels, 0.25 to 3.
        sigma: f64,
    },
    /// Derivative of the cubic B-spline of the 4x4x4 voxels around the position, continuous
    /// everywhere (5.3-11); [`Gradient::Central`] where some of them are absent or over the border.
    BSpline,
}

const SIGMA: std::ops::RangeInclusive<f64> = 0.25..=3.0;
/// Half width of the widest stencil: three times the largest sigma.
const MAX_RADIUS: usize = 9;

impl Gradient {
    /// The estimator as weights of samples one index step apart: smoothing across an axis and
    /// derivative along it, both from `-r` to `r` with the same r, so that a gradient's x is the sum of
    /// `derivative(i) smoothing(j) smoothing(k) f(x + i, y + j, z + k)` wherever all of these exist
    /// (5.3-6). `None` for [`Gradient::BSpline`], whose weights depend on the position.
    pub fn stencil(&self) -> Option<[Vec<f64>; 2]> {
        let differences = |derivative: [f64; 3]| Some([vec![0.0, 1.0, 0.0], derivative.to_vec()]);
        let separable = |stencil: Stencil| {
            let offsets = -(stencil.radius as i32)..=stencil.radius as i32;
            let smoothing = offsets.clone().map(|o| stencil.smoothing[o.unsigned_abs() as usize]).collect();
            Some([smoothing, offsets.map(|o| stencil.derivative(o)).collect()])
        };
        match *self {
            Self::Forward => differences([0.0, -1.0, 1.0]),
            Self::Backward => differences([-1.0, 1.0, 0.0]),
            Self::Central => differences([-0.5, 0.0, 0.5]),
            Self::Sobel => separable(Stencil::three([2.0, 1.0])),
            Self::SobelIsotropic => separable(Stencil::three([10.0, 3.0])),
            Self::Prewitt => separable(Stencil::three([1.0, 1.0])),
            Self::Gaussian { sigma } => separable(Stencil::gaussian(sigma)),
            Self::BSpline => None,
        }
    }

    /// Checks the parameters.
    ///
    /// # Errors
    /// [`FieldError::Parameter`] if sigma is out of range; [`index_gradient`] would limit it.
    pub fn validate(&self) -> Result<(), FieldError> {
        match *self {
            Self::Gaussian { sigma } if !SIGMA.contains(&sigma) => {
                let expected = "must be 0.25 to 3 voxels";
                Err(FieldError::Parameter { name: "gradient sigma", found: sigma, expected })
            }
            _ => Ok(()),
        }
    }
}

/// The gradient of `field` at `p` per index step, with `center` the field's value there.
///
/// `field` gives NaN where the data are absent, clipped away or outside. Such a tap is the point
/// reflection of its opposite through the centre, `f(p - o) := 2 f(p) - f(p + o)`, so that a
/// central difference becomes one-sided and affine fields stay exact; if both are absent there is
/// no difference between them. Without a finite `center` the gradient is zero.
///
/// [`Gradient::BSpline`] samples `field` at the 64 voxels around `p` and so wants one that
/// interpolates them; without clipping, [`Reconstruct::gradient`](crate::Reconstruct::gradient)
/// reads them much faster.
#[inline]
pub fn index_gradient(kind: Gradient, p: DVec3, center: f64, field: impl Fn(DVec3) -> f64) -> DVec3 {
    if !center.is_finite() {
        return DVec3::ZERO;
    }
    let taps = Taps { p, center, field };
    match kind {
        Gradient::Forward => taps.axes(|o| taps.forward(o)),
        Gradient::Backward => taps.axes(|o| -taps.forward(-o)),
        Gradient::Central => taps.axes(|o| 0.5 * taps.difference(o)),
        Gradient::Sobel => taps.separable(&Stencil::three([2.0, 1.0])),
        Gradient::SobelIsotropic => taps.separable(&Stencil::three([10.0, 3.0])),
        Gradient::Prewitt => taps.separable(&Stencil::three([1.0, 1.0])),
        Gradient::Gaussian { sigma } => taps.separable(&Stencil::gaussian(sigma)),
        Gradient::BSpline => match SplineCell::gather(p, &taps.field) {
            Some(cell) => cell.gradient(),
            None => taps.axes(|o| 0.5 * taps.difference(o)),
        },
    }
}

/// A gradient per world unit from one per index step (5.3, 2.2-1).
pub fn world_gradient(grid: &Grid, index_gradient: DVec3) -> DVec3 {
    grid.world_from_index_gradient() * index_gradient
}

/// The unit normal of the isosurface through a point, towards larger values; zero where the
/// gradient is shorter than `eps` (in its own unit) or not finite, so that illumination vanishes
/// there (5.3-1).
pub fn normal(gradient: DVec3, eps: f64) -> DVec3 {
    let length = gradient.length();
    let usable = length.is_finite() && length >= eps && length > 0.0;
    if usable { gradient / length } else { DVec3::ZERO }
}

struct Taps<F> {
    p: DVec3,
    center: f64,
    field: F,
}

impl<F: Fn(DVec3) -> f64> Taps<F> {
    #[inline(always)]
    fn axes(&self, along: impl Fn(DVec3) -> f64) -> DVec3 {
        DVec3::new(along(DVec3::X), along(DVec3::Y), along(DVec3::Z))
    }

    /// f(p + o) - f(p), where f(p + o) may be the reflection of f(p - o).
    #[inline(always)]
    fn forward(&self, offset: DVec3) -> f64 {
        let right = (self.field)(self.p + offset);
        if right.is_finite() {
            return right - self.center;
        }
        let left = (self.field)(self.p - offset);
        if left.is_finite() { self.center - left } else { 0.0 }
    }

    /// f(p + o) - f(p - o), where either may be the reflection of the other.
    #[inline(always)]
    fn difference(&self, offset: DVec3) -> f64 {
        let (right, left) = ((self.field)(self.p + offset), (self.field)(self.p - offset));
        match (right.is_finite(), left.is_finite()) {
            (true, true) => right - left,
            (true, false) => 2.0 * (right - self.center),
            (false, true) => 2.0 * (self.center - left),
            (false, false) => 0.0,
        }
    }

    /// A separable stencil as a sum over pairs of opposite taps.
    fn separable(&self, stencil: &Stencil) -> DVec3 {
        let r = stencil.radius as i32;
        let mut sum = DVec3::ZERO;
        for z in 0..=r {
            for y in if z == 0 { 0 } else { -r }..=r {
                for x in if z == 0 && y == 0 { 1 } else { -r }..=r {
                    let offset = [x, y, z];
                    let [sx, sy, sz] = offset.map(|o| stencil.smoothing[o.unsigned_abs() as usize]);
                    let [dx, dy, dz] = offset.map(|o| stencil.derivative(o));
                    let weights = DVec3::new(dx * sy * sz, sx * dy * sz, sx * sy * dz);
                    sum += weights * self.difference(DVec3::from_array(offset.map(f64::from)));
                }
            }
        }
        sum
    }
}

/// Smoothing across and derivative along an axis, for offsets from 0 to the radius; one is even,
/// the other odd (5.3-6).
struct Stencil {
    radius: usize,
    smoothing: [f64; MAX_RADIUS + 1],
    derivative: [f64; MAX_RADIUS + 1],
}

impl Stencil {
    /// A central difference smoothed by the weights (side, middle, side) over their sum.
    fn three([middle, side]: [f64; 2]) -> Self {
        Self::normalised(1, |offset| if offset == 0 { middle } else { side })
    }

    fn gaussian(sigma: f64) -> Self {
        let sigma = sigma.max(*SIGMA.start()).min(*SIGMA.end());
        let radius = ((3.0 * sigma).ceil() as usize).max(2);
        Self::normalised(radius, |offset| (-0.5 * (offset as f64 / sigma).powi(2)).exp())
    }

    /// From a bell g: g over its sum, and `o g(o)`, a sampled derivative up to its scale, over the
    /// slope it finds in a ramp. What the cut-off took away is thereby made good.
    fn normalised(radius: usize, bell: impl Fn(usize) -> f64) -> Self {
        let mut stencil = Self { radius, smoothing: [0.0; MAX_RADIUS + 1], derivative: [0.0; MAX_RADIUS + 1] };
        let (mut sum, mut slope) = (bell(0), 0.0);
        for offset in 1..=radius {
            let o = offset as f64;
            sum += 2.0 * bell(offset);
            slope += 2.0 * o * o * bell(offset);
        }
        for offset in 0..=radius {
            stencil.smoothing[offset] = bell(offset) / sum;
            stencil.derivative[offset] = offset as f64 * bell(offset) / slope;
        }
        stencil
    }

    fn derivative(&self, offset: i32) -> f64 {
        f64::from(offset.signum()) * self.derivative[offset.unsigned_abs() as usize]
    }
}

/// The 4x4x4 voxels around a position, as coefficients of a cubic B-spline with derivatives
/// (9.2-11, 9.2-12).
#[derive(Clone, Debug, PartialEq)]
pub struct SplineCell {
    voxels: [f64; 64],
    u: DVec3,
}

impl SplineCell {
    /// The voxels -1 to 2 of the cell that `p` is in, x fastest; `voxel` gives the value at an
    /// integer index position. `None` if any is not finite.
    #[inline]
    pub fn gather(p: DVec3, voxel: impl Fn(DVec3) -> f64) -> Option<Self> {
        let cell = p.floor();
        let mut voxels = [0.0; 64];
        for (i, value) in voxels.iter_mut().enumerate() {
            let offset = DVec3::new((i & 3) as f64, (i >> 2 & 3) as f64, (i >> 4) as f64);
            *value = voxel(cell - 1.0 + offset);
            if !value.is_finite() {
                return None;
            }
        }
        Some(Self { voxels, u: p - cell })
    }

    /// The gradient per index step.
    pub fn gradient(&self) -> DVec3 {
        DVec3::new(self.derivative([1, 0, 0]), self.derivative([0, 1, 0]), self.derivative([0, 0, 1]))
    }

    /// The symmetric matrix of second derivatives per index step squared.
    pub fn hessian(&self) -> DMat3 {
        let [xx, yy, zz] = [[2, 0, 0], [0, 2, 0], [0, 0, 2]].map(|order| self.derivative(order));
        let [xy, yz, zx] = [[1, 1, 0], [0, 1, 1], [1, 0, 1]].map(|order| self.derivative(order));
        DMat3::from_cols(DVec3::new(xx, xy, zx), DVec3::new(xy, yy, yz), DVec3::new(zx, yz, zz))
    }

    /// The partial derivative of the given order, 0 to 2, along each axis, not 0 along all. Its
    /// weights cancel, so it is taken of the differences to one voxel: rounding then leaves no slope,
    /// and no direction, in a flat field.
    #[inline(always)]
    fn derivative(&self, order: [usize; 3]) -> f64 {
        let middle = self.voxels[21];
        let [x, y, z]: [[f64; 4]; 3] = std::array::from_fn(|axis| match order[axis] {
            0 => bspline_weights(self.u[axis]),
            1 => bspline_derivative_weights(self.u[axis]),
            _ => bspline_second_derivative_weights(self.u[axis]),
        });
        let mut sum = 0.0;
        for (row, voxels) in self.voxels.as_chunks::<4>().0.iter().enumerate() {
            let along: f64 = (0..4).map(|i| x[i] * (voxels[i] - middle)).sum();
            sum += y[row & 3] * z[row >> 2] * along;
        }
        sum
    }
}
