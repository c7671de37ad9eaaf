//! What slabs hold where rays of light cross them.

use std::ops::Range;

use pellucid_scene::half_angle::{LightFrame, Slabs};

use super::crossing::{Crossing, Crossings, Passage};
use super::transport;
use crate::classify::Lookup;
use crate::field::{Any, Field};
use crate::lanes::*;
use crate::prepare::Prepared;
use crate::skip::SkipGrid;
use crate::vary::Varied;

/// Lengths that differ by less are the same.
const ROUNDING: f32 = 1e-6;

/// Rows of texels in a band, which one thread works on at a time.
pub const BAND: usize = 16;
/// Texels per row in a tile of a band: where nothing is, nothing is done.
pub const TILE: usize = 64;
/// Most slabs whose matter is looked up at once, while its rays are at hand.
const MOST_RUN: usize = 8;

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
    /// For every slab of a run, a plane of opacities on the light's way, and three planes of its indirect
    /// opacities if these are other ones.
    planes: Vec<Vec<Vec<f32>>>,
    /// For every slab of a run, which tiles hold anything; their planes are zero elsewhere.
    held: Vec<Vec<bool>>,
}

struct LightPacket {
    crossing: Crossing,
    /// The first slab that may hold anything, and the end of all rays.
    next: usize,
    last: usize,
}

impl Band {
    /// The rows from `top` on of a light's picture, `width` texels wide.
    pub fn new(
        prepared: &Prepared,
        frame: &LightFrame,
        slabs: &Slabs,
        [top, rows, width]: [usize; 3],
        [lanes, run]: [usize; 2],
        chromatic: bool,
    ) -> Self {
        let (grid, step) = (prepared.grid(), prepared.stage.step);
        // A light that is somewhere shines from there on, a directional one from ever.
        let from = if frame.position().is_some() { 0.0 } else { f64::NEG_INFINITY };
        let packet = |row: usize, column: usize| {
            let mut crossing = Crossing::NOTHING;
            for lane in 0..lanes {
                let ray = frame.ray((column + lane) as f64 + 0.5, (top + row) as f64 + 0.5);
                if let Some(span) = super::crossing::chord(&ray, from, grid, &prepared.region) {
                    crossing.set(lane, &ray, span, slabs, grid, step);
                }
            }
            let Range { start, end } = crossing.slabs();
            LightPacket { crossing, next: start, last: end }
        };
        let columns = (0..width).step_by(lanes);
        let packets = (0..rows).flat_map(|row| columns.clone().map(move |column| (row, column)));
        let planes = if chromatic { 4 } else { 1 };
        Self {
            packets: packets.map(|(row, column)| packet(row, column)).collect(),
            planes: vec![vec![vec![0.0; rows * width]; planes]; run],
            held: vec![vec![false; width.div_ceil(TILE)]; run],
        }
    }

    /// Whether a tile holds anything in a slab, by its number in the run.
    pub fn holds(&self, number: usize, tile: usize) -> bool {
        self.held[number][tile]
    }

    /// Opacity, or indirect opacity of a colour (planes 1 to 3; opacity if they are the same), of texels from
    /// a place in the band on.
    #[inline(always)]
    pub fn opacity<S: Lanes>(&self, s: S, number: usize, plane: usize, at: usize) -> F32<S> {
        let planes = &self.planes[number];
        F32::<S>::from_slice(s, &planes[plane.min(planes.len() - 1)][at..at + width::<S>()])
    }

    /// The rays of texels, by their place in the band.
    #[inline(always)]
    pub fn rays<S: Lanes>(&self, s: S, at: usize) -> Crossings<S> {
        Crossings::new(s, &self.packets[at / width::<S>()].crossing)
    }
}

/// What is needed to look matter up.
pub struct Matter<'a, S> {
    /// The instruction set.
    pub s: S,
    /// The field.
    pub field: Any<'a, S>,
    /// How far light travels in a slab, in steps.
    pub steps: f32,
    /// Opacities over that length.
    pub table: Lookup<'a>,
    /// What gets through of indirect light, if that is something else.
    pub transport: Option<Lookup<'a>>,
    /// Blocks that can contribute, if empty space is skipped.
    pub skip: Option<&'a SkipGrid>,
    /// What varies them, if anything does.
    pub varied: Option<Varied<'a>>,
}

impl<S: Lanes> Matter<'_, S> {
    /// Looks up what a run of slabs holds in a band.
    pub fn look_up(&self, band: &mut Band, run: Range<usize>, texels: usize) {
        for (planes, held) in band.planes.iter_mut().zip(&mut band.held) {
            for (tile, held) in held.iter_mut().enumerate().filter(|(_, held)| **held) {
                *held = false;
                for plane in planes.iter_mut() {
                    for row in plane.chunks_exact_mut(texels) {
                        let from = tile * TILE;
                        row[from..texels.min(from + TILE)].fill(0.0);
                    }
                }
            }
        }
        let s = self.s;
        s.vectorize(
            #[inline(always)]
            || {
                for (number, packet) in band.packets.iter_mut().enumerate() {
                    if packet.next >= run.end || packet.last <= run.start {
                        continue;
                    }
                    let rays = Crossings::new(s, &packet.crossing);
                    let at = number * width::<S>();
                    let mut k = packet.next.max(run.start);
                    while k < run.end.min(packet.last) {
                        if let Some(skip) = self.skip {
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
                        for k in k..run.end.min(packet.last) {
                            self.store(
                                &rays,
                                k,
                                &mut band.planes[k - run.start],
                                &mut band.held[k - run.start],
                                at,
                                texels,
                            );
                        }
                        k = run.end;
                    }
                    packet.next = k;
                }
            },
        );
    }

    #[inline(always)]
    fn store(
        &self,
        rays: &Crossings<S>,
        k: usize,
        planes: &mut [Vec<f32>],
        held: &mut [bool],
        at: usize,
        texels: usize,
    ) {
        let (s, zero, one) = (self.s, splat(self.s, 0.0), splat(self.s, 1.0));
        let Passage { index, ratio, lanes, .. } = rays.passage(s, k);
        if !lanes.any_true() {
            return;
        }
        let value = self.field.values(s, index, lanes);
        let position = self.table.position(s, value);
        let candidates = lanes & self.table.may_be_visible(s, position);
        if !candidates.any_true() {
            return;
        }
        let mut alpha = self.table.at(s, position, None)[3];
        let visible = candidates & alpha.simd_gt(zero);
        if !visible.any_true() {
            return;
        }
        let noise = self.varied.map(
            #[inline(always)]
            |varied| (varied, varied.noise(s, &index)),
        );
        if let Some((varied, noise)) = &noise {
            alpha = varied.opacity(s, noise, alpha);
        }
        // Of the length that the tables are for: all of it, but where rays enter or leave, and of near lights.
        let is_whole = (ratio - self.steps).abs().simd_le(splat(s, self.steps * ROUNDING));
        let ratio = is_whole.select(one, ratio / self.steps);
        let corrected = if is_whole.all_true() { alpha } else { is_whole.select(alpha, opacity_over(s, alpha, ratio)) };
        held[at % texels / TILE] = true;
        visible.select(corrected, zero).store_slice(&mut planes[0][at..at + width::<S>()]);
        if let Some(table) = &self.transport {
            let mut through = transport::through(s, table, value, ratio);
            if let Some((varied, noise)) = &noise {
                through = varied.transport(s, noise, through);
            }
            for channel in 0..3 {
                let opacity = visible.select(one - through[channel], zero);
                opacity.store_slice(&mut planes[channel + 1][at..at + width::<S>()]);
            }
        }
    }
}
