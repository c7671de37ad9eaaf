//! Light on its way through a slab: attenuated, and what is scattered forward spread over a cone
//! (Eq. 6.6, 6.7, K-06, K-09).

use pellucid_optics::Chroma;
use pellucid_plan::half_angle::LightFrame;
use pellucid_scene::InScatter;

use super::blur::Blur;
use super::buffer::{LightBuffer, MOST_CHANNELS};
use super::matter::{Band, TILE};
use crate::lanes::*;

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

impl<S: Lanes> Step<'_, S> {
    /// Passes a tile of a band: from `light` into rows of the next buffer, which begin with the padding at the
    /// left. Returns whether any of it differs from light as it entered.
    pub fn pass(&self, light: &LightBuffer, next: &mut [f32], band: &Band, [top, tile]: [usize; 2]) -> bool {
        let s = self.s;
        s.vectorize(
            #[inline(always)]
            || {
                let (shape, channels) = (light.shape, light.channels());
                let columns = tile * TILE..shape.width.min((tile + 1) * TILE);
                let length = columns.len() * channels;
                let holds = band.holds(self.number, tile);
                let blur = (channels > 1).then(
                    #[inline(always)]
                    || Blur::new(self, light),
                );
                // Direct light goes straight on, and numbers repeat from texel to texel.
                let [mut fresh, mut blurred] = [[0.0; MOST_LANES]; 2];
                for (number, (fresh, blurred)) in fresh.iter_mut().zip(&mut blurred).enumerate() {
                    *fresh = light.fresh[number % channels];
                    *blurred = if number % channels > 0 { 1.0 } else { 0.0 };
                }
                let fresh = load(s, &fresh);
                let blurred = load(s, &blurred).simd_gt(splat(s, 0.5));
                let (zero, nothing) = (splat(s, 0.0), [0.0; TILE * MOST_CHANNELS]);
                let mut spread = nothing;
                let mut touched = all(s, false);
                for row in 0..next.len() / (shape.stride * channels) {
                    let from = shape.at(columns.start, top + row);
                    let here = &light.lost[from * channels..][..length];
                    let opacity = if holds { band.opacities(self.number, row, &columns) } else { &nothing[..length] };
                    if let Some(blur) = &blur {
                        blur.spread(&mut spread[..length], [columns.start, top + row], opacity, (band, row));
                    }
                    let to = (row * shape.stride + shape.pad + columns.start) * channels;
                    let next = &mut next[to..][..length];
                    for at in (0..length).step_by(width::<S>()) {
                        let lost = blurred.select(texels(s, &spread, at), texels(s, here, at));
                        let lost = texels(s, opacity, at).mul_add(fresh - lost, lost);
                        touched |= lost.simd_ne(zero);
                        lost.store_slice(&mut next[at..at + width::<S>()]);
                    }
                    // Beside the picture nothing is lost, on either side of it.
                    let inside = shape.columns.saturating_sub(columns.start) * channels;
                    if inside < length {
                        next[inside..].fill(0.0);
                    }
                }
                touched.any_true()
            },
        )
    }
}

/// Numbers of texels from a place on.
#[inline(always)]
pub fn texels<S: Lanes>(s: S, numbers: &[f32], from: usize) -> F32<S> {
    F32::<S>::from_slice(s, &numbers[from..from + width::<S>()])
}
