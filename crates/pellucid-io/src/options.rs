//! What callers choose, and what they get.

use std::path::Path;

use pellucid_field::{Volume, Warning};

use crate::{Limits, Mapping, RawLayout};

/// A family of volume files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// NRRD: `.nrrd`, or a detached header `.nhdr` beside its data.
    Nrrd,
    /// MetaImage: `.mha`, or a detached header `.mhd` beside its data.
    MetaImage,
    /// NIfTI: `.nii`, `.nii.gz`, or a pair `.hdr` and `.img`.
    Nifti,
    /// Values without a header: `.raw`.
    Raw,
}

impl Format {
    /// The format an extension names, whatever its case.
    pub fn from_extension(path: impl AsRef<Path>) -> Option<Self> {
        match plain_extension(path.as_ref()).as_str() {
            "nrrd" | "nhdr" => Some(Self::Nrrd),
            "mha" | "mhd" => Some(Self::MetaImage),
            "nii" | "hdr" | "img" => Some(Self::Nifti),
            "raw" => Some(Self::Raw),
            _ => None,
        }
    }
}

/// The lower-case extension below a `.gz`.
pub(crate) fn plain_extension(path: &Path) -> String {
    let path = if is_gzip_name(path) { path.with_extension("") } else { path.to_owned() };
    path.extension().map(|extension| extension.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// Whether a name ends in `.gz`.
pub(crate) fn is_gzip_name(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("gz"))
}

/// How to read a volume.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// Which time point of a time series to read, from 0. Time points are counted along the axis
    /// after the three of space.
    pub time: usize,
    /// Read the file as headerless values of this layout, whatever it looks like.
    pub raw: Option<RawLayout>,
    /// Whether a header may name data files outside of its own folder, see [`locate`](crate::locate).
    pub outside: bool,
    /// What the file may cost.
    pub limits: Limits,
    /// Leave to map plain data in native order into memory; without it they are read.
    pub map: Option<Mapping>,
}

/// How to write a volume.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WriteOptions {
    /// The format; by default the one the extension names.
    pub format: Option<Format>,
    /// Deflate level 1 (fast) to 9 (small), or `None` for plain values, which can be
    /// memory-mapped when they are read again. NIfTI is compressed if, and only if, its name ends
    /// in `.gz` (level 6 by default); raw files are never compressed.
    pub compression: Option<u8>,
}

/// A volume read from a file.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The volume, named after the file.
    pub volume: Volume,
    /// What was converted, guessed or ignored.
    pub warnings: Vec<Warning>,
}
