//! What slabs hold where rays of light cross them.

use std::ops::Range;
use std::slice;

use pellucid_field::Grid;
use pellucid_plan::half_angle::Slabs;
use pellucid_scene::HalfAngle;

use super::crossing::{Crossing, Crossings, Passage, UNASKED};
use super::lengths::Lengths;
use super::optics::{SlabOptics, SlabSample};
use crate::chroma;
use crate::classify::Post;
use crate::field::Field;
use crate::lanes::{self, *};
use crate::medium::OneGrid;
use crate::packet::Packet;
use crate::prepare::Prepared;
use crate::rays::Emitter;
use crate::solid::Solid;
use crate::vary::Placed;

/// Lengths that differ by less are the same.
const ROUNDING: f32 = 1e-6;

/// Rows of texels in a band, which one thread works on at a time.
pub const BAND: usize = 16;
/// Texels per row in a tile of a band: where nothing is, nothing is done.
pub const TILE: usize = 64;
/// Most slabs that are passed at once, while their rays are at hand.
const MOST_RUN: usize = 16;

/// How many slabs to look up at once for pictures of a size: fewer, where each takes much memory. No picture
/// depends on it.
pub fn run_length([width, height]: [usize; 2]) -> usize {
    const TEXELS: usize = 1 << 22;
    (TEXELS / (width * height)).clamp(1, MOST_RUN)
}

/// A few rows of the light's picture.
pub struct Band {
    /// Its rays, row by row.
    packets: Vec<LightPacket>,
    /// Texels per row, and numbers per texel.
    width: usize,
    channels: usize,
    /// For every slab of a run the opacities on the light's way, and if there is indirect light the three of it, too:
    /// texel by texel, as light lies in its buffer.
    opacities: Vec<Vec<f32>>,
    /// For every slab of a run, which tiles hold anything; opacities are zero elsewhere.
    held: Vec<Vec<bool>>,
}

struct LightPacket {
    crossing: Crossing,
    /// The first slab that may hold anything, and the end of all rays.
    next: usize,
    last: usize,
}

impl Band {
    /// The rows from `top` on of a light's picture, `width` texels wide, for so many slabs at once and numbers per
    /// texel; rays in a solid of a grid, `step` world units to a step.
    pub fn new<S: Lanes>(
        s: S,
        (grid, solid, step): (&Grid, &Solid, f64),
        (emitter, slabs): (&Emitter, &Slabs),
        [top, rows, width]: [usize; 3],
        [run, channels]: [usize; 2],
    ) -> Self {
        let lanes = lanes::width::<S>();
        let packet = |(row, column): (usize, usize)| {
            let (mut x, y) = ([0.0; MOST_LANES], [(top + row) as f64 + 0.5; MOST_LANES]);
            x.iter_mut().zip(column..column + lanes).for_each(|(x, column)| *x = column as f64 + 0.5);
            let mut rays = Packet::NOTHING;
            let met = (slice::from_ref(solid), slice::from_mut(&mut rays));
            emitter.emit(&x, &y, &[true; MOST_LANES], 0, met);
            let mut packet = LightPacket { crossing: Crossing::NOTHING, next: 0, last: 0 };
            packet.crossing.take(s, &rays, slabs, grid, step);
            (packet.next, packet.last) = (packet.crossing.slabs().start, packet.crossing.slabs().end);
            packet
        };
        let columns = (0..width).step_by(lanes);
        let packets = (0..rows).flat_map(|row| columns.clone().map(move |column| (row, column)));
        Self {
            packets: packets.map(packet).collect(),
            width,
            channels,
            opacities: vec![vec![0.0; rows * width * channels]; run],
            held: vec![vec![false; width.div_ceil(TILE)]; run],
        }
    }

    /// Whether a tile holds anything in a slab, by its number in the run.
    pub fn holds(&self, number: usize, tile: usize) -> bool {
        self.held[number][tile]
    }

    /// Opacities of texels of a row, by the slab's number in the run.
    #[inline(always)]
    pub fn opacities(&self, number: usize, row: usize, columns: &Range<usize>) -> &[f32] {
        &self.opacities[number][(row * self.width + columns.start) * self.channels..][..columns.len() * self.channels]
    }

