//! Several volumes in one picture: composited together, sample by sample.

use pellucid_scene::Overlap;

use super::{Layer, Ways};
use crate::composite::{Accumulation, Accumulator};
use crate::element::Element;
use crate::integrator::{Counter, Integrator, Tally, Traced};
use crate::lanes::*;
use crate::packet::Packet;

/// Layers on one lattice.
pub struct Many<'a, S> {
    /// The instruction set.
    pub s: S,
    /// The layers, in an order that the picture does not depend on, but for [`Overlap::Priority`].
    pub layers: Vec<Box<dyn Layer<S> + 'a>>,
    /// What lies where they overlap.
    pub overlap: Overlap,
    /// How their light accumulates.
    pub accumulation: Accumulation,
    /// Of the lattice, in world units.
    pub step: f64,
}

impl<S: Lanes> Integrator for Many<'_, S> {
    fn width(&self) -> usize {
        width::<S>()
    }

    fn trace(&self, wave: &[Packet], traced: &mut [Traced], tally: &mut Tally) {
        let s = self.s;
        s.vectorize(
            #[inline(always)]
            || {
                for (packets, traced) in wave.chunks_exact(self.layers.len() + 1).zip(traced) {
                    let ways = Ways::of_eye(s, packets, &self.layers, self.step);
                    let (mut counter, mut ray) = (Counter::new(s), self.accumulation.start(s));
                    self.follow(&ways, &mut ray, &mut counter);
                    self.accumulation.finish(
                        s,
                        &ray,
                        traced,
                        #[inline(always)]
                        |half, met| ways.normals(s, &self.layers, half, met),
                    );
                    counter.finish(traced, tally);
                }
            },
        );
    }
}

impl<S: Lanes> Many<'_, S> {
    #[inline(always)]
    fn follow(&self, ways: &Ways<S>, ray: &mut Accumulator<S>, counter: &mut Counter<S>) {
        let (s, what) = (self.s, (&*self.layers, self.overlap));
        let mut progress = ways.start(s);
        while ways.run(
            s,
            &mut progress,
            what,
            counter,
            #[inline(always)]
            |distance, Element { rgba, visible }, _| self.accumulation.add(s, ray, distance, *rgba, *visible),
        ) {}
    }
}
