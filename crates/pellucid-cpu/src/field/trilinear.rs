//! Trilinear interpolation and its central differences, for all lanes at once (1.5-10, 5.3-4).

use pellucid_field::{ComponentView, Linear};

use super::general::{gradient_of_each, value_of_each};
use super::taps::Bounds;
use super::{Corners, Course, Cubic, Field, Knots, Near, Probe, Quad, Texel};
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
    /// From differences of stored numbers per index step to data units per world unit.
    gradient_map: [[f32; 3]; 3],
    exact: Probe<'a, Linear<'a, T>>,
    has_holes: bool,
}

/// The stored voxels around pieces of rays.
struct Edges<S: Lanes> {
    /// The lowest of each.
    voxel: [I32<S>; 3],
    /// The rows along x at (y, z), as [`Cell`]s have them; those that are absent have the value of the nearest.
    rows: [[F32<S>; 2]; 4],
    /// Lanes in which the field is there.
    lanes: Mask<S>,
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
    /// The field of a component some voxels of which may be absent, or `None` if it cannot be read with vectors: several components
    /// to a voxel, an axis without cells, or more voxels than 32-bit offsets reach.
    pub fn new(
        view: ComponentView<'a, T>,
        has_holes: bool,
        bounds: Bounds,
        exact: Probe<'a, Linear<'a, T>>,
    ) -> Option<Self> {
        let (dims, stride, data) = (view.dims(), view.stride(), view.data());
        let fits = data.len() < i32::MAX as usize && dims.iter().product::<usize>() == data.len();
        if stride[0] != 1 || !fits || dims.iter().any(|&n| n < 2) {
            return None;
        }
        let map = view.value_map();
        let matrix = (exact.world_from_index_gradient() * map.scale).as_mat3().transpose();
        Some(Self {
            data,
            stride: [stride[1] as i32, stride[2] as i32],
            last: dims.map(|n| ((n - 1) as f32).next_down()),
            last_cell: dims.map(|n| n as i32 - 2),
            scale: map.scale as f32,
            offset: map.offset as f32,
            bounds,
            gradient_map: matrix.to_cols_array_2d(),
            exact,
            has_holes,
        })
    }

