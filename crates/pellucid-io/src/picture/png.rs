//! PNG files.

use std::io::{Cursor, Write};
use std::path::Path;

use pellucid_field::memory;
use png::{BitDepth, ColorType, DecodingError, EncodingError, ScaledFloat, SrgbRenderingIntent, Transformations};

use crate::source::Source;
use crate::{AtomicFile, IoError};

/// What the numbers of a picture are proportional to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transfer {
    /// Perceived brightness: encoded by the sRGB curve.
    Srgb,
    /// Light.
    Linear,
}

/// Pixels to write: rows from the top, 3 (RGB) or 4 (RGBA, not premultiplied) values per pixel;
/// the number of values decides which.
#[derive(Clone, Copy, Debug)]
pub enum PngPixels<'a> {
    /// 8 bits per value.
    U8(&'a [u8]),
    /// 16 bits per value.
    U16(&'a [u16]),
}

/// A picture read from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// RGBA as stored, rows from the top: of a PNG in 0..=1, not premultiplied and not decoded.
    pub pixels: Vec<[f32; 4]>,
    /// What the file says of its numbers; sRGB where it says nothing.
    pub transfer: Transfer,
}

/// Writes a PNG with an sRGB chunk for sRGB data, or a gamma of 1.0 for linear ones.
///
/// # Errors
/// [`IoError::PictureSize`] if the values do not fill the picture, and [`IoError::Io`].
pub fn write_png(
    path: impl AsRef<Path>,
    width: u32,
    height: u32,
    pixels: PngPixels,
    transfer: Transfer,
) -> Result<(), IoError> {
    let path = path.as_ref();
    let (values, depth) = match pixels {
        PngPixels::U8(values) => (values.len(), BitDepth::Eight),
        PngPixels::U16(values) => (values.len(), BitDepth::Sixteen),
    };
    let area = u64::from(width) * u64::from(height);
    let color = match values as u64 {
        _ if area == 0 => None,
        n if Some(n) == area.checked_mul(3) => Some(ColorType::Rgb),
        n if Some(n) == area.checked_mul(4) => Some(ColorType::Rgba),
        _ => None,
    };
    let Some(color) = color else {
        let expected = area.saturating_mul(4) as usize;
        return Err(IoError::PictureSize {
            path: path.to_owned(),
            found: values,
            expected,
            width,
            height,
            channels: 4,
        });
    };
    let mut file = AtomicFile::create(path)?;
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    match transfer {
        Transfer::Srgb => encoder.set_source_srgb(SrgbRenderingIntent::RelativeColorimetric),
        Transfer::Linear => encoder.set_source_gamma(ScaledFloat::new(1.0)),
    }
    let encode = || -> Result<(), EncodingError> {
        let mut writer = encoder.write_header()?;
        match pixels {
            PngPixels::U8(values) => writer.write_image_data(values)?,
            PngPixels::U16(values) => {
                let mut stream = writer.stream_writer()?;
                for row in values.chunks(values.len() / height as usize) {
                    let bytes: Vec<u8> = row.iter().flat_map(|value| value.to_be_bytes()).collect();
                    stream.write_all(&bytes)?;
                }
                stream.finish()?;
            }
        }
        writer.finish()
    };
    encode().map_err(|error| match error {
        EncodingError::IoError(source) => IoError::io(path)(source),
        other => IoError::io(path)(std::io::Error::other(other)),
    })?;
    file.commit()
}

/// Reads a PNG of any kind as RGBA; grey becomes three equal values, a missing alpha 1.
///
/// # Errors
/// [`IoError::Io`], [`IoError::Damaged`] if it is not a PNG or broken, [`IoError::Truncated`] if
/// its size cannot hold its pixels, and [`IoError::Memory`].
pub fn read_png(path: impl AsRef<Path>) -> Result<Picture, IoError> {
    let path = path.as_ref();
    let source = Source::open(path)?;
    let damaged = |error: DecodingError| match error {
        DecodingError::IoError(source) if source.kind() != std::io::ErrorKind::UnexpectedEof => {
            IoError::io(path)(source)
        }
        other => IoError::Damaged { path: path.to_owned(), encoding: "PNG", reason: other.to_string() },
    };
    let mut decoder = png::Decoder::new(Cursor::new(source.bytes()));
    decoder.set_transformations(Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(damaged)?;
    let info = reader.info();
    let (width, height) = (info.width, info.height);
    // Linear data state a gamma of 1; whatever else files state is close to sRGB.
    let is_linear = info.gamma().is_some_and(|gamma| (gamma.into_value() - 1.0).abs() < 0.01);
    let row = u64::from(width) * info.bits_per_pixel() as u64 / 8;
    let (needed, most) = (row * u64::from(height), source.bytes().len() as u64 * 1032);
    if needed > most {
        let what = "the picture, at best,";
        return Err(IoError::Truncated { path: path.to_owned(), what, found: most, expected: needed });
    }
    let out_of_memory = |bytes: u64| IoError::Memory { path: path.to_owned(), bytes };
    let size = reader.output_buffer_size().ok_or_else(|| out_of_memory(u64::MAX))?;
    let mut bytes = Vec::new();
    memory::reserve(&mut bytes, size).map_err(|_| out_of_memory(size as u64))?;
    bytes.resize(size, 0);
    let frame = reader.next_frame(&mut bytes).map_err(damaged)?;
    let channels = frame.color_type.samples();
    let area = width as usize * height as usize;
    let mut pixels = Vec::new();
    memory::reserve(&mut pixels, area).map_err(|_| out_of_memory(area as u64 * 16))?;
    let rgba = |pixel: [f32; 4]| match channels {
        1 => [pixel[0], pixel[0], pixel[0], 1.0],
        2 => [pixel[0], pixel[0], pixel[0], pixel[1]],
        3 => [pixel[0], pixel[1], pixel[2], 1.0],
        _ => pixel,
    };
    let part = |pixel: &[u8], channel: usize| match frame.bit_depth {
        BitDepth::Sixteen => {
            let at = 2 * channel.min(channels - 1);
            f32::from(u16::from_be_bytes([pixel[at], pixel[at + 1]])) / 65535.0
        }
        _ => f32::from(pixel[channel.min(channels - 1)]) / 255.0,
    };
    let stride = channels * if frame.bit_depth == BitDepth::Sixteen { 2 } else { 1 };
    let stored = bytes[..frame.buffer_size()].chunks_exact(stride).take(area);
    pixels.extend(stored.map(|pixel| rgba(std::array::from_fn(|channel| part(pixel, channel)))));
    Ok(Picture { width, height, pixels, transfer: if is_linear { Transfer::Linear } else { Transfer::Srgb } })
}
