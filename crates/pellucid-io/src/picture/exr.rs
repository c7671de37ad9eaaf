//! OpenEXR files.

use std::path::Path;

use exr::prelude::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage};

use crate::{AtomicFile, IoError};

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
    let list = channels.iter().map(|(name, values)| AnyChannel::new(*name, FlatSamples::F32(values.to_vec())));
    let layer = Layer::new(
        (width as usize, height as usize),
        LayerAttributes::default(),
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort(list.collect()),
    );
    let mut file = AtomicFile::create(path)?;
    let written = Image::from_layer(layer).write().to_buffered(&mut file);
    written.map_err(|error| match error {
        exr::error::Error::Io(source) => IoError::io(path)(source),
        other => IoError::io(path)(std::io::Error::other(other)),
    })?;
    file.commit()
}
