//! Tiles of the picture, drawn in parallel.

use std::sync::Mutex;

use pellucid_scene::{Control, Frame};
use rayon::prelude::*;

use crate::RenderError;
use crate::integrator::{Found, Tally};

/// Pixels per tile side: large enough to share voxels in cache, small enough to balance.
pub const TILE: usize = 32;

/// A rectangle of pixels and what was drawn there, row by row.
#[derive(Clone, Debug, Default)]
pub struct Tile {
    /// Left column.
    pub x: usize,
    /// Top row.
    pub y: usize,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Whether it is told of each colour what is held back.
    chromatic: bool,
    color: Vec<[f32; 4]>,
    opacities: Vec<[f32; 3]>,
    depth: Vec<f32>,
    normal: Vec<[f32; 3]>,
    samples: Vec<u32>,
    noise: Vec<f32>,
    /// Counts of its rays.
    pub tally: Tally,
    /// Rays that met the volume.
    pub hit: u64,
}

impl Tile {
    fn place(&mut self, x: usize, y: usize, width: usize, height: usize) {
        (self.x, self.y, self.width, self.height) = (x, y, width, height);
    }

    /// The top rows and left columns of the packets that cover it.
    pub fn corners(&self, columns: usize, rows: usize) -> impl Iterator<Item = (usize, usize)> + use<> {
        let (width, height) = (self.width, self.height);
        (0..height).step_by(rows).flat_map(move |y| (0..width).step_by(columns).map(move |x| (y, x)))
    }

    /// Forgets what was drawn.
    pub fn clear(&mut self) {
        let n = self.width * self.height;
        self.color.clear();
        self.color.resize(n, [0.0; 4]);
        self.opacities.clear();
        self.opacities.resize(if self.chromatic { n } else { 0 }, [0.0; 3]);
        self.depth.clear();
        self.depth.resize(n, f32::INFINITY);
        self.normal.clear();
        self.normal.resize(n, [0.0; 3]);
        self.samples.clear();
        self.samples.resize(n, 0);
        self.noise.clear();
        self.noise.resize(n, 0.0);
        (self.tally, self.hit) = (Tally::default(), 0);
    }

    /// Notes the standard error of a pixel's luminance.
    pub fn set_noise(&mut self, x: usize, y: usize, noise: f32) {
        self.noise[y * self.width + x] = noise;
    }

    /// Adds what one ray found to its pixel: its share of the colour, and its surface if it is the
    /// nearest of the pixel.
    pub fn add(&mut self, x: usize, y: usize, weight: f32, found: &Found) {
        let pixel = y * self.width + x;
        for (sum, channel) in self.color[pixel].iter_mut().zip(found.color) {
            *sum += channel * weight;
        }
        if let Some(opacities) = self.opacities.get_mut(pixel) {
            for (sum, opacity) in opacities.iter_mut().zip(found.opacities) {
                *sum += opacity * weight;
            }
        }
        self.samples[pixel] += found.samples;
        if found.depth < self.depth[pixel] {
            self.depth[pixel] = found.depth;
            self.normal[pixel] = found.normal;
        }
    }
}

/// The tiles of a picture; kept from frame to frame with their memory.
#[derive(Debug, Default)]
pub struct Tiles {
    /// Those of the picture, then those that larger pictures had.
    tiles: Vec<Tile>,
    layout: [usize; 3],
    count: usize,
}

impl Tiles {
    /// Covers a picture with tiles of a side; `chromatic` if it is told of each colour what is held back.
    pub fn cover(&mut self, width: usize, height: usize, side: usize, chromatic: bool) {
        if self.tiles.first().is_none_or(|tile| tile.chromatic != chromatic) {
            self.layout = [0; 3];
        }
        if self.layout == [width, height, side] {
            return;
        }
        self.layout = [width, height, side];
        let [columns, rows] = [width.div_ceil(side), height.div_ceil(side)];
        self.count = columns * rows;
        self.tiles.resize_with(self.tiles.len().max(self.count), Tile::default);
        for (number, tile) in self.tiles[..self.count].iter_mut().enumerate() {
            let (x, y) = (number % columns * side, number / columns * side);
            tile.place(x, y, side.min(width - x), side.min(height - y));
            tile.chromatic = chromatic;
        }
    }

    /// Those of the picture.
    pub fn all(&self) -> &[Tile] {
        &self.tiles[..self.count]
    }

    /// Those of the picture, to be drawn into.
    pub fn all_mut(&mut self) -> &mut [Tile] {
        &mut self.tiles[..self.count]
    }

    /// Forgets what was drawn.
    pub fn clear(&mut self) {
        self.all_mut().par_iter_mut().for_each(Tile::clear);
    }

    /// Draws every tile on the current thread pool, reporting progress.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`] as soon as a tile reports that it was interrupted.
    pub fn draw(
        &mut self,
        control: &Control,
        draw: impl Fn(&mut Tile) -> Result<(), RenderError> + Sync,
    ) -> Result<(), RenderError> {
        let (done, all) = (Mutex::new(0usize), self.count);
        self.tiles[..all].par_iter_mut().with_max_len(1).try_for_each(|tile| {
            tile.clear();
            draw(tile)?;
            // Reported under the lock, so that progress never runs backwards.
            let mut done = done.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
            *done += 1;
            control.report(*done as f64 / all as f64);
            Ok(())
        })
    }

    /// Puts the tiles together.
    pub fn assemble(&self, frame: &mut Frame) {
        let [width, height, side] = self.layout;
        let chromatic = self.all().iter().any(|tile| tile.chromatic);
        frame.opacities.resize(if chromatic { width * height } else { 0 }, [0.0; 3]);
        for tile in self.all().iter().filter(|tile| tile.chromatic) {
            for (row, opacities) in tile.opacities.chunks_exact(tile.width).enumerate() {
                let place = (tile.y + row) * width + tile.x;
                frame.opacities[place..place + tile.width].copy_from_slice(opacities);
            }
        }
        let columns = width.div_ceil(side);
        let band = side * width;
        let color = frame.color.par_chunks_mut(band);
        let depth = frame.depth.par_chunks_mut(band);
        let normal = frame.normal.par_chunks_mut(band);
        let samples = frame.samples.par_chunks_mut(band);
        let noise = frame.noise.par_chunks_mut(band);
        let tiles = self.tiles[..self.count].par_chunks(columns);
        tiles.zip(color).zip(depth).zip(normal).zip(samples).zip(noise).for_each(
            |(((((tiles, color), depth), normal), samples), noise)| {
                for (tile, row) in tiles.iter().flat_map(|tile| (0..tile.height).map(move |row| (tile, row))) {
                    let (from, to) = (row * tile.width, row * width + tile.x);
                    let (from, to) = (from..from + tile.width, to..to + tile.width);
                    color[to.clone()].copy_from_slice(&tile.color[from.clone()]);
                    depth[to.clone()].copy_from_slice(&tile.depth[from.clone()]);
                    normal[to.clone()].copy_from_slice(&tile.normal[from.clone()]);
                    samples[to.clone()].copy_from_slice(&tile.samples[from.clone()]);
                    noise[to].copy_from_slice(&tile.noise[from]);
                }
            },
        );
    }

    /// The counts of all tiles, and the rays that met the volume.
    pub fn total(&self) -> (Tally, u64) {
        let mut total = (Tally::default(), 0);
        for tile in &self.tiles[..self.count] {
            total.0.add(&tile.tally);
            total.1 += tile.hit;
        }
        total
    }
}
