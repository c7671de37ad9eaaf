//! What is the same for all light that passes a slab.

use pellucid_optics::Chroma;
use pellucid_plan::half_angle::LightFrame;
use pellucid_scene::InScatter;

/// How light passes one slab, the same for all texels.
pub struct Step<'a, S> {
    /// The instruction set.
    pub s: S,
    /// The slab, and its number in the run.
    pub slab: usize,
    pub number: usize,
    /// Offsets of the taps as shares of the radius; none if nothing is blurred.
    pub offsets: &'a [[f32; 2]],
    /// Radius of the blur.
    pub radius: Radius<'a>,
    /// How each colour of direct light is held back, if not all alike.
    pub chroma: Option<Chroma>,
    /// What becomes indirect light.
    pub in_scatter: InScatter,
    /// Weights of direct light that is scattered into the cone.
    pub phase: [f32; 3],
    /// 1 where something is, else 0, texel by texel, if light comes from there alone.
    pub presence: Option<&'a [f32]>,
}

/// How far a blur reaches.
#[derive(Clone, Copy)]
pub enum Radius<'a> {
    /// So many texels to the right and up, everywhere.
    Texels([f32; 2]),
    /// The tangent of half the cone's angle times this power of the path in a slab, in world units: the way
    /// of a light that is somewhere grows towards the picture's rim, and its texels with the distance.
    Path {
        /// Where texels are in the world.
        frame: &'a LightFrame,
        /// Radius in world units at a path of 1.
        scale: f32,
        /// Whether it grows with the root of the path.
        root: bool,
        /// A step in world units.
        step: f32,
    },
}