    #[inline(always)]
    fn locate<S: Lanes>(&self, s: S, p: &Vec3<S>) -> Cell<S> {
        // Both limits hold whatever the position: every offset made of these voxels is in the data.
        let inside = xyz!(I => within(s, p[I], self.last[I]));
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

    /// The voxels around pieces of rays, with no knot between their ends.
    #[inline(always)]
    fn edges<S: Lanes>(&self, s: S, [from, to]: &[Vec3<S>; 2], mut lanes: Mask<S>) -> Edges<S> {
        let Cell { voxel, offset, u: middle } = self.locate(s, &xyz!(I => (from[I] + to[I]) * 0.5));
        let [dy, dz] = self.stride;
        let at_end = T::OVERREAD > 0 && self.at_end(s, offset, (dy + dz) as usize + 1 + T::OVERREAD);
        let steps = [0, dy, dz, dy + dz];
        // SAFETY: `locate` gives a cell of the grid, and the rows at dy, dz and dy + dz are its
        // other edges.
        let mut rows = unsafe { rgba!(R => T::pair(s, self.data, offset, steps[R], at_end)) };
        if self.has_holes {
            // No piece passes from the part of one voxel to that of another, and there is none where that is absent.
            let high = xyz!(I => middle[I].simd_ge(splat(s, 0.5)));
            let [a, b, c, d] = rgba!(R => high[0].select(rows[R][1], rows[R][0]));
            let nearest = high[2].select(high[1].select(d, c), high[1].select(b, a));
            lanes &= nearest.is_finite();
            rows = rgba!(R => {
                let [a, b] = rows[R];
                [a.is_finite().select(a, nearest), b.is_finite().select(b, nearest)]
            });
        }
        Edges { voxel, rows, lanes }
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

    /// Data values of interpolated stored numbers, absent ones asked for again.
    #[inline(always)]
    fn found<S: Lanes>(&self, s: S, stored: F32<S>, index: Vec3<S>, lanes: Mask<S>) -> F32<S> {
        let mapped = stored.mul_add(splat(s, self.scale), splat(s, self.offset));
        if !T::TYPE.is_integer() {
            let holes = lanes & !stored.is_finite();
            if holes.any_true() {
                return holes.select(value_of_each(s, &self.exact, index, holes), mapped);
            }
        }
        mapped
    }

    /// The rows of cells at (y, z), each with the voxel before and after, where there is one.
    #[inline(always)]
    fn rows<S: Lanes>(&self, s: S, offset: I32<S>) -> [Quad<S>; 4] {
        let [dy, dz] = self.stride;
        let at_end = offset.simd_le(whole(s, 0)).any_true() || self.at_end(s, offset, (dy + dz) as usize + 2);
        // SAFETY: the caller's cell is of the grid, and the rows at dy, dz and dy + dz are its other
        // edges; the row that starts first has a voxel before it and the one that ends last one
        // after it unless `at_end`.
        unsafe {
            [
                T::quad(s, self.data, offset, 0, at_end),
                T::quad(s, self.data, offset, dy, at_end),
                T::quad(s, self.data, offset, dz, at_end),
                T::quad(s, self.data, offset, dy + dz, at_end),
            ]
        }
    }

    /// The 32 voxels that the six taps stand on, each read once: the taps share their fractions
    /// with the position. `rows` are those of the cells, in the lanes that are asked for.
    #[inline(always)]
    fn differences<S: Lanes>(&self, s: S, index: Vec3<S>, rows: Option<&[Quad<S>; 4]>, lanes: Mask<S>) -> Vec3<S> {
        // Lanes that are not asked for must not take the others to the border.
        let index = xyz!(I => lanes.select(index[I], splat(s, 1.5)));
        let Cell { voxel, offset, u } = self.locate(s, &index);
        let [dy, dz] = self.stride;
        let first = xyz!(I => voxel[I].simd_le(whole(s, 0)));
        let last = xyz!(I => voxel[I].simd_ge(whole(s, self.last_cell[I])));
        let border = first[0] | first[1] | first[2] | last[0] | last[1] | last[2];
        let inside = !border.any_true() && self.bounds.is_box();
        // One row before and one after the cell; where there is none, the one at the border.
        let (mut y0, mut y3, mut z0, mut z3) = (offset - dy, offset + 2 * dy, offset - dz, offset + 2 * dz);
        let mut at_end = false;
        if !inside {
            (y0, y3) = (first[1].select(offset, y0), last[1].select(offset + dy, y3));
            (z0, z3) = (first[2].select(offset, z0), last[2].select(offset + dz, z3));
            let furthest = (y3 + dz).max(z3 + dy);
            at_end = self.at_end(s, furthest, 1 + T::OVERREAD);
        }
        let cells = match rows {
            Some(rows) => *rows,
            None => self.rows(s, offset),
        };
        let quads = rgba!(R => T::numbers(s, &cells[R]));
        // SAFETY: `locate` gives a cell of the grid; rows before and after it are the grid's, as it
        // is inside or by the selects above.
        let beside = unsafe {
            [
                [self.row(s, y0, 0, u[0], at_end), self.row(s, y0, dz, u[0], at_end)],
                [self.row(s, y3, 0, u[0], at_end), self.row(s, y3, dz, u[0], at_end)],
                [self.row(s, z0, 0, u[0], at_end), self.row(s, z0, dy, u[0], at_end)],
                [self.row(s, z3, 0, u[0], at_end), self.row(s, z3, dy, u[0], at_end)],
            ]
        };
        let taps = if inside { None } else { Some(xyz!(I => self.bounds.taps(s, &index, I))) };
        let [y0, y3, z0, z3] = beside;
        // The rows of the cell at (y, z), interpolated along x.
        let middle = rgba!(R => lerp::<S>(u[0], quads[R][1], quads[R][2]));
        let [m00, m10, m01, m11] = middle;
        let x = rgba!(R => difference::<S>(u[0], quads[R], taps.as_ref().map(|taps| &taps[0])));
        let x = lerp::<S>(u[2], lerp::<S>(u[1], x[0], x[1]), lerp::<S>(u[1], x[2], x[3]));
        let along_y = taps.as_ref().map(|taps| &taps[1]);
        let y = lerp::<S>(
            u[2],
            difference::<S>(u[1], [y0[0], m00, m10, y3[0]], along_y),
            difference::<S>(u[1], [y0[1], m01, m11, y3[1]], along_y),
        );
        let along_z = taps.as_ref().map(|taps| &taps[2]);
        let z = lerp::<S>(
            u[1],
            difference::<S>(u[2], [z0[0], m00, m01, z3[0]], along_z),
            difference::<S>(u[2], [z0[1], m10, m11, z3[1]], along_z),
        );
        let mut g = [x * 0.5, y * 0.5, z * 0.5];
        if let Some(taps) = &taps {
            // A one-sided difference spans one voxel, not two.
            g = xyz!(I => (taps[I][0] & taps[I][1]).select(g[I], g[I] + g[I]));
        }
        let matrix = &self.gradient_map;
        let gradient = xyz!(I => dot::<S>(xyz!(J => splat(s, matrix[I][J])), g));
        if !T::TYPE.is_integer() {
            // Every difference stands on voxels of the cell, so an absent one there is seen, too.
            let holes = lanes & !(gradient[0] + gradient[1] + gradient[2]).is_finite();
            if holes.any_true() {
                let repaired = gradient_of_each(s, &self.exact, index, holes);
                return xyz!(I => holes.select(repaired[I], gradient[I]));
            }
        }
        gradient
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
        self.found(s, lerp::<S>(u[2], near, far), index, lanes)
    }

    #[inline(always)]
    fn corners(&self, s: S, index: Vec3<S>, _: Mask<S>) -> Option<Corners<S>> {
        let Cell { offset, u, .. } = self.locate(s, &index);
        let [dy, dz] = self.stride;
        let at_end = T::OVERREAD > 0 && self.at_end(s, offset, (dy + dz) as usize + 1 + T::OVERREAD);
        // SAFETY: `locate` gives a cell of the grid, and the rows at dy, dz and dy + dz are its
        // other edges.
        let rows = unsafe {
            [
                T::pair(s, self.data, offset, 0, at_end),
                T::pair(s, self.data, offset, dy, at_end),
                T::pair(s, self.data, offset, dz, at_end),
                T::pair(s, self.data, offset, dy + dz, at_end),
            ]
        };
        let (scale, shift) = (splat(s, self.scale), splat(s, self.offset));
        let [[a, b], [c, d], [e, f], [g, h]] = rows;
        let mut values = [a, b, c, d, e, f, g, h];
        for value in &mut values {
            *value = value.mul_add(scale, shift);
        }
        Some(Corners { values, u })
    }

    #[inline(always)]
    fn values_near(&self, s: S, index: Vec3<S>, lanes: Mask<S>) -> (F32<S>, Near<S>) {
        let Cell { offset, u, .. } = self.locate(s, &index);
        let rows = self.rows(s, offset);
        let [a, b, c, d] = rgba!(R => {
            let [_, left, right, _] = T::numbers(s, &rows[R]);
            lerp::<S>(u[0], left, right)
        });
        let stored = lerp::<S>(u[2], lerp::<S>(u[1], a, b), lerp::<S>(u[1], c, d));
        let value = self.found(s, stored, index, lanes);
        (value, Near { index, value, rows: Some(rows) })
    }

    /// Rays of a packet are close to each other: its corners stand for all. Pays from the size of
    /// last-level caches on: 17 % for 512^3 u16, 9 % for 256^3 f32; below it would cost 2 %.
    #[inline(always)]
    fn prefetch(&self, s: S, index: Vec3<S>) {
        const LARGE: usize = 32 << 20;
        if size_of_val(self.data) < LARGE {
            return;
        }
        let Cell { offset, .. } = self.locate(s, &index);
        let lanes = width::<S>();
        let columns = 1 << lanes.ilog2().div_ceil(2);
        for lane in [0, columns - 1, lanes - columns, lanes - 1] {
            for d in [0, self.stride[1]] {
                s.prefetch(self.data.as_ptr().wrapping_offset((offset[lane] + d) as isize));
            }
        }
    }

    #[inline(always)]
    fn gradients(&self, s: S, index: Vec3<S>, lanes: Mask<S>) -> Vec3<S> {
        self.differences(s, index, None, lanes)
    }

    #[inline(always)]
    fn gradients_near(&self, s: S, near: &Near<S>, lanes: Mask<S>) -> Vec3<S> {
        self.differences(s, near.index, near.rows.as_ref(), lanes)
    }

    #[inline(always)]
    fn knots(&self) -> Knots {
        if self.has_holes { Knots::BOTH } else { Knots::VOXELS }
    }

    /// Along a ray the interpolation in a cell is a cubic, whose largest value is known; none is more than the
    /// largest voxel, so that most cells need no more than that.
    #[inline(always)]
    fn highest(&self, s: S, piece: &[Vec3<S>; 2], sign: f32, above: F32<S>, lanes: Mask<S>) -> [F32<S>; 2] {
        let (zero, one) = (splat(s, 0.0), splat(s, 1.0));
        let Edges { voxel, mut rows, lanes } = self.edges(s, piece, lanes);
        if sign * self.scale < 0.0 {
            rows = rgba!(R => [-rows[R][0], -rows[R][1]]);
        }
        let (scale, shift) = (splat(s, self.scale.abs()), splat(s, sign * self.offset));
        let top = highest_of::<S>(&rows);
        let none = splat(s, f32::NEG_INFINITY);
        let live = lanes & top.is_finite() & top.mul_add(scale, shift).simd_gt(above);
        if !live.any_true() {
            return [none, zero];
        }
        let cubic = along(s, &rows, &voxel, piece);
        let (start, end) = (cubic.0[0], cubic.at(one));
        let rises = end.simd_gt(start);
        let (mut best, mut part) = (rises.select(end, start), rises.select(one, zero));
        for t in cubic.turns(s) {
            // Numbers that are none are not between 0 and 1.
            let inside = live & t.simd_gt(zero) & t.simd_lt(one);
            if inside.any_true() {
                let value = cubic.at(t);
                let better = inside & value.simd_gt(best);
                (best, part) = (better.select(value, best), better.select(t, part));
            }
        }
        [live.select(best.min(top).mul_add(scale, shift), none), part]
    }

    #[inline(always)]
    fn course(&self, s: S, piece: &[Vec3<S>; 2], [from, to]: [F32<S>; 2], lanes: Mask<S>) -> Course<S> {
        let Edges { voxel, rows, lanes } = self.edges(s, piece, lanes);
        let (scale, offset) = (splat(s, self.scale), splat(s, self.offset));
        let ends = [lowest_of::<S>(&rows), highest_of::<S>(&rows)].map(|stored| stored.mul_add(scale, offset));
        let [low, high] = if self.scale < 0.0 { [ends[1], ends[0]] } else { ends };
        let present = lanes & low.is_finite() & high.is_finite();
        let (passes, value) = (present & low.simd_le(to) & high.simd_ge(from), present.select(low, splat(s, f32::NAN)));
        let stored = if passes.any_true() { along(s, &rows, &voxel, piece).0 } else { [splat(s, 0.0); 4] };
        let [c0, c1, c2, c3] = stored;
        Course { passes, cubic: Cubic([c0.mul_add(scale, offset), c1 * scale, c2 * scale, c3 * scale]), value }
    }
}

/// The smallest of the voxels around.
#[inline(always)]
fn lowest_of<S: Lanes>(rows: &[[F32<S>; 2]; 4]) -> F32<S> {
    let [a, b, c, d] = rgba!(R => rows[R][0].min(rows[R][1]));
    a.min(b).min(c.min(d))
}

/// The largest of the voxels around.
#[inline(always)]
fn highest_of<S: Lanes>(rows: &[[F32<S>; 2]; 4]) -> F32<S> {
    let [a, b, c, d] = rgba!(R => rows[R][0].max(rows[R][1]));
    a.max(b).max(c.max(d))
}

/// The interpolation along pieces of rays in the cells of voxels with such rows.
#[inline(always)]
fn along<S: Lanes>(s: S, rows: &[[F32<S>; 2]; 4], voxel: &[I32<S>; 3], [from, to]: &[Vec3<S>; 2]) -> Cubic<S> {
    let (zero, one) = (splat(s, 0.0), splat(s, 1.0));
    let start = xyz!(I => (from[I] - voxel[I].to_float::<F32<S>>()).max(zero).min(one));
    let way = xyz!(I => (to[I] - voxel[I].to_float::<F32<S>>()).max(zero).min(one) - start[I]);
    let [a, b, c, d] = rgba!(R => {
        let [left, right] = rows[R];
        between::<S>(&[left, zero, zero, zero], &[right, zero, zero, zero], start[0], way[0])
    });
    let (near, far) = (between::<S>(&a, &b, start[1], way[1]), between::<S>(&c, &d, start[1], way[1]));
    Cubic(between::<S>(&near, &far, start[2], way[2]))
}

/// The difference of the values one voxel after and one before a position between the middle two of
/// four; where a tap is missing, of the value on the other side and the one in the middle.
#[inline(always)]
fn difference<S: Lanes>(u: F32<S>, [a, b, c, d]: [F32<S>; 4], taps: Option<&[Mask<S>; 2]>) -> F32<S> {
    match taps {
        None => lerp::<S>(u, c - a, d - b),
        Some([before, after]) => {
            let (left, right) = ([before.select(a, b), before.select(b, c)], [after.select(c, b), after.select(d, c)]);
            lerp::<S>(u, right[0] - left[0], right[1] - left[1])
        }
    }
}

/// The polynomial `p (1 - u) + q u`, where `u` is `start + way t`; lowest coefficient first.
#[inline(always)]
fn between<S: Lanes>(p: &[F32<S>; 4], q: &[F32<S>; 4], start: F32<S>, way: F32<S>) -> [F32<S>; 4] {
    let step = rgba!(N => q[N] - p[N]);
    [
        start.mul_add(step[0], p[0]),
        way.mul_add(step[0], start.mul_add(step[1], p[1])),
        way.mul_add(step[1], start.mul_add(step[2], p[2])),
        way * step[2],
    ]
}
