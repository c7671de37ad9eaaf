//! First surfaces of constant value, found along the ray without a mesh (5.5-8).

use pellucid_optics::{ColorSpace, TransferFunction};
use pellucid_scene::Isovalue;

use crate::field::{Field, Knots};
use crate::integrator::{Counter, Integrator, Tally, Traced, one_by_one};
use crate::lanes::*;
use crate::packet::{Packet, Rays};
use crate::segments::{Segment, Verdict, Visit, each_surface};
use crate::skip::SkipGrid;
use crate::surface::{Aim, Surface, Unlit, normals};

/// A surface, classified.
#[derive(Clone, Copy, Debug)]
pub struct Level {
    /// Data value.
    pub value: f32,
    /// Linear RGB.
    pub color: [f32; 3],
    /// Opacity.
    pub opacity: f32,
}

impl Level {
    /// The surface of the document, its colour from the transfer function unless it has its own.
    pub fn new(iso: &Isovalue, tf: &TransferFunction) -> Self {
        let color = iso.color.map_or_else(|| tf.color(iso.value), |color| color.to_linear(ColorSpace::Srgb));
        Self { value: iso.value as f32, color, opacity: iso.opacity }
    }
}

/// Shaded isosurfaces.
pub struct Isosurfaces<'a, S, F> {
    /// The instruction set.
    pub s: S,
    /// The field.
    pub field: F,
    /// Light, if surfaces are shaded.
    pub surface: Option<Surface<'a, S>>,
    /// The surfaces, in ascending order.
    pub levels: Vec<Level>,
    /// Turns a gradient per index step into one per world unit.
    pub world_from_index_gradient: [[f32; 3]; 3],
    /// Blocks that hold a surface, if the others are skipped.
    pub skip: Option<&'a SkipGrid>,
    /// Opacity at which a ray stops.
    pub early_termination: f32,
}

/// Lanes in which a level lies between two values that are there.
#[inline(always)]
pub fn between<S: Lanes>([front, back]: [F32<S>; 2], level: F32<S>) -> Mask<S> {
    let (below, under) = (front.simd_lt(level), back.simd_lt(level));
    let present = front.is_finite() & back.is_finite();
    present & ((below & !under) | (!below & under))
}

/// Pieces of rays that surfaces cross.
struct Crossed<S: Lanes> {
    distance: [F32<S>; 2],
    value: [F32<S>; 2],
    lanes: Mask<S>,
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
        self.s.vectorize(
            #[inline(always)]
            || self.follow(packet, &Rays::new(self.s, packet), Some(Vec::new()), counter).hits.unwrap_or_default(),
        )
    }
}

