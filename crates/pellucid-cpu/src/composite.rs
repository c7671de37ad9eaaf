//! Emission and absorption, front to back (1.4-8, 7.1-2).

use pellucid_optics::Chroma;

use crate::chroma;
use crate::classify::Classify;
use crate::element::Element;
use crate::field::Field;
use crate::integrator::{Counter, Integrator, Tally, Traced, one_by_one};
use crate::lanes::*;
use crate::medium::{Beam, Integrals, OneGrid};
use crate::packet::{Packet, Rays};
use crate::samples::March;
use crate::segments::each_segment;
use crate::vary::Vary;
use crate::walk::{Segment, Verdict, Visit};

/// The accumulated light of every ray.
pub struct Accumulator<S: Lanes> {
    color: [F32<S>; 4],
    /// Distance at which opacity first reached one half.
    half: F32<S>,
}

impl<S: Lanes> Accumulator<S> {
    /// Opacity of what has been met, of the colour that is lost least.
    #[inline(always)]
    pub fn opacity(&self) -> F32<S> {
        self.color[3]
    }
}

/// How light accumulates along rays.
pub struct Accumulation {
    /// How each colour is held back, if not all alike.
    pub chroma: Option<Chroma>,
    /// Opacity at which a ray stops.
    pub early_termination: f32,
}

impl Accumulation {
    /// Nothing yet.
    #[inline(always)]
    pub fn start<S: Lanes>(&self, s: S) -> Accumulator<S> {
        Accumulator { color: [splat(s, 0.0); 4], half: splat(s, f32::INFINITY) }
    }

    /// Adds samples behind what is there. Returns the rays that are done.
    #[inline(always)]
    pub fn add<S: Lanes>(
        &self,
        s: S,
        ray: &mut Accumulator<S>,
        distance: F32<S>,
        rgba: [F32<S>; 4],
        lanes: Mask<S>,
    ) -> Mask<S> {
        let zero = splat(s, 0.0);
        let transmittance = lanes.select(splat(s, 1.0) - ray.color[3], zero);
        match &self.chroma {
            None => ray.color = rgba!(C => transmittance.mul_add(rgba[C], ray.color[C])),
            Some(_) => {
                let found = chroma::over(s, self.chroma.as_ref(), ray.color, rgba);
                ray.color = rgba!(C => lanes.select(found[C], ray.color[C]));
            }
        }
        let reached = ray.color[3].simd_ge(splat(s, 0.5)) & ray.half.simd_eq(splat(s, f32::INFINITY));
        ray.half = reached.select(distance, ray.half);
        ray.color[3].simd_ge(splat(s, self.early_termination))
    }

    /// Writes down what rays have met; `normals` are asked for where opacity has reached one half.
    #[inline(always)]
    pub fn finish<S: Lanes>(
        &self,
        s: S,
        ray: &Accumulator<S>,
        traced: &mut Traced,
        normals: impl FnOnce(F32<S>, Mask<S>) -> Vec3<S>,
    ) {
        let [r, g, b, alpha] = ray.color;
        traced.set_color::<S>([r, g, b, chroma::coverage(s, self.chroma.as_ref(), alpha)]);
        if self.chroma.is_some() {
            traced.set_opacities::<S>(chroma::opacities(s, self.chroma.as_ref(), alpha));
        }
        let met = ray.half.is_finite();
        let mut normal = [splat(s, 0.0); 3];
        if met.any_true() {
            normal = normals(met.select(ray.half, splat(s, 0.0)), met);
        }
        traced.set_surface(s, met, ray.half, normal);
    }
}

/// Compositing of classified samples.
pub struct Composite<'a, S, F, C> {
    /// What lies along rays.
    pub medium: OneGrid<'a, S, F, C>,
    /// How its light accumulates.
    pub accumulation: Accumulation,
}

impl<S: Lanes, F: Field<S>, C: Classify<S>> Integrator for Composite<'_, S, F, C> {
    fn width(&self) -> usize {
        width::<S>()
    }

    fn trace(&self, wave: &[Packet], traced: &mut [Traced], tally: &mut Tally) {
        match self.medium.lighting {
            Some(_) => self.follow::<true>(wave, traced, tally),
            None => self.follow::<false>(wave, traced, tally),
        }
    }
}

