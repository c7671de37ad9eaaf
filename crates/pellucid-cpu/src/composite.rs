//! Emission and absorption, front to back (1.4-8, 7.1-2).

use pellucid_optics::Chroma;

use crate::chroma;
use crate::classify::{Classified, Classify, Segments};
use crate::cut::{Cut, Cuts};
use crate::field::Field;
use crate::integrator::{Counter, Integrator, Tally, Traced, one_by_one};
use crate::lanes::*;
use crate::packet::{Packet, Rays};
use crate::samples::March;
use crate::segments::{Segment, Verdict, Visit, each_segment};
use crate::skip::{Levels, SkipGrid};
use crate::surface::{Aim, Surface, Unlit, normals};
use crate::vary::Vary;

/// What every compositing loop shares: the field, light, empty blocks and the stop criterion.
pub struct Medium<'a, S, F> {
    /// The instruction set.
    pub s: S,
    /// The field.
    pub field: F,
    /// Light, if surfaces are shaded.
    pub surface: Option<Surface<'a, S>>,
    /// Where matter is cut.
    pub cuts: Cuts,
    /// Blocks that can contribute, if empty space is skipped.
    pub skip: Option<&'a SkipGrid>,
    /// The strides that blocks allow, if steps adapt to the data.
    pub levels: Option<&'a Levels>,
    /// How each colour is held back, if not all alike.
    pub chroma: Option<Chroma>,
    /// Opacity at which a ray stops.
    pub early_termination: f32,
}

/// The accumulated light of every ray.
struct Accumulator<S: Lanes> {
    color: [F32<S>; 4],
    /// Distance at which opacity first reached one half.
    half: F32<S>,
    /// What light needs of the ray, if samples are lit.
    lit: Option<Ray<S>>,
}

/// How a ray that is lit came in.
struct Ray<S: Lanes> {
    aim: Aim<S>,
    cut: Cut<S>,
}

impl<S: Lanes, F: Field<S>> Medium<'_, S, F> {
    #[inline(always)]
    fn start(&self, packet: &Packet, rays: &Rays<S>) -> Accumulator<S> {
        let (s, zero) = (self.s, splat(self.s, 0.0));
        let to_eye = xyz!(I => -load(s, &packet.world_direction[I]));
        let lit = self.surface.as_ref().map(
            #[inline(always)]
            |surface| Ray { aim: surface.aim(s, to_eye), cut: self.cut(rays) },
        );
        Accumulator { color: [zero; 4], half: splat(s, f32::INFINITY), lit }
    }

    #[inline(always)]
    fn cut(&self, rays: &Rays<S>) -> Cut<S> {
        self.cuts.met(self.s, &rays.origin, &rays.direction)
    }

    /// Shades associated samples, if samples are lit.
    #[inline(always)]
    fn lit(&self, ray: &Option<Ray<S>>, sample: &Unlit<S>, gradients: impl FnOnce() -> Vec3<S>) -> [F32<S>; 4] {
        let (Some(surface), Some(Ray { aim, cut })) = (&self.surface, ray) else { return sample.rgba };
        surface.shade(
            self.s,
            sample,
            aim,
            #[inline(always)]
            || if surface.weighs_gradients() { gradients() } else { cut.gradients(self.s, &sample.index, gradients()) },
        )
    }

    /// Adds samples behind what is there. Returns the rays that are done.
    #[inline(always)]
    fn add(&self, ray: &mut Accumulator<S>, distance: F32<S>, rgba: [F32<S>; 4], lanes: Mask<S>) -> Mask<S> {
        let zero = splat(self.s, 0.0);
        let through = lanes.select(splat(self.s, 1.0) - ray.color[3], zero);
        match &self.chroma {
            None => ray.color = rgba!(C => through.mul_add(rgba[C], ray.color[C])),
            Some(_) => {
                let found = chroma::over(self.s, self.chroma.as_ref(), ray.color, rgba);
                ray.color = rgba!(C => lanes.select(found[C], ray.color[C]));
            }
        }
        let reached = ray.color[3].simd_ge(splat(self.s, 0.5)) & ray.half.simd_eq(splat(self.s, f32::INFINITY));
        ray.half = reached.select(distance, ray.half);
        ray.color[3].simd_ge(splat(self.s, self.early_termination))
    }

    #[inline(always)]
    fn finish(&self, ray: &Accumulator<S>, rays: &Rays<S>, traced: &mut Traced) {
        let [r, g, b, alpha] = ray.color;
        traced.set_color::<S>([r, g, b, chroma::coverage(self.s, self.chroma.as_ref(), alpha)]);
        if self.chroma.is_some() {
            traced.set_opacities::<S>(chroma::opacities(self.s, self.chroma.as_ref(), alpha));
        }
        let met = ray.half.is_finite();
        let mut normal = [splat(self.s, 0.0); 3];
        if met.any_true() {
            let index = rays.at(met.select(ray.half, splat(self.s, 0.0)));
            let value = self.field.values(self.s, index, met);
            let present = value.is_finite();
            let gradient = self.field.gradients(self.s, index, met);
            let found = normals(self.s, gradient).0;
            normal = xyz!(I => present.select(found[I], splat(self.s, 0.0)));
        }
        traced.set_surface(self.s, met, ray.half, normal);
    }
}

