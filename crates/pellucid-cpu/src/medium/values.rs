//! ValueOptics of a field and what they look like, where one of them stands for a whole ray (1.4-10, 1.4-11).

use super::OneGrid;
use crate::classify::Lookup;
use crate::element::Element;
use crate::field::Field;
use crate::lanes::*;

/// Optics of values that stand for rays.
pub struct ValueOptics<'a> {
    /// The transfer function. Its opacity is corrected for no length.
    pub table: Lookup<'a>,
    /// Opacity 1 wherever there is a value (slices) instead of the table's.
    pub opaque: bool,
}

impl<S: Lanes, F: Field<S>> OneGrid<'_, S, F, ValueOptics<'_>> {
    /// Data values at index positions; not finite where there is none.
    #[inline(always)]
    pub fn values(&self, index: Vec3<S>, lanes: Mask<S>) -> F32<S> {
        self.field.values(self.s, index, lanes)
    }

    /// What values look like.
    #[inline(always)]
    pub fn shown(&self, value: F32<S>) -> Element<S> {
        let (s, ValueOptics { table, opaque }) = (self.s, &self.optics);
        let visible = value.is_finite();
        let [r, g, b, a] = table.lookup(s, value);
        let a = if *opaque { visible.select(splat(s, 1.0), splat(s, 0.0)) } else { a };
        Element { rgba: [r * a, g * a, b * a, a], visible }
    }
}
