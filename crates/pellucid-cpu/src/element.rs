//! What a place on a ray sends to the eye, and takes away.

use crate::lanes::*;

/// The optical element at samples, or of segments.
pub struct Element<S: Lanes> {
    /// Associated linear RGB and opacity: of one step, or of a segment's own length.
    pub rgba: [F32<S>; 4],
    /// Lanes with any opacity.
    pub visible: Mask<S>,
}
