//! What is the same for all light that passes a slab.

use pellucid_optics::Chroma;
use pellucid_scene::InScatter;

use super::looks::Looks;

/// How light passes one slab, the same for all texels.
pub struct Step<'a, S> {
    /// The instruction set.
    pub s: S,
    /// The slab's number in the run.
    pub number: usize,
    /// Where light is gathered from.
    pub looks: Looks<'a>,
    /// How each colour of direct light is held back, if not all alike.
    pub chroma: Option<Chroma>,
    /// What becomes indirect light.
    pub in_scatter: InScatter,
    /// Weights of direct light that is scattered into the cone.
    pub phase: [f32; 3],
    /// 1 where something is, else 0, in every channel of a texel, if light comes from there alone.
    pub presence: Option<&'a [f32]>,
}
