//! The walk over the pieces of rays on which a field only rises or only falls, of one that is a cubic between the planes
//! of its voxels, as trilinear interpolation is (5.5-8, G-03). Between the ends of such a piece a level is passed once or
//! not at all: no surface is missed, whatever the step.

use crate::cells::Cells;
use crate::field::{Course, Field};
use crate::integrator::Counter;
use crate::lanes::*;
use crate::packet::Rays;
use crate::skip::SkipGrid;
use crate::walk::{Following, Next, Segment, Visit};

/// How many pieces are looked at between two looks at the blocks: few, as most blocks with a surface are crossed by its
/// side.
const RUN: usize = 2;

/// Visits the pieces on which a field may pass any level of a range, nearest first.
///
/// What a ray was at the end of a piece it is at the beginning of the next: rounding of the values on a plane of voxels,
/// which are computed from both sides, puts no hole into a surface.
#[inline(always)]
pub fn each_monotone<S: Lanes, F: Field<S>>(
    s: S,
    field: &F,
    rays: &Rays<S>,
    (skip, [low, high]): (Option<&SkipGrid>, [f32; 2]),
    counter: &mut Counter<S>,
    visitor: &mut impl Visit<S>,
) {
    let (zero, one, unknown) = (splat(s, 0.0), splat(s, 1.0), splat(s, f32::NAN));
    let (beneath, range) = (splat(s, low.next_down()), [splat(s, low), splat(s, high)]);
    let mut cells = Cells::new(s, rays, field.knots());
    let mut following = Following::new(s, rays);
    // How far rays are in their cells, and the values there.
    let (mut part, mut front) = (zero, unknown);
    loop {
        if let Some(skip) = skip {
            let (leaps, way) = skip.leap_cells(s, rays, &mut cells, following.open);
            (part, front) = (leaps.select(zero, part), leaps.select(unknown, front));
            counter.skip(way);
        }
        for _ in 0..RUN {
            following.open &= cells.are_there();
            let open = following.open;
            if !open.any_true() {
                break;
            }
            counter.sample(open);
            let [from, to] = cells.ends;
            let Course { passes, cubic, value } = field.course(s, &[rays.at(from), rays.at(to)], range, open);
            let passes = passes & open;
            let mut next = one;
            // On the same side of all levels as the field is.
            let mut back = value.is_finite().select(value.max(beneath).min(range[1]), unknown);
            if passes.any_true() {
                for turn in cubic.turns(s) {
                    // Numbers that are none are not ahead.
                    next = (passes & turn.simd_gt(part) & turn.simd_lt(next)).select(turn, next);
                }
                back = passes.select(cubic.at(next), back);
                let begin = front.is_finite().select(front, cubic.at(part));
                let segment = Segment {
                    distance: [lerp::<S>(part, from, to), lerp::<S>(next, from, to)],
                    length: next - part,
                    value: [begin, back],
                    lanes: passes,
                };
                following.visit(&segment, counter, visitor);
            }
            front = open.select(back, front);
            let leaves = open & next.simd_ge(one);
            part = leaves.select(zero, open.select(next, part));
            cells.advance(s, leaves);
        }
        if following.next(s, counter, visitor) == Next::Done {
            return;
        }
    }
}
