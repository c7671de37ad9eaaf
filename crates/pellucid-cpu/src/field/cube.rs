//! Sums over cubes of voxels under separable weights, for all lanes at once.

use pellucid_field::{ComponentView, Kernel};

use super::Texel;
use super::kernel::{MOST_TAPS, weight};
use crate::lanes::*;

/// The voxels of type `T` of a volume with at least 4 of them.
pub struct Cubes<'a, T> {
    data: &'a [T],
    dims: [i32; 3],
    /// Distances of neighbours.
    stride: [i32; 3],
}

/// Weights of voxels along an axis.
type Row<S, const MOST: usize> = [F32<S>; MOST];

/// Where a cube of voxels is, of `taps` along each axis, and where in its middle a position.
struct Place<S: Lanes> {
    /// Lowest voxel.
    first: [I32<S>; 3],
    /// Position between the middle voxels, less 1/2.
    v: Vec3<S>,
}

impl<'a, T: Texel> Cubes<'a, T> {
    /// The voxels of a component, or `None` if they cannot be read with vectors: several components
    /// to a voxel, or more voxels than 32-bit offsets reach.
    pub fn new(view: &ComponentView<'a, T>) -> Option<Self> {
        let (dims, stride, data) = (view.dims(), view.stride(), view.data());
        let reachable = (4..i32::MAX as usize).contains(&data.len()) && dims.iter().product::<usize>() == data.len();
        (stride[0] == 1 && reachable).then(|| Self {
            data,
            dims: dims.map(|n| n as i32),
            stride: stride.map(|n| n as i32),
        })
    }

    /// Whether a cube of so many voxels along each axis fits among them, and on lanes.
    pub fn hold(&self, taps: usize) -> bool {
        (4..=MOST_TAPS).contains(&taps) && self.dims.iter().all(|&n| n >= taps as i32)
    }

    /// Last voxel along an axis.
    #[inline(always)]
    pub fn last(&self, axis: usize) -> f32 {
        (self.dims[axis] - 1) as f32
    }

    /// The voxel nearest to a position; halfway, the one with the larger index.
    #[inline(always)]
    pub fn nearest<S: Lanes>(&self, s: S, p: &Vec3<S>) -> F32<S> {
        let inside = xyz!(I => within(s, p[I], self.last(I)));
        let voxel = xyz!(I => (inside[I] + 0.5).to_int::<I32<S>>().min(whole(s, self.dims[I] - 1)));
        let offset = voxel[0] + voxel[1] * self.stride[1] + voxel[2] * self.stride[2];
        let last = whole(s, self.data.len() as i32 - 2);
        // SAFETY: the voxel is one of the data, and moved to one with another behind it.
        let [a, b] = unsafe { T::pair(s, self.data, offset.min(last), 0, true) };
        offset.simd_gt(last).select(b, a)
    }

    /// The sum under a kernel's weights along all axes. Kernels that reach over the border meet the
    /// border voxel again. Needs [`Cubes::hold`] of the kernel's taps.
    #[inline(always)]
    pub fn sum<S: Lanes>(&self, s: S, p: &Vec3<S>, kernel: &Kernel) -> F32<S> {
        match kernel.taps() {
            4 => self.sum_of::<S, 4>(s, p, kernel, 4),
            taps => self.sum_of::<S, MOST_TAPS>(s, p, kernel, taps),
        }
    }

