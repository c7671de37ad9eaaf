//! Files that appear whole or not at all.

mod destination;
mod disk;
mod together;
mod unfinished;

use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::Path;

use crate::IoError;
use destination::Destination;
use disk::Disk;
pub(crate) use together::commit_together;
use unfinished::Unfinished;
pub use unfinished::discard_unfinished;

/// A file under construction: written under a temporary name in the folder of its destination,
/// brought to the disk and renamed into place by [`AtomicFile::commit`]. Dropped without a commit,
/// it leaves nothing behind and an existing destination untouched.
///
/// The destination stays what it is but for its content: a symbolic link leads to the same place
/// as before, and a file that is replaced keeps its permissions and, where the system allows it, its
/// owner and group. (It is another file under the same name: hard links, access lists and extended
/// attributes stay with the old one.) Only regular files are replaced.
///
/// A process that is killed leaves its temporary file behind; the next one that writes to the same
/// destination removes it. Temporary files are locked while they are written, so that nobody takes
/// them for left behind.
#[derive(Debug)]
pub struct AtomicFile {
    destination: Destination,
    unfinished: Unfinished,
    file: BufWriter<Disk>,
}

impl AtomicFile {
    /// Begins a file that will appear at `destination`.
    ///
    /// # Errors
    /// [`IoError::Io`] if the folder does not exist or cannot be written to, or if something that
    /// is not a regular file has the name.
    pub fn create(destination: impl AsRef<Path>) -> Result<Self, IoError> {
        let named = destination.as_ref();
        let destination = Destination::of(named).map_err(IoError::io(named))?;
        let (unfinished, file) = Unfinished::create(&destination).map_err(IoError::io(named))?;
        Ok(Self { destination, unfinished, file: BufWriter::with_capacity(1 << 18, Disk::new(file)) })
    }

    /// Where the file will appear.
    pub fn destination(&self) -> &Path {
        &self.destination.named
    }

    /// Flushes and renames the file into place, replacing what was there.
    ///
    /// # Errors
    /// [`IoError::Io`] if the disk is full or the destination cannot be replaced; nothing is left
    /// behind then.
    pub fn commit(self) -> Result<(), IoError> {
        commit_together(vec![self])
    }

    /// Brings everything but the name to the disk.
    fn complete(&mut self) -> io::Result<()> {
        self.file.flush()?;
        self.file.get_ref().complete(&self.destination)
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Seek for AtomicFile {
    fn seek(&mut self, position: SeekFrom) -> io::Result<u64> {
        self.file.seek(position)
    }
}
