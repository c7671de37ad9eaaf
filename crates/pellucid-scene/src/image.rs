//! The picture: size, background and encoding.

use pellucid_optics::{Color, ColorSpace};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::{Checked, require};

/// Size and encoding of the picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ImageSettings {
    /// Pixels per row, 1 to 32768. Default 1024.
    pub width: u32,
    /// Rows, 1 to 32768. Default 1024.
    pub height: u32,
    /// What lies behind the volume. Default black.
    pub background: Background,
    /// How linear radiance becomes numbers in an 8- or 16-bit file. Default srgb.
    pub encoding: Encoding,
    /// Factor on the radiance before encoding, greater than 0. Default 1.
    pub exposure: f32,
}

impl Default for ImageSettings {
    fn default() -> Self {
        Self {
            width: 1024,
            height: 1024,
            background: Background::default(),
            encoding: Encoding::default(),
            exposure: 1.0,
        }
    }
}

/// What lies behind the volume.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum Background {
    /// Nothing: the picture keeps its alpha.
    Transparent,
    /// The environment of the path tracer, where the eye looks past the volume and through it. Black with other
    /// techniques, and where there is no environment.
    Environment,
    /// One colour.
    Color(Color),
    /// A vertical gradient, interpolated in linear light.
    Gradient {
        /// Colour of the top row.
        top: Color,
        /// Colour of the bottom row.
        bottom: Color,
    },
}

impl Default for Background {
    /// Black.
    fn default() -> Self {
        Self::Color(Color::BLACK)
    }
}

impl Background {
    /// Linear RGBA behind row `y` of `height`: alpha is 0 if transparent, else 1. A gradient begins and ends in the
    /// middles of its first and last row; a single row has the colour halfway.
    pub fn at(&self, y: usize, height: usize) -> [f32; 4] {
        let opaque = |[r, g, b]: [f32; 3]| [r, g, b, 1.0];
        match self {
            Self::Transparent => [0.0; 4],
            // Its colours are the frame's, pixel by pixel.
            Self::Environment => opaque([0.0; 3]),
            Self::Color(color) => opaque(color.to_linear(ColorSpace::Srgb)),
            Self::Gradient { top, bottom } => {
                let t = if height > 1 { y as f32 / (height - 1) as f32 } else { 0.5 };
                let (a, b) = (top.to_linear(ColorSpace::Srgb), bottom.to_linear(ColorSpace::Srgb));
                opaque(std::array::from_fn(|k| a[k] + (b[k] - a[k]) * t))
            }
        }
    }
}

/// How linear radiance becomes picture numbers. Floating-point files are always linear.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Encoding {
    /// The sRGB curve: right on a screen.
    #[default]
    Srgb,
    /// Numbers proportional to radiance: for measuring and for comparison with other programs.
    Linear,
}

impl ImageSettings {
    pub(crate) fn check(&self, path: &str) -> Checked {
        for (key, size) in [("width", self.width), ("height", self.height)] {
            require((1..=32768).contains(&size), path, key, size, "1 to 32768 pixels")?;
        }
        let exposure = self.exposure;
        require(exposure > 0.0 && exposure.is_finite(), path, "exposure", exposure, "a factor greater than 0")
    }
}