/// Compositing of classified samples.
pub struct Composite<'a, S, F, C> {
    /// The shared parts.
    pub medium: Medium<'a, S, F>,
    /// How samples get colour and opacity.
    pub classifier: C,
}

impl<S: Lanes, F: Field<S>, C: Classify<S>> Integrator for Composite<'_, S, F, C> {
    fn width(&self) -> usize {
        width::<S>()
    }

    fn trace(&self, wave: &[Packet], traced: &mut [Traced], tally: &mut Tally) {
        // Two loops: one that never lights has registers to spare.
        match self.medium.surface {
            Some(_) => self.follow::<true>(wave, traced, tally),
            None => self.follow::<false>(wave, traced, tally),
        }
    }
}

impl<S: Lanes, F: Field<S>, C: Classify<S>> Composite<'_, S, F, C> {
    #[inline(always)]
    fn follow<const LIT: bool>(&self, wave: &[Packet], traced: &mut [Traced], tally: &mut Tally) {
        let (medium, s) = (&self.medium, self.medium.s);
        s.vectorize(
            #[inline(always)]
            || {
                let mut followed: Vec<Followed<S>> = Vec::with_capacity(wave.len());
                for packet in wave {
                    let (rays, counter) = (Rays::new(s, packet), Counter::new(s));
                    let march = March::new(s, &rays, medium.levels);
                    let ray = medium.start(packet, &rays);
                    followed.push(Followed { rays, march, counter, ray, open: true });
                }
                while followed.iter().any(|packet| packet.open) {
                    for packet in followed.iter_mut().filter(|packet| packet.open) {
                        let ray = &mut packet.ray;
                        packet.open = packet.march.run(
                            s,
                            &packet.rays,
                            medium.skip,
                            &mut packet.counter,
                            #[inline(always)]
                            |index| medium.field.prefetch(s, index),
                            #[inline(always)]
                            |sample, counter| {
                                let (value, near) = if LIT {
                                    let (value, near) = medium.field.values_near(s, sample.index, sample.lanes);
                                    (value, Some(near))
                                } else {
                                    (medium.field.values(s, sample.index, sample.lanes), None)
                                };
                                let classified = self.classifier.classify(s, value, sample);
                                let Some(Classified { mut rgba, visible }) = classified else { return all(s, false) };
                                counter.see(visible);
                                if sample.shortened {
                                    rgba = chroma::over_length(s, medium.chroma.as_ref(), rgba, sample.ratio);
                                }
                                if let Some(near) = near {
                                    rgba = medium.lit(
                                        &ray.lit,
                                        &Unlit { rgba, value, index: sample.index, lanes: visible },
                                        #[inline(always)]
                                        || medium.field.gradients_near(s, &near, visible),
                                    );
                                }
                                medium.add(ray, sample.distance, rgba, visible)
                            },
                        );
                    }
                }
                for (packet, traced) in followed.into_iter().zip(traced) {
                    medium.finish(&packet.ray, &packet.rays, traced);
                    packet.counter.finish(traced, tally);
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
    ray: Accumulator<S>,
    open: bool,
}

/// Compositing of pre-integrated segments between the nodes of the lattice (4.6-7, 7.2-3): one
/// fetch a step, and the first segment starts at the entry, not at a made-up value of 0.
pub struct PreIntegrated<'a, S, F, V> {
    /// The shared parts.
    pub medium: Medium<'a, S, F>,
    /// Ray integrals of one full step.
    pub table: Segments<'a>,
    /// What varies them.
    pub vary: V,
}

impl<S: Lanes, F: Field<S>, V: Vary> Integrator for PreIntegrated<'_, S, F, V> {
    fn width(&self) -> usize {
        width::<S>()
    }

    fn trace(&self, wave: &[Packet], traced: &mut [Traced], tally: &mut Tally) {
        let (medium, s) = (&self.medium, self.medium.s);
        one_by_one(
            s,
            wave,
            traced,
            tally,
            #[inline(always)]
            |packet, rays, traced, counter| {
                let mut ray = medium.start(packet, rays);
                let (skip, field) = (medium.skip, &medium.field);
                let mut compositing = Compositing { mode: self, rays, ray: &mut ray };
                each_segment(s, field, rays, skip, counter, &mut compositing);
                medium.finish(&ray, rays, traced);
            },
        );
    }
}

/// Segments on their way into the accumulator.
struct Compositing<'a, S: Lanes, F, V> {
    mode: &'a PreIntegrated<'a, S, F, V>,
    rays: &'a Rays<S>,
    ray: &'a mut Accumulator<S>,
}

