//! Which of the six taps of a central difference exist: inside the box and not clipped.

use glam::DVec3;
use pellucid_field::Grid;
use pellucid_scene::Region;

use crate::lanes::*;
use crate::solid::half_spaces;

/// The rounding of positions must not cut off a tap that lies in the border.
const TOLERANCE: f32 = 1e-4;

/// Less of the box's extent is lost in the rounding of positions: a direction that leads off a side by less, on the
/// longest way in the box, goes along it.
const ROUNDING: f32 = 1e-6;

/// The box and the clip planes around a field, in index space.
pub struct Bounds {
    /// The box, and the last voxel.
    low: [f32; 3],
    high: [f32; 3],
    last: [f32; 3],
    /// Half-spaces `normal . p >= offset`.
    planes: Vec<([f32; 3], f32)>,
}

impl Bounds {
    /// The bounds of a grid and a region.
    pub fn new(grid: &Grid, region: &Region) -> Self {
        let plane = |(normal, offset): (DVec3, f64)| {
            let length = normal.length();
            ((normal / length).as_vec3().to_array(), (offset / length) as f32)
        };
        let planes = half_spaces(grid, region).map(plane).collect();
        let [low, high] = <[DVec3; 2]>::from(grid.index_bounds()).map(|corner| corner.as_vec3().to_array());
        Self { low, high, last: grid.dims().map(|n| (n - 1) as f32), planes }
    }

    /// Whether nothing but the box bounds the field.
    pub fn is_box(&self) -> bool {
        self.planes.is_empty()
    }

    /// Lanes around whose position no plane cuts a cube that reaches so far along each axis.
    #[inline(always)]
    pub fn surround<S: Lanes>(&self, s: S, p: &Vec3<S>, reach: f32) -> Mask<S> {
        let mut clear = all(s, true);
        for (normal, offset) in &self.planes {
            let deepest = reach * (normal[0].abs() + normal[1].abs() + normal[2].abs());
            clear &= dot::<S>(xyz!(I => splat(s, normal[I])), *p).simd_ge(splat(s, offset + deepest));
        }
        clear
    }

    /// Lanes whose position is in the box and not clipped.
    #[inline(always)]
    pub fn contain<S: Lanes>(&self, s: S, p: &Vec3<S>) -> Mask<S> {
        let mut inside = all(s, true);
        for axis in 0..3 {
            inside &= p[axis].simd_ge(splat(s, self.low[axis] - TOLERANCE));
            inside &= p[axis].simd_le(splat(s, self.high[axis] + TOLERANCE));
        }
        for (normal, offset) in &self.planes {
            let above = dot::<S>(xyz!(I => splat(s, normal[I])), *p);
            inside &= above.simd_ge(splat(s, offset - TOLERANCE));
        }
        inside
    }

    /// How often a direction fits into the way from positions inside to the border of the box or region;
    /// 0 for positions outside. `inverse` is one over the direction, very large where that is 0.
    #[inline(always)]
    pub fn exit<S: Lanes>(&self, s: S, p: &Vec3<S>, direction: &Vec3<S>, inverse: &Vec3<S>) -> F32<S> {
        let [_, exit] = self.span(s, p, direction, inverse);
        exit.max(splat(s, 0.0))
    }

    /// Between how many lengths of a direction from positions, wherever these are, the way lies in the box and region;
    /// the first is not less than 0, and not less than the second where there is no such way.
    #[inline(always)]
    pub fn span<S: Lanes>(&self, s: S, p: &Vec3<S>, direction: &Vec3<S>, inverse: &Vec3<S>) -> [F32<S>; 2] {
        let (zero, never) = (splat(s, 0.0), splat(s, f32::INFINITY));
        let extent = [0, 1, 2].map(|axis| self.high[axis] - self.low[axis]);
        let ways = xyz!(I => inverse[I].abs() * extent[I]);
        let longest = ways[0].min(ways[1]).min(ways[2]);
        let (mut first, mut nearest) = (zero, never);
        for axis in 0..3 {
            let (low, high) = (splat(s, self.low[axis]), splat(s, self.high[axis]));
            let ascends = inverse[axis].simd_gt(zero);
            // Along a side there is no end, least of all for a position on it, by rounding beyond it.
            let leaves = (ways[axis] * ROUNDING).simd_le(longest);
            let border = ascends.select(high, low);
            nearest = leaves.select(nearest.min((border - p[axis]) * inverse[axis]), nearest);
            let beside = p[axis].simd_lt(low - TOLERANCE) | p[axis].simd_gt(high + TOLERANCE);
            let entry = (ascends.select(low, high) - p[axis]) * inverse[axis];
            first = first.max(leaves.select(entry, beside.select(never, zero)));
        }
        let flattest = splat(s, ROUNDING * extent[0].max(extent[1]).max(extent[2])) / longest;
        for (normal, offset) in &self.planes {
            let normal = xyz!(I => splat(s, normal[I]));
            let (slope, above) = (dot::<S>(normal, *direction), dot::<S>(normal, *p) - *offset);
            let (leaves, enters) = (slope.simd_lt(-flattest), slope.simd_gt(flattest));
            let crossing = above / leaves.select(-slope, splat(s, 1.0));
            nearest = leaves.select(nearest.min(crossing), nearest);
            let entry = -above / enters.select(slope, splat(s, 1.0));
            let beside = !leaves & above.simd_lt(splat(s, -TOLERANCE));
            first = first.max(enters.select(entry, beside.select(never, zero)));
        }
        [first, nearest]
    }

