//! The walk over segments between the nodes of a lattice, for modes that look at pairs of values.

use crate::cells::{self, Cells};
use crate::field::{Field, Knots};
use crate::integrator::Counter;
use crate::lanes::*;
use crate::packet::Rays;
use crate::skip::{Leap, SkipGrid};
use crate::walk::{Following, Next, Segment, Visit};

/// How many segments are visited between two looks at the blocks: fewer than samples, because what
/// is looked for is often a surface.
const RUN: usize = 4;

/// Visits the segments that can contribute, nearest first. The value at a segment's end is carried
/// over to the next: one fetch a segment (4.6-7).
#[inline(always)]
pub fn each_segment<S: Lanes, F: Field<S>>(
    s: S,
    field: &F,
    rays: &Rays<S>,
    skip: Option<&SkipGrid>,
    counter: &mut Counter<S>,
    visitor: &mut impl Visit<S>,
) {
    let nothing = splat(s, 0.0);
    // The node in front of the segment; the last segment starts at node `count`.
    let mut n = nothing;
    let mut following = Following::new(s, rays);
    let mut front = splat(s, f32::NAN);
    let mut carried = false;
    // Rays that have taken their front value: a packet fetches all of them when one ray needs it.
    let mut taken = all(s, false);
    loop {
        if let Some(skip) = skip {
            let to = skip.leap(s, rays, n, following.open, Leap::Segments);
            counter.skip(to.min(rays.count) - n);
            let stays = to.simd_eq(n);
            carried &= stays.all_true();
            taken &= stays;
            n = to;
        }
        if !carried {
            front = field.values(s, rays.at(rays.node(s, n)), following.open);
            counter.sample(following.open & rays.has_node(n) & !taken);
            carried = true;
            taken = all(s, true);
        }
        let mut distance = rays.node(s, n);
        for _ in 0..RUN {
            following.open &= rays.has_node(n);
            let open = following.open;
            if !open.any_true() {
                break;
            }
            let end = rays.node(s, n + 1.0);
            let back = field.values(s, rays.at(end), open);
            counter.sample(open);
            let segment = Segment {
                distance: [distance, end],
                length: rays.segment_length(s, n),
                value: [front, back],
                lanes: open,
            };
            // Rays that wait stay where they will go on.
            n = open.select(n + 1.0, n);
            (front, distance) = (back, end);
            following.visit(&segment, counter, visitor);
        }
        match following.next(s, counter, visitor) {
            Next::Done => return,
            Next::Resumed => carried = false,
            Next::Same => {}
        }
    }
}

/// Visits the faces between voxels where a field jumps from the value of one to that of the other: segments of
/// no length. Between nodes of a lattice corners of voxels would be missed.
#[inline(always)]
pub fn each_face<S: Lanes, F: Field<S>>(
    s: S,
    field: &F,
    rays: &Rays<S>,
    skip: Option<&SkipGrid>,
    counter: &mut Counter<S>,
    visitor: &mut impl Visit<S>,
) {
    let (zero, absent) = (splat(s, 0.0), splat(s, f32::NAN));
    let mut cells = Cells::new(s, rays, Knots::FACES);
    let mut following = Following::new(s, rays);
    // The value in front of the cell; there is no face at the entry, nor behind what is leapt over.
    let mut front = absent;
    loop {
        if let Some(skip) = skip {
            let (leaps, way) = skip.leap_cells(s, rays, &mut cells, following.open);
            front = leaps.select(absent, front);
            counter.skip(way);
        }
        for _ in 0..cells::RUN {
            following.open &= cells.are_there();
            let open = following.open;
            if !open.any_true() {
                break;
            }
            let back = field.values(s, rays.at(cells.middle()), open);
            counter.sample(open);
            let face = cells.ends[0];
            let segment = Segment { distance: [face, face], length: zero, value: [front, back], lanes: open };
            front = open.select(back, front);
            cells.advance(s, open);
            following.visit(&segment, counter, visitor);
        }
        if following.next(s, counter, visitor) == Next::Done {
            return;
        }
    }
}
