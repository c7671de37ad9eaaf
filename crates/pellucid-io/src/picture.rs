//! Pictures: PNG with 8 or 16 bits, and EXR with named floating point channels.

mod exr;
mod guard;
mod png;

use std::io::{BufRead, BufReader, Cursor, Seek};
use std::path::Path;

pub use self::exr::write_exr;
use self::guard::guarded;
pub use self::guard::is_guarded;
pub use self::png::{PngPixels, write_png};
use crate::{IoError, Limits, open_regular};

/// What the numbers of a picture are proportional to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transfer {
    /// Perceived brightness: encoded by the sRGB curve.
    Srgb,
    /// Light.
    Linear,
}

/// A picture read from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// RGBA as stored, rows from the top: of a PNG in 0..=1, not premultiplied and not decoded; of an EXR linear
    /// light.
    pub pixels: Vec<[f32; 4]>,
    /// What the file says of its numbers; sRGB where it says nothing.
    pub transfer: Transfer,
}

/// Reads a PNG of any kind as RGBA; grey becomes three equal values, a missing alpha 1.
///
/// # Errors
/// As [`read_picture`].
pub fn read_png(path: impl AsRef<Path>) -> Result<Picture, IoError> {
    File::open(path.as_ref(), &Limits::default())?.decode(PictureFormat::Png)
}

/// Reads the first layer of an EXR that has channels `R`, `G` and `B`, and perhaps `A`, as 32-bit floats of
/// linear light, as they are.
///
/// # Errors
/// As [`read_picture`].
pub fn read_exr(path: impl AsRef<Path>) -> Result<Picture, IoError> {
    File::open(path.as_ref(), &Limits::default())?.decode(PictureFormat::Exr)
}

/// Reads an EXR, if the extension says so, or else a PNG.
///
/// # Errors
/// [`IoError::Io`], [`IoError::Damaged`] if it is no such picture, broken or without colours, [`IoError::Truncated`] if
/// its size cannot hold its pixels, and [`IoError::Limit`] and [`IoError::Memory`] if they are too many.
pub fn read_picture(path: impl AsRef<Path>, limits: &Limits) -> Result<Picture, IoError> {
    let path = path.as_ref();
    File::open(path, limits)?.decode(PictureFormat::of(path))
}

/// Reads a picture from bytes in memory as if they were the content of the file `name`.
///
/// # Errors
/// As [`read_picture`].
pub fn read_picture_bytes(name: impl AsRef<Path>, bytes: &[u8], limits: &Limits) -> Result<Picture, IoError> {
    let path = name.as_ref();
    File { path, limits, stored: bytes.len() as u64, reader: Cursor::new(bytes) }.decode(PictureFormat::of(path))
}

#[derive(Clone, Copy)]
enum PictureFormat {
    Png,
    Exr,
}

impl PictureFormat {
    fn of(path: &Path) -> Self {
        let is_exr = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("exr"));
        if is_exr { Self::Exr } else { Self::Png }
    }
}

/// A picture file to be decoded.
struct File<'a, R> {
    path: &'a Path,
    limits: &'a Limits,
    /// Bytes of the file.
    stored: u64,
    reader: R,
}

impl<'a> File<'a, BufReader<std::fs::File>> {
    fn open(path: &'a Path, limits: &'a Limits) -> Result<Self, IoError> {
        let file = open_regular(path)?;
        let stored = file.metadata().map_err(IoError::io(path))?.len();
        Ok(Self { path, limits, stored, reader: BufReader::new(file) })
    }
}

impl<R: BufRead + Seek> File<'_, R> {
    fn decode(self, format: PictureFormat) -> Result<Picture, IoError> {
        let (path, encoding) = (self.path.to_owned(), if matches!(format, PictureFormat::Exr) { "EXR" } else { "PNG" });
        let damaged = |reason| IoError::Damaged { path, encoding, reason };
        guarded(damaged, || match format {
            PictureFormat::Png => self.png(),
            PictureFormat::Exr => self.exr(),
        })
    }
}

/// Refuses pixels that the `stored` bytes of a file must not decode to, with `others` bytes on the way to them.
fn check_size(limits: &Limits, path: &Path, stored: u64, pixels: u64, others: u64) -> Result<(), IoError> {
    let bytes = pixels.saturating_mul(size_of::<[f32; 4]>() as u64).saturating_add(others);
    limits.check_bytes(path, bytes, stored)
}
