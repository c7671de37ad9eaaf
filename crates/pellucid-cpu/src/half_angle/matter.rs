//! What slabs hold where rays of light cross them.

use std::ops::Range;

use pellucid_scene::{HalfAngle, Overlap};

use super::band::{Band, TILE};
use super::crossing::{Crossings, Passage, UNASKED};
use super::lengths::Lengths;
use super::optics::{SlabOptics, SlabSample};
use super::pieces::{MetLayer, PerLayer, each_piece, leap, shares};
use crate::chroma;
use crate::classify::Post;
use crate::field::Field;
use crate::lanes::*;
use crate::medium::OneGrid;
use crate::prepare::Prepared;
use crate::vary::Placed;

/// Lengths that differ by less are the same.
const ROUNDING: f32 = 1e-6;

/// What is needed to look matter up.
pub struct Matter<'a, S, F> {
    /// What lies along the light's rays, by the length that light travels in a slab.
    pub medium: OneGrid<'a, S, &'a F, SlabOptics<'a>>,
    /// That length in steps.
    steps: f32,
}

impl<'a, S: Lanes, F: Field<S>> Matter<'a, S, F> {
    /// A volume on the ways of a light, and of indirect light if there is such.
    pub fn new(s: S, prepared: &'a Prepared, lengths: &'a Lengths, field: &'a F, settings: &HalfAngle) -> Self {
        let optics = SlabOptics {
            classifier: Post(lengths.opacity()),
            transport: lengths.transport().filter(|_| settings.indirect > 0.0),
            // Light is lost in a place, whatever the colours of its voxels.
            placed: Placed { paint: None, varied: prepared.varied() },
        };
        Self { medium: prepared.one_grid(s, field, optics, None), steps: lengths.steps }
    }

    /// Whether indirect light, or any of its colours, loses something else than direct light.
    pub fn tells_colors_apart(&self) -> bool {
        self.medium.optics.transport.is_some() || self.medium.chroma.is_some()
    }

    /// How much of the length that the tables are for rays pass: all of it, but where they enter or leave, and of near
    /// lights.
    #[inline(always)]
    fn part(&self, passage: &Passage<S>) -> F32<S> {
        let s = self.medium.s;
        let is_whole = (passage.ratio - self.steps).abs().simd_le(splat(s, self.steps * ROUNDING));
        is_whole.select(splat(s, 1.0), passage.ratio / self.steps)
    }

    /// What a sample holds back over a part of the length: of direct light and, if it is asked for, of each colour of
    /// indirect light.
    #[inline(always)]
    fn opacities(&self, sample: &SlabSample<S>, part: F32<S>, is_indirect: bool) -> [F32<S>; 4] {
        let s = self.medium.s;
        let (zero, one, alpha) = (splat(s, 0.0), splat(s, 1.0), sample.rgba[3]);
        let is_whole = part.simd_eq(one);
        let corrected = if is_whole.all_true() { alpha } else { is_whole.select(alpha, opacity_over(s, alpha, part)) };
        let alpha = sample.visible.select(corrected, zero);
        if !is_indirect {
            return [alpha, zero, zero, zero];
        }
        let [red, green, blue] = chroma::opacities(s, self.medium.chroma.as_ref(), alpha);
        let mut opacities = [alpha, red, green, blue];
        if let Some(transmittance) = sample.transmittance {
            for (opacity, transmittance) in opacities[1..].iter_mut().zip(transmittance) {
                *opacity = sample.visible.select(one - transmittance, zero);
            }
        }
        opacities
    }

    /// Writes down what rays meet of the volume in a slab, if anything.
    #[inline(always)]
    fn store(&self, rays: &Crossings<S>, k: usize, to: &mut [f32]) -> bool {
        let s = self.medium.s;
        let passage = rays.passage(s, k);
        if !passage.lanes.any_true() {
            return false;
        }
        let part = self.part(&passage);
        let Some(sample) = self.medium.at(&passage.index, passage.lanes, part) else {
            return false;
        };
        write(s, self.opacities(&sample, part, to.len() > width::<S>()), to);
        true
    }
}

/// Looks up what a run of slabs holds in a band: of one volume, or of all layers by the rule of their overlap.
pub fn look_up<S: Lanes, F: Field<S>>(layers: &[Matter<S, F>], overlap: Overlap, band: &mut Band, run: Range<usize>) {
    band.clear();
    let Band { packets, width: texels, channels, opacities, held } = band;
    let s = layers[0].medium.s;
    s.vectorize(
        #[inline(always)]
        || {
            for (number, packet) in packets.iter_mut().enumerate() {
                if packet.next >= run.end || packet.last <= run.start {
                    continue;
                }
                let mut rays = PerLayer::new();
                for crossing in &packet.crossings {
                    rays.push(Crossings::new(s, crossing));
                }
                let met: PerLayer<MetLayer<S, F>> = layers.iter().map(|matter| &matter.medium).zip(&rays).collect();
                let at = number * width::<S>();
                let mut k = packet.next.max(run.start);
                while k < run.end.min(packet.last) {
                    let leap = leap(&met, k);
                    if leap > 0 {
                        k += leap;
                        continue;
                    }
                    let stop = run.end.min(packet.last).min(k + UNASKED);
                    for k in k..stop {
                        let to = &mut opacities[k - run.start][at * *channels..][..width::<S>() * *channels];
                        held[k - run.start][at % *texels / TILE] |= match (layers, rays.as_slice()) {
                            ([matter], [rays]) => matter.store(rays, k, to),
                            _ => store_together(layers, overlap, &met, k, to),
                        };
                    }
                    k = stop;
                }
                packet.next = k;
            }
        },
    );
}

/// Writes down what rays meet of all layers in a slab, piece by piece, if anything.
#[inline(never)]
fn store_together<'m, 'a: 'm, S: Lanes, F: Field<S>>(
    layers: &[Matter<'a, S, F>],
    overlap: Overlap,
    met: &[MetLayer<'m, 'a, S, F>],
    k: usize,
    to: &mut [f32],
) -> bool {
    let s = layers[0].medium.s;
    s.vectorize(
        #[inline(always)]
        || {
            let mut held = None;
            each_piece(
                s,
                met,
                k,
                #[inline(always)]
                |ends| {
                    let (_, shares) = shares(
                        s,
                        overlap,
                        met,
                        #[inline(always)]
                        |rays| rays.between(s, ends),
                        #[inline(always)]
                        |passage| layers[0].part(passage),
                    );
                    for share in &shares {
                        let (matter, before) = (&layers[share.layer], held.unwrap_or([splat(s, 0.0); 4]));
                        let own = matter.opacities(&share.sample, matter.part(&share.passage), to.len() > width::<S>());
                        held = Some(rgba!(C => before[C] + (own[C] - before[C] * own[C])));
                    }
                },
            );
            let Some(held) = held else { return false };
            write(s, held, to);
            true
        },
    )
}

/// Writes opacities down, texel by texel: of direct light, or of all.
#[inline(always)]
fn write<S: Lanes>(s: S, opacities: [F32<S>; 4], to: &mut [f32]) {
    if to.len() == width::<S>() {
        opacities[0].store_slice(to);
    } else {
        store_rows(s, opacities, to);
    }
}
