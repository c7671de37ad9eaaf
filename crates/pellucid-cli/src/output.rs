//! Files the command writes.

use std::io::Write;
use std::path::Path;

use pellucid::io::{AtomicFile, IoError};

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

/// Writes a text, whole or not at all.
pub fn write(path: &Path, text: &str) -> Result<(), Failure> {
    let mut file = AtomicFile::create(path)?;
    file.write_all(text.as_bytes()).map_err(|source| IoError::Io { path: path.to_owned(), source })?;
    Ok(file.commit()?)
}
