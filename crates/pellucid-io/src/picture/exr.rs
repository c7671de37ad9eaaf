//! OpenEXR files.

use std::io::{BufRead, ErrorKind, Seek};
use std::path::Path;

use exr::meta::MetaData;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, ReadChannels, ReadLayers, Vec2,
    WritableImage,
};

use pellucid_field::memory;

use super::{File, Picture, Transfer, check_size};
use crate::{AtomicFile, IoError};

impl<R: BufRead + Seek> File<'_, R> {
    pub(super) fn exr(mut self) -> Result<Picture, IoError> {
        let Self { path, limits, stored, .. } = self;
        let damaged = |error: exr::error::Error| match error {
            exr::error::Error::Io(source) if source.kind() != ErrorKind::UnexpectedEof => IoError::io(path)(source),
            other => IoError::Damaged { path: path.to_owned(), encoding: "EXR", reason: other.to_string() },
        };
        // Headers lie: what is too large is refused before anything is allocated for it.
        let meta = MetaData::read_from_buffered(&mut self.reader, false).map_err(damaged)?;
        self.reader.rewind().map_err(IoError::io(path))?;
        for header in &meta.headers {
            let size = header.layer_size;
            let pixels = (size.width() as u64).saturating_mul(size.height() as u64);
            check_size(limits, path, stored, pixels, pixels.saturating_mul(header.channels.bytes_per_pixel as u64))?;
        }
        let create = |size: Vec2<usize>, _: &_| (size, vec![[0.0f32; 4]; size.area()]);
        let store =
            |(size, pixels): &mut (Vec2<usize>, Vec<[f32; 4]>), at: Vec2<usize>, (r, g, b, a): (f32, f32, f32, f32)| {
                if let Some(pixel) = pixels.get_mut(at.y() * size.width() + at.x()) {
                    *pixel = [r, g, b, a];
                }
            };
        let reader = exr::prelude::read().no_deep_data().largest_resolution_level().rgba_channels(create, store);
        let read = reader.first_valid_layer().all_attributes().from_buffered(&mut self.reader);
        let image = read.map_err(damaged)?;
        let (size, pixels) = image.layer_data.channel_data.pixels;
        let [width, height] = [size.width(), size.height()].map(|n| n as u32);
        Ok(Picture { width, height, pixels, transfer: Transfer::Linear })
    }
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
