//! A made-up technique: one gray everywhere.

use pellucid_scene::MadeUp;

use crate::integrator::Found;
use crate::tiles::Tile;

/// Draws a tile.
pub fn draw(settings: &MadeUp, tile: &mut Tile) {
    let color = [settings.gray, settings.gray, settings.gray, 1.0];
    let found = Found { color, opacities: [1.0; 3], depth: f32::INFINITY, normal: [0.0; 3], samples: 0 };
    let (width, height) = (tile.width, tile.height);
    (0..width * height).for_each(|pixel| tile.add(pixel % width, pixel / width, 1.0, &found));
}
