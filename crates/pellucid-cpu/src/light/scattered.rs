//! Scattering by a phase function (6.2, K-07).

use super::gradient::Slope;
use super::lights::{Arrivals, Arrived};
use super::scatter::Scatter;
use super::shading::Shading;
use super::unlit::Unlit;
use crate::lanes::*;

/// Samples that scatter light once, and have no surfaces.
pub struct Scattered<'a> {
    /// How they do.
    pub scatter: Scatter<'a>,
    /// What is sent in the dark.
    pub unlit: f32,
}

impl<S: Lanes> Shading<S> for Scattered<'_> {
    fn has_surface(&self, _: S, _: &Unlit<S>) -> bool {
        false
    }

    fn weighs_gradients(&self) -> bool {
        false
    }

    #[inline(always)]
    fn along(&self, s: S, mu: F32<S>) -> Option<[F32<S>; 3]> {
        self.scatter.along(s, mu)
    }

    #[inline(always)]
    fn shade(&self, s: S, sample: &Unlit<S>, _: &Slope<S>, _: Option<F32<S>>, lights: &Arrivals<S>) -> [F32<S>; 4] {
        let (zero, unlit, anisotropy) = (splat(s, 0.0), splat(s, self.unlit), self.scatter.at(s, sample.value).g);
        let mut scattered = [zero; 3];
        lights.each(
            s,
            #[inline(always)]
            |light| self.scatter.add(s, &mut scattered, light, (anisotropy, &lights.aim.to_eye), sample.lanes),
        );
        sample.lit(s, xyz!(C => scattered[C] + unlit), [zero; 3])
    }
}

impl Scatter<'_> {
    /// Adds what is scattered of a light.
    #[inline(always)]
    pub fn add<S: Lanes>(
        &self,
        s: S,
        scattered: &mut [F32<S>; 3],
        light: &Arrived<S>,
        (anisotropy, to_eye): (F32<S>, &Vec3<S>),
        lanes: Mask<S>,
    ) {
        let weight = match light.along {
            Some(weight) => weight,
            None => self.weight(s, anisotropy, -dot::<S>(light.to_light, *to_eye), lanes),
        };
        *scattered = xyz!(C => weight[C].mul_add(light.radiance[C], scattered[C]));
    }
}
