//! Tiles of the picture, drawn in parallel.

use std::sync::Mutex;

use pellucid_scene::Control;
use rayon::prelude::*;

use crate::RenderError;

/// Pixels per tile side: large enough to share voxels in cache, small enough to balance.
pub const TILE: usize = 32;

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug)]
pub struct Tile {
    /// Left column.
    pub x: usize,
    /// Top row.
    pub y: usize,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl Tile {
    /// Its pixels as (x, y), row by row.
    pub fn pixels(self) -> impl Iterator<Item = (usize, usize)> {
        (self.y..self.y + self.height).flat_map(move |y| (self.x..self.x + self.width).map(move |x| (x, y)))
    }
}

/// All tiles of a picture, of side `size`.
pub fn tiles(width: usize, height: usize, size: usize) -> Vec<Tile> {
    let rows = (0..height).step_by(size);
    rows.flat_map(|y| {
        (0..width).step_by(size).map(move |x| Tile { x, y, width: size.min(width - x), height: size.min(height - y) })
    })
    .collect()
}

/// Draws every tile on the current thread pool, reporting progress; results come in tile order.
///
/// # Errors
/// [`RenderError::Cancelled`] as soon as a tile reports that it was interrupted.
pub fn draw<T: Send>(
    tiles: &[Tile],
    control: &Control,
    tile: impl Fn(Tile) -> Result<T, RenderError> + Sync,
) -> Result<Vec<T>, RenderError> {
    let done = Mutex::new(0usize);
    tiles
        .par_iter()
        .map(|&t| {
            let result = tile(t)?;
            // Reported under the lock, so that progress never runs backwards.
            let mut done = done.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
            *done += 1;
            control.report(*done as f64 / tiles.len() as f64);
            Ok(result)
        })
        .collect()
}