    #[inline(always)]
    fn sum_of<S: Lanes, const MOST: usize>(&self, s: S, p: &Vec3<S>, kernel: &Kernel, taps: usize) -> F32<S> {
        let zero = splat(s, 0.0);
        let (mut first, mut weights) = ([whole(s, 0); 3], [[zero; MOST]; 3]);
        for axis in 0..3 {
            let inside = within(s, p[axis], self.last(axis));
            let cell = inside.to_int::<I32<S>>();
            let v = inside - cell.to_float::<F32<S>>() - 0.5;
            for tap in 0..taps {
                weights[axis][tap] = weight(s, kernel, tap, v);
            }
            let wanted = cell - (taps as i32 / 2 - 1);
            first[axis] = wanted.max(whole(s, 0)).min(whole(s, self.dims[axis] - taps as i32));
            if !wanted.simd_eq(first[axis]).all_true() {
                self.fold(s, axis, taps, wanted, first[axis], &mut weights[axis]);
            }
        }
        let [mut x, y, z] = weights;
        in_fours(s, taps, &mut x);
        let (offset, middle) = self.start(s, first, taps);
        let mut sum = zero;
        for k in 0..taps {
            let mut slice = zero;
            for j in 0..taps {
                let d = k as i32 * self.stride[2] + j as i32 * self.stride[1];
                let mut row = zero;
                for i in (0..taps).step_by(4) {
                    let voxels = self.four(s, offset, d, i.min(taps - 4), middle);
                    row = along::<S>([x[i], x[i + 1], x[i + 2], x[i + 3]], voxels, row);
                }
                slice = y[j].mul_add(row, slice);
            }
            sum = z[k].mul_add(slice, sum);
        }
        sum + middle
    }

    /// The gradient per index step, in stored numbers, under kernels for across and along an axis, and
    /// where it is one: where no voxel of the sum is beyond the border.
    #[inline(always)]
    pub fn gradient<S: Lanes>(&self, s: S, p: &Vec3<S>, kernels: &[Kernel; 2]) -> Vec3<S> {
        match kernels[0].taps() {
            4 => self.gradient_of::<S, 4>(s, p, kernels, 4),
            taps => self.gradient_of::<S, MOST_TAPS>(s, p, kernels, taps),
        }
    }

    #[inline(always)]
    fn gradient_of<S: Lanes, const MOST: usize>(
        &self,
        s: S,
        p: &Vec3<S>,
        [across, along_axis]: &[Kernel; 2],
        taps: usize,
    ) -> Vec3<S> {
        let Place { first, v } = self.place(s, p, taps);
        let zero = splat(s, 0.0);
        let (mut x, mut y) = ([[zero; MOST]; 2], [[zero; MOST]; 2]);
        for tap in 0..taps {
            (x[0][tap], x[1][tap]) = (weight(s, across, tap, v[0]), weight(s, along_axis, tap, v[0]));
            (y[0][tap], y[1][tap]) = (weight(s, across, tap, v[1]), weight(s, along_axis, tap, v[1]));
        }
        in_fours(s, taps, &mut x[0]);
        in_fours(s, taps, &mut x[1]);
        let (offset, middle) = self.start(s, first, taps);
        let mut gradient = [zero; 3];
        for k in 0..taps {
            let mut slice = [zero; 3];
            for j in 0..taps {
                let d = k as i32 * self.stride[2] + j as i32 * self.stride[1];
                let mut row = [zero; 2];
                for i in (0..taps).step_by(4) {
                    let voxels = self.four(s, offset, d, i.min(taps - 4), middle);
                    row[0] = along::<S>([x[0][i], x[0][i + 1], x[0][i + 2], x[0][i + 3]], voxels, row[0]);
                    row[1] = along::<S>([x[1][i], x[1][i + 1], x[1][i + 2], x[1][i + 3]], voxels, row[1]);
                }
                slice[0] = y[0][j].mul_add(row[1], slice[0]);
                slice[1] = y[1][j].mul_add(row[0], slice[1]);
                slice[2] = y[0][j].mul_add(row[0], slice[2]);
            }
            let (smoothing, derivative) = (weight(s, across, k, v[2]), weight(s, along_axis, k, v[2]));
            gradient[0] = smoothing.mul_add(slice[0], gradient[0]);
            gradient[1] = smoothing.mul_add(slice[1], gradient[1]);
            gradient[2] = derivative.mul_add(slice[2], gradient[2]);
        }
        gradient
    }

