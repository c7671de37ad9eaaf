//! From a frame to the numbers of a picture.

use pellucid_field::parallel;
use pellucid_optics::srgb_encode;
use rayon::prelude::*;

use crate::srgb8::SRGB8;
use crate::{Background, Encoding, Frame, ImageSettings};

impl Frame {
    /// The pixel over its background, exposed: linear RGB, not associated, and alpha.
    pub fn composited(&self, pixel: usize, image: &ImageSettings) -> [f32; 4] {
        self.backdrop(image, pixel / self.width).of(self, pixel).behind(self.color[pixel])
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
        let encode = |(y, (values, colors)): (usize, (&mut [[T; 4]], &[[f32; 4]]))| {
            let backdrop = self.backdrop(image, y);
            let code = |[r, g, b, a]: [f32; 4]| [light(r), light(g), light(b), alpha(a)];
            if backdrop.varies {
                for (x, (value, color)) in values.iter_mut().zip(colors).enumerate() {
                    *value = code(backdrop.of(self, y * width + x).behind(*color));
                }
            } else {
                for (value, color) in values.iter_mut().zip(colors) {
                    *value = code(backdrop.behind(*color));
                }
            }
        };
        parallel(|| {
            let rows = values.par_chunks_mut(width).zip(self.color.par_chunks(width)).enumerate();
            rows.with_min_len(LEAST.div_ceil(width)).for_each(encode);
        });
        values.into_flattened()
    }

    fn backdrop(&self, image: &ImageSettings, row: usize) -> Backdrop {
        Backdrop {
            color: image.background.at(row, self.height),
            exposure: image.exposure,
            straight: image.background == Background::Transparent,
            varies: image.background == Background::Environment && self.backdrop.len() == self.color.len(),
        }
    }
}

/// What lies behind one row of pixels.
struct Backdrop {
    color: [f32; 4],
    exposure: f32,
    /// Whether colours are divided by their alpha: only a transparent background leaves it below 1,
    /// and files hold colours not associated.
    straight: bool,
    /// Whether every pixel has a colour of its own behind it.
    varies: bool,
}

impl Backdrop {
    /// What lies behind a pixel.
    fn of(&self, frame: &Frame, pixel: usize) -> Self {
        let [r, g, b] = frame.backdrop.get(pixel).copied().unwrap_or_default();
        let color = if self.varies { [r, g, b, 1.0] } else { self.color };
        Self { color, ..*self }
    }

    /// The pixel over it, exposed.
    #[inline(always)]
    fn behind(&self, [r, g, b, a]: [f32; 4]) -> [f32; 4] {
        let through = 1.0 - a;
        let alpha = a + through * self.color[3];
        let rgb = [r + through * self.color[0], g + through * self.color[1], b + through * self.color[2]];
        let rgb = if self.straight && alpha > 0.0 { rgb.map(|c| c / alpha) } else { rgb };
        let [r, g, b] = rgb.map(|c| c * self.exposure);
        [r, g, b, alpha]
    }
}

/// The number as a part of 0 to 1; NaN is 0.
#[inline(always)]
pub fn part(v: f32) -> f32 {
    if v > 0.0 { v.min(1.0) } else { 0.0 }
}

/// The nearest whole number of a number of 0 to 65535, halves up. `f32::round` and casts are calls
/// and branches on the oldest processors; this becomes a few instructions for several numbers.
#[inline(always)]
pub fn nearest(v: f32) -> u32 {
    /// From here on floats have no fractions: a sum is rounded, halves to even.
    const WHOLE: f32 = (1 << 23) as f32;
    let sum = v + WHOLE;
    let low_bits = sum.to_bits() - WHOLE.to_bits();
    low_bits + u32::from(v - (sum - WHOLE) >= 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_rounds_as_the_standard_library_does() {
        let halves = (0..65535u16).flat_map(|k| {
            let half = f32::from(k) + 0.5;
            [half.next_down(), half, half.next_up()]
        });
        for v in halves.chain((0..1_000_000).map(|k| k as f32 * 0.06553)) {
            assert_eq!(nearest(v), v.round() as u32, "{v}");
        }
        assert_eq!([f32::NAN, -1.0, -0.0, 2.0, 0.25].map(part), [0.0, 0.0, 0.0, 1.0, 0.25]);
    }
}
