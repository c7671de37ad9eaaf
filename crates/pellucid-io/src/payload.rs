//! Where the values of a volume lie in its files.

use std::path::PathBuf;

use crate::encoding::Encoding;
use crate::file_names::FileNames;
use crate::source::Source;
use crate::{Endian, IoError, Limits, StoredType};

/// The files that hold the values, in order; all hold equally many.
pub(crate) enum Parts {
    /// The rest of the header's own file, from this byte on.
    Attached(Source, u64),
    /// Files beside the header.
    Files(FileNames),
}

/// What comes before the values in each file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Skip {
    /// So many lines of the file, and then so many bytes: of the file, or, if it is compressed, of
    /// what it decompresses to.
    Forward { lines: u64, bytes: u64 },
    /// Everything but the last bytes.
    FromEnd,
}

impl Skip {
    pub const NONE: Self = Self::Forward { lines: 0, bytes: 0 };
}

/// Everything needed to find and decode the values of a volume.
pub(crate) struct Payload {
    /// The file that describes them.
    pub header: PathBuf,
    pub parts: Parts,
    pub skip: Skip,
    pub encoding: Encoding,
    pub stored: StoredType,
    pub endian: Endian,
    /// Values per time point.
    pub count: u64,
    /// Time points.
    pub frames: u64,
    /// The time point wanted.
    pub frame: u64,
    /// Components that lie one after the other, each a whole grid; 1 if they are interleaved.
    pub planes: usize,
}

impl Payload {
    /// Bytes of one time point; [`Payload::check`] has ruled out an overflow.
    pub fn frame_bytes(&self) -> u64 {
        self.count * self.stored.size() as u64
    }

    pub fn part_count(&self) -> u64 {
        match &self.parts {
            Parts::Attached(..) => 1,
            Parts::Files(files) => files.count(),
        }
    }

    /// Bytes of values in each file.
    pub fn part_bytes(&self) -> u64 {
        self.frame_bytes() * self.frames / self.part_count()
    }

    /// Whether the bytes of each value are in the wrong order for this machine.
    pub fn is_foreign(&self) -> bool {
        self.stored.size() > 1 && self.encoding != Encoding::Text && self.endian != Endian::NATIVE
    }

    /// Rules out numbers that later arithmetic would overflow on, and files that are too many or cannot share
    /// the values equally.
    pub fn check(&self, limits: &Limits) -> Result<(), IoError> {
        let values = self.count.checked_mul(self.frames);
        let bytes = values.and_then(|values| values.checked_mul(self.stored.size() as u64));
        let Some(bytes) = bytes.filter(|&bytes| isize::try_from(bytes).is_ok()) else {
            return Err(IoError::too_large(&self.header));
        };
        let parts = self.part_count();
        limits.check_files(&self.header, parts)?;
        if parts == 0 || !(bytes / self.stored.size() as u64).is_multiple_of(parts) {
            let expected = "so many that each holds equally many values";
            return Err(IoError::malformed(&self.header, "number of data files", parts, expected));
        }
        Ok(())
    }
}
