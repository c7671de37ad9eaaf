//! Shadow rays through a medium (6.1-1, K-03): `exp` of less the extinction along the way.

use super::{DARK, Shadow, ToLights};
use crate::integrator::Counter;
use crate::lanes::*;
use crate::medium::Shadowing;
use crate::samples::March;

/// A medium between samples and lights.
pub struct Media<'a, S: Lanes> {
    /// What it is made of, by steps of shadow rays.
    pub medium: Shadowing<'a, S>,
    /// The ways.
    pub ways: ToLights,
}

impl<S: Lanes> Shadow<S> for Media<'_, S> {
    fn transmittance(&self, s: S, light: usize, index: &Vec3<S>, lanes: Mask<S>) -> F32<S> {
        s.vectorize(
            #[inline(always)]
            || {
                let rays = self.ways.rays(s, light, index, lanes, 0.0);
                let (one, mut transmittance) = (splat(s, 1.0), splat(s, 1.0));
                let (mut march, mut counter) = (March::new(s, &rays, None), Counter::new(s));
                while march.run(
                    s,
                    &rays,
                    self.medium.skip,
                    &mut counter,
                    |_| (),
                    #[inline(always)]
                    |sample, _| {
                        let Some((alpha, visible)) = self.medium.opacities(sample) else { return all(s, false) };
                        transmittance = visible.select(transmittance * (one - alpha), transmittance);
                        transmittance.simd_lt(splat(s, DARK))
                    },
                ) {}
                transmittance
            },
        )
    }
}
