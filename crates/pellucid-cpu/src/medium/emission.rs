//! Emission without absorption (1.2-7, model 2): the medium of the transfer function gives its light `q = kappa c` and
//! takes none away.

use super::OneGrid;
use crate::classify::Lookup;
use crate::field::Field;
use crate::lanes::*;
use crate::samples::Sample;

/// Optics of a medium that only shines.
pub struct Emission<'a> {
    /// Colour and opacity per unit distance.
    pub table: Lookup<'a>,
    /// Step in unit distances.
    pub step_ratio: f32,
}

impl<S: Lanes, F: Field<S>> OneGrid<'_, S, F, Emission<'_>> {
    /// Colours of samples, what they are to be multiplied with, and the lanes that shine.
    #[inline(always)]
    pub fn emission(&self, sample: &Sample<S>) -> ([F32<S>; 3], F32<S>, Mask<S>) {
        /// Opacity 1 would shine infinitely; this one emits 9.2 times its colour per unit distance.
        const BRIGHTEST: f32 = 0.9999;
        let (s, Emission { table, step_ratio }) = (self.s, &self.optics);
        let [r, g, b, a] = table.lookup(s, self.field.values(s, sample.index, sample.lanes));
        let visible = sample.lanes & a.simd_gt(splat(s, 0.0));
        let depth = extinction(s, a.min(splat(s, BRIGHTEST))) * sample.ratio * *step_ratio;
        ([r, g, b], visible.select(depth, splat(s, 0.0)), visible)
    }
}
