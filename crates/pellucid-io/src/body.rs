//! The values of a volume on their way into a file.

use std::ffi::OsStr;
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use bytemuck::{NoUninit, cast_slice};
use flate2::Compression;
use flate2::write::{GzEncoder, ZlibEncoder};
use pellucid_field::{Volume, Voxel, VoxelType, Voxels, Warning, for_voxels};

use crate::atomic::commit_together;
use crate::{AtomicFile, IoError};

/// The type a volume's values have in formats that know no halves: `f16` becomes `f32`, exactly.
pub(crate) fn written_type(volume: &Volume, warnings: &mut Vec<Warning>) -> VoxelType {
    let found = volume.voxels().voxel_type();
    if found != VoxelType::F16 {
        return found;
    }
    let (from, to) = (found.name().to_owned(), VoxelType::F32);
    warnings.push(Warning::Converted { from, to, largest_error: 0.0 });
    to
}

/// Values of 32 bits that are written in 64, and what is added to each: in the file they are what they are, whatever its
/// format knows of scales and offsets.
#[derive(Clone, Copy)]
pub(crate) enum Wide<'v> {
    U32(&'v [u32], i64),
    I32(&'v [i32], i64),
    /// Far from 0 for what they differ by, so that single precision would lose that.
    F32(&'v [f32], f64),
}

impl<'v> Wide<'v> {
    /// Those of a volume, if they would be others with 32 bits.
    pub fn of(volume: &'v Volume) -> Option<Self> {
        let (map, range) = (volume.value_map(), volume.statistics());
        if map.scale != 1.0 || map.offset == 0.0 {
            return None;
        }
        // Sums of such numbers fit.
        let whole = (map.offset.fract() == 0.0 && map.offset.abs() <= 9.0e18).then_some(map.offset as i64);
        match volume.voxels() {
            Voxels::U32(data) => whole.map(|base| Self::U32(data, base)),
            Voxels::I32(data) => whole.map(|base| Self::I32(data, base)),
            // Readers count doubles from the smallest where singles would lose about as much.
            Voxels::F32(data) if map.offset.abs() > 4.0 * (range.max - range.min) => Some(Self::F32(data, map.offset)),
            _ => None,
        }
    }

    /// Whether they become integers; doubles, otherwise.
    pub fn is_integer(&self) -> bool {
        !matches!(self, Self::F32(..))
    }

    /// Writes every `stride`th value from the first on.
    fn write(self, out: &mut impl Write, first: usize, stride: usize) -> io::Result<()> {
        fn every<T: Copy>(data: &[T], first: usize, stride: usize) -> impl Iterator<Item = T> {
            data[first..].iter().step_by(stride).copied()
        }
        match self {
            Self::U32(data, base) => write_each(out, every(data, first, stride).map(|value| base + i64::from(value))),
            Self::I32(data, base) => write_each(out, every(data, first, stride).map(|value| base + i64::from(value))),
            Self::F32(data, base) => write_each(out, every(data, first, stride).map(|value| base + f64::from(value))),
        }
    }
}

/// How values are packed.
#[derive(Clone, Copy)]
pub(crate) enum Packing {
    Plain,
    /// At this deflate level.
    Gzip(u8),
    /// At this deflate level.
    Zlib(u8),
}

/// Writes the values in their [`written_type`], native order, components interleaved; the position
/// after them.
fn write_body(file: &mut AtomicFile, volume: &Volume, packing: Packing) -> io::Result<u64> {
    let level = |level: u8| Compression::new(level.clamp(1, 9).into());
    match packing {
        Packing::Plain => write_interleaved(file, volume)?,
        Packing::Gzip(n) => {
            let mut encoder = GzEncoder::new(&mut *file, level(n));
            write_interleaved(&mut encoder, volume)?;
            encoder.finish()?;
        }
        Packing::Zlib(n) => {
            let mut encoder = ZlibEncoder::new(&mut *file, level(n));
            write_interleaved(&mut encoder, volume)?;
            encoder.finish()?;
        }
    }
    file.stream_position()
}

/// Values as they are in memory, or as 64-bit integers.
pub(crate) fn write_interleaved(out: &mut impl Write, volume: &Volume) -> io::Result<()> {
    match Wide::of(volume) {
        Some(wide) => wide.write(out, 0, 1),
        None => write_as_they_are(out, volume.voxels()),
    }
}

fn write_as_they_are(out: &mut impl Write, voxels: &Voxels) -> io::Result<()> {
    match voxels {
        Voxels::F16(data) => write_each(out, data.iter().map(|value| value.to_f32())),
        voxels => out.write_all(voxels.as_bytes()),
    }
}

/// Each component as a whole grid, one after the other.
pub(crate) fn write_planar(out: &mut impl Write, volume: &Volume) -> io::Result<()> {
    let components = volume.components();
    for component in 0..components {
        if let Some(wide) = Wide::of(volume) {
            wide.write(out, component, components)?;
            continue;
        }
        match volume.voxels() {
            Voxels::F16(data) => {
                write_each(out, data[component..].iter().step_by(components).map(|value| value.to_f32()))?;
            }
            voxels => for_voxels!(voxels, data => write_plane(out, &data[component..], components))?,
        }
    }
    Ok(())
}

fn write_plane<T: Voxel>(out: &mut impl Write, data: &[T], stride: usize) -> io::Result<()> {
    write_each(out, data.iter().step_by(stride).copied())
}

fn write_each<T: NoUninit>(out: &mut impl Write, mut values: impl Iterator<Item = T>) -> io::Result<()> {
    let mut chunk: Vec<T> = Vec::with_capacity(1 << 13);
    loop {
        chunk.clear();
        chunk.extend(values.by_ref().take(1 << 13));
        if chunk.is_empty() {
            return Ok(());
        }
        out.write_all(cast_slice(&chunk))?;
    }
}

/// A file of values beside a text header.
pub(crate) struct DataFile {
    pub path: PathBuf,
    /// What the header calls it.
    pub name: String,
}

impl DataFile {
    /// The data file of a header, named after all of its name, so that it cannot replace a `.raw` that was read.
    ///
    /// # Errors
    /// [`IoError::Unsupported`] if readers of the header would take the name for something else.
    pub fn of(header: &Path, extension: &str) -> Result<Self, IoError> {
        let path = header.with_added_extension(extension);
        let name = path.file_name().and_then(OsStr::to_str).filter(|name| is_plain(name)).map(str::to_owned);
        match name {
            Some(name) => Ok(Self { path, name }),
            None => {
                let found = header.file_name().unwrap_or_default().to_string_lossy();
                let advice = "headers hold names of data files in UTF-8, not beginning with white space or LIST, \
                    without line breaks and percent signs: choose another name, or a format with the data inside";
                Err(IoError::unsupported(header, "the name", format!("'{found}'"), advice))
            }
        }
    }
}

/// Whether a text header can hold a name. Readers cut lines at their breaks and white space off at the ends, take what
/// follows `LIST` for the beginning of a list, and `%` for a series of numbered files.
fn is_plain(name: &str) -> bool {
    let is_list = name.split_whitespace().next() == Some("LIST");
    name.trim() == name && !is_list && !name.contains(|c: char| c == '%' || c.is_control())
}

/// A header and where to store the values that it describes.
pub(crate) struct Files<'a> {
    pub path: &'a Path,
    pub header: &'a [u8],
    /// Where in the header to fill in the size of the stored values, [`SIZE_DIGITS`] wide.
    pub size_at: Option<u64>,
    /// The values' own file; without one they follow the header.
    pub data_file: Option<&'a DataFile>,
    pub packing: Packing,
}

/// Room for the digits of any size.
pub(crate) const SIZE_DIGITS: usize = 20;

impl Files<'_> {
    /// Writes all files; they appear together or not at all.
    pub fn write(&self, volume: &Volume) -> Result<(), IoError> {
        let mut file = AtomicFile::create(self.path)?;
        file.write_all(self.header).map_err(IoError::io(self.path))?;
        let Some(DataFile { path: data_path, .. }) = self.data_file else {
            let size = write_body(&mut file, volume, self.packing).map_err(IoError::io(self.path))?;
            self.fill_in(&mut file, size - self.header.len() as u64)?;
            return file.commit();
        };
        let mut data = AtomicFile::create(data_path)?;
        let size = write_body(&mut data, volume, self.packing).map_err(IoError::io(data_path))?;
        self.fill_in(&mut file, size)?;
        commit_together(vec![data, file])
    }

    fn fill_in(&self, file: &mut AtomicFile, size: u64) -> Result<(), IoError> {
        let Some(at) = self.size_at else { return Ok(()) };
        let digits = format!("{size:<SIZE_DIGITS$}");
        let written = file.seek(SeekFrom::Start(at)).and_then(|_| file.write_all(digits.as_bytes()));
        written.map_err(IoError::io(self.path))
    }
}

/// Lengthens a header by a comment, so that the values after `tail` more bytes are aligned for
/// every type and can be mapped into memory.
pub(crate) fn align(header: &mut String, comment: &str, tail: usize) {
    const ALIGNMENT: usize = 16;
    let shortest = header.len() + comment.len() + 1 + tail;
    let spaces = shortest.next_multiple_of(ALIGNMENT) - shortest;
    header.push_str(comment);
    header.extend(std::iter::repeat_n(' ', spaces));
    header.push('\n');
}
