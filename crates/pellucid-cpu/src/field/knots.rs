//! Where a reconstructed field bends, and what is between two such places on a ray.

use pellucid_field::Filter;

use super::{Course, Cubic, Field};
use crate::lanes::*;

/// Planes across every axis, in index space: `x * per_voxel + shift` is a whole number on them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knots {
    /// Planes a voxel.
    pub per_voxel: f32,
    /// Where one of them is.
    pub shift: f32,
}

impl Knots {
    /// Through the voxels, between which filters are polynomials.
    pub const VOXELS: Self = Self { per_voxel: 1.0, shift: 0.0 };
    /// Half way between voxels, where the nearest one changes.
    pub const FACES: Self = Self { per_voxel: 1.0, shift: 0.5 };
    /// Both: the nearest voxel stands for absent ones.
    pub const BOTH: Self = Self { per_voxel: 2.0, shift: 0.0 };

    /// Those of a filter on voxels of which some may be absent.
    pub fn new(filter: Filter, has_holes: bool) -> Self {
        match (filter, has_holes) {
            (Filter::Nearest, _) => Self::FACES,
            (_, true) => Self::BOTH,
            (_, false) => Self::VOXELS,
        }
    }
}

/// How far inside a piece its ends are looked at, as a share of it: where a voxel is absent the field ends there, and
/// rounding must not decide on which side a look is.
const INSIDE: f32 = 1e-3;

/// Where four looks are, and how far one is from the next, as shares of a piece.
fn looks(knots: Knots) -> [f32; 2] {
    let first = if knots == Knots::BOTH { INSIDE } else { 0.0 };
    [first, (1.0 - 2.0 * first) / 3.0]
}

/// [`Field::course`] for fields that are asked four times.
#[inline(always)]
pub fn course_sampled<S: Lanes, F: Field<S> + ?Sized>(
    s: S,
    field: &F,
    [from, to]: &[Vec3<S>; 2],
    lanes: Mask<S>,
) -> Course<S> {
    let ([first, third], way) = (looks(field.knots()), xyz!(I => to[I] - from[I]));
    let values = rgba!(N => look(s, field, from, &way, splat(s, first + third * N as f32), 1.0, lanes));
    let [a, b] = [values[0] + values[1], values[2] + values[3]];
    let present = (a + b).is_finite();
    Course {
        passes: lanes & present,
        cubic: Cubic::through(values).measured(s, 1.0 / third, -first / third),
        value: present.select(values[0], splat(s, f32::NAN)),
    }
}

/// [`Field::highest`] for fields of which no more is known than that they are smooth: of four looks, and where the
/// cubic through these is largest. Trilinear fields are such cubics.
#[inline(always)]
pub fn highest_sampled<S: Lanes, F: Field<S> + ?Sized>(
    s: S,
    field: &F,
    [from, to]: &[Vec3<S>; 2],
    sign: f32,
    lanes: Mask<S>,
) -> [F32<S>; 2] {
    let (knots, half) = (field.knots(), splat(s, 0.5));
    let way = xyz!(I => to[I] - from[I]);
    if knots == Knots::FACES {
        return [look(s, field, from, &way, half, sign, lanes), half];
    }
    let [first, third] = looks(knots);
    let parts = rgba!(N => splat(s, first + third * N as f32));
    let values = rgba!(N => look(s, field, from, &way, parts[N], sign, lanes));
    let front = larger::<S>([values[0], parts[0]], [values[1], parts[1]]);
    let back = larger::<S>([values[2], parts[2]], [values[3], parts[3]]);
    let mut best = larger::<S>(front, back);
    for place in Cubic::through(values).turns(s) {
        // Numbers that are none are not inside.
        let inside = lanes & place.simd_gt(splat(s, 0.0)) & place.simd_lt(splat(s, 3.0));
        if inside.any_true() {
            let part = inside.select(place.mul_add(splat(s, third), splat(s, first)), half);
            let found = look(s, field, from, &way, part, sign, inside);
            best = larger::<S>(best, [inside.select(found, best[0]), part]);
        }
    }
    best
}

/// Values a part of the way, times a sign; negative infinity where absent. One copy of the field's code, which is
/// long where the filter is wide, serves all looks.
#[inline(never)]
fn look<S: Lanes, F: Field<S> + ?Sized>(
    s: S,
    field: &F,
    from: &Vec3<S>,
    way: &Vec3<S>,
    part: F32<S>,
    sign: f32,
    lanes: Mask<S>,
) -> F32<S> {
    s.vectorize(
        #[inline(always)]
        || {
            let value = field.values(s, xyz!(I => way[I].mul_add(part, from[I])), lanes) * sign;
            value.is_finite().select(value, splat(s, f32::NEG_INFINITY))
        },
    )
}

/// The larger of two values, with its place.
#[inline(always)]
fn larger<S: Lanes>(a: [F32<S>; 2], b: [F32<S>; 2]) -> [F32<S>; 2] {
    let better = b[0].simd_gt(a[0]);
    [better.select(b[0], a[0]), better.select(b[1], a[1])]
}
