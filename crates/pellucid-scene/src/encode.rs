//! From a frame to the numbers of a picture.

use pellucid_field::parallel;
use pellucid_optics::srgb_encode;
use rayon::prelude::*;

use crate::srgb8::{SRGB8, nearest, part};
use crate::{Background, Encoding, Frame, ImageSettings};

impl Frame {
    /// The pixel over its background, exposed: linear RGB, not associated, and alpha. Where there is more light
    /// than an alpha of the coverage lets be seen, as of emission without absorption, alpha is as large as that
    /// needs: over black it is the same light.
    pub fn composited(&self, pixel: usize, image: &ImageSettings) -> [f32; 4] {
        let backdrop = self.backdrop(image, pixel / self.width);
        backdrop.straightened(backdrop.of(self, pixel).behind(self.color[pixel], self.held_back(pixel)))
    }

    /// The pixel over its background, exposed: linear RGB associated with the coverage, and that. Light that
    /// nothing covers keeps its colours at an alpha of 0.
    pub fn associated(&self, pixel: usize, image: &ImageSettings) -> [f32; 4] {
        let backdrop = self.backdrop(image, pixel / self.width);
        backdrop.of(self, pixel).behind(self.color[pixel], self.held_back(pixel))
    }

    /// What is held back of each colour behind a pixel.
    #[inline(always)]
    fn held_back(&self, pixel: usize) -> [f32; 3] {
        self.opacities.get(pixel).copied().unwrap_or([self.color[pixel][3]; 3])
    }

    /// The picture as 8-bit RGBA, encoded as the settings say.
    pub fn to_rgba8(&self, image: &ImageSettings) -> Vec<u8> {
        let linear = |v: f32| nearest(part(v) * 255.0) as u8;
        match image.encoding {
            Encoding::Srgb => {
                let table = &*SRGB8;
                self.encoded(image, |c| table.code(c), linear)
            }
            Encoding::Linear => self.encoded(image, linear, linear),
        }
    }

    /// The picture as 16-bit RGBA, encoded as the settings say.
    pub fn to_rgba16(&self, image: &ImageSettings) -> Vec<u16> {
        let linear = |v: f32| nearest(part(v) * 65535.0) as u16;
        match image.encoding {
            Encoding::Srgb => self.encoded(image, |c| linear(srgb_encode(part(c))), linear),
            Encoding::Linear => self.encoded(image, linear, linear),
        }
    }

    /// Rows in parallel.
    fn encoded<T: Copy + Default + Send>(
        &self,
        image: &ImageSettings,
        light: impl Fn(f32) -> T + Sync,
        alpha: impl Fn(f32) -> T + Sync,
    ) -> Vec<T> {
        /// Fewer pixels are done before another thread has woken up.
        const LEAST: usize = 1 << 14;
        let width = self.width.max(1);
        let mut values = vec![[T::default(); 4]; self.color.len()];
        parallel(|| {
            let rows = values.par_chunks_mut(width).zip(self.color.par_chunks(width)).enumerate();
            rows.with_min_len(LEAST.div_ceil(width)).for_each(|(y, (values, colors))| {
                let backdrop = self.backdrop(image, y);
                let code = |color| {
                    let [r, g, b, a] = backdrop.straightened(color);
                    [light(r), light(g), light(b), alpha(a)]
                };
                if backdrop.varies || !self.opacities.is_empty() {
                    for (x, (value, color)) in values.iter_mut().zip(colors).enumerate() {
                        let pixel = y * width + x;
                        *value = code(backdrop.of(self, pixel).behind(*color, self.held_back(pixel)));
                    }
                } else {
                    for (value, color) in values.iter_mut().zip(colors) {
                        *value = code(backdrop.behind(*color, [color[3]; 3]));
                    }
                }
            });
        });
        values.into_flattened()
    }

    fn backdrop(&self, image: &ImageSettings, row: usize) -> RowBackdrop {
        RowBackdrop {
            color: image.background.at(row, self.height),
            exposure: image.exposure,
            straight: image.background == Background::Transparent,
            varies: image.background == Background::Environment && self.backdrop.len() == self.color.len(),
        }
    }
}

/// What lies behind one row of pixels.
struct RowBackdrop {
    color: [f32; 4],
    exposure: f32,
    /// Whether colours are divided by their alpha: only a transparent background leaves it below 1,
    /// and files hold colours not associated.
    straight: bool,
    /// Whether every pixel has a colour of its own behind it.
    varies: bool,
}

impl RowBackdrop {
    /// What lies behind a pixel.
    fn of(&self, frame: &Frame, pixel: usize) -> Self {
        let [r, g, b] = frame.backdrop.get(pixel).copied().unwrap_or_default();
        let color = if self.varies { [r, g, b, 1.0] } else { self.color };
        Self { color, ..*self }
    }

    /// The pixel over it, exposed and associated.
    #[inline(always)]
    fn behind(&self, [r, g, b, a]: [f32; 4], held_back: [f32; 3]) -> [f32; 4] {
        let [x, y, z] = held_back.map(|opacity| 1.0 - opacity);
        let alpha = a + (1.0 - a) * self.color[3];
        let rgb = [r + x * self.color[0], g + y * self.color[1], b + z * self.color[2]];
        let [r, g, b] = rgb.map(|c| c * self.exposure);
        [r, g, b, alpha]
    }

    /// The same, not associated, where the background leaves alpha below 1.
    #[inline(always)]
    fn straightened(&self, [r, g, b, a]: [f32; 4]) -> [f32; 4] {
        if !self.straight {
            return [r, g, b, a];
        }
        // No file has more light than 1.
        let alpha = a.max(part(r.max(g).max(b)));
        if alpha > 0.0 { [r / alpha, g / alpha, b / alpha, alpha] } else { [r, g, b, alpha] }
    }
}
