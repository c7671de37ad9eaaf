//! The walk over the samples of rays, for modes that look at one value at a time.

use pellucid_plan::SAMPLES_PER_LOOK;

use crate::integrator::Counter;
use crate::lanes::*;
use crate::packet::Rays;
use crate::skip::{Leap, Levels, SkipGrid};

/// How many samples are taken between two looks at the blocks.
pub const RUN: usize = SAMPLES_PER_LOOK;

/// One sample in every lane.
pub struct Sample<S: Lanes> {
    /// Distance from the entry, in steps.
    pub distance: F32<S>,
    /// Index position.
    pub index: Vec3<S>,
    /// Length of the segment it stands for, in strides.
    pub ratio: F32<S>,
    /// The binary logarithm of the stride, if strides are not all 1.
    pub level: Option<I32<S>>,
    /// Whether any ratio is not 1.
    pub shortened: bool,
    /// Lanes that have this sample.
    pub lanes: Mask<S>,
}

/// How far the rays of a packet have been followed.
pub struct March<'a, S: Lanes> {
    k: F32<S>,
    open: Mask<S>,
    levels: Option<&'a Levels>,
}

impl<'a, S: Lanes> March<'a, S> {
    /// At the first samples, with the strides that blocks allow if steps adapt to the data.
    #[inline(always)]
    pub fn new(s: S, rays: &Rays<S>, levels: Option<&'a Levels>) -> Self {
        let k = splat(s, 0.0);
        Self { k, open: rays.has(k), levels }
    }

    /// Visits the next [`RUN`] samples that can contribute, nearest first; `see` returns the lanes
    /// whose ray is done. `prefetch` hears of positions that come next. Returns whether any ray goes
    /// on.
    #[inline(always)]
    pub fn run(
        &mut self,
        s: S,
        rays: &Rays<S>,
        skip: Option<&SkipGrid>,
        counter: &mut Counter<S>,
        prefetch: impl Fn(Vec3<S>),
        mut see: impl FnMut(&Sample<S>, &mut Counter<S>) -> Mask<S>,
    ) -> bool {
        let Self { mut k, mut open, levels } = *self;
        let mut strides = None;
        if let Some(skip) = skip {
            let to = skip.leap(s, rays, k, open, Leap::Samples);
            counter.skip(to.min(rays.count) - k);
            k = to;
        }
        if let Some(levels) = levels {
            strides = Some(Strides::at(s, rays, levels, k));
        }
        for number in 0..RUN {
            open &= rays.has(k);
            if !open.any_true() {
                return false;
            }
            let (sample, stride) = match &strides {
                None => (sample(s, rays, k, open), splat(s, 1.0)),
                Some(strides) => (strides.sample(s, rays, k, open), strides.length),
            };
            if number % 2 == 0 {
                prefetch(rays.at(stride.mul_add(splat(s, RUN as f32), k)));
            }
            counter.sample(open);
            let done = see(&sample, counter) & open;
            counter.terminate(done);
            open &= !done;
            k += stride;
        }
        *self = Self { k, open, levels };
        open.any_true()
    }
}

/// Sample k of every open ray that has one.
#[inline(always)]
pub fn sample<S: Lanes>(s: S, rays: &Rays<S>, k: F32<S>, open: Mask<S>) -> Sample<S> {
    let lanes = open & rays.has(k);
    let shortened = (lanes & rays.is_last(k)).any_true();
    let ratio = if shortened { rays.ratio(s, k) } else { splat(s, 1.0) };
    let distance = if shortened { rays.sample(s, k) } else { k + rays.jitter };
    Sample { distance, index: rays.at(distance), ratio, level: None, shortened, lanes }
}

/// Steps of different lengths in every lane, for one run.
struct Strides<S: Lanes> {
    level: I32<S>,
    /// In steps.
    length: F32<S>,
}

impl<S: Lanes> Strides<S> {
    /// What the blocks at the next samples allow.
    #[inline(always)]
    fn at(s: S, rays: &Rays<S>, levels: &Levels, k: F32<S>) -> Self {
        let level = levels.at(s, &rays.at(rays.sample(s, k)));
        Self { level, length: (whole(s, 1) << level).to_float() }
    }

    /// The sample of the stride that starts with segment k, in the middle of what is left of it.
    #[inline(always)]
    fn sample(&self, s: S, rays: &Rays<S>, k: F32<S>, open: Mask<S>) -> Sample<S> {
        let lanes = open & rays.has(k);
        let length = rays.stride(k, self.length);
        let shortened = (lanes & length.simd_lt(self.length)).any_true();
        let distance = rays.jitter.mul_add(length, k);
        let ratio = if shortened { length / self.length } else { splat(s, 1.0) };
        Sample { distance, index: rays.at(distance), ratio, level: Some(self.level), shortened, lanes }
    }
}
