//! Frames as picture files.

use std::path::{Path, PathBuf};

use pellucid_io::{IoError, PngPixels, Transfer, write_exr, write_png};
use pellucid_scene::{Background, Encoding, Frame, ImageSettings};

/// Bits per channel of a PNG.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PngDepth {
    /// 8 bits, for screens.
    #[default]
    Eight,
    /// 16 bits, for measuring and for smooth gradients.
    Sixteen,
}

/// Why a frame is not saved.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SaveError {
    /// The extension names no picture format.
    #[error("{}: a picture's name must end in .png or .exr", path.display())]
    Extension {
        /// The file asked for.
        path: PathBuf,
    },
    /// The file cannot be written.
    #[error(transparent)]
    Io(#[from] IoError),
}

/// Saves a frame, whole or not at all: `.png` with 8 bits per channel as [`save_png`], `.exr` with
/// all layers as [`save_exr`].
///
/// # Errors
/// [`SaveError`].
pub fn save(path: impl AsRef<Path>, frame: &Frame, image: &ImageSettings) -> Result<(), SaveError> {
    let path = path.as_ref();
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    match extension.to_str() {
        Some("png") => Ok(save_png(path, frame, image, PngDepth::Eight)?),
        Some("exr") => Ok(save_exr(path, frame, image)?),
        _ => Err(SaveError::Extension { path: path.to_owned() }),
    }
}

/// Saves the picture, over its background and encoded as the settings say. Alpha is kept (not
/// premultiplied) if the background is transparent.
///
/// # Errors
/// [`IoError::Io`].
pub fn save_png(path: impl AsRef<Path>, frame: &Frame, image: &ImageSettings, depth: PngDepth) -> Result<(), IoError> {
    let (width, height) = (frame.width as u32, frame.height as u32);
    let transfer = match image.encoding {
        Encoding::Srgb => Transfer::Srgb,
        Encoding::Linear => Transfer::Linear,
    };
    match depth {
        PngDepth::Eight => write_png(path, width, height, PngPixels::U8(&frame.to_rgba8(image)), transfer),
        PngDepth::Sixteen => write_png(path, width, height, PngPixels::U16(&frame.to_rgba16(image)), transfer),
    }
}

/// Saves all layers of a frame as 32-bit floats: `R` `G` `B` `A`, the picture over its background
/// in linear light, premultiplied; `Z`, the depth in world units along the ray, infinite where
/// there is none; `N.X` `N.Y` `N.Z`, the world normal; `samples`, the field samples per pixel.
///
/// # Errors
/// [`IoError::Io`].
pub fn save_exr(path: impl AsRef<Path>, frame: &Frame, image: &ImageSettings) -> Result<(), IoError> {
    let mut rgba = [const { Vec::new() }; 4];
    for pixel in 0..frame.color.len() {
        let [r, g, b, a] = frame.composited(pixel, image);
        // Composited colours are divided by their alpha only over a transparent background.
        let coverage = if image.background == Background::Transparent { a } else { 1.0 };
        for (channel, value) in rgba.iter_mut().zip([r * coverage, g * coverage, b * coverage, a]) {
            channel.push(value);
        }
    }
    let [x, y, z] = [0, 1, 2].map(|axis| frame.normal.iter().map(|normal| normal[axis]).collect::<Vec<f32>>());
    let samples: Vec<f32> = frame.samples.iter().map(|count| *count as f32).collect();
    let [r, g, b, a] = &rgba;
    let channels: [(&str, &[f32]); 9] = [
        ("R", r),
        ("G", g),
        ("B", b),
        ("A", a),
        ("Z", &frame.depth),
        ("N.X", &x),
        ("N.Y", &y),
        ("N.Z", &z),
        ("samples", &samples),
    ];
    write_exr(path, frame.width as u32, frame.height as u32, &channels)
}
