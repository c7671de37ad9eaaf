//! Projections: what a ray makes of its values without an order (1.4-10, 1.4-11).

use crate::cells::{self, Cells};
use crate::classify::Post;
use crate::element::Element;
use crate::field::{Any, Field};
use crate::integrator::{Counter, Integrator, Tally, Traced, one_by_one};
use crate::lanes::*;
use crate::medium::{Emission, OneGrid, ValueOptics};
use crate::packet::{Packet, Rays};
use crate::samples::March;
use crate::skip::ExtremeGrid;

/// The largest or the smallest value of the field on a ray: exact where the field is trilinear, whatever the step.
pub struct Extreme<'a, S, F> {
    /// What lies along rays: values.
    pub medium: OneGrid<'a, S, F, ValueOptics<'a>>,
    /// Blocks, if those that cannot change the extreme are leapt over.
    pub blocks: Option<&'a ExtremeGrid>,
    /// Smallest instead of largest.
    pub minimum: bool,
}

impl<S: Lanes, F: Field<S>> Integrator for Extreme<'_, S, F> {
    fn width(&self) -> usize {
        width::<S>()
    }

    fn trace(&self, wave: &[Packet], traced: &mut [Traced], tally: &mut Tally) {
        let s = self.medium.s;
        s.vectorize(
            #[inline(always)]
            || {
                let mut searches: Vec<ExtremeSearch<S>> = Vec::with_capacity(wave.len());
                for packet in wave {
                    let (rays, counter) = (Rays::new(s, packet), Counter::new(s));
                    let cells = Cells::new(s, &rays, self.medium.field.knots());
                    let (best, depth) = (splat(s, f32::NEG_INFINITY), splat(s, f32::INFINITY));
                    searches.push(ExtremeSearch { rays, counter, cells, best, depth, open: true });
                }
                while searches.iter().any(|search| search.open) {
                    for search in searches.iter_mut().filter(|search| search.open) {
                        self.run(search);
                    }
                }
                for (mut search, traced) in searches.into_iter().zip(traced) {
                    let best = search.best;
                    let value = best.is_finite().select(best * self.sign(), splat(s, f32::NAN));
                    show(&self.medium, value, search.depth, traced, &mut search.counter);
                    search.counter.finish(traced, tally);
                }
            },
        );
    }
}

/// A packet on its way to its extremes.
struct ExtremeSearch<S: Lanes> {
    rays: Rays<S>,
    counter: Counter<S>,
    cells: Cells<S>,
    best: F32<S>,
    depth: F32<S>,
    open: bool,
}

impl<S: Lanes, F: Field<S>> Extreme<'_, S, F> {
    /// The smallest value is the largest with its sign turned.
    #[inline(always)]
    fn sign(&self) -> f32 {
        if self.minimum { -1.0 } else { 1.0 }
    }

    /// Looks at the next pieces that may exceed the best.
    #[inline(always)]
    fn run(&self, search: &mut ExtremeSearch<S>) {
        let s = self.medium.s;
        let ExtremeSearch { rays, counter, cells, .. } = search;
        let (mut best, mut depth) = (search.best, search.depth);
        if let Some(skip) = self.blocks {
            let from = cells.ends[0];
            skip.leap(s, rays, cells, best);
            counter.skip(cells.ends[0].min(rays.length()).max(from) - from);
        }
        for number in 0..cells::RUN {
            let lanes = cells.are_there();
            if !lanes.any_true() {
                break;
            }
            if number % 2 == 0 {
                self.medium.field.prefetch(s, rays.at(cells.middle() + cells::RUN as f32));
            }
            counter.sample(lanes);
            let [from, to] = cells.ends;
            let [value, part] = self.medium.field.highest(s, &[rays.at(from), rays.at(to)], self.sign(), best, lanes);
            let better = lanes & value.simd_gt(best);
            best = better.select(value, best);
            depth = better.select(lerp::<S>(part, from, to), depth);
            cells.advance(s, lanes);
        }
        search.open = cells.are_there().any_true();
        (search.best, search.depth) = (best, depth);
    }
}

/// The mean value.
pub struct Average<'a, S, F> {
    /// What lies along rays: values.
    pub medium: OneGrid<'a, S, F, ValueOptics<'a>>,
}

