//! What a place on a ray sends to the eye, and takes away.

use crate::lanes::*;

/// The optical element at samples, or of segments.
#[derive(Clone, Copy)]
pub struct Element<S: Lanes> {
    /// Associated linear RGB and opacity: of one step, or of a segment's own length.
    pub rgba: [F32<S>; 4],
    /// Lanes with any opacity.
    pub visible: Mask<S>,
}

impl<S: Lanes> Element<S> {
    /// Of what nothing is seen.
    #[inline(always)]
    pub fn nothing(s: S) -> Self {
        Self { rgba: [splat(s, 0.0); 4], visible: all(s, false) }
    }
}
