//! From paths to a pixel: their mean, its standard error, and when there are enough of them.

use pellucid_optics::luminance;
use pellucid_scene::{Control, PathTrace};

use super::random::Random;
use super::sights::Sight;
use super::surroundings::Surroundings;
use super::{Draw, Paths};
use crate::RenderError;
use crate::integrator::Found;
use crate::tiles::Tile;

/// Paths between two looks at the caller's switch: about a millisecond.
const BATCH: u32 = 16;

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

/// What the paths of a pixel found.
struct Pixel {
    found: Found,
    /// Standard error of the luminance.
    noise: f32,
    paths: u32,
    /// Luminance that the paths brought, and what of it was held back.
    light: [f64; 2],
    /// Paths that met the volume, and those that collided there.
    met: u32,
    collided: u32,
}

impl<M: Surroundings> Draw for Paths<'_, M> {
    fn draw(&self, tile: &mut Tile, control: &Control) -> Result<(), RenderError> {
        let mut depths = Vec::new();
        for row in 0..tile.height {
            for column in 0..tile.width {
                let pixel = self.pixel(tile.x + column, tile.y + row, &mut depths, control)?;
                tile.add(column, row, 1.0, &pixel.found);
                tile.set_noise(column, row, pixel.noise);
                tile.hit += u64::from(pixel.met);
                let tally = &mut tile.tally;
                tally.paths += u64::from(pixel.paths);
                tally.samples += u64::from(pixel.found.samples);
                tally.visible += u64::from(pixel.collided);
                tally.light = [tally.light[0] + pixel.light[0], tally.light[1] + pixel.light[1]];
            }
        }
        Ok(())
    }
}

impl<M: Surroundings> Paths<'_, M> {
    /// Draws a pixel. `depths` is memory to use.
    fn pixel(&self, x: usize, y: usize, depths: &mut Vec<f32>, control: &Control) -> Result<Pixel, RenderError> {
        let settings = self.world.settings;
        let between = match self.sights.as_ref().map(|sights| sights.of_pixel(x, y)) {
            None => [0.0, f64::INFINITY],
            Some(Sight::Between(between)) => between,
            Some(Sight::Nowhere(met)) => {
                // The middle ray was cast for all of them.
                let (depth, normal) = (f32::INFINITY, [0.0; 3]);
                let found = Found { color: [0.0; 4], opacities: [0.0; 3], depth, normal, samples: 0 };
                return Ok(Pixel { found, noise: 0.0, paths: 1, light: [0.0; 2], met: u32::from(met), collided: 0 });
            }
        };
        let (mut radiance, mut passed, mut met, mut collided, mut evaluations) =
            ([0.0f64; 3], [0.0f64; 3], 0u32, 0u32, 0u32);
        let (mut brightness, mut light) = (Welford::default(), [0.0f64; 2]);
        depths.clear();
        for sample in 0..settings.samples {
            if sample % BATCH == 0 && control.is_cancelled() {
                return Err(RenderError::Cancelled);
            }
            let mut random = Random::new(self.seeds, y * self.width + x, sample);
            let ray = self.lens.ray(x, y, &mut random);
            let found = self.world.follow(&ray, between, &mut random);
            let brought = luminance(found.radiance);
            let kept = self.kept(brought);
            for channel in 0..3 {
                radiance[channel] += f64::from(found.radiance[channel] * kept);
                passed[channel] += f64::from(found.passed[channel]);
            }
            light = [light[0] + f64::from(brought), light[1] + f64::from(brought * (1.0 - kept))];
            brightness.add(f64::from(brought * kept));
            met += u32::from(found.met);
            collided += u32::from(found.depth.is_finite());
            evaluations = evaluations.saturating_add(found.evaluations);
            depths.push(found.depth);
            let looked_at =
                settings.noise > 0.0 && (sample + 1) % BATCH == 0 && sample + 1 >= PathTrace::LEAST_TO_JUDGE;
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
        let color = [r, g, b, (f64::from(collided) / count) as f32];
        let normal = self.world.normal(&self.lens.middle(x, y), *depth);
        let opacities = passed.map(|sum| (1.0 - sum / count) as f32);
        let found = Found { color, opacities, depth: *depth, normal, samples: evaluations };
        let noise = brightness.standard_error() as f32;
        Ok(Pixel { found, noise, paths: brightness.count, light, met, collided })
    }

    /// The share that is kept of a path's luminance.
    fn kept(&self, luminance: f32) -> f32 {
        let clamp = self.world.settings.firefly_clamp;
        if clamp > 0.0 && luminance > clamp { clamp / luminance } else { 1.0 }
    }
}
