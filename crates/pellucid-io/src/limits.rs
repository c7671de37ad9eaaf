//! What a file may cost to read.

use std::path::Path;

use crate::IoError;

/// What a file may cost to read, whatever it says of itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Most bytes that the values of a volume, or a picture at 16 bytes a pixel, may decode to, together with those
    /// that are decoded on the way to them.
    ///
    /// `None`, the default, leaves plain values alone, which their file's own size bounds, and expects of all others
    /// no more than [`Limits::TRUSTED`] bytes, or [`Limits::EXPANSION`] for each byte stored if that is more.
    pub bytes: Option<u64>,
    /// Most files of values that one header may name. Default 2^17; one file per slice needs some thousands.
    pub files: u64,
    /// Most bytes of a text: a scene, a transfer function, a table. Default 2^22.
    pub text: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { bytes: None, files: 1 << 17, text: 1 << 22 }
    }
}

impl Limits {
    /// Bytes that anything may decode to by default: 512 MiB, a volume of 512 x 512 x 1024 shorts.
    pub const TRUSTED: u64 = 1 << 29;

    /// Bytes that each stored byte may decode to by default. Scans pack 2 or 3 to 1 and label volumes some tens or
    /// hundreds; deflate packs zeros 1032 to 1, and bzip2 a million to 1.
    pub const EXPANSION: u64 = 256;

    /// The most bytes that `stored` bytes may decode to.
    pub fn bytes_for(&self, stored: u64) -> u64 {
        self.bytes.unwrap_or_else(|| stored.saturating_mul(Self::EXPANSION).max(Self::TRUSTED))
    }

    /// Refuses what `stored` bytes of a file, or of several, must not decode to.
    pub(crate) fn check_bytes(&self, path: &Path, found: u64, stored: u64) -> Result<(), IoError> {
        check(path, "bytes", found, self.bytes_for(stored))
    }

    pub(crate) fn check_files(&self, path: &Path, found: u64) -> Result<(), IoError> {
        check(path, "files", found, self.files)
    }

    pub(crate) fn check_text(&self, path: &Path, found: u64) -> Result<(), IoError> {
        check(path, "text", found, self.text)
    }
}

fn check(path: &Path, setting: &'static str, found: u64, allowed: u64) -> Result<(), IoError> {
    if found <= allowed {
        return Ok(());
    }
    Err(IoError::Limit { path: path.to_owned(), setting, found, allowed })
}
