//! Frames as picture files.

use std::path::{Path, PathBuf};

use pellucid_field::memory;
use pellucid_io::{IoError, PngPixels, Transfer, write_exr, write_png};
use pellucid_scene::{Encoding, Frame, ImageSettings};

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
    let path = path.as_ref();
    let (width, height) = (frame.width as u32, frame.height as u32);
    let bytes_per_pixel = if depth == PngDepth::Eight { 4 } else { 8 };
    // Once as they are, once packed.
    afford(path, frame, 2 * bytes_per_pixel)?;
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
    let path = path.as_ref();
    // Nine channels, here and in what is packed.
    afford(path, frame, 2 * 9 * size_of::<f32>())?;
    let mut rgba = [const { Vec::new() }; 4];
    for pixel in 0..frame.color.len() {
        for (channel, value) in rgba.iter_mut().zip(frame.associated(pixel, image)) {
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

/// Refuses a picture that does not fit into memory once more, in the form of a file.
fn afford(path: &Path, frame: &Frame, bytes_per_pixel: usize) -> Result<(), IoError> {
    memory::afford(frame.color.len() * bytes_per_pixel).map_err(|refused| IoError::memory(path, refused))
}

#[cfg(test)]
mod tests {
    use exr::prelude::read_first_flat_layer_from_file;
    use pellucid_optics::Color;
    use pellucid_scene::Background;

    use super::*;

    #[test]
    fn exr_layers_hold_the_frame_in_linear_premultiplied_light() {
        let mut frame = Frame::new(2, 1);
        frame.color[0] = [0.2, 0.1, 0.05, 0.5];
        frame.depth[0] = 7.0;
        frame.normal[0] = [0.0, -1.0, 0.0];
        frame.samples[0] = 3;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.EXR");
        let read = |background| {
            save(&path, &frame, &ImageSettings { background, exposure: 2.0, ..Default::default() }).unwrap();
            let layers = read_first_flat_layer_from_file(&path).unwrap().layer_data.channel_data.list;
            move |name: &str| {
                let layer = layers.iter().find(|layer| layer.name == *name).unwrap();
                layer.sample_data.values_as_f32().collect::<Vec<f32>>()
            }
        };
        let transparent = read(Background::Transparent);
        // Twice the radiance; coverage is no light.
        for (name, expected) in [
            ("R", [0.4, 0.0]),
            ("G", [0.2, 0.0]),
            ("B", [0.1, 0.0]),
            ("A", [0.5, 0.0]),
            ("Z", [7.0, f32::INFINITY]),
            ("N.X", [0.0, 0.0]),
            ("N.Y", [-1.0, 0.0]),
            ("N.Z", [0.0, 0.0]),
            ("samples", [3.0, 0.0]),
        ] {
            for (found, expected) in transparent(name).into_iter().zip(expected) {
                assert!(found == expected || (found - expected).abs() < 1e-6, "{name}: {found}, expected {expected}");
            }
        }
        // (0.2 + (1 - 0.5) * 1) * 2 over white, and white itself.
        let white = read(Background::Color(Color::WHITE));
        assert_eq!((white("R"), white("A")), (vec![1.4, 2.0], vec![1.0, 1.0]));
    }

    /// Emission without absorption covers nothing, and is light all the same.
    #[test]
    fn exr_keeps_light_that_covers_nothing() {
        let mut frame = Frame::new(1, 1);
        frame.color[0] = [0.5, 0.25, 2.0, 0.0];
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("light.exr");
        save(&path, &frame, &ImageSettings { background: Background::Transparent, ..Default::default() }).unwrap();
        let layers = read_first_flat_layer_from_file(&path).unwrap().layer_data.channel_data.list;
        for (name, expected) in [("R", 0.5), ("G", 0.25), ("B", 2.0), ("A", 0.0)] {
            let layer = layers.iter().find(|layer| layer.name == *name).unwrap();
            assert_eq!(layer.sample_data.values_as_f32().next(), Some(expected), "{name}");
        }
    }

    #[test]
    fn other_extensions_are_refused() {
        let frame = Frame::new(1, 1);
        for name in ["a.jpg", "png", "a."] {
            let error = save(name, &frame, &ImageSettings::default()).unwrap_err();
            assert!(matches!(error, SaveError::Extension { .. }), "{error}");
        }
    }
}
