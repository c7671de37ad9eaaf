//! Light on its way through a slab: attenuated, and what is scattered forward spread over a cone
//! (Eq. 6.6, 6.7, K-06, K-09).

use pellucid_scene::InScatter;

use super::band::{Band, TILE};
use super::blur::Blur;
use super::buffer::{LightBuffer, MOST_CHANNELS, each_channel, each_texel, first_channel, texels};
use super::step::Step;
use crate::chroma;
use crate::lanes::*;
use crate::packet::PerLane;

/// Numbers that texels have in each of their channels, lane by lane.
struct Channels<S: Lanes> {
    /// Light as it entered.
    fresh: F32<S>,
    /// Direct light, which goes straight on.
    is_direct: Mask<S>,
    /// What direct light adds to each.
    phase: F32<S>,
    /// How often what direct light loses is lost of each, if not of all alike.
    ratios: Option<PerLane>,
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
                let holds = band.holds(self.number, tile);
                let numbers = self.channels(light);
                let blur = Blur::new(self, light, numbers.fresh);
                let nothing = [0.0; TILE * MOST_CHANNELS];
                let zero = splat(s, 0.0);
                let mut touched = all(s, false);
                for row in 0..next.len() / (shape.stride * channels) {
                    let from = shape.at(columns.start, top + row);
                    let here = &light.lost[from * channels..][..columns.len() * channels];
                    let opacities = if holds { band.opacities(self.number, row, &columns) } else { &nothing };
                    let to = (row * shape.stride + shape.pad + columns.start) * channels;
                    let next = &mut next[to..][..columns.len() * channels];
                    for x in (0..columns.len()).step_by(width::<S>()) {
                        if channels == 1 {
                            let lost = texels(s, here, x);
                            let lost = texels(s, opacities, x).mul_add(numbers.fresh - lost, lost);
                            touched |= lost.simd_ne(zero);
                            lost.store_slice(&mut next[x..x + width::<S>()]);
                            continue;
                        }
                        let opacity = match band.channels {
                            1 => each_channel::<S>(texels(s, opacities, x)),
                            _ => rgba!(C => texels(s, opacities, x * MOST_CHANNELS + C * width::<S>())),
                        };
                        let around = blur.around([columns.start + x, top + row]);
                        let scattered = self.scattered(&numbers, around, opacity);
                        for part in 0..MOST_CHANNELS {
                            let at = x * MOST_CHANNELS + part * width::<S>();
                            let lost = numbers.is_direct.select(texels(s, here, at), around[part]);
                            let lost = opacity[part].mul_add(numbers.fresh - lost, lost);
                            let lost = lost - scattered[part];
                            touched |= lost.simd_ne(zero);
                            lost.store_slice(&mut next[at..at + width::<S>()]);
                        }
                    }
                    // Beside the picture nothing is lost, on either side of it.
                    let inside = shape.columns.saturating_sub(columns.start) * channels;
                    if inside < next.len() {
                        next[inside..].fill(0.0);
                    }
                }
                touched.any_true()
            },
        )
    }

    #[inline(always)]
    fn channels(&self, light: &LightBuffer) -> Channels<S> {
        let s = self.s;
        let (direct, indirect) = (light.fresh[0], *light.fresh.last().unwrap_or(&0.0));
        let [red, green, blue] = self.phase;
        let ratios = self.chroma.map(|chroma| chroma.ratios);
        let fresh = if light.channels() == 1 { [direct; 4] } else { [direct, indirect, indirect, indirect] };
        Channels {
            fresh: load(s, &each_texel(fresh)),
            is_direct: load(s, &each_texel([1.0, 0.0, 0.0, 0.0])).simd_gt(splat(s, 0.5)),
            phase: load(s, &each_texel([0.0, red, green, blue])),
            ratios: ratios.map(|[red, green, blue]| each_texel([1.0, red, green, blue])),
        }
    }

    /// What direct light adds to each channel behind the slab (6.3-7), of what is lost around and opacities.
    #[inline(always)]
    fn scattered(
        &self,
        numbers: &Channels<S>,
        around: [F32<S>; MOST_CHANNELS],
        opacity: [F32<S>; MOST_CHANNELS],
    ) -> [F32<S>; MOST_CHANNELS] {
        let (zero, one) = (splat(self.s, 0.0), splat(self.s, 1.0));
        if self.in_scatter == InScatter::Indirect {
            return [zero; MOST_CHANNELS];
        }
        let (direct, held) = (first_channel::<S>(around), first_channel::<S>(opacity));
        rgba!(C => {
            // Light that becomes indirect on the way loses the rest of the way as such.
            let scattered = one - opacity[C] - numbers.left(self.s, held[C]);
            scattered.max(zero) * numbers.phase * numbers.left(self.s, direct[C])
        })
    }
}

impl<S: Lanes> Channels<S> {
    /// What is left in each where so much is lost of direct light.
    #[inline(always)]
    fn left(&self, s: S, lost: F32<S>) -> F32<S> {
        let left = splat(s, 1.0) - lost;
        match self.ratios {
            None => left,
            Some(ratios) => chroma::of_lanes(s, load(s, &ratios), left),
        }
    }
}
