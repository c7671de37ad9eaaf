//! What the writers ask of the system, each operation in one place where tests can make it fail.

use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind, Seek, SeekFrom, Write};
use std::path::Path;

use super::destination::Destination;

/// An open temporary file.
#[derive(Debug)]
pub struct Disk(File);

impl Disk {
    pub fn new(file: File) -> Self {
        Self(file)
    }

    /// Takes permissions over and waits until the content is on the disk. A rename may reach the disk
    /// before it, and some file systems tell only now that they are full.
    pub fn complete(&self, destination: &Destination) -> io::Result<()> {
        fault()?;
        destination.dress(&self.0)?;
        fault()?;
        match self.0.sync_data() {
            // Some file systems have no such request.
            Err(error) if matches!(error.kind(), ErrorKind::Unsupported | ErrorKind::InvalidInput) => Ok(()),
            done => done,
        }
    }
}

impl Write for Disk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        fault()?;
        self.0.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

impl Seek for Disk {
    fn seek(&mut self, position: SeekFrom) -> io::Result<u64> {
        fault()?;
        self.0.seek(position)
    }
}

/// Makes a new file that only its owner can read while it is not finished, if `like` can be read by him alone.
pub fn create_new(path: &Path, like: &Destination) -> io::Result<File> {
    fault()?;
    let mut options = OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, like.mode() | 0o200);
    #[cfg(not(unix))]
    let _ = like;
    options.open(path)
}

pub fn rename(from: &Path, to: &Path) -> io::Result<()> {
    fault()?;
    fs::rename(from, to)
}

pub fn hard_link(original: &Path, link: &Path) -> io::Result<()> {
    fault()?;
    fs::hard_link(original, link)
}

/// Fails in the place of the n-th operation since the process began, where n is what the environment
/// says in `PELLUCID_FAULT_DISK`: tests count n up until the work succeeds. Not in release builds.
#[cfg(debug_assertions)]
fn fault() -> io::Result<()> {
    use std::sync::LazyLock;
    use std::sync::atomic::{AtomicU64, Ordering};
    static AT: LazyLock<Option<u64>> =
        LazyLock::new(|| std::env::var("PELLUCID_FAULT_DISK").ok().and_then(|number| number.parse().ok()));
    static COUNT: AtomicU64 = AtomicU64::new(0);
    match *AT {
        Some(at) if COUNT.fetch_add(1, Ordering::Relaxed) + 1 == at => Err(ErrorKind::StorageFull.into()),
        _ => Ok(()),
    }
}

#[cfg(not(debug_assertions))]
#[inline(always)]
fn fault() -> io::Result<()> {
    Ok(())
}
