//! Several files that appear together.

use std::io;
use std::path::{Path, PathBuf};

use super::AtomicFile;
use super::disk;
use super::unfinished::{live, unique};
use crate::IoError;

/// Puts finished files in their places, in this order, all of them or none: where one cannot be renamed, those before
/// it get their old content back. No signal that is handled comes between. (A process that is killed outright
/// between two renames leaves the first file new and the second one old.)
///
/// # Errors
/// [`IoError::Io`] of the file that failed; all files are what they were then, and nothing else is left.
pub(crate) fn commit_together(mut files: Vec<AtomicFile>) -> Result<(), IoError> {
    for file in &mut files {
        file.complete().map_err(|error| IoError::io(file.destination())(error))?;
    }
    let mut live = live();
    let mut replaced: Vec<Replaced> = Vec::new();
    let mut failed = None;
    for (number, file) in files.iter().enumerate() {
        let temporary = &file.unfinished.path;
        let is_last = number + 1 == files.len();
        match replace(temporary, &file.destination.target, is_last) {
            Ok(done) => {
                live.retain(|path| path != temporary);
                replaced.push(done);
            }
            Err(error) => {
                failed = Some((file, error));
                break;
            }
        }
    }
    let Some((file, error)) = failed else {
        replaced.iter().for_each(Replaced::forget);
        return Ok(());
    };
    let undone = replaced.iter().rev().try_for_each(Replaced::undo);
    drop(live);
    let told = match undone {
        Ok(()) => error,
        Err(trouble) => io::Error::new(error.kind(), format!("{error}; and {trouble}")),
    };
    Err(IoError::io(file.destination())(told))
}

/// A file that took the place of another.
struct Replaced {
    target: PathBuf,
    /// Another name of the old content, if there was some.
    old: Option<PathBuf>,
}

/// Renames a temporary file; unless it is the last one, the way back is kept.
fn replace(temporary: &Path, target: &Path, is_last: bool) -> io::Result<Replaced> {
    let mut replaced = Replaced { target: target.to_owned(), old: None };
    if !is_last && target.symlink_metadata().is_ok() {
        let old = unique(target);
        // Without a moment in which there is no file of the name, where the file system knows hard links.
        if disk::hard_link(target, &old).is_err() {
            disk::rename(target, &old)?;
        }
        replaced.old = Some(old);
    }
    match disk::rename(temporary, target) {
        Ok(()) => Ok(replaced),
        Err(error) => {
            if replaced.old.is_some() {
                replaced.undo()?;
            }
            Err(error)
        }
    }
}

impl Replaced {
    /// Gives the place back.
    fn undo(&self) -> io::Result<()> {
        let Some(old) = &self.old else { return std::fs::remove_file(&self.target) };
        disk::rename(old, &self.target).map_err(|error| {
            let (name, kept) = (self.target.display(), old.display());
            io::Error::new(error.kind(), format!("what {name} was is now {kept} ({error})"))
        })?;
        // Two names of one file: renaming one to the other did nothing.
        self.forget();
        Ok(())
    }

    /// Gives the old content up.
    fn forget(&self) {
        if let Some(old) = &self.old {
            let _ = std::fs::remove_file(old);
        }
    }
}
