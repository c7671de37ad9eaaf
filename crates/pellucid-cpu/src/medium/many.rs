//! Several volumes in one picture: composited together, sample by sample.

use pellucid_scene::Overlap;

use super::{Layer, Progress, Ways};
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
                let group = self.layers.len() + 1;
                let mut followed: Vec<FollowedLayers<S>> = Vec::with_capacity(traced.len());
                for packets in wave.chunks_exact(group) {
                    let ways = Ways::of_eye(s, packets, &self.layers, self.step);
                    let (progress, counter) = (ways.start(s), Counter::new(s));
                    followed.push(FollowedLayers {
                        ways,
                        progress,
                        counter,
                        ray: self.accumulation.start(s),
                        open: true,
                    });
                }
                while followed.iter().any(|packet| packet.open) {
                    for packet in followed.iter_mut().filter(|packet| packet.open) {
                        packet.open = self.run(packet);
                    }
                }
                for (FollowedLayers { ways, ray, counter, .. }, traced) in followed.into_iter().zip(traced) {
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

/// A packet on its way.
struct FollowedLayers<S: Lanes> {
    ways: Ways<S>,
    progress: Progress<S>,
    counter: Counter<S>,
    ray: Accumulator<S>,
    open: bool,
}

impl<S: Lanes> Many<'_, S> {
    /// Goes on with a packet for a run. Returns whether there is more.
    #[inline(always)]
    fn run(&self, FollowedLayers { ways, progress, counter, ray, .. }: &mut FollowedLayers<S>) -> bool {
        progress.front = Some(ray.opacity());
        ways.run(
            self.s,
            progress,
            (&*self.layers, self.overlap),
            counter,
            #[inline(always)]
            |distance, Element { rgba, visible }, _| self.accumulation.add(self.s, ray, distance, *rgba, *visible),
        )
    }
}