impl<S: Lanes, F: Field<S>> Integrator for Isosurfaces<'_, S, F> {
    fn width(&self) -> usize {
        width::<S>()
    }

    fn trace(&self, wave: &[Packet], traced: &mut [Traced], tally: &mut Tally) {
        let s = self.s;
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
        let (crossed, done) = (&mut self.crossed, all(self.mode.s, false));
        let wait = segment.lanes & self.mode.crosses(segment.value);
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
        let s = self.s;
        let (zero, none) = (splat(s, 0.0), all(s, false));
        let to_eye = xyz!(I => -load(s, &packet.world_direction[I]));
        let aim = self.surface.as_ref().map(
            #[inline(always)]
            |surface| surface.aim(s, to_eye),
        );
        let met = Surfacing { color: [zero; 4], depth: splat(s, f32::INFINITY), normal: [zero; 3], aim, hits };
        let crossed = Crossed { distance: [zero; 2], value: [zero; 2], lanes: none };
        let mut search = Search { mode: self, rays, crossed, met };
        each_surface(s, &self.field, rays, self.skip, counter, &mut search);
        search.met
    }

    /// Lanes in which any level lies between two values.
    #[inline(always)]
    fn crosses(&self, value: [F32<S>; 2]) -> Mask<S> {
        let mut any = all(self.s, false);
        for level in &self.levels {
            any |= between::<S>(value, splat(self.s, level.value));
        }
        any
    }

    /// Adds the surfaces that segments cross, nearest first. Returns the rays that are done.
    #[inline(always)]
    fn meet(&self, rays: &Rays<S>, crossed: &Crossed<S>, met: &mut Surfacing<S>, counter: &mut Counter<S>) -> Mask<S> {
        let s = self.s;
        let mut done = all(s, false);
        // A ray leaves the value at the segment's start and meets levels in the order of value.
        let rising = crossed.value[1].simd_gt(crossed.value[0]);
        for (up, down) in self.levels.iter().zip(self.levels.iter().rev()) {
            let level = rising.select(splat(s, up.value), splat(s, down.value));
            let lanes = crossed.lanes & !done & between::<S>(crossed.value, level);
            if !lanes.any_true() {
                continue;
            }
            counter.see(lanes);
            let (distance, gradient) = if self.field.knots() == Knots::FACES {
                (crossed.distance[0], self.across_face(rays, crossed))
            } else {
                let distance = self.root(rays, crossed, level, lanes);
                (distance, self.field.gradients(s, rays.at(distance), lanes))
            };
            let index = rays.at(distance);
            let base = xyz!(C => rising.select(splat(s, up.color[C]), splat(s, down.color[C])));
            let opacity = rising.select(splat(s, up.opacity), splat(s, down.opacity));
            let mut rgba = [base[0] * opacity, base[1] * opacity, base[2] * opacity, opacity];
            if let (Some(surface), Some(aim)) = (&self.surface, &met.aim) {
                let sample = Unlit { rgba, value: level, index, lanes };
                rgba = surface.shade(
                    s,
                    &sample,
                    aim,
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

    /// Gradients of a field of nearest voxels where rays pass the face between two: the jump from the one to the
    /// other, one voxel on. Central differences would be those of other voxels.
    #[inline(always)]
    fn across_face(&self, rays: &Rays<S>, crossed: &Crossed<S>) -> Vec3<S> {
        let zero = splat(self.s, 0.0);
        // Which of the planes half way between voxels is passed here, in steps off.
        let off = xyz!(I => {
            let place = rays.direction[I].mul_add(crossed.distance[0], rays.origin[I]) + 0.5;
            ((place - (place + 0.5).floor()) * rays.inverse[I]).abs()
        });
        let nearest = off[0].min(off[1]).min(off[2]);
        let x = off[0].simd_le(nearest);
        let y = !x & off[1].simd_le(nearest);
        let jump = crossed.value[1] - crossed.value[0];
        let rise = xyz!(I => rays.inverse[I].simd_gt(zero).select(jump, -jump));
        let slope = [x.select(rise[0], zero), y.select(rise[1], zero), (x | y).select(zero, rise[2])];
        let [a, b, c] = &self.world_from_index_gradient;
        xyz!(I => slope[0] * a[I] + slope[1] * b[I] + slope[2] * c[I])
    }

    /// Where the field passes `level` between two distances whose values bracket it: regula falsi
    /// with the Illinois rule, with bisection when it stalls. What is absent on the way counts as
    /// beyond the surface, which then is where the field ends.
    #[inline(always)]
    fn root(&self, rays: &Rays<S>, crossed: &Crossed<S>, level: F32<S>, lanes: Mask<S>) -> F32<S> {
        /// Width of the bracket, in voxels, at which a root is found.
        const ROOT_VOXELS: f32 = 2e-5;
        let (s, zero) = (self.s, splat(self.s, 0.0));
        let [mut t0, mut t1] = crossed.distance;
        let (mut f0, mut f1) = (crossed.value[0] - level, crossed.value[1] - level);
        let [x, y, z] = xyz!(I => rays.direction[I].abs());
        let tolerance = splat(s, ROOT_VOXELS) / x.max(y).max(z).max(splat(s, 1e-12));
        let mut found = t0;
        let mut there = lanes;
        let mut open = lanes;
        let (mut kept_left, mut kept_right) = (all(s, false), all(s, false));
        for round in 0..32 {
            let middle = (t0 + t1) * 0.5;
            let secant = (t1 - t0).mul_add(f0 / (f0 - f1), t0);
            // Never outside the bracket: rounding, or both ends on the level.
            let inside = secant.simd_ge(t0) & secant.simd_le(t1);
            let t = if round % 3 == 2 { middle } else { inside.select(secant, middle) };
            found = open.select(t, found);
            let f = self.field.values(s, rays.at(t), open) - level;
            let present = f.is_finite();
            there = (open & present) | (!open & there);
            let same = f.simd_lt(zero);
            let front = f0.simd_lt(zero);
            let left = present & ((same & front) | (!same & !front));
            // An end that stays twice counts half, or it would stay for ever.
            f1 = (left & kept_right).select(f1 * 0.5, f1);
            f0 = (!left & kept_left).select(f0 * 0.5, f0);
            (kept_right, kept_left) = (left, !left);
            t0 = left.select(t, t0);
            f0 = left.select(f, f0);
            t1 = left.select(t1, t);
            f1 = (present & !left).select(f, f1);
            // An exact value ends the search, too.
            open &= (t1 - t0).simd_gt(tolerance) & f.simd_ne(zero);
            if !open.any_true() {
                break;
            }
        }
        there.select(found, t0)
    }
}
