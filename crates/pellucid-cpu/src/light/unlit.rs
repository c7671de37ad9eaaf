//! What light is to fall on.

use crate::lanes::*;

/// Samples to be lit.
pub struct Unlit<S: Lanes> {
    /// Associated linear RGB and opacity.
    pub rgba: [F32<S>; 4],
    /// Data values.
    pub value: F32<S>,
    /// Index positions.
    pub index: Vec3<S>,
    /// Lanes that have a sample.
    pub lanes: Mask<S>,
}

impl<S: Lanes> Unlit<S> {
    /// Factors of their own colours, and highlights, as what goes to the eye. Colours are associated and stay so: light is
    /// weighted by the sample's opacity, or transparent samples would glow (5.4-1).
    #[inline(always)]
    pub fn lit(&self, s: S, factor: [F32<S>; 3], highlight: [F32<S>; 3]) -> [F32<S>; 4] {
        let (rgba, lanes, zero) = (&self.rgba, self.lanes, splat(s, 0.0));
        let [r, g, b] = xyz!(C => rgba[C].mul_add(factor[C], highlight[C] * rgba[3]));
        [lanes.select(r, zero), lanes.select(g, zero), lanes.select(b, zero), rgba[3]]
    }
}
