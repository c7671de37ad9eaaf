//! What lies along rays: one answer to the questions of all techniques, whatever it is made of.
//!
//! [`OneGrid`] is a volume with its optics, compiled into the loops of the modes. [`Many`] are several, each behind
//! [`Layer`], merged sample by sample.

mod choice;
mod crossing;
mod emission;
mod many;
mod merge;
mod one_grid;
mod run;
mod values;
mod ways;

pub use choice::{Shadowing, WithMedium};
pub use crossing::{Crossed, Isolevels, Level, crosses, each_piece, root};
pub use emission::Emission;
pub use many::Many;
pub use merge::{merged, settle};
pub use one_grid::{Integrals, OneGrid, Segmented};
pub use run::{Piece, Run, Span};
pub use values::ValueOptics;
pub use ways::{Progress, Ways};

use crate::cut::Cut;
use crate::element::Element;
use crate::lanes::*;
use crate::light::{Aim, Lighting};
use crate::packet::{Packet, Rays};

/// What light needs of the eye's rays.
pub struct Beam<S: Lanes> {
    /// Where the eye and the lights are.
    pub aim: Aim<S>,
    /// The faces of cut matter by which rays came in.
    pub cut: Cut<S>,
}

impl<S: Lanes> Beam<S> {
    /// Gradients at index positions as a surface takes them: what is cut has those of its faces.
    #[inline(always)]
    pub fn gradients(&self, s: S, lighting: &Lighting<S>, index: &Vec3<S>, gradients: Vec3<S>) -> Vec3<S> {
        if lighting.weighs_gradients() { gradients } else { self.cut.gradients(s, index, gradients) }
    }
}

/// A volume among others.
pub trait Layer<S: Lanes>: Sync {
    /// What light needs of the eye's rays, if samples are lit.
    fn aim(&self, packet: &Packet, rays: &Rays<S>) -> Option<Beam<S>>;

    /// How many of the lattice's pieces from nodes on certainly show nothing, where no border cuts them: the nodes are so
    /// far from where rays enter the layer, and samples lie where `jitter` says.
    fn clear(&self, rays: &Rays<S>, node: F32<S>, jitter: F32<S>) -> F32<S>;

    /// Writes down what pieces of rays in it send to the eye, over their own length: into every `stride`-th place.
    fn look(&self, span: &Span<S>, run: &Run<S>, found: (&mut [Element<S>], usize));

    /// Unit normals of the field at index positions; zero where there is none.
    fn normals(&self, index: Vec3<S>, lanes: Mask<S>) -> Vec3<S>;
}
