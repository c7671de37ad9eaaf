//! Trilinear interpolation and its central differences, for all lanes at once (1.5-10, 5.3-4).

use pellucid_field::{ComponentView, Gradient, Linear};

use super::general::{gradient_of_each, value_of_each};
use super::taps::Bounds;
use super::{Field, Probe, Texel};
use crate::lanes::*;

/// A volume of voxels of type `T` under the trilinear filter.
///
/// Lanes that meet an absent voxel are asked again one by one.
pub struct Trilinear<'a, T> {
    data: &'a [T],
    /// Offsets of neighbours along y and z.
    stride: [i32; 2],
    /// The last position along each axis that lies in a cell, just below the last voxel.
    last: [f32; 3],
    /// Cells along each axis, less one.
    last_cell: [i32; 3],
    scale: f32,
    offset: f32,
    bounds: Bounds,
    central: bool,
    world_from_index_gradient: [[f32; 3]; 3],
    exact: Probe<'a, Linear<'a, T>>,
}

/// Where positions lie among the voxels.
struct Cell<S: Lanes> {
    /// Lowest voxel of the cell.
    voxel: [I32<S>; 3],
    /// Its place in the data.
    offset: I32<S>,
    /// Position within the cell.
    u: Vec3<S>,
}

impl<'a, T: Texel> Trilinear<'a, T> {
    /// The field of a component, or `None` if it cannot be read with vectors: several components
    /// to a voxel, an axis without cells, or more voxels than 32-bit offsets reach.
    pub fn new(
        view: ComponentView<'a, T>,
        bounds: Bounds,
        gradient: Gradient,
        exact: Probe<'a, Linear<'a, T>>,
    ) -> Option<Self> {
        let (dims, stride, data) = (view.dims(), view.stride(), view.data());
        let fits = data.len() < i32::MAX as usize && dims.iter().product::<usize>() == data.len();
        if stride[0] != 1 || !fits || dims.iter().any(|&n| n < 2) {
            return None;
        }
        let map = view.value_map();
        let matrix = exact.world_from_index_gradient().as_mat3().transpose();
        Some(Self {
            data,
            stride: [stride[1] as i32, stride[2] as i32],
            last: dims.map(|n| ((n - 1) as f32).next_down()),
            last_cell: dims.map(|n| n as i32 - 2),
            scale: map.scale as f32,
            offset: map.offset as f32,
            bounds,
            central: gradient == Gradient::Central,
            world_from_index_gradient: matrix.to_cols_array_2d(),
            exact,
        })
    }

    #[inline(always)]
    fn locate<S: Lanes>(&self, s: S, p: &Vec3<S>) -> Cell<S> {
        // Both limits hold whatever the position: every offset made of these voxels is in the data.
        let inside = xyz!(I => p[I].max(splat(s, 0.0)).min(splat(s, self.last[I])));
        let voxel = xyz!(I => inside[I].to_int::<I32<S>>());
        let u = xyz!(I => inside[I] - voxel[I].to_float::<F32<S>>());
        let offset = voxel[0] + voxel[1] * self.stride[0] + voxel[2] * self.stride[1];
        Cell { voxel, offset, u }
    }

    /// Whether any of these places has fewer than `behind` voxels behind it.
    #[inline(always)]
    fn at_end<S: Lanes>(&self, s: S, offset: I32<S>, behind: usize) -> bool {
        let last = self.data.len() as i64 - 1 - behind as i64;
        offset.simd_gt(whole(s, last as i32)).any_true()
    }

    /// Two neighbours along x, `d` voxels from a place, interpolated.
    ///
    /// # Safety
    /// As [`Texel::pair`].
    #[inline(always)]
    unsafe fn row<S: Lanes>(&self, s: S, offset: I32<S>, d: i32, u: F32<S>, at_end: bool) -> F32<S> {
        // SAFETY: as the caller's.
        let [a, b] = unsafe { T::pair(s, self.data, offset, d, at_end) };
        lerp::<S>(u, a, b)
    }

    /// Stored numbers as data values.
    #[inline(always)]
    fn mapped<S: Lanes>(&self, s: S, stored: F32<S>) -> F32<S> {
        stored.mul_add(splat(s, self.scale), splat(s, self.offset))
    }
}

