//! Temporary files: their names, who knows of them, and what becomes of those that were left behind.

use std::collections::HashMap;
use std::ffi::OsStr;
use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError as Held};
use std::time::Duration;

use super::destination::Destination;
use super::disk;

/// The unfinished files of this process. Who puts files in their places holds it.
static LIVE: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// A temporary file. Dropped, it is removed, unless it has been given its name.
#[derive(Debug)]
pub struct Unfinished {
    pub path: PathBuf,
}

impl Unfinished {
    /// Makes the temporary file of a destination, and removes what dead processes left of it.
    pub fn create(destination: &Destination) -> io::Result<(Self, File)> {
        let target = &destination.target;
        remove_left_behind(target);
        loop {
            let path = unique(target);
            let mut live = live();
            let file = match disk::create_new(&path, destination) {
                Err(error) if error.kind() == ErrorKind::AlreadyExists => continue,
                file => file?,
            };
            live.push(path.clone());
            drop(live);
            let unfinished = Self { path };
            // Somebody who cleans up may have met the file between these two steps. File systems without locks
            // have nobody who cleans up.
            let is_taken = matches!(file.try_lock(), Err(TryLockError::WouldBlock));
            if !is_taken && fs::symlink_metadata(&unfinished.path).is_ok() {
                return Ok((unfinished, file));
            }
        }
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        let mut live = live();
        if let Some(place) = live.iter().position(|path| *path == self.path) {
            live.swap_remove(place);
            // Nobody is left to hear of a failure to clean up.
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// The unfinished files, for one who takes names out because they are finished. As long as it is held the process
/// is not ended by [`discard_unfinished`].
pub fn live() -> MutexGuard<'static, Vec<PathBuf>> {
    LIVE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes every unfinished file of this process, and lets none be begun or finished any more: for the
/// last act of a process that ends in the middle of its work, such as a handler of signals. Threads that
/// write files from now on wait for ever.
pub fn discard_unfinished() {
    // Renames take no longer. If this thread itself holds the list, there is nothing to wait for.
    for _ in 0..200 {
        let live = match LIVE.try_lock() {
            Ok(live) => live,
            Err(Held::Poisoned(poisoned)) => poisoned.into_inner(),
            Err(Held::WouldBlock) => {
                std::thread::sleep(Duration::from_millis(5));
                continue;
            }
        };
        for path in live.iter() {
            let _ = fs::remove_file(path);
        }
        std::mem::forget(live);
        return;
    }
}

/// A name beside `target` that no file has: unique among threads by the counter, among processes by the id.
pub fn unique(target: &Path) -> PathBuf {
    static COUNTER: AtomicU64 = AtomicU64::new(0);
    let count = COUNTER.fetch_add(1, Ordering::Relaxed);
    target.with_file_name(format!("{}{}-{count}{SUFFIX}", prefix(target), std::process::id()))
}

const SUFFIX: &str = ".tmp";

/// What the names of a target's temporary files begin with. Names have at most 255 bytes, and some are that long.
fn prefix(target: &Path) -> String {
    const LONGEST: usize = 200;
    let name = target.file_name().unwrap_or(OsStr::new("")).to_string_lossy();
    format!(".{}.", &name[..name.floor_char_boundary(LONGEST)])
}

/// Removes the temporary files of a target whose processes were killed.
fn remove_left_behind(target: &Path) {
    /// What lay in folders when this process first wrote there: folders may be large, and are listed once.
    static LEFT: Mutex<Option<HashMap<PathBuf, Vec<PathBuf>>>> = Mutex::new(None);
    let Some(folder) = target.parent() else { return };
    let mut left = LEFT.lock().unwrap_or_else(PoisonError::into_inner);
    let left = left.get_or_insert_default().entry(folder.to_owned()).or_insert_with(|| list(folder));
    let prefix = prefix(target);
    let is_of_target = |path: &mut PathBuf| named(path).is_some_and(|(start, _)| start == prefix);
    for path in left.extract_if(.., is_of_target) {
        let process = named(&path).map_or(0, |(_, process)| process);
        // A lock tells more than a process id, which others may have by now, but not every writer can lock.
        if process != std::process::id() && lives(process) {
            continue;
        }
        if let Ok(file) = File::open(&path)
            && file.try_lock().is_ok()
        {
            let _ = fs::remove_file(&path);
        }
    }
}

/// Files in a folder whose names are those of temporary files.
fn list(folder: &Path) -> Vec<PathBuf> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let files = entries.flatten().filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_file()));
    files.map(|entry| entry.path()).filter(|path| named(path).is_some()).collect()
}

/// What a temporary file's name says: the prefix of its target, and the process.
fn named(path: &Path) -> Option<(&str, u32)> {
    let name = path.file_name()?.to_str()?.strip_suffix(SUFFIX)?;
    let (target, numbers) = name.rsplit_once('.').filter(|(target, _)| target.starts_with('.'))?;
    let (process, count) = numbers.split_once('-')?;
    count.parse::<u64>().ok()?;
    Some((&name[..target.len() + 1], process.parse().ok()?))
}

/// Whether a process of this id is known to run on this machine.
fn lives(process: u32) -> bool {
    Path::new("/proc").join(process.to_string()).exists()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_tell_their_target_and_process() {
        for target in ["a.nrrd", "a", ".a.1-2.tmp", "b c", "1-2", &"é".repeat(127)] {
            let path = unique(Path::new(target));
            assert_eq!(named(&path), Some((&*prefix(Path::new(target)), std::process::id())), "{target}");
            assert!(path.as_os_str().len() <= 255);
        }
        for other in ["a.nrrd", ".a.nrrd.tmp", ".a.1-x.tmp", "a.1-2.tmp", ".1-2.tmp", ".a.1-2"] {
            assert_eq!(named(Path::new(other)), None, "{other}");
        }
    }

    #[test]
    fn only_what_the_dead_left_of_the_same_target_is_removed() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        // No process has this id: Linux counts to 2^22.
        let dead = 1 << 30;
        let [stale, other, alive, held] = [
            format!(".a.nrrd.{dead}-0.tmp"),
            format!(".b.nrrd.{dead}-0.tmp"),
            ".a.nrrd.1-0.tmp".to_owned(),
            format!(".a.nrrd.{dead}-1.tmp"),
        ];
        for name in [&stale, &other, &alive, &held] {
            fs::write(path(name), "").unwrap();
        }
        let writer = File::open(path(&held)).unwrap();
        writer.lock().unwrap();
        let destination = Destination::of(&path("a.nrrd")).unwrap();
        let (unfinished, file) = Unfinished::create(&destination).unwrap();
        assert!(!path(&stale).exists() && path(&other).exists() && path(&held).exists());
        assert!(path(&alive).exists() || !lives(1));
        // Its own file is safe from others.
        assert!(matches!(File::open(&unfinished.path).unwrap().try_lock(), Err(TryLockError::WouldBlock)));
        drop(file);
        drop(unfinished);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2 + usize::from(lives(1)));
    }
}
