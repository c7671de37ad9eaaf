//! Shadow rays through a medium (6.1-1, K-03): `exp` of less the extinction along the way.

use super::{DARK, Shadow, ToLights};
use crate::classify::Lookup;
use crate::field::Any;
use crate::field::Field;
use crate::integrator::Counter;
use crate::lanes::*;
use crate::samples::March;
use crate::skip::SkipGrid;
use crate::vary::Varied;

/// A medium between samples and lights.
pub struct Media<'a, S> {
    /// The field.
    pub field: Any<'a, S>,
    /// Opacities of one step on the way to a light.
    pub table: Lookup<'a>,
    /// The ways.
    pub ways: ToLights,
    /// Blocks that can contribute, if empty space is skipped.
    pub skip: Option<&'a SkipGrid>,
    /// What varies opacities, if anything does.
    pub varied: Option<Varied<'a>>,
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
                    self.skip,
                    &mut counter,
                    |_| (),
                    #[inline(always)]
                    |sample, _| {
                        let value = self.field.values(s, sample.index, sample.lanes);
                        let position = self.table.position(s, value);
                        let visible = sample.lanes & self.table.may_be_visible(s, position);
                        if !visible.any_true() {
                            return all(s, false);
                        }
                        let mut alpha = self.table.at(s, position, None)[3];
                        if let Some(varied) = &self.varied {
                            alpha = varied.opacity(s, &varied.noise(s, &sample.index), alpha);
                        }
                        if sample.shortened {
                            alpha = sample.ratio.simd_lt(one).select(opacity_over(s, alpha, sample.ratio), alpha);
                        }
                        transmittance = visible.select(transmittance * (one - alpha), transmittance);
                        transmittance.simd_lt(splat(s, DARK))
                    },
                ) {}
                transmittance
            },
        )
    }
}
