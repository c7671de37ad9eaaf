//! The walk over segments between the nodes of a lattice, for modes that look at pairs of values.

use crate::cells::{self, Cells};
use crate::field::{Field, Knots};
use crate::integrator::Counter;
use crate::lanes::*;
use crate::packet::Rays;
use crate::skip::{Leap, SkipGrid};

/// How many segments are visited between two looks at the blocks: fewer than samples, because what
/// is looked for is often a surface.
const RUN: usize = 4;

/// A piece of a ray between two nodes, in every lane.
pub struct Segment<S: Lanes> {
    /// Distances of its ends from the entry, in steps.
    pub distance: [F32<S>; 2],
    /// Its length in steps: exactly 1 between two samples.
    pub length: F32<S>,
    /// Data values at its ends; NaN where absent.
    pub value: [F32<S>; 2],
    /// Lanes that have this segment.
    pub lanes: Mask<S>,
}

impl<S: Lanes> Segment<S> {
    /// Distance of its middle from the entry, in steps.
    #[inline(always)]
    pub fn middle(&self) -> F32<S> {
        (self.distance[0] + self.distance[1]) * 0.5
    }
}

/// What becomes of rays after a segment.
pub struct Verdict<S: Lanes> {
    /// Rays that are done.
    pub done: Mask<S>,
    /// Rays that wait with this segment until all others do, too.
    pub wait: Mask<S>,
}

/// What is done with segments.
pub trait Visit<S: Lanes> {
    /// Looks at the next segment of every ray.
    fn visit(&mut self, segment: &Segment<S>, counter: &mut Counter<S>) -> Verdict<S>;

    /// Called when every ray has ended or waits; returns the rays that are done.
    fn resume(&mut self, s: S, _: &mut Counter<S>) -> Mask<S> {
        all(s, false)
    }
}

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
    let mut open = rays.count.simd_gt(nothing);
    let mut waiting = all(s, false);
    let mut front = splat(s, f32::NAN);
    let mut carried = false;
    // Rays that have taken their front value: a packet fetches all of them when one ray needs it.
    let mut taken = all(s, false);
    loop {
        if let Some(skip) = skip {
            let to = skip.leap(s, rays, n, open, Leap::Segments);
            counter.skip(to.min(rays.count) - n);
            let stays = to.simd_eq(n);
            carried &= stays.all_true();
            taken &= stays;
            n = to;
        }
        if !carried {
            front = field.values(s, rays.at(rays.node(s, n)), open);
            counter.sample(open & rays.has_node(n) & !taken);
            carried = true;
            taken = all(s, true);
        }
        let mut distance = rays.node(s, n);
        for _ in 0..RUN {
            open &= rays.has_node(n);
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
            let Verdict { done, wait } = visitor.visit(&segment, counter);
            // Rays that wait stay where they will go on.
            n = open.select(n + 1.0, n);
            (front, distance) = (back, end);
            counter.terminate(done & open);
            waiting |= wait & open;
            open &= !(done | wait);
        }
        if !open.any_true() {
            if !waiting.any_true() {
                return;
            }
            let done = visitor.resume(s, counter) & waiting;
            counter.terminate(done);
            open = waiting & !done;
            waiting = all(s, false);
            carried = false;
        }
    }
}

/// Visits what surfaces are looked for on: [segments](each_segment), or, of nearest voxels, their faces.
#[inline(always)]
pub fn each_surface<S: Lanes, F: Field<S>>(
    s: S,
    field: &F,
    rays: &Rays<S>,
    skip: Option<&SkipGrid>,
    counter: &mut Counter<S>,
    visitor: &mut impl Visit<S>,
) {
    if field.knots() == Knots::FACES {
        each_face(s, field, rays, skip, counter, visitor);
    } else {
        each_segment(s, field, rays, skip, counter, visitor);
    }
}

/// Visits the faces between voxels where a field jumps from the value of one to that of the other: segments of
/// no length. Between nodes of a lattice corners of voxels would be missed.
#[inline(always)]
fn each_face<S: Lanes, F: Field<S>>(
    s: S,
    field: &F,
    rays: &Rays<S>,
    skip: Option<&SkipGrid>,
    counter: &mut Counter<S>,
    visitor: &mut impl Visit<S>,
) {
    let (zero, absent) = (splat(s, 0.0), splat(s, f32::NAN));
    let mut cells = Cells::new(s, rays, Knots::FACES);
    let mut open = rays.count.simd_gt(zero);
    let mut waiting = all(s, false);
    // The value in front of the cell; there is no face at the entry, nor behind what is leapt over.
    let mut front = absent;
    loop {
        if let Some(skip) = skip {
            // From the face by which the cell is entered, which is not looked at if the cell is left.
            let from = cells.ends[0];
            let to = from + skip.way(s, &rays.at(from), &rays.inverse);
            let leaps = open & to.simd_gt(cells.ends[1]);
            cells.leap(s, to, leaps);
            front = leaps.select(absent, front);
            counter.skip(cells.ends[0].min(rays.length()).max(from) - from);
        }
        for _ in 0..cells::RUN {
            open &= cells.are_there();
            if !open.any_true() {
                break;
            }
            let back = field.values(s, rays.at(cells.middle()), open);
            counter.sample(open);
            let face = cells.ends[0];
            let segment = Segment { distance: [face, face], length: zero, value: [front, back], lanes: open };
            let Verdict { done, wait } = visitor.visit(&segment, counter);
            front = open.select(back, front);
            cells.advance(s, open);
            counter.terminate(done & open);
            waiting |= wait & open;
            open &= !(done | wait);
        }
        if !open.any_true() {
            if !waiting.any_true() {
                return;
            }
            let done = visitor.resume(s, counter) & waiting;
            counter.terminate(done);
            open = waiting & !done;
            waiting = all(s, false);
        }
    }
}
