//! What a backend gives back.

use std::fmt;

use pellucid_optics::srgb_encode;

use crate::{Background, Encoding, ImageSettings};

/// A drawn picture and what was measured on the way; rows from the top, `width * height` each.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Linear RGB radiance times coverage, and coverage (associated alpha); no background.
    pub color: Vec<[f32; 4]>,
    /// Distance from the eye (along the ray, world units) to where the ray's opacity first reaches
    /// one half, to the surface, or to the projected extreme; infinite where there is none.
    pub depth: Vec<f32>,
    /// Unit world normal at that depth, out of the surface towards lower values; zero where there
    /// is none.
    pub normal: Vec<[f32; 3]>,
    /// Field samples taken for the pixel, gradient taps not counted.
    pub samples: Vec<u32>,
    /// Totals.
    pub statistics: FrameStatistics,
    /// What the user should know.
    pub warnings: Vec<RenderWarning>,
}

/// Totals of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameStatistics {
    /// Rays cast.
    pub rays: u64,
    /// Rays that met the volume.
    pub rays_hit: u64,
    /// Rays that stopped early because they were opaque.
    pub rays_terminated: u64,
    /// Samples taken.
    pub samples: u64,
    /// Samples that added opacity (7.0-1).
    pub samples_visible: u64,
    /// Samples leapt over in empty blocks.
    pub samples_skipped: u64,
    /// Seconds to build tables and block maps.
    pub setup_seconds: f64,
    /// Seconds to draw.
    pub render_seconds: f64,
}

/// Something a user should hear of although the picture was drawn.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum RenderWarning {
    /// Nothing of the volume is in the picture.
    Empty {
        /// Why, as far as known.
        reason: String,
    },
}

impl fmt::Display for RenderWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty { reason } => write!(f, "the picture is empty: {reason}"),
        }
    }
}

impl Frame {
    /// An empty picture.
    pub fn new(width: usize, height: usize) -> Self {
        let n = width * height;
        Self {
            width,
            height,
            color: vec![[0.0; 4]; n],
            depth: vec![f32::INFINITY; n],
            normal: vec![[0.0; 3]; n],
            samples: vec![0; n],
            ..Self::default()
        }
    }

    /// The pixel over its background, exposed: linear RGB, not associated, and alpha.
    pub fn composited(&self, pixel: usize, image: &ImageSettings) -> [f32; 4] {
        let [r, g, b, a] = self.color[pixel];
        let behind = image.background.at(pixel / self.width, self.height);
        let through = 1.0 - a;
        let alpha = a + through * behind[3];
        let rgb = [r + through * behind[0], g + through * behind[1], b + through * behind[2]];
        // Only a transparent background leaves alpha below 1; files hold colours not associated.
        let divide = if image.background == Background::Transparent && alpha > 0.0 { alpha } else { 1.0 };
        let [r, g, b] = rgb.map(|c| c / divide * image.exposure);
        [r, g, b, alpha]
    }

    /// The picture as 8-bit RGBA, encoded as the settings say.
    pub fn to_rgba8(&self, image: &ImageSettings) -> Vec<u8> {
        self.quantized(image, 255.0, |v| v as u8)
    }

    /// The picture as 16-bit RGBA, encoded as the settings say.
    pub fn to_rgba16(&self, image: &ImageSettings) -> Vec<u16> {
        self.quantized(image, 65535.0, |v| v as u16)
    }

    fn quantized<T>(&self, image: &ImageSettings, levels: f32, cast: impl Fn(f32) -> T) -> Vec<T> {
        let encode = |c: f32| match image.encoding {
            Encoding::Srgb => srgb_encode(c.clamp(0.0, 1.0)),
            Encoding::Linear => c.clamp(0.0, 1.0),
        };
        let mut values = Vec::with_capacity(self.color.len() * 4);
        for pixel in 0..self.color.len() {
            let [r, g, b, a] = self.composited(pixel, image);
            let rgba = [encode(r), encode(g), encode(b), a.clamp(0.0, 1.0)];
            values.extend(rgba.map(|v| cast((v * levels).round())));
        }
        values
    }
}
