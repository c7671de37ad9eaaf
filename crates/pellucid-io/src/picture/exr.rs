//! OpenEXR files.

use std::io::Cursor;
use std::path::Path;

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, ReadChannels, ReadLayers, Vec2,
    WritableImage,
};

use pellucid_field::memory;

use super::{Picture, Transfer};
use crate::source::Source;
use crate::{AtomicFile, IoError};

/// Most pixels that are read: 1 GiB of RGBA.
const MOST_PIXELS: u64 = 1 << 26;

/// Reads the first layer of an EXR that has channels `R`, `G` and `B`, and perhaps `A`, as 32-bit floats of
/// linear light, as they are.
///
/// # Errors
/// [`IoError::Io`], [`IoError::Damaged`] if it is not an EXR, broken or without these channels, and
/// [`IoError::Memory`] for more than 2^26 pixels.
pub fn read_exr(path: impl AsRef<Path>) -> Result<Picture, IoError> {
    let path = path.as_ref();
    let source = Source::open(path)?;
    let damaged = |reason: String| IoError::Damaged { path: path.to_owned(), encoding: "EXR", reason };
    // Headers lie: a picture that is too large is not allocated, and its pixels go nowhere.
    let fits = |size: Vec2<usize>| (size.width() as u64).saturating_mul(size.height() as u64) <= MOST_PIXELS;
    let create = |size: Vec2<usize>, _: &_| {
        let pixels = if fits(size) { vec![[0.0f32; 4]; size.area()] } else { Vec::new() };
        (size, pixels)
    };
    let store =
        |(size, pixels): &mut (Vec2<usize>, Vec<[f32; 4]>), at: Vec2<usize>, (r, g, b, a): (f32, f32, f32, f32)| {
            if let Some(pixel) = pixels.get_mut(at.y() * size.width() + at.x()) {
                *pixel = [r, g, b, a];
            }
        };
    let reader = exr::prelude::read().no_deep_data().largest_resolution_level().rgba_channels(create, store);
    let read = reader.first_valid_layer().all_attributes().from_buffered(Cursor::new(source.bytes()));
    let image = read.map_err(|error| damaged(error.to_string()))?;
    let (size, pixels) = image.layer_data.channel_data.pixels;
    if !fits(size) {
        let bytes = (size.width() as u64).saturating_mul(size.height() as u64).saturating_mul(16);
        return Err(IoError::Memory { path: path.to_owned(), bytes });
    }
    let [width, height] = [size.width(), size.height()].map(|n| n as u32);
    Ok(Picture { width, height, pixels, transfer: Transfer::Linear })
}

/// Writes a single-layer EXR of 32-bit floating point channels, compressed without loss. Each
/// channel has a name (`R`, `G`, `B`, `A`, `Z`, `N.X`, ...) and one value per pixel, rows from the
/// top. By the convention of the format colours are linear and premultiplied.
///
/// # Errors
/// [`IoError::PictureSize`] if a channel does not fill the picture, [`IoError::Malformed`] if the
/// names are empty or repeat themselves, and [`IoError::Io`].
pub fn write_exr(path: impl AsRef<Path>, width: u32, height: u32, channels: &[(&str, &[f32])]) -> Result<(), IoError> {
    let path = path.as_ref();
    let expected = width as usize * height as usize;
    for (index, (name, values)) in channels.iter().enumerate() {
        if values.len() != expected || expected == 0 {
            let path = path.to_owned();
            return Err(IoError::PictureSize { path, found: values.len(), expected, width, height, channels: 1 });
        }
        if name.is_empty() || channels[..index].iter().any(|(other, _)| other == name) {
            return Err(IoError::malformed(path, "channel name", name, "a name of its own for every channel"));
        }
    }
    if channels.is_empty() {
        return Err(IoError::malformed(path, "channels", "none", "at least one"));
    }
    let channel = |(name, values): &(&str, &[f32])| {
        let values = memory::copied(values).map_err(|refused| IoError::memory(path, refused))?;
        Ok(AnyChannel::new(*name, FlatSamples::F32(values)))
    };
    let list = channels.iter().map(channel).collect::<Result<_, IoError>>()?;
    let layer = Layer::new(
        (width as usize, height as usize),
        LayerAttributes::default(),
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort(list),
    );
    let mut file = AtomicFile::create(path)?;
    let written = Image::from_layer(layer).write().to_buffered(&mut file);
    written.map_err(|error| match error {
        exr::error::Error::Io(source) => IoError::io(path)(source),
        other => IoError::io(path)(std::io::Error::other(other)),
    })?;
    file.commit()
}
