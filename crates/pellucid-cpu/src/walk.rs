//! What walks along rays have in common: pieces of rays that are looked at, and rays that wait for the others.

use crate::integrator::Counter;
use crate::lanes::*;
use crate::packet::Rays;

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

/// Rays that are followed side by side, some of which wait for the others.
pub struct Following<S: Lanes> {
    /// Rays that go on.
    pub open: Mask<S>,
    /// Rays that wait.
    waiting: Mask<S>,
}

/// What becomes of a packet after a few segments.
#[derive(PartialEq, Eq)]
pub enum Next {
    /// It goes on.
    Same,
    /// It goes on with the rays that waited.
    Resumed,
    /// All its rays have ended.
    Done,
}

impl<S: Lanes> Following<S> {
    /// All rays of a packet that have any length.
    #[inline(always)]
    pub fn new(s: S, rays: &Rays<S>) -> Self {
        Self { open: rays.count.simd_gt(splat(s, 0.0)), waiting: all(s, false) }
    }

    /// Visits the next segments of open rays.
    #[inline(always)]
    pub fn visit(&mut self, segment: &Segment<S>, counter: &mut Counter<S>, visitor: &mut impl Visit<S>) {
        let Verdict { done, wait } = visitor.visit(segment, counter);
        counter.terminate(done & self.open);
        self.waiting |= wait & self.open;
        self.open &= !(done | wait);
    }

    /// Lets waiting rays go on where no other does.
    #[inline(always)]
    pub fn next(&mut self, s: S, counter: &mut Counter<S>, visitor: &mut impl Visit<S>) -> Next {
        if self.open.any_true() {
            return Next::Same;
        }
        if !self.waiting.any_true() {
            return Next::Done;
        }
        let done = visitor.resume(s, counter) & self.waiting;
        counter.terminate(done);
        *self = Self { open: self.waiting & !done, waiting: all(s, false) };
        Next::Resumed
    }
}