    /// Forgets what the run before this one held.
    pub fn clear(&mut self) {
        for (opacities, held) in self.opacities.iter_mut().zip(self.held.iter_mut()) {
            for (tile, held) in held.iter_mut().enumerate().filter(|(_, held)| **held) {
                *held = false;
                for row in opacities.chunks_exact_mut(self.width * self.channels) {
                    row[tile * TILE * self.channels..self.width.min((tile + 1) * TILE) * self.channels].fill(0.0);
                }
            }
        }
    }

    /// Holds also what another layer holds in the same rows: light passes both.
    pub fn join(&mut self, other: &Self) {
        let (width, channels) = (self.width, self.channels);
        let slabs = self.opacities.iter_mut().zip(self.held.iter_mut()).zip(other.opacities.iter().zip(&other.held));
        for ((opacities, held), (others, theirs)) in slabs {
            for tile in (0..held.len()).filter(|&tile| theirs[tile]) {
                held[tile] = true;
                let columns = tile * TILE * channels..width.min((tile + 1) * TILE) * channels;
                let rows = opacities.chunks_exact_mut(width * channels).zip(others.chunks_exact(width * channels));
                for (row, other) in rows {
                    for (own, other) in row[columns.clone()].iter_mut().zip(&other[columns.clone()]) {
                        *own += other - *own * other;
                    }
                }
            }
        }
    }

    /// The rays of texels, by their place in the band.
    #[inline(always)]
    pub fn rays<S: Lanes>(&self, s: S, at: usize) -> Crossings<S> {
        Crossings::new(s, &self.packets[at / width::<S>()].crossing)
    }
}

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

    /// Looks up what a run of slabs holds in a band.
    pub fn look_up(&self, band: &mut Band, run: Range<usize>) {
        band.clear();
        let Band { packets, width: texels, channels, opacities, held } = band;
        let s = self.medium.s;
        s.vectorize(
            #[inline(always)]
            || {
                for (number, packet) in packets.iter_mut().enumerate() {
                    if packet.next >= run.end || packet.last <= run.start {
                        continue;
                    }
                    let rays = Crossings::new(s, &packet.crossing);
                    let at = number * width::<S>();
                    let mut k = packet.next.max(run.start);
                    while k < run.end.min(packet.last) {
                        if let Some(skip) = self.medium.skip {
                            let leap = rays.leap(
                                s,
                                k,
                                #[inline(always)]
                                |index| skip.clear(s, index, &rays.inverse),
                            );
                            if leap > 0 {
                                k += leap;
                                continue;
                            }
                        }
                        let stop = run.end.min(packet.last).min(k + UNASKED);
                        for k in k..stop {
                            let to = &mut opacities[k - run.start][at * *channels..][..width::<S>() * *channels];
                            held[k - run.start][at % *texels / TILE] |= self.store(&rays, k, to);
                        }
                        k = stop;
                    }
                    packet.next = k;
                }
            },
        );
    }

    /// Writes down what rays meet in a slab, if anything.
    #[inline(always)]
    fn store(&self, rays: &Crossings<S>, k: usize, to: &mut [f32]) -> bool {
        let s = self.medium.s;
        let (zero, one) = (splat(s, 0.0), splat(s, 1.0));
        let Passage { index, ratio, lanes, .. } = rays.passage(s, k);
        if !lanes.any_true() {
            return false;
        }
        // Of the length that the tables are for: all of it, but where rays enter or leave, and of near lights.
        let is_whole = (ratio - self.steps).abs().simd_le(splat(s, self.steps * ROUNDING));
        let ratio = is_whole.select(one, ratio / self.steps);
        let Some(SlabSample { rgba, visible, transmittance, .. }) = self.medium.at(&index, lanes, ratio) else {
            return false;
        };
        let alpha = rgba[3];
        let corrected = if is_whole.all_true() { alpha } else { is_whole.select(alpha, opacity_over(s, alpha, ratio)) };
        let alpha = visible.select(corrected, zero);
        if to.len() == width::<S>() {
            alpha.store_slice(to);
            return true;
        }
        let [red, green, blue] = chroma::opacities(s, self.medium.chroma.as_ref(), alpha);
        let mut opacities = [alpha, red, green, blue];
        if let Some(transmittance) = transmittance {
            for (opacity, transmittance) in opacities[1..].iter_mut().zip(transmittance) {
                *opacity = visible.select(one - transmittance, zero);
            }
        }
        store_rows(s, opacities, to);
        true
    }
}
