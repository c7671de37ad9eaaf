//! Fields that are asked lane by lane, and fields of any kind behind one type.

use std::ops::Deref;

use glam::DVec3;
use pellucid_field::{Reconstruct, Sampler};

use super::{Corners, Course, Field, Knots, Near, Probe};
use crate::lanes::*;

/// Any reconstruction, in f64, one lane after the other: for what lanes cannot read, as several
/// components to a voxel, or sums wider than the grid.
pub struct General<'a>(pub Probe<'a, Sampler<'a>>, pub Knots);

impl<S: Lanes> Field<S> for General<'_> {
    #[inline(always)]
    fn values(&self, s: S, index: Vec3<S>, lanes: Mask<S>) -> F32<S> {
        value_of_each(s, &self.0, index, lanes)
    }

    #[inline(always)]
    fn gradients(&self, s: S, index: Vec3<S>, lanes: Mask<S>) -> Vec3<S> {
        gradient_of_each(s, &self.0, index, lanes)
    }

    fn knots(&self) -> Knots {
        self.1
    }
}

/// A field known at run time only: one virtual call a packet, for modes that are not worth a copy
/// of their own for every voxel type.
pub type Any<'a, S> = Box<dyn Field<S> + 'a>;

/// What leads to a field stands for it.
impl<S: Lanes, P: Deref<Target: Field<S>> + Sync> Field<S> for P {
    #[inline(always)]
    fn values(&self, s: S, index: Vec3<S>, lanes: Mask<S>) -> F32<S> {
        (**self).values(s, index, lanes)
    }

    #[inline(always)]
    fn gradients(&self, s: S, index: Vec3<S>, lanes: Mask<S>) -> Vec3<S> {
        (**self).gradients(s, index, lanes)
    }

    #[inline(always)]
    fn prefetch(&self, s: S, index: Vec3<S>) {
        (**self).prefetch(s, index);
    }

    #[inline(always)]
    fn values_near(&self, s: S, index: Vec3<S>, lanes: Mask<S>) -> (F32<S>, Near<S>) {
        (**self).values_near(s, index, lanes)
    }

    #[inline(always)]
    fn gradients_near(&self, s: S, near: &Near<S>, lanes: Mask<S>) -> Vec3<S> {
        (**self).gradients_near(s, near, lanes)
    }

    #[inline(always)]
    fn knots(&self) -> Knots {
        (**self).knots()
    }

    #[inline(always)]
    fn highest(&self, s: S, piece: &[Vec3<S>; 2], sign: f32, above: F32<S>, lanes: Mask<S>) -> [F32<S>; 2] {
        (**self).highest(s, piece, sign, above, lanes)
    }

    #[inline(always)]
    fn course(&self, s: S, piece: &[Vec3<S>; 2], range: [F32<S>; 2], lanes: Mask<S>) -> Course<S> {
        (**self).course(s, piece, range, lanes)
    }

    #[inline(always)]
    fn corners(&self, s: S, index: Vec3<S>, lanes: Mask<S>) -> Option<Corners<S>> {
        (**self).corners(s, index, lanes)
    }
}

/// A field as it goes into [`Any`]: its methods are entered with the instruction set switched on.
pub struct Entered<F>(pub F);

impl<S: Lanes, F: Field<S>> Field<S> for Entered<F> {
    fn values(&self, s: S, index: Vec3<S>, lanes: Mask<S>) -> F32<S> {
        s.vectorize(
            #[inline(always)]
            || self.0.values(s, index, lanes),
        )
    }

    fn gradients(&self, s: S, index: Vec3<S>, lanes: Mask<S>) -> Vec3<S> {
        s.vectorize(
            #[inline(always)]
            || self.0.gradients(s, index, lanes),
        )
    }

    fn prefetch(&self, s: S, index: Vec3<S>) {
        s.vectorize(
            #[inline(always)]
            || self.0.prefetch(s, index),
        );
    }

    fn values_near(&self, s: S, index: Vec3<S>, lanes: Mask<S>) -> (F32<S>, Near<S>) {
        s.vectorize(
            #[inline(always)]
            || self.0.values_near(s, index, lanes),
        )
    }

    fn gradients_near(&self, s: S, near: &Near<S>, lanes: Mask<S>) -> Vec3<S> {
        s.vectorize(
            #[inline(always)]
            || self.0.gradients_near(s, near, lanes),
        )
    }

    fn knots(&self) -> Knots {
        self.0.knots()
    }

    fn highest(&self, s: S, piece: &[Vec3<S>; 2], sign: f32, above: F32<S>, lanes: Mask<S>) -> [F32<S>; 2] {
        s.vectorize(
            #[inline(always)]
            || self.0.highest(s, piece, sign, above, lanes),
        )
    }

    fn course(&self, s: S, piece: &[Vec3<S>; 2], range: [F32<S>; 2], lanes: Mask<S>) -> Course<S> {
        s.vectorize(
            #[inline(always)]
            || self.0.course(s, piece, range, lanes),
        )
    }

    fn corners(&self, s: S, index: Vec3<S>, lanes: Mask<S>) -> Option<Corners<S>> {
        s.vectorize(
            #[inline(always)]
            || self.0.corners(s, index, lanes),
        )
    }
}

/// The position of one lane.
#[inline(always)]
pub fn lane_position<S: Lanes>(index: &Vec3<S>, lane: usize) -> DVec3 {
    DVec3::new(f64::from(index[0][lane]), f64::from(index[1][lane]), f64::from(index[2][lane]))
}

/// Values, one lane after the other.
#[inline(never)]
pub fn value_of_each<S: Lanes, R: Reconstruct>(s: S, probe: &Probe<R>, index: Vec3<S>, lanes: Mask<S>) -> F32<S> {
    let mut values = splat(s, f32::NAN);
    let bits = lanes.to_bitmask();
    for lane in (0..width::<S>()).filter(|lane| bits >> lane & 1 == 1) {
        values[lane] = probe.value(lane_position::<S>(&index, lane)) as f32;
    }
    values
}

/// World gradients, one lane after the other.
#[inline(never)]
pub fn gradient_of_each<S: Lanes, R: Reconstruct>(s: S, probe: &Probe<R>, index: Vec3<S>, lanes: Mask<S>) -> Vec3<S> {
    let mut gradients = [splat(s, 0.0); 3];
    let bits = lanes.to_bitmask();
    for lane in (0..width::<S>()).filter(|lane| bits >> lane & 1 == 1) {
        let gradient = probe.gradient(lane_position::<S>(&index, lane));
        for (axis, lanes) in gradients.iter_mut().enumerate() {
            lanes[lane] = gradient[axis] as f32;
        }
    }
    gradients
}