impl<S: Lanes, F: Field<S>> Integrator for Average<'_, S, F> {
    fn width(&self) -> usize {
        width::<S>()
    }

    fn trace(&self, wave: &[Packet], traced: &mut [Traced], tally: &mut Tally) {
        let s = self.medium.s;
        one_by_one(
            s,
            wave,
            traced,
            tally,
            #[inline(always)]
            |_, rays, traced, counter| {
                let (mut sum, mut length) = (splat(s, 0.0), splat(s, 0.0));
                // What rounding took from the sum (Kahan): values may be many times the width of what a
                // transfer function tells apart.
                let mut lost = splat(s, 0.0);
                let mut march = March::new(s, rays, None);
                while march.run(
                    s,
                    rays,
                    None,
                    counter,
                    |_| (),
                    #[inline(always)]
                    |sample, _| {
                        let value = self.medium.values(sample.index, sample.lanes);
                        let present = sample.lanes & value.is_finite();
                        let part = value.mul_add(sample.ratio, -lost);
                        let next = sum + part;
                        lost = present.select((next - sum) - part, lost);
                        sum = present.select(next, sum);
                        length = present.select(length + sample.ratio, length);
                        all(s, false)
                    },
                ) {}
                // An empty ray divides zero by zero: NaN, which is absent.
                let nowhere = splat(s, f32::INFINITY);
                show(&self.medium, sum / length, nowhere, traced, counter);
            },
        );
    }
}

/// Writes down what one value for a whole ray looks like.
#[inline(always)]
pub fn show<S: Lanes, F: Field<S>>(
    medium: &OneGrid<S, F, ValueOptics>,
    value: F32<S>,
    depth: F32<S>,
    traced: &mut Traced,
    counter: &mut Counter<S>,
) {
    let (s, Element { rgba, visible }) = (medium.s, medium.shown(value));
    counter.see(visible);
    traced.set_color::<S>(rgba);
    traced.set_surface(s, visible, depth, [splat(s, 0.0); 3]);
}

/// Emission without absorption: the picture adds to what is behind it.
pub struct Additive<'a, S, F> {
    /// What lies along rays: what shines.
    pub medium: OneGrid<'a, S, F, Emission<'a>>,
}

impl<S: Lanes, F: Field<S>> Integrator for Additive<'_, S, F> {
    fn width(&self) -> usize {
        width::<S>()
    }

    fn trace(&self, wave: &[Packet], traced: &mut [Traced], tally: &mut Tally) {
        let s = self.medium.s;
        one_by_one(
            s,
            wave,
            traced,
            tally,
            #[inline(always)]
            |_, rays, traced, counter| {
                let mut sum = [splat(s, 0.0); 3];
                let mut march = March::new(s, rays, None);
                while march.run(
                    s,
                    rays,
                    self.medium.skip,
                    counter,
                    |_| (),
                    #[inline(always)]
                    |sample, counter| {
                        let (color, depth, visible) = self.medium.emission(sample);
                        counter.see(visible);
                        for (sum, channel) in sum.iter_mut().zip(color) {
                            *sum = channel.mul_add(depth, *sum);
                        }
                        all(s, false)
                    },
                ) {}
                let [r, g, b] = sum;
                traced.set_color::<S>([r, g, b, splat(s, 0.0)]);
            },
        );
    }
}

/// A radiograph (1.2-7, model 1; 1.4-11): the share of light held back, in white.
pub struct XRay<'a, S: Lanes> {
    /// What lies along rays: opacities of single steps.
    pub medium: OneGrid<'a, S, Any<'a, S>, Post<'a>>,
}

impl<S: Lanes> Integrator for XRay<'_, S> {
    fn width(&self) -> usize {
        width::<S>()
    }

    fn trace(&self, wave: &[Packet], traced: &mut [Traced], tally: &mut Tally) {
        let s = self.medium.s;
        one_by_one(
            s,
            wave,
            traced,
            tally,
            #[inline(always)]
            |_, rays, traced, counter| {
                let mut transmittance = splat(s, 1.0);
                let mut march = March::new(s, rays, None);
                while march.run(
                    s,
                    rays,
                    self.medium.skip,
                    counter,
                    |_| (),
                    #[inline(always)]
                    |sample, counter| {
                        let Some((alpha, visible)) = self.medium.opacities(sample) else { return all(s, false) };
                        counter.see(visible);
                        transmittance = visible.select(transmittance - transmittance * alpha, transmittance);
                        all(s, false)
                    },
                ) {}
                traced.set_color::<S>([splat(s, 1.0) - transmittance; 4]);
            },
        );
    }
}