impl<S: Lanes, T: Texel> Field<S> for Trilinear<'_, T> {
    #[inline(always)]
    fn values(&self, s: S, index: Vec3<S>, lanes: Mask<S>) -> F32<S> {
        let Cell { offset, u, .. } = self.locate(s, &index);
        let [dy, dz] = self.stride;
        let at_end = T::OVERREAD > 0 && self.at_end(s, offset, (dy + dz) as usize + 1 + T::OVERREAD);
        // SAFETY: `locate` gives a cell of the grid, and the rows at dy, dz and dy + dz are its
        // other edges.
        let (near, far) = unsafe {
            (
                lerp::<S>(u[1], self.row(s, offset, 0, u[0], at_end), self.row(s, offset, dy, u[0], at_end)),
                lerp::<S>(u[1], self.row(s, offset, dz, u[0], at_end), self.row(s, offset, dz + dy, u[0], at_end)),
            )
        };
        let stored = lerp::<S>(u[2], near, far);
        if !T::TYPE.is_integer() {
            let holes = lanes & !stored.is_finite();
            if holes.any_true() {
                return holes.select(value_of_each(s, &self.exact, index, holes), self.mapped(s, stored));
            }
        }
        self.mapped(s, stored)
    }

    /// The 32 voxels that the six taps stand on, each read once: the taps share their fractions
    /// with the position.
    #[inline(always)]
    fn gradients(&self, s: S, index: Vec3<S>, centers: F32<S>, lanes: Mask<S>) -> Vec3<S> {
        if !self.central {
            return gradient_of_each(s, &self.exact, index, lanes);
        }
        let cell = self.locate(s, &index);
        let (u, zero) = (cell.u, whole(s, 0));
        let [dy, dz] = self.stride;
        let first = xyz!(I => cell.voxel[I].simd_le(zero));
        let last = xyz!(I => cell.voxel[I].simd_ge(whole(s, self.last_cell[I])));
        // One row before and one after the cell, where there are.
        let y0 = cell.offset + first[1].select(zero, whole(s, -dy));
        let y3 = cell.offset + last[1].select(whole(s, dy), whole(s, 2 * dy));
        let z0 = cell.offset + first[2].select(zero, whole(s, -dz));
        let z3 = cell.offset + last[2].select(whole(s, dz), whole(s, 2 * dz));
        let furthest = (y3 + dz).max(z3 + dy).max(cell.offset + (dy + dz + 1));
        let at_end = cell.offset.simd_le(zero).any_true() || self.at_end(s, furthest, 1 + T::OVERREAD);
        // SAFETY: `locate` gives a cell of the grid; rows before and after it are the grid's by
        // the selects above.
        let (rows, beside) = unsafe {
            (
                [
                    lerped_along_x::<S>(T::quad(s, self.data, cell.offset, 0, at_end), u[0], first[0], last[0]),
                    lerped_along_x::<S>(T::quad(s, self.data, cell.offset, dy, at_end), u[0], first[0], last[0]),
                    lerped_along_x::<S>(T::quad(s, self.data, cell.offset, dz, at_end), u[0], first[0], last[0]),
                    lerped_along_x::<S>(T::quad(s, self.data, cell.offset, dy + dz, at_end), u[0], first[0], last[0]),
                ],
                [
                    lerp::<S>(u[2], self.row(s, y0, 0, u[0], at_end), self.row(s, y0, dz, u[0], at_end)),
                    lerp::<S>(u[2], self.row(s, y3, 0, u[0], at_end), self.row(s, y3, dz, u[0], at_end)),
                    lerp::<S>(u[1], self.row(s, z0, 0, u[0], at_end), self.row(s, z0, dy, u[0], at_end)),
                    lerp::<S>(u[1], self.row(s, z3, 0, u[0], at_end), self.row(s, z3, dy, u[0], at_end)),
                ],
            )
        };
        let [r00, r10, r01, r11] = rows;
        // Interpolated along x and z at either y, and along x and y at either z.
        let y = [lerp::<S>(u[2], r00[1], r01[1]), lerp::<S>(u[2], r10[1], r11[1])];
        let z = [lerp::<S>(u[1], r00[1], r10[1]), lerp::<S>(u[1], r01[1], r11[1])];
        let left = lerp::<S>(u[2], lerp::<S>(u[1], r00[0], r10[0]), lerp::<S>(u[1], r01[0], r11[0]));
        let right = lerp::<S>(u[2], lerp::<S>(u[1], r00[2], r10[2]), lerp::<S>(u[1], r01[2], r11[2]));
        let sides = [
            [left, right],
            [lerp::<S>(u[1], beside[0], y[0]), lerp::<S>(u[1], y[1], beside[1])],
            [lerp::<S>(u[2], beside[2], z[0]), lerp::<S>(u[2], z[1], beside[3])],
        ];
        let g = xyz!(I => {
            let sides = [self.mapped(s, sides[I][0]), self.mapped(s, sides[I][1])];
            self.bounds.difference(s, &index, I, sides, centers)
        });
        let matrix = &self.world_from_index_gradient;
        let gradient = xyz!(I => dot::<S>(xyz!(J => splat(s, matrix[I][J])), g));
        if !T::TYPE.is_integer() {
            // Also where a voxel of the cell itself is absent and only the value in the middle knows:
            // that was repaired in f64, which rounds other than these taps.
            let cell = y[0] + y[1];
            let holes = lanes & !(gradient[0] + gradient[1] + gradient[2] + cell).is_finite();
            if holes.any_true() {
                let repaired = gradient_of_each(s, &self.exact, index, holes);
                return xyz!(I => holes.select(repaired[I], gradient[I]));
            }
        }
        gradient
    }
}

/// A row of four voxels interpolated along x: one voxel to the left, in place, and one to the
/// right. Where the row has no voxel there, its neighbour stands for it.
#[inline(always)]
fn lerped_along_x<S: Lanes>([a, b, c, d]: [F32<S>; 4], u: F32<S>, first: Mask<S>, last: Mask<S>) -> [F32<S>; 3] {
    [lerp::<S>(u, first.select(b, a), b), lerp::<S>(u, b, c), lerp::<S>(u, c, last.select(c, d))]
}
