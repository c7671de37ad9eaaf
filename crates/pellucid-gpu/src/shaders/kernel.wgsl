// Weights of voxels around a position, for filters and gradients but the usual ones (1.5-9, 5.3-6):
// products of one per axis, polynomials of the place between two voxels, as `kernel.rs` of
// `pellucid-field` makes them. `kernels.rs` has the same structure.
#define_import_path pellucid::kernel

struct Kernels {
    // Voxels along an axis of the filter's sum, 0 for the nearest voxel alone; of the gradient's sums;
    // radius of the gradient's stencil; first row of the gradient's weights.
    taps: vec4<u32>,
    // 1 if the gradient is of a B-spline; if it is the one at the nearest voxel; if polynomials have
    // more than four coefficients.
    flags: vec4<u32>,
    // Data value of a voxel that is classified = stored * x + y.
    classified: vec4<f32>,
    // Weights of samples one voxel apart: smoothing across an axis, derivative along it.
    stencil: array<vec4<f32>, 19>,
    // Four for every weight, the lowest power first: the filter's, then the gradient's across an axis,
    // then along it.
    polynomials: array<vec4<f32>, 336>,
}

#ifdef STORED_CONSTANTS
@group(1) @binding(3) var<storage, read> kernels: Kernels;
#else
@group(1) @binding(3) var<uniform> kernels: Kernels;
#endif

// The most taps of a filter, in fours, and of a gradient.
const MOST_FOURS: u32 = 4u;
const MOST_GRADIENT_TAPS: u32 = 34u;

// The weight with a number, for `v = u - 1/2`.
fn weight(number: u32, v: f32) -> f32 {
    let low = kernels.polynomials[4u * number];
    var high = 0.0;
    if kernels.flags.z != 0u {
        let b = kernels.polynomials[4u * number + 1u];
        let c = kernels.polynomials[4u * number + 2u];
        let d = kernels.polynomials[4u * number + 3u];
        high = c.x + v * (c.y + v * (c.z + v * (c.w + v * d.x)));
        high = b.x + v * (b.y + v * (b.z + v * (b.w + v * high)));
    }
    return low.x + v * (low.y + v * (low.z + v * (low.w + v * high)));
}
