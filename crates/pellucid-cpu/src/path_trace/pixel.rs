//! From paths to a pixel: their mean, its standard error, and when there are enough of them.

use pellucid_optics::luminance;
use pellucid_scene::Control;

use super::random::Random;
use super::values::Values;
use super::{Draw, Paths};
use crate::RenderError;
use crate::integrator::Found;
use crate::tiles::Tile;

/// Paths between two looks at the caller's switch: about a millisecond.
const BATCH: u32 = 16;

/// Fewest paths before a pixel may be done: with fewer, dark ones are often not noisy but unlucky.
const FEWEST: u32 = 64;

/// Brightness below which noise is not worth more paths, as a share of white.
const DARK: f64 = 1e-3;

/// Mean and variance of numbers as they come (Welford 1962).
#[derive(Default)]
struct Welford {
    count: u32,
    mean: f64,
    squares: f64,
}

impl Welford {
    fn add(&mut self, number: f64) {
        self.count += 1;
        let difference = number - self.mean;
        self.mean += difference / f64::from(self.count);
        self.squares += difference * (number - self.mean);
    }

    /// Of the mean.
    fn standard_error(&self) -> f64 {
        let count = f64::from(self.count);
        (self.squares / (count * (count - 1.0).max(1.0))).sqrt()
    }
}

impl<F: Values> Draw for Paths<'_, F> {
    fn draw(&self, tile: &mut Tile, control: &Control) -> Result<(), RenderError> {
        let mut depths = Vec::new();
        for row in 0..tile.height {
            for column in 0..tile.width {
                let (found, noise) = self.pixel(tile.x + column, tile.y + row, &mut depths, control)?;
                tile.add(column, row, 1.0, &found);
                tile.set_noise(column, row, noise);
                tile.tally.samples += u64::from(found.samples);
                tile.tally.visible += u64::from(found.color[3] > 0.0);
                tile.hit += u64::from(found.samples > 0);
            }
        }
        Ok(())
    }
}

impl<F: Values> Paths<'_, F> {
    /// A pixel and the standard error of its luminance. `depths` is memory to use.
    fn pixel(&self, x: usize, y: usize, depths: &mut Vec<f32>, control: &Control) -> Result<(Found, f32), RenderError> {
        let settings = self.world.settings;
        let (mut radiance, mut covered, mut looks) = ([0.0f64; 3], 0u32, 0u32);
        let mut brightness = Welford::default();
        depths.clear();
        for sample in 0..settings.samples {
            if sample % BATCH == 0 && control.is_cancelled() {
                return Err(RenderError::Cancelled);
            }
            let mut random = Random::new(self.seeds, y * self.width + x, sample);
            let ray = self.lens.ray(x, y, &mut random);
            let found = self.world.follow(&ray, &mut random);
            for channel in 0..3 {
                radiance[channel] += f64::from(found.radiance[channel]);
            }
            brightness.add(f64::from(luminance(found.radiance)));
            covered += u32::from(found.depth.is_finite());
            looks = looks.saturating_add(found.looks);
            depths.push(found.depth);
            let looked_at = settings.noise > 0.0 && (sample + 1) % BATCH == 0 && sample + 1 >= FEWEST;
            let allowed = f64::from(settings.noise) * brightness.mean.max(DARK);
            if looked_at && brightness.standard_error() <= allowed {
                break;
            }
        }
        let count = f64::from(brightness.count);
        let [r, g, b] = radiance.map(|sum| (sum / count) as f32);
        // The ray's opacity reaches one half where half of its paths have collided.
        let middle = depths.len().div_ceil(2) - 1;
        let (_, depth, _) = depths.select_nth_unstable_by(middle, f32::total_cmp);
        let color = [r, g, b, (f64::from(covered) / count) as f32];
        let found = Found { color, depth: *depth, normal: [0.0; 3], samples: looks };
        Ok((found, brightness.standard_error() as f32))
    }
}
