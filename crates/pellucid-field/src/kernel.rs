//! The weights of separable sums over voxels, as polynomials of the position between two voxels.
//!
//! Every filter but the nearest voxel, and every gradient estimator, is a sum over a cube of voxels
//! whose weights are a product of three weights, one per axis (1.5-9, 5.3-6). Those of the tent and
//! of the cubics are cubic polynomials of the fraction u between two voxels; those of a windowed sinc
//! are close enough to polynomials of a higher degree. A difference of samples is the filter's sum
//! under weights shifted by whole voxels, so it is of the same form.

use std::f64::consts::PI;

use crate::{Filter, Gradient, bspline_derivative_weights, bspline_weights};

/// Highest degree of a polynomial.
const HIGHEST: usize = 12;

/// Weights of an even number of voxels in a row around a position, the middle two of which are its
/// neighbours.
#[derive(Clone, Debug, PartialEq)]
pub struct Kernel {
    degree: usize,
    /// For every voxel, of `u - 1/2`, the lowest power first.
    coefficients: Vec<[f32; Kernel::COEFFICIENTS]>,
}

impl Kernel {
    /// How many coefficients a polynomial is given by.
    pub const COEFFICIENTS: usize = HIGHEST + 1;

    /// The kernel of a filter; `None` for [`Filter::Nearest`], which has none that is continuous.
    pub fn of_filter(filter: Filter) -> Option<Self> {
        (filter != Filter::Nearest).then(|| Self::fit(degree(filter), |u| filter.weights(u).to_vec()))
    }

    /// Smoothing across and derivative along an axis for a gradient of a field under a filter, per
    /// index step. The field of nearest voxels is that of a tent at rounded positions.
    pub fn of_gradient(filter: Filter, gradient: Gradient) -> [Self; 2] {
        let Some(stencil) = gradient.stencil() else {
            let cubic = |weights: fn(f64) -> [f64; 4]| Self::fit(3, |u| weights(u).to_vec());
            return [cubic(bspline_weights), cubic(bspline_derivative_weights)];
        };
        let filter = if filter == Filter::Nearest { Filter::Linear } else { filter };
        stencil.map(|stencil| Self::fit(degree(filter), |u| convolution(&filter.weights(u), &stencil)))
    }

    /// How many voxels it takes of a row.
    #[inline(always)]
    pub fn taps(&self) -> usize {
        self.coefficients.len()
    }

    /// The degree of its polynomials: 3, or 9 to 12 for windowed sincs.
    #[inline(always)]
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// The polynomial that is a voxel's weight: coefficients of `v = u - 1/2`, the lowest power first,
    /// zeros beyond the [degree](Kernel::degree).
    ///
    /// # Panics
    /// If there are not so many taps.
    #[inline(always)]
    pub fn polynomial(&self, tap: usize) -> &[f32; Self::COEFFICIENTS] {
        &self.coefficients[tap]
    }

    /// The polynomials of a degree that are `weights` at the Chebyshev nodes of `[0, 1]`.
    fn fit(degree: usize, weights: impl Fn(f64) -> Vec<f64>) -> Self {
        let count = degree + 1;
        let nodes: Vec<f64> = (0..count).map(|k| 0.5 * (PI * (k as f64 + 0.5) / count as f64).cos()).collect();
        let values: Vec<Vec<f64>> = nodes.iter().map(|v| weights(v + 0.5)).collect();
        let taps = values[0].len();
        let polynomial = |tap: usize| {
            let found = interpolation(&nodes, values.iter().map(|row| row[tap]).collect());
            std::array::from_fn(|power| found.get(power).map_or(0.0, |&c| c as f32))
        };
        Self { degree, coefficients: (0..taps).map(polynomial).collect() }
    }
}

/// The degree of a filter's polynomials. Interpolated at Chebyshev nodes and rounded to `f32`, those
/// of windowed sincs are off by 8e-7 at most; the narrowest windows bend most and need the highest.
fn degree(filter: Filter) -> usize {
    match filter {
        Filter::Sinc { half_width: 2, .. } => HIGHEST,
        Filter::Sinc { .. } => 9,
        _ => 3,
    }
}

/// Weights of voxels, from those of samples around a position and those of voxels around a sample.
fn convolution(filter: &[f64], stencil: &[f64]) -> Vec<f64> {
    let mut sum = vec![0.0; filter.len() + stencil.len() - 1];
    for (i, a) in filter.iter().enumerate() {
        for (j, b) in stencil.iter().enumerate() {
            sum[i + j] += a * b;
        }
    }
    sum
}

/// Coefficients of the polynomial through values at nodes, the lowest power first (Newton).
fn interpolation(nodes: &[f64], mut values: Vec<f64>) -> Vec<f64> {
    let count = nodes.len();
    for order in 1..count {
        for i in (order..count).rev() {
            values[i] = (values[i] - values[i - 1]) / (nodes[i] - nodes[i - order]);
        }
    }
    let mut polynomial = vec![0.0; count];
    for i in (0..count).rev() {
        // The polynomial so far times (v - node), plus the next difference.
        for power in (1..count).rev() {
            polynomial[power] = polynomial[power - 1] - nodes[i] * polynomial[power];
        }
        polynomial[0] = values[i] - nodes[i] * polynomial[0];
    }
    polynomial
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SincWindow;

    impl Kernel {
        fn at(&self, u: f64) -> Vec<f64> {
            let power = |(i, &c): (usize, &f32)| f64::from(c) * (u - 0.5).powi(i as i32);
            self.coefficients.iter().map(|c| c.iter().enumerate().map(power).sum()).collect()
        }
    }

    #[test]
    fn polynomials_are_the_filters() {
        let windows = [SincWindow::Lanczos, SincWindow::Hann, SincWindow::Blackman, SincWindow::Kaiser];
        let sincs =
            windows.into_iter().flat_map(|window| [2, 3, 5, 8].map(|half_width| Filter::Sinc { window, half_width }));
        let cubics = [Filter::CATMULL_ROM, Filter::MITCHELL, Filter::BSpline { prefilter: false }, Filter::Linear];
        for filter in sincs.chain(cubics) {
            let kernel = Kernel::of_filter(filter).unwrap();
            for u in (0..1000).map(|i| f64::from(i) / 1000.0) {
                let worst =
                    kernel.at(u).iter().zip(&*filter.weights(u)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(worst < 8e-7, "{filter:?} at {u}: {worst}");
            }
        }
    }

    /// What a derivative is of: flat fields have none, a ramp has its slope.
    #[test]
    fn derivatives_of_ramps_are_slopes() {
        let gaussian = Gradient::Gaussian { sigma: 1.3 };
        for gradient in [Gradient::Forward, Gradient::Backward, Gradient::Prewitt, gaussian, Gradient::BSpline] {
            for filter in [Filter::Nearest, Filter::Linear, Filter::CATMULL_ROM] {
                let kernels = Kernel::of_gradient(filter, gradient);
                for u in [0.0, 0.3, 0.9] {
                    let [smoothing, derivative] = [0, 1].map(|i| kernels[i].at(u));
                    let moment: f64 = derivative.iter().enumerate().map(|(i, w)| w * i as f64).sum();
                    let sums = [&smoothing, &derivative].map(|w| w.iter().sum::<f64>());
                    let close = [sums[0] - 1.0, sums[1], moment - 1.0].iter().all(|e| e.abs() < 1e-6);
                    assert!(close, "{filter:?} {gradient:?} at {u}: {sums:?} {moment}");
                }
            }
        }
    }
}
