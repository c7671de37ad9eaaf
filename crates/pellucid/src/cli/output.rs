//! Files the command writes.

use std::path::Path;

use pellucid::io::AtomicFile;

use super::failure::Failure;

/// Refuses before long work what could not be written after it.
pub fn writable(path: &Path) -> Result<(), Failure> {
    if path.is_dir() {
        return Err(Failure::work(format_args!("{}: a folder has this name", path.display())));
    }
    // Begun and dropped: nothing is left behind.
    AtomicFile::create(path)?;
    Ok(())
}
