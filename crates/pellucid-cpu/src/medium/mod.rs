//! What lies along rays: one answer to the questions of all techniques, whatever it is made of.

mod one_grid;

pub use one_grid::{Integrals, OneGrid};

use crate::cut::Cut;
use crate::lanes::*;
use crate::surface::Aim;

/// The optical element at samples, or of segments.
pub struct Element<S: Lanes> {
    /// Associated linear RGB and opacity: of one step, or of a segment's own length.
    pub rgba: [F32<S>; 4],
    /// Lanes with any opacity.
    pub visible: Mask<S>,
}

/// What light needs of the eye's rays.
pub struct Beam<S: Lanes> {
    /// Where the eye and the lights are.
    pub aim: Aim<S>,
    /// The faces of cut matter by which rays came in.
    pub cut: Cut<S>,
}
