//! The weights of separable sums over voxels, in lanes.

use pellucid_field::Kernel;

use crate::lanes::*;

/// The most voxels along an axis of a sum on lanes: the widest sinc, and the widest Gaussian over
/// a trilinear field. Wider combinations are asked in f64.
pub const MOST_TAPS: usize = 20;

/// The weight of a voxel of a kernel, for `v = u - 1/2`.
#[inline(always)]
pub fn weight<S: Lanes>(s: S, kernel: &Kernel, tap: usize, v: F32<S>) -> F32<S> {
    let coefficients = kernel.polynomial(tap);
    let mut weight = splat(s, coefficients[kernel.degree()]);
    for power in (0..kernel.degree()).rev() {
        weight = weight.mul_add(v, splat(s, coefficients[power]));
    }
    weight
}
