//! Surfaces of constant value in a volume, and where rays cross them.

use pellucid_optics::{ColorSpace, TransferFunction};
use pellucid_scene::Isovalue;

use super::OneGrid;
use crate::field::{Field, Knots};
use crate::integrator::Counter;
use crate::lanes::*;
use crate::monotone::each_monotone;
use crate::packet::Rays;
use crate::segments::{each_face, each_segment};
use crate::skip::SkipGrid;
use crate::walk::Visit;

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

/// The surfaces of a volume.
pub struct Isolevels {
    /// In ascending order.
    pub each: Vec<Level>,
    /// Whether every one is to be found, of a field that is a cubic along rays.
    pub is_exact: bool,
}

impl Isolevels {
    /// The lowest and the highest value.
    #[inline(always)]
    pub fn range(&self) -> [f32; 2] {
        let ends = [self.each.first(), self.each.last()];
        let [low, high] = ends.map(|level| level.map(|level| level.value));
        [low.unwrap_or(f32::INFINITY), high.unwrap_or(f32::NEG_INFINITY)]
    }
}

/// Lanes in which a level lies between two values that are there.
#[inline(always)]
pub fn crosses<S: Lanes>([front, back]: [F32<S>; 2], level: F32<S>) -> Mask<S> {
    let (below, under) = (front.simd_lt(level), back.simd_lt(level));
    let present = front.is_finite() & back.is_finite();
    present & ((below & !under) | (!below & under))
}

/// Pieces of rays that surfaces cross.
pub struct Crossed<S: Lanes> {
    /// Distances of their ends from the entry, in steps.
    pub distance: [F32<S>; 2],
    /// Data values there.
    pub value: [F32<S>; 2],
    /// Lanes that have one.
    pub lanes: Mask<S>,
}

impl<S: Lanes, F: Field<S>> OneGrid<'_, S, F, Isolevels> {
    /// Visits what surfaces are [looked for on](each_piece).
    #[inline(always)]
    pub fn each_piece(&self, rays: &Rays<S>, counter: &mut Counter<S>, visitor: &mut impl Visit<S>) {
        let Self { s, field, optics, skip, .. } = self;
        each_piece(*s, field, rays, (*skip, optics.is_exact.then(|| optics.range())), counter, visitor);
    }

    /// Lanes in which any level lies between two values.
    #[inline(always)]
    pub fn crosses(&self, value: [F32<S>; 2]) -> Mask<S> {
        let mut any = all(self.s, false);
        for level in &self.optics.each {
            any |= crosses::<S>(value, splat(self.s, level.value));
        }
        any
    }

    /// Where pieces of rays cross a level, and the gradients there.
    #[inline(always)]
    pub fn crossing(&self, rays: &Rays<S>, crossed: &Crossed<S>, level: F32<S>, lanes: Mask<S>) -> (F32<S>, Vec3<S>) {
        if self.field.knots() == Knots::FACES {
            return (crossed.distance[0], self.across_face(rays, crossed));
        }
        let distance = root(self.s, &self.field, rays, crossed, level, lanes);
        (distance, self.field.gradients(self.s, rays.at(distance), lanes))
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
        self.cuts.world_gradients::<S>(&slope)
    }
}

/// Visits what surfaces are looked for on: pieces on which the field [rises or falls](each_monotone), where every surface
/// of a range of values is to be found; of nearest voxels, their faces; [segments](each_segment) of others.
#[inline(always)]
pub fn each_piece<S: Lanes, F: Field<S>>(
    s: S,
    field: &F,
    rays: &Rays<S>,
    (skip, range): (Option<&SkipGrid>, Option<[f32; 2]>),
    counter: &mut Counter<S>,
    visitor: &mut impl Visit<S>,
) {
    match range {
        _ if field.knots() == Knots::FACES => each_face(s, field, rays, skip, counter, visitor),
        Some(range) => each_monotone(s, field, rays, (skip, range), counter, visitor),
        None => each_segment(s, field, rays, skip, counter, visitor),
    }
}

/// Where the field passes `level` between two distances whose values bracket it: regula falsi
/// with the Illinois rule, with bisection when it stalls. What is absent on the way counts as
/// beyond the surface, which then is where the field ends.
#[inline(always)]
pub fn root<S: Lanes, F: Field<S>>(
    s: S,
    field: &F,
    rays: &Rays<S>,
    crossed: &Crossed<S>,
    level: F32<S>,
    lanes: Mask<S>,
) -> F32<S> {
    /// Width of the bracket, in voxels, at which a root is found.
    const ROOT_VOXELS: f32 = 2e-5;
    let zero = splat(s, 0.0);
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
        let f = field.values(s, rays.at(t), open) - level;
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
