//! A few rows of the light's picture: its rays, and what slabs hold where they cross them.

use std::ops::Range;

use pellucid_field::Grid;
use pellucid_plan::half_angle::Slabs;

use super::crossing::{Crossing, slabs_of};
use super::pieces::PerLayer;
use crate::lanes::{self, *};
use crate::packet::Packet;
use crate::rays::Emitter;
use crate::solid::Solid;

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
    pub packets: Vec<LightPacket>,
    /// Texels per row.
    pub width: usize,
    /// Numbers per texel.
    pub channels: usize,
    /// For every slab of a run the opacities on the light's way, and the three of indirect light where those are others:
    /// texel by texel, as light lies in its buffer.
    pub opacities: Vec<Vec<f32>>,
    /// For every slab of a run, which tiles hold anything; opacities are zero elsewhere.
    pub held: Vec<Vec<bool>>,
}

/// Rays of light side by side.
pub struct LightPacket {
    /// In each of the layers.
    pub crossings: PerLayer<Crossing>,
    /// The first slab that may hold anything, and the end of all rays.
    pub next: usize,
    pub last: usize,
}

impl Band {
    /// The rows from `top` on of a light's picture, `width` texels wide, for so many slabs at once and numbers per
    /// texel; rays in the solids of layers with such grids, `step` world units to a step.
    pub fn new<S: Lanes>(
        s: S,
        (grids, solids, step): (&[Grid], &[Solid], f64),
        (emitter, slabs): (&Emitter, &Slabs),
        [top, rows, width]: [usize; 3],
        [run, channels]: [usize; 2],
    ) -> Self {
        let lanes = lanes::width::<S>();
        let packet = |(row, column): (usize, usize)| {
            let (mut x, y) = ([0.0; MOST_LANES], [(top + row) as f64 + 0.5; MOST_LANES]);
            x.iter_mut().zip(column..column + lanes).for_each(|(x, column)| *x = column as f64 + 0.5);
            let mut rays = vec![Packet::NOTHING; solids.len()];
            emitter.emit(&x, &y, &[true; MOST_LANES], 0, (solids, &mut rays));
            let crossing = |(rays, grid): (&Packet, &Grid)| {
                let mut crossing = Crossing::NOTHING;
                crossing.take(s, rays, slabs, grid, step);
                crossing
            };
            let crossings: PerLayer<Crossing> = rays.iter().zip(grids).map(crossing).collect();
            let Range { start: next, end: last } = slabs_of(&crossings);
            LightPacket { crossings, next, last }
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
}
