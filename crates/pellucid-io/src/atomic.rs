//! Files that appear whole or not at all.

use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use crate::IoError;

/// A file under construction: written under a temporary name in the folder of its destination and
/// renamed into place by [`AtomicFile::commit`]. Dropped without a commit, it leaves nothing
/// behind and an existing destination untouched.
///
/// The rename is atomic for other programs; the data are not forced to the disk, so it is no
/// protection against a power failure.
#[derive(Debug)]
pub struct AtomicFile {
    destination: PathBuf,
    /// `None` once it has been renamed.
    temporary: Option<PathBuf>,
    file: BufWriter<File>,
}

impl AtomicFile {
    /// Begins a file that will appear at `destination`.
    ///
    /// # Errors
    /// [`IoError::Io`] if the folder does not exist or cannot be written to.
    pub fn create(destination: impl AsRef<Path>) -> Result<Self, IoError> {
        let destination = destination.as_ref();
        let Some(name) = destination.file_name() else {
            let source = io::Error::new(io::ErrorKind::InvalidInput, "not the name of a file");
            return Err(IoError::io(destination)(source));
        };
        // Unique among threads by the counter, among processes by the id; `create_new` refuses the
        // rest, such as what a crash left behind.
        static COUNTER: AtomicU64 = AtomicU64::new(0);
        loop {
            let mut temporary_name = std::ffi::OsString::from(".");
            temporary_name.push(name);
            let count = COUNTER.fetch_add(1, Ordering::Relaxed);
            temporary_name.push(format!(".{}-{count}.tmp", std::process::id()));
            let temporary = destination.with_file_name(temporary_name);
            match OpenOptions::new().write(true).create_new(true).open(&temporary) {
                Ok(file) => {
                    let file = BufWriter::with_capacity(1 << 18, file);
                    return Ok(Self { destination: destination.to_owned(), temporary: Some(temporary), file });
                }
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(IoError::io(destination)(error)),
            }
        }
    }

    /// Where the file will appear.
    pub fn destination(&self) -> &Path {
        &self.destination
    }

    /// Flushes and renames the file into place, replacing what was there.
    ///
    /// # Errors
    /// [`IoError::Io`] if the disk is full or the destination cannot be replaced; nothing is left
    /// behind then.
    pub fn commit(mut self) -> Result<(), IoError> {
        self.file.flush().map_err(IoError::io(&self.destination))?;
        if let Some(temporary) = &self.temporary {
            std::fs::rename(temporary, &self.destination).map_err(IoError::io(&self.destination))?;
            self.temporary = None;
        }
        Ok(())
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

impl Drop for AtomicFile {
    fn drop(&mut self) {
        if let Some(temporary) = &self.temporary {
            // Nobody is left to hear of a failure to clean up.
            let _ = std::fs::remove_file(temporary);
        }
    }
}
