//! Mountains out of noise.

use pellucid_field::Noise;

use crate::HeightMap;

impl HeightMap {
    /// Land of `points` x `points` heights, 0 to 1, the same for a seed on every machine: ridges of noise in octaves,
    /// each of half the height and twice as fine, that are rough where the land is high (as Musgrave models terrain).
    pub fn terrain(seed: u32, points: usize) -> Self {
        const OCTAVES: u32 = 8;
        let (noise, points) = (Noise::new(seed), points.max(1));
        let height = |i: usize| {
            let place = [i % points, i / points].map(|x| (x as f32 + 0.5) / points as f32);
            let (mut sum, mut weight, mut rough) = (0.0f32, 0.5f32, 1.0f32);
            for octave in 0..OCTAVES {
                // Six texels of the noise across the land, and twice as many from octave to octave.
                let scale = 6.0 * (1u32 << octave) as f32;
                let slice = 3.7 * octave as f32;
                let [value, ..] = noise.signed([place[0] * scale, place[1] * scale, slice]);
                // The noise's standard deviation is about 0.13.
                let ridge = (1.0 - (3.0 * value).abs()).max(0.0).powi(2);
                sum += weight * rough * ridge;
                rough = (ridge * 1.6).min(1.0);
                weight *= 0.5;
            }
            sum.min(1.0)
        };
        let heights = (0..points * points).map(height).collect();
        Self { dims: [points, points], heights }
    }

    /// The same heights times a factor.
    pub fn scaled(mut self, factor: f32) -> Self {
        self.heights.iter_mut().for_each(|height| *height *= factor);
        self
    }
}
