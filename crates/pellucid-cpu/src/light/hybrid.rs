//! Between a cloud and a surface: `C = E ((1 - S) P + S f)` (K-10, K-11).

use super::blinn_phong::{BlinnPhong, Reflected};
use super::gradient::{Slope, ramp};
use super::lights::Arrivals;
use super::scatter::Scatter;
use super::shading::Shading;
use super::unlit::Unlit;
use crate::lanes::*;

/// Samples of which a share reflects light, and the rest scatters it.
pub struct Hybrid<'a> {
    /// How the rest does, and what share is a surface.
    pub scatter: Scatter<'a>,
    /// How the share does.
    pub reflection: BlinnPhong,
}

impl<S: Lanes> Shading<S> for Hybrid<'_> {
    #[inline(always)]
    fn has_surface(&self, s: S, sample: &Unlit<S>) -> bool {
        let share = || self.scatter.at(s, sample.value).surface;
        self.scatter.by_gradient().is_some() || (sample.lanes & share().simd_gt(splat(s, 0.0))).any_true()
    }

    fn weighs_gradients(&self) -> bool {
        self.reflection.weight.is_some() || self.scatter.by_gradient().is_some()
    }

    #[inline(always)]
    fn along(&self, s: S, mu: F32<S>) -> Option<[F32<S>; 3]> {
        self.scatter.along(s, mu)
    }

    #[inline(always)]
    fn shade(&self, s: S, sample: &Unlit<S>, slope: &Slope<S>, _: Option<F32<S>>, lights: &Arrivals<S>) -> [F32<S>; 4] {
        let (Self { scatter, reflection }, zero) = (self, splat(s, 0.0));
        let (found, to_eye) = (scatter.at(s, sample.value), &lights.aim.to_eye);
        let normal = reflection.normal(s, slope, to_eye);
        let (mut scattered, mut reflected) = ([zero; 3], Reflected { diffuse: [zero; 3], specular: [zero; 3] });
        lights.each(
            s,
            #[inline(always)]
            |light| {
                reflection.reflect(s, &mut reflected, light, &normal);
                scatter.add(s, &mut scattered, light, (found.g, to_eye), sample.lanes);
            },
        );
        let share = match scatter.by_gradient() {
            Some(weight) => ramp(s, weight, slope.magnitude),
            None => found.surface,
        };
        let (Reflected { diffuse, specular }, unlit) = (reflected, splat(s, reflection.unlit()));
        let factor = xyz!(C => lerp::<S>(share, scattered[C], diffuse[C]) + unlit);
        sample.lit(s, factor, xyz!(C => specular[C] * share))
    }
}
