//! The walk over the samples of a lattice, for modes that look at one value at a time.

use crate::integrator::Counter;
use crate::lanes::*;
use crate::packet::Rays;
use crate::skip::{Leap, SkipGrid};

/// How many samples are taken between two looks at the blocks: asking at every border costs more
/// than the samples it saves.
pub const RUN: usize = 8;

/// One sample in every lane.
pub struct Sample<S: Lanes> {
    /// Distance from the entry, in steps.
    pub distance: F32<S>,
    /// Index position.
    pub index: Vec3<S>,
    /// Length of the segment it stands for, in steps.
    pub ratio: F32<S>,
    /// Whether any ratio is not 1.
    pub shortened: bool,
    /// Lanes that have this sample.
    pub lanes: Mask<S>,
}

/// Visits the samples that can contribute, nearest first. The visitor returns the lanes whose ray
/// is done.
#[inline(always)]
pub fn each_sample<S: Lanes>(
    s: S,
    rays: &Rays<S>,
    skip: Option<&SkipGrid>,
    counter: &mut Counter<S>,
    mut visit: impl FnMut(Sample<S>, &mut Counter<S>) -> Mask<S>,
) {
    let mut k = splat(s, 0.0);
    let mut open = rays.has(k);
    while open.any_true() {
        if let Some(skip) = skip {
            let to = skip.leap(s, rays, k, open, Leap::Samples);
            counter.skip(to.min(rays.count) - k);
            k = to;
        }
        for _ in 0..RUN {
            open &= rays.has(k);
            if !open.any_true() {
                return;
            }
            let last = open & rays.is_last(k);
            let shortened = last.any_true();
            let ratio = if shortened { rays.ratio(s, k) } else { splat(s, 1.0) };
            let distance = if shortened { rays.sample(s, k) } else { k + rays.jitter };
            counter.sample(open);
            let sample = Sample { distance, index: rays.at(distance), ratio, shortened, lanes: open };
            let done = visit(sample, counter) & open;
            counter.terminate(done);
            open &= !done;
            k += 1.0;
        }
    }
}
