//! Light on its way through a slab: attenuated, and what is scattered forward spread over a cone
//! (Eq. 6.6, 6.7, K-06, K-09).

use super::band::{Band, TILE};
use super::blur::Blur;
use super::buffer::{LightBuffer, MOST_CHANNELS, texels};
use super::step::Step;
use crate::lanes::*;

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
