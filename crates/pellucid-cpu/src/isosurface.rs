//! First surfaces of constant value, found along the ray without a mesh (5.5-8).

use crate::field::Field;
use crate::illumination::{Illuminate, SeenSurface};
use crate::integrator::{Counter, Integrator, Tally, Traced, one_by_one};
use crate::lanes::*;
use crate::light::{Aim, Unlit, normals};
use crate::medium::{Crossed, Isolevels, OneGrid, crosses};
use crate::packet::{Packet, Rays};
use crate::walk::{Segment, Verdict, Visit};

/// Shaded isosurfaces.
pub struct Isosurfaces<'a, S, F> {
    /// What lies along rays: the surfaces, in ascending order.
    pub medium: OneGrid<'a, S, F, Isolevels>,
    /// What lights them from everywhere, if anything does.
    pub illumination: Option<Box<dyn Illuminate<S> + 'a>>,
    /// Opacity at which a ray stops.
    pub early_termination: f32,
}

/// What rays have met so far.
struct Surfacing<S: Lanes> {
    color: [F32<S>; 4],
    depth: F32<S>,
    normal: Vec3<S>,
    aim: Option<Aim<S>>,
    /// Every surface by itself, if it is to be known.
    hits: Option<Vec<Hit<S>>>,
}

/// A surface that rays meet.
pub struct Hit<S: Lanes> {
    /// Distance from the entry, in steps.
    pub distance: F32<S>,
    /// Associated linear RGB and opacity.
    pub rgba: [F32<S>; 4],
    /// Unit normals.
    pub normal: Vec3<S>,
    /// Lanes that meet it.
    pub lanes: Mask<S>,
}

/// Surfaces of a volume among others.
pub trait Surfaced<S: Lanes>: Sync {
    /// All surfaces that the rays of a packet meet, up to where those of this volume alone hide all behind.
    fn hits(&self, packet: &Packet, counter: &mut Counter<S>) -> Vec<Hit<S>>;
}

impl<S: Lanes, F: Field<S>> Surfaced<S> for Isosurfaces<'_, S, F> {
    fn hits(&self, packet: &Packet, counter: &mut Counter<S>) -> Vec<Hit<S>> {
        self.medium.s.vectorize(
            #[inline(always)]
            || {
                self.follow(packet, &Rays::new(self.medium.s, packet), Some(Vec::new()), counter)
                    .hits
                    .unwrap_or_default()
            },
        )
    }
}

impl<S: Lanes, F: Field<S>> Integrator for Isosurfaces<'_, S, F> {
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
            |packet, rays, traced, counter| {
                let met = self.follow(packet, rays, None, counter);
                traced.set_color::<S>(met.color);
                traced.set_surface(s, met.depth.is_finite(), met.depth, met.normal);
            },
        );
    }
}

/// The search along the rays of a packet. Rays that meet a surface wait for the others, so that
/// surfaces are located and shaded for all of them at once.
struct Search<'a, S: Lanes, F> {
    mode: &'a Isosurfaces<'a, S, F>,
    rays: &'a Rays<S>,
    crossed: Crossed<S>,
    met: Surfacing<S>,
}

impl<S: Lanes, F: Field<S>> Visit<S> for Search<'_, S, F> {
    #[inline(always)]
    fn visit(&mut self, segment: &Segment<S>, _: &mut Counter<S>) -> Verdict<S> {
        let (crossed, done) = (&mut self.crossed, all(self.mode.medium.s, false));
        let wait = segment.lanes & self.mode.medium.crosses(segment.value);
        if wait.any_true() {
            for end in 0..2 {
                crossed.distance[end] = wait.select(segment.distance[end], crossed.distance[end]);
                crossed.value[end] = wait.select(segment.value[end], crossed.value[end]);
            }
            crossed.lanes |= wait;
        }
        Verdict { done, wait }
    }

    #[inline(always)]
    fn resume(&mut self, s: S, counter: &mut Counter<S>) -> Mask<S> {
        let done = self.mode.meet(self.rays, &self.crossed, &mut self.met, counter);
        self.crossed.lanes = all(s, false);
        done
    }
}

impl<S: Lanes, F: Field<S>> Isosurfaces<'_, S, F> {
    /// What rays meet.
    #[inline(always)]
    fn follow(
        &self,
        packet: &Packet,
        rays: &Rays<S>,
        hits: Option<Vec<Hit<S>>>,
        counter: &mut Counter<S>,
    ) -> Surfacing<S> {
        let s = self.medium.s;
        let (zero, none) = (splat(s, 0.0), all(s, false));
        let aim = self.medium.aim(packet.to_eye(s));
        let met = Surfacing { color: [zero; 4], depth: splat(s, f32::INFINITY), normal: [zero; 3], aim, hits };
        let crossed = Crossed { distance: [zero; 2], value: [zero; 2], lanes: none };
        let mut search = Search { mode: self, rays, crossed, met };
        self.medium.each_piece(rays, counter, &mut search);
        search.met
    }

    /// Adds the surfaces that segments cross, nearest first. Returns the rays that are done.
    #[inline(always)]
    fn meet(&self, rays: &Rays<S>, crossed: &Crossed<S>, met: &mut Surfacing<S>, counter: &mut Counter<S>) -> Mask<S> {
        let (s, levels) = (self.medium.s, &self.medium.optics.each);
        let mut done = all(s, false);
        // A ray leaves the value at the segment's start and meets levels in the order of value.
        let rising = crossed.value[1].simd_gt(crossed.value[0]);
        for (up, down) in levels.iter().zip(levels.iter().rev()) {
            let level = rising.select(splat(s, up.value), splat(s, down.value));
            let lanes = crossed.lanes & !done & crosses::<S>(crossed.value, level);
            if !lanes.any_true() {
                continue;
            }
            counter.see(lanes);
            let (distance, gradient) = self.medium.crossing(rays, crossed, level, lanes);
            let index = rays.at(distance);
            let base = xyz!(C => rising.select(splat(s, up.color[C]), splat(s, down.color[C])));
            let opacity = rising.select(splat(s, up.opacity), splat(s, down.opacity));
            let mut rgba = [base[0] * opacity, base[1] * opacity, base[2] * opacity, opacity];
            if let Some(illumination) = &self.illumination {
                let light = illumination.light(&SeenSurface { index, level, from_below: rising, lanes });
                rgba = [rgba[0] * light[0], rgba[1] * light[1], rgba[2] * light[2], opacity];
            } else if let (Some(lighting), Some(aim)) = (&self.medium.lighting, &met.aim) {
                let sample = Unlit { rgba, value: level, index, lanes };
                rgba = lighting.shade(
                    s,
                    &sample,
                    aim,
                    Some(met.color[3]),
                    #[inline(always)]
                    || gradient,
                );
            }
            let transmittance = lanes.select(splat(s, 1.0) - met.color[3], splat(s, 0.0));
            met.color = rgba!(C => transmittance.mul_add(rgba[C], met.color[C]));
            let first = lanes & met.depth.simd_eq(splat(s, f32::INFINITY));
            let normal = normals(s, gradient).0;
            met.depth = first.select(distance, met.depth);
            met.normal = xyz!(I => first.select(normal[I], met.normal[I]));
            if let Some(hits) = &mut met.hits {
                hits.push(Hit { distance, rgba, normal, lanes });
            }
            done |= lanes & met.color[3].simd_ge(splat(s, self.early_termination));
        }
        done
    }
}
