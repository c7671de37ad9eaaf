//! The bytes of a file, mapped into memory. The only module with `unsafe` code.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::IoError;

/// Shared bytes that decoders and mapped volumes keep alive.
pub(crate) type Bytes = Arc<dyn AsRef<[u8]> + Send + Sync>;

/// A file's name and content.
#[derive(Clone)]
pub(crate) struct Source {
    pub path: PathBuf,
    bytes: Bytes,
}

impl Source {
    /// Maps a file.
    pub fn open(path: &Path) -> Result<Self, IoError> {
        let file = File::open(path).map_err(IoError::io(path))?;
        let kind = file.metadata().map_err(IoError::io(path))?.file_type();
        if !kind.is_file() {
            let source = io::Error::new(io::ErrorKind::InvalidInput, "not a regular file");
            return Err(IoError::io(path)(source));
        }
        // SAFETY: the map is private and read-only, and only ever viewed as plain bytes and
        // numbers for which every bit pattern is valid. What remains is the invariant of every
        // file mapping: nobody truncates or rewrites the file in place while a volume made from
        // it lives. This crate keeps to it by replacing files through a rename (`AtomicFile`),
        // which leaves the mapped one intact.
        let map = unsafe { memmap2::Mmap::map(&file) }.map_err(IoError::io(path))?;
        Ok(Self { path: path.to_owned(), bytes: Arc::new(map) })
    }

    /// Bytes that are already in memory, under the name of the file they stand for.
    pub fn memory(path: &Path, bytes: Vec<u8>) -> Self {
        Self { path: path.to_owned(), bytes: Arc::new(bytes) }
    }

    pub fn bytes(&self) -> &[u8] {
        (*self.bytes).as_ref()
    }

    pub fn shared(&self) -> Bytes {
        Arc::clone(&self.bytes)
    }

    /// A file named by this one, relative to its folder.
    pub fn sibling(&self, name: impl AsRef<Path>) -> PathBuf {
        self.path.parent().unwrap_or(Path::new("")).join(name)
    }
}