impl<S: Lanes, F: Field<S>, C: Classify<S>> Composite<'_, S, F, C> {
    #[inline(always)]
    fn follow<const LIT: bool>(&self, wave: &[Packet], traced: &mut [Traced], tally: &mut Tally) {
        let (medium, accumulation, s) = (&self.medium, &self.accumulation, self.medium.s);
        s.vectorize(
            #[inline(always)]
            || {
                let mut followed: Vec<Followed<S>> = Vec::with_capacity(wave.len());
                for packet in wave {
                    let (rays, counter) = (Rays::new(s, packet), Counter::new(s));
                    let march = March::new(s, &rays, medium.levels);
                    let beam = medium.beam(packet.to_eye(s), &rays.origin, &rays.direction);
                    followed.push(Followed { rays, march, counter, beam, ray: accumulation.start(s), open: true });
                }
                while followed.iter().any(|packet| packet.open) {
                    for packet in followed.iter_mut().filter(|packet| packet.open) {
                        let (ray, beam) = (&mut packet.ray, packet.beam.as_ref());
                        packet.open = packet.march.run(
                            s,
                            &packet.rays,
                            medium.skip,
                            &mut packet.counter,
                            #[inline(always)]
                            |index| medium.field.prefetch(s, index),
                            #[inline(always)]
                            |sample, counter| {
                                let element = medium.sample::<LIT>(beam, sample, Some(ray.opacity()));
                                let Some(Element { rgba, visible }) = element else { return all(s, false) };
                                counter.see(visible);
                                accumulation.add(s, ray, sample.distance, rgba, visible)
                            },
                        );
                    }
                }
                for (Followed { rays, ray, counter, .. }, traced) in followed.into_iter().zip(traced) {
                    accumulation.finish(
                        s,
                        &ray,
                        traced,
                        #[inline(always)]
                        |half, met| medium.normals_at(rays.at(half), met),
                    );
                    counter.finish(traced, tally);
                }
            },
        );
    }
}

/// A packet on its way.
struct Followed<'a, S: Lanes> {
    rays: Rays<S>,
    march: March<'a, S>,
    counter: Counter<S>,
    beam: Option<Beam<S>>,
    ray: Accumulator<S>,
    open: bool,
}

/// Compositing of pre-integrated segments between the nodes of the lattice (4.6-7, 7.2-3): one
/// fetch a step, and the first segment starts at the entry, not at a made-up value of 0.
pub struct PreIntegrated<'a, S, F, V> {
    /// What lies along rays.
    pub medium: OneGrid<'a, S, F, Integrals<'a, V>>,
    /// How its light accumulates.
    pub accumulation: Accumulation,
}

impl<S: Lanes, F: Field<S>, V: Vary> Integrator for PreIntegrated<'_, S, F, V> {
    fn width(&self) -> usize {
        width::<S>()
    }

    fn trace(&self, wave: &[Packet], traced: &mut [Traced], tally: &mut Tally) {
        let (medium, accumulation, s) = (&self.medium, &self.accumulation, self.medium.s);
        one_by_one(
            s,
            wave,
            traced,
            tally,
            #[inline(always)]
            |packet, rays, traced, counter| {
                let (mut ray, beam) =
                    (accumulation.start(s), medium.beam(packet.to_eye(s), &rays.origin, &rays.direction));
                let mut compositing = Compositing { mode: self, rays, beam: beam.as_ref(), ray: &mut ray };
                each_segment(s, &medium.field, rays, medium.skip, counter, &mut compositing);
                accumulation.finish(
                    s,
                    &ray,
                    traced,
                    #[inline(always)]
                    |half, met| medium.normals_at(rays.at(half), met),
                );
            },
        );
    }
}

/// Segments on their way into the accumulator.
struct Compositing<'a, S: Lanes, F, V> {
    mode: &'a PreIntegrated<'a, S, F, V>,
    rays: &'a Rays<S>,
    beam: Option<&'a Beam<S>>,
    ray: &'a mut Accumulator<S>,
}

impl<S: Lanes, F: Field<S>, V: Vary> Visit<S> for Compositing<'_, S, F, V> {
    #[inline(always)]
    fn visit(&mut self, segment: &Segment<S>, counter: &mut Counter<S>) -> Verdict<S> {
        let PreIntegrated { medium, accumulation } = self.mode;
        let none = all(medium.s, false);
        let element = medium.between(self.rays, self.beam, segment, Some(self.ray.opacity()));
        let Some(Element { rgba, visible }) = element else { return Verdict { done: none, wait: none } };
        counter.see(visible);
        Verdict { done: accumulation.add(medium.s, self.ray, segment.middle(), rgba, visible), wait: none }
    }
}
