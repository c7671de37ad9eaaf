//! Shadows of isosurfaces: the first opaque one on the way to a light holds all of it back.

use super::{Shadow, ToLights, Turn};
use crate::field::Any;
use crate::integrator::Counter;
use crate::lanes::*;
use crate::medium::{Isolevels, OneGrid, crosses};
use crate::packet::Rays;
use crate::walk::{Segment, Verdict, Visit};

/// Surfaces between samples, which lie on one of them, and lights.
pub struct Surfaces<'a, S> {
    /// What they lie in.
    pub medium: OneGrid<'a, S, Any<'a, S>, Isolevels>,
    /// The ways.
    pub ways: ToLights,
    /// How many steps off the surface they begin: as far as the roughness of sampled data reaches.
    pub away: f32,
}

impl<S: Lanes> Shadow<S> for Surfaces<'_, S> {
    fn transmittance(&self, s: S, light: usize, index: &Vec3<S>, lanes: Mask<S>) -> F32<S> {
        s.vectorize(
            #[inline(always)]
            || {
                // Away from the surface that is lit: how it is turned is what `n . l` tells.
                self.along(s, &self.ways.rays(s, light, index, lanes, self.away))
            },
        )
    }
}

/// The surfaces of several volumes on the way to samples of one of them, each with the way into its own index space.
pub struct Product<'a, S>(pub Vec<(Turn, Surfaces<'a, S>)>);

impl<S: Lanes> Shadow<S> for Product<'_, S> {
    fn transmittance(&self, s: S, light: usize, index: &Vec3<S>, lanes: Mask<S>) -> F32<S> {
        s.vectorize(
            #[inline(always)]
            || {
                let mut transmittance = splat(s, 1.0);
                for (turn, surfaces) in &self.0 {
                    let span = surfaces.ways.span(s, light, &turn.of(s, index), lanes, surfaces.away);
                    transmittance *= surfaces.along(s, &span.rays);
                }
                transmittance
            },
        )
    }
}

impl<S: Lanes> Surfaces<'_, S> {
    /// What is left of light that comes along rays.
    #[inline(always)]
    fn along(&self, s: S, rays: &Rays<S>) -> F32<S> {
        let mut passing = Passing { surfaces: self, transmittance: splat(s, 1.0) };
        self.medium.each_piece(rays, &mut Counter::new(s), &mut passing);
        passing.transmittance
    }
}

/// Light on its way through surfaces.
struct Passing<'a, S: Lanes> {
    surfaces: &'a Surfaces<'a, S>,
    transmittance: F32<S>,
}

impl<S: Lanes> Visit<S> for Passing<'_, S> {
    #[inline(always)]
    fn visit(&mut self, segment: &Segment<S>, _: &mut Counter<S>) -> Verdict<S> {
        let (s, levels) = (self.surfaces.medium.s, &self.surfaces.medium.optics.each);
        for level in levels {
            let met = segment.lanes & crosses::<S>(segment.value, splat(s, level.value));
            self.transmittance = met.select(self.transmittance * (1.0 - level.opacity), self.transmittance);
        }
        Verdict { done: self.transmittance.simd_le(splat(s, 0.0)), wait: all(s, false) }
    }
}