    /// The faces on which rays in some directions enter at positions: unit normals inwards, and their offsets;
    /// negative infinity, so that everything is deep behind it, where a ray enters in the middle of the field.
    #[inline(always)]
    pub fn entered<S: Lanes>(&self, s: S, entry: &Vec3<S>, direction: &Vec3<S>) -> (Vec3<S>, F32<S>) {
        /// How far rounding may take an entry off its face.
        const OFF: f32 = 2e-3;
        let (zero, one) = (splat(s, 0.0), splat(s, 1.0));
        let (mut found, mut offset, mut least) = ([zero; 3], splat(s, f32::NEG_INFINITY), splat(s, OFF));
        for axis in 0..3 {
            let ascends = direction[axis].simd_gt(zero);
            let sign = ascends.select(one, -one);
            let at = ascends.select(splat(s, self.low[axis]), splat(s, -self.high[axis]));
            let off = sign.mul_add(entry[axis], -at).abs();
            let nearer = off.simd_lt(least) & direction[axis].simd_ne(zero);
            found = xyz!(I => nearer.select(if I == axis { sign } else { zero }, found[I]));
            (offset, least) = (nearer.select(at, offset), nearer.select(off, least));
        }
        for (normal, at) in &self.planes {
            let normal = xyz!(I => splat(s, normal[I]));
            let off = (dot::<S>(normal, *entry) - *at).abs();
            let nearer = off.simd_lt(least) & dot::<S>(normal, *direction).simd_gt(zero);
            found = xyz!(I => nearer.select(normal[I], found[I]));
            (offset, least) = (nearer.select(splat(s, *at), offset), nearer.select(off, least));
        }
        (found, offset)
    }

    /// Whether the taps one index step before and after a position along an axis exist. The
    /// position itself does.
    #[inline(always)]
    pub fn taps<S: Lanes>(&self, s: S, p: &Vec3<S>, axis: usize) -> [Mask<S>; 2] {
        let mut left = p[axis].simd_ge(splat(s, 1.0 - TOLERANCE));
        let mut right = p[axis].simd_le(splat(s, self.last[axis] - 1.0 + TOLERANCE));
        for (normal, offset) in &self.planes {
            let above = dot::<S>(xyz!(I => splat(s, normal[I])), *p) - *offset;
            left &= above.simd_ge(splat(s, normal[axis] - TOLERANCE));
            right &= above.simd_ge(splat(s, -normal[axis] - TOLERANCE));
        }
        [left, right]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::packet::inverse;

    /// Spans of ways from a position, in the first lane.
    fn span<S: Lanes>(s: S, bounds: &Bounds, p: [f32; 3], direction: [f32; 3]) -> [f32; 3] {
        let [p, direction] = [p, direction].map(|v| xyz!(I => splat(s, v[I])));
        let inverse = inverse(s, &direction);
        let [first, last] = bounds.span(s, &p, &direction, &inverse);
        [first[0], last[0], bounds.exit(s, &p, &direction, &inverse)[0]]
    }

    fn bounds(clipped: bool) -> Bounds {
        let mut region = Region::from_clips(&[]);
        if clipped {
            region.keep(DVec3::Y, DVec3::new(0.0, 2.0, 0.0));
        }
        Bounds::new(&Grid::new([9, 9, 9]).unwrap(), &region)
    }

    /// On a side, by rounding within it or beyond it, the way along it is as long as within the box.
    #[test]
    fn ways_along_a_side_are_inside() {
        for set in InstructionSet::ALL.into_iter().filter_map(InstructionSet::resolve) {
            for (axis, side, off) in [0, 1].into_iter().flat_map(|axis| {
                [0.0, 8.0].into_iter().flat_map(move |side| [-1e-5, 0.0, 1e-5].map(|off| (axis, side, off)))
            }) {
                for up in [-1.0f32, 1.0] {
                    let mut p = [3.0, 4.0, 5.0];
                    p[axis] = side + off;
                    let inside = if up > 0.0 { 3.0 } else { 5.0 };
                    let found = dispatch!(set, s => span(s, &bounds(false), p, [0.0, -0.0, up]));
                    assert_eq!(found, [0.0, inside, inside], "{set}: {p:?}, {up}");
                    // From below or above the box.
                    p[2] -= 10.0 * up;
                    let found = dispatch!(set, s => span(s, &bounds(false), p, [0.0, -0.0, up]));
                    assert_eq!(found[..2], [10.0 - (8.0 - inside), 10.0 + inside], "{set}: {p:?}, {up}");
                    // Well beside it there is no way.
                    p[axis] = if side > 0.0 { 8.1 } else { -0.1 };
                    let [first, last, _] = dispatch!(set, s => span(s, &bounds(false), p, [0.0, -0.0, up]));
                    assert!(first >= last, "{set}: {p:?}, {up}: {first} to {last}");
                }
            }
        }
    }

    #[test]
    fn clips_begin_and_end_ways() {
        for set in InstructionSet::ALL.into_iter().filter_map(InstructionSet::resolve) {
            let of = |p, direction| dispatch!(set, s => span(s, &bounds(true), p, direction));
            assert_eq!(of([4.0, -1.0, 4.0], [0.0, 1.0, 0.0])[..2], [3.0, 9.0]);
            assert_eq!(of([4.0, 5.0, 4.0], [0.0, -1.0, 0.0]), [0.0, 3.0, 3.0]);
            // Along the clip, on it and below it.
            assert_eq!(of([4.0, 2.0, 4.0], [1.0, 0.0, 0.0]), [0.0, 4.0, 4.0]);
            let [first, last, _] = of([4.0, 1.5, 4.0], [1.0, 0.0, 0.0]);
            assert!(first >= last, "{first} to {last}");
        }
    }
}