    /// Lanes whose position is in the middle of a cube of voxels that all are there.
    #[inline(always)]
    pub fn surround<S: Lanes>(&self, s: S, p: &Vec3<S>, taps: usize) -> Mask<S> {
        let reach = (taps / 2) as f32;
        let within = |axis: usize| (splat(s, reach - 1.0), splat(s, self.last(axis) + 1.0 - reach));
        let [x, y, z] = [within(0), within(1), within(2)];
        p[0].simd_ge(x.0)
            & p[0].simd_le(x.1)
            & p[1].simd_ge(y.0)
            & p[1].simd_le(y.1)
            & p[2].simd_ge(z.0)
            & p[2].simd_le(z.1)
    }

    /// The cube around a position, or the nearest one that is among the voxels.
    #[inline(always)]
    fn place<S: Lanes>(&self, s: S, p: &Vec3<S>, taps: usize) -> Place<S> {
        let before = taps as i32 / 2 - 1;
        let inside = xyz!(I => within(s, p[I], self.last(I)));
        let cell = xyz!(I => {
            let cell = inside[I].to_int::<I32<S>>();
            cell.max(whole(s, before)).min(whole(s, self.dims[I] - 1 - taps as i32 / 2))
        });
        let v = xyz!(I => inside[I] - cell[I].to_float::<F32<S>>() - 0.5);
        Place { first: xyz!(I => cell[I] - before), v }
    }

    /// Adds up the weights of voxels over the border at the border voxel: from those that start at
    /// `wanted` to those that start at `first`.
    #[inline(always)]
    fn fold<S: Lanes, const MOST: usize>(
        &self,
        s: S,
        axis: usize,
        taps: usize,
        wanted: I32<S>,
        first: I32<S>,
        weights: &mut Row<S, MOST>,
    ) {
        let mut folded = [splat(s, 0.0); MOST];
        for (tap, &weight) in weights[..taps].iter().enumerate() {
            let voxel = (wanted + tap as i32).max(whole(s, 0)).min(whole(s, self.dims[axis] - 1)) - first;
            for (place, sum) in folded[..taps].iter_mut().enumerate() {
                *sum = voxel.simd_eq(whole(s, place as i32)).select(*sum + weight, *sum);
            }
        }
        *weights = folded;
    }

    /// The place in the data of a cube's first voxel, and the one in its middle. Sums are of
    /// differences to that one, so that a flat field stays flat to the bit.
    #[inline(always)]
    fn start<S: Lanes>(&self, s: S, first: [I32<S>; 3], taps: usize) -> (I32<S>, F32<S>) {
        let offset = first[0] + first[1] * self.stride[1] + first[2] * self.stride[2];
        let before = taps as i32 / 2 - 1;
        let d = before * (self.stride[1] + self.stride[2]);
        (offset, self.four(s, offset, d, before as usize - 1, splat(s, 0.0))[1])
    }

    /// Four voxels of a row of a cube, `d` voxels from its first, less a number.
    #[inline(always)]
    fn four<S: Lanes>(&self, s: S, offset: I32<S>, d: i32, i: usize, less: F32<S>) -> [F32<S>; 4] {
        // SAFETY: cubes are limited to the voxels there are, and the four are of one row.
        let quad = unsafe { T::quad(s, self.data, offset, d + i as i32 + 1, false) };
        let voxels = T::numbers(s, &quad);
        rgba!(N => voxels[N] - less)
    }
}

/// Adds four voxels under their weights.
#[inline(always)]
fn along<S: Lanes>(weights: [F32<S>; 4], voxels: [F32<S>; 4], sum: F32<S>) -> F32<S> {
    let [a, b, c, d] = rgba!(N => weights[N]);
    d.mul_add(voxels[3], c.mul_add(voxels[2], b.mul_add(voxels[1], a.mul_add(voxels[0], sum))))
}

/// Rows are read four voxels at a time; the last four of 6, 10, ... begin with two that were read
/// before.
#[inline(always)]
fn in_fours<S: Lanes, const MOST: usize>(s: S, taps: usize, weights: &mut Row<S, MOST>) {
    if taps % 4 == 2 {
        (weights[taps], weights[taps + 1]) = (weights[taps - 2], weights[taps - 1]);
        (weights[taps - 2], weights[taps - 1]) = (splat(s, 0.0), splat(s, 0.0));
    }
}