impl<S: Lanes, F: Field<S>, V: Vary> Visit<S> for Compositing<'_, S, F, V> {
    #[inline(always)]
    fn visit(&mut self, segment: &Segment<S>, counter: &mut Counter<S>) -> Verdict<S> {
        let medium = &self.mode.medium;
        let none = all(medium.s, false);
        let (rgba, visible) = self.mode.integral(segment);
        if !visible.any_true() {
            return Verdict { done: none, wait: none };
        }
        counter.see(visible);
        let middle = (segment.distance[0] + segment.distance[1]) * 0.5;
        let (index, [front, back]) = (self.rays.at(middle), segment.value);
        let rgba = self.mode.vary.vary(medium.s, &index, rgba);
        let value = (front.is_finite().select(front, back) + back.is_finite().select(back, front)) * 0.5;
        let rgba = medium.lit(
            &self.ray.lit,
            &Unlit { rgba, value, index, lanes: visible },
            #[inline(always)]
            || medium.field.gradients(medium.s, index, visible),
        );
        Verdict { done: medium.add(self.ray, middle, rgba, visible), wait: none }
    }
}

impl<S: Lanes, F: Field<S>, V> PreIntegrated<'_, S, F, V> {
    /// The integrals over segments, and the lanes that have any opacity. Where one end is absent
    /// the field reaches half way with the value of the other.
    #[inline(always)]
    fn integral(&self, segment: &Segment<S>) -> ([F32<S>; 4], Mask<S>) {
        let s = self.medium.s;
        let [front, back] = segment.value;
        let present = [front.is_finite(), back.is_finite()];
        let length = (present[0] & present[1]).select(segment.length, segment.length * 0.5);
        let lanes = segment.lanes & (present[0] | present[1]);
        let [from, to] = [present[0].select(front, back), present[1].select(back, front)];
        let rgba = self.table.lookup(s, [from, to], length, lanes);
        (rgba, lanes & rgba[3].simd_gt(splat(s, 0.0)))
    }
}
