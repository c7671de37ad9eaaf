//! The contract of shading: what a sample sends to the eye of the light that arrives there.

use super::gradient::Slope;
use super::lights::Arrivals;
use super::unlit::Unlit;
use crate::lanes::*;

/// How samples answer light. It is entered with the instruction set switched on, and `lanes` tells what of the vectors
/// counts.
pub trait Shading<S: Lanes>: Sync {
    /// Whether any of the samples may be part of a surface, so that it is asked with their gradients; else without.
    fn has_surface(&self, s: S, sample: &Unlit<S>) -> bool;

    /// Whether it depends on the length of a gradient, not on its direction alone.
    fn weighs_gradients(&self) -> bool;

    /// What of a light that is the same everywhere goes to the eye, where that is the same along rays, by the cosine
    /// between its way before and after.
    fn along(&self, s: S, mu: F32<S>) -> Option<[F32<S>; 3]>;

    /// Associated colours that go to the eye, and opacities. `front` is the opacity of what is in front of the samples; of
    /// several volumes, in front of the pieces that are looked at together; `None` where rays are not followed from the eye
    /// on.
    fn shade(
        &self,
        s: S,
        sample: &Unlit<S>,
        slope: &Slope<S>,
        front: Option<F32<S>>,
        lights: &Arrivals<S>,
    ) -> [F32<S>; 4];
}
