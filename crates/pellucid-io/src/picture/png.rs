//! PNG files.

use std::io::{BufRead, ErrorKind, Seek, Write};
use std::path::Path;

use pellucid_field::memory;
use png::{BitDepth, ColorType, DecodingError, EncodingError, ScaledFloat, SrgbRenderingIntent, Transformations};

use super::{File, Picture, Transfer, check_size};
use crate::encoding::DEFLATE_RATIO;
use crate::{AtomicFile, IoError};

/// Pixels to write: rows from the top, 3 (RGB) or 4 (RGBA, not premultiplied) values per pixel;
/// the number of values decides which.
#[derive(Clone, Copy, Debug)]
pub enum PngPixels<'a> {
    /// 8 bits per value.
    U8(&'a [u8]),
    /// 16 bits per value.
    U16(&'a [u16]),
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

impl<R: BufRead + Seek> File<'_, R> {
    pub(super) fn png(self) -> Result<Picture, IoError> {
        let Self { path, limits, stored, reader } = self;
        let damaged = |reason| IoError::Damaged { path: path.to_owned(), encoding: "PNG", reason };
        let failed = |error: DecodingError| match error {
            DecodingError::IoError(source) if source.kind() != ErrorKind::UnexpectedEof => IoError::io(path)(source),
            other => damaged(other.to_string()),
        };
        let mut decoder = png::Decoder::new(reader);
        decoder.set_transformations(Transformations::EXPAND);
        // They may unpack to more than the picture.
        decoder.set_ignore_text_chunk(true);
        decoder.set_ignore_iccp_chunk(true);
        let mut reader = decoder.read_info().map_err(failed)?;
        let info = reader.info();
        let (width, height) = (info.width, info.height);
        // Linear data state a gamma of 1; whatever else files state is close to sRGB.
        let is_linear = info.gamma().is_some_and(|gamma| (gamma.into_value() - 1.0).abs() < 0.01);
        if info.color_type == ColorType::Indexed {
            // Other lengths make png 0.18.1 panic (image-png issue 694).
            let found = info.palette.as_ref().map_or(0, |palette| palette.len());
            if !(3..=768).contains(&found) || !found.is_multiple_of(3) {
                return Err(damaged(format!("the palette has {found} bytes, expected 3 for each of 1 to 256 colours")));
            }
        }
        let row = u64::from(width) * info.bits_per_pixel() as u64 / 8;
        let (needed, most) = (row.saturating_mul(height.into()), stored.saturating_mul(DEFLATE_RATIO));
        if needed > most {
            let what = "the picture, at best,";
            return Err(IoError::Truncated { path: path.to_owned(), what, found: most, expected: needed });
        }
        let out_of_memory = |bytes: u64| IoError::Memory { path: path.to_owned(), bytes };
        let size = reader.output_buffer_size().ok_or_else(|| out_of_memory(u64::MAX))?;
        check_size(limits, path, stored, u64::from(width) * u64::from(height), size as u64)?;
        let mut bytes = Vec::new();
        memory::reserve(&mut bytes, size).map_err(|_| out_of_memory(size as u64))?;
        bytes.resize(size, 0);
        let frame = reader.next_frame(&mut bytes).map_err(failed)?;
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
        let values = bytes[..frame.buffer_size()].chunks_exact(stride).take(area);
        pixels.extend(values.map(|pixel| rgba(std::array::from_fn(|channel| part(pixel, channel)))));
        if pixels.len() < area {
            return Err(damaged(format!("{} pixels, expected {area}", pixels.len())));
        }
        Ok(Picture { width, height, pixels, transfer: if is_linear { Transfer::Linear } else { Transfer::Srgb } })
    }
}
