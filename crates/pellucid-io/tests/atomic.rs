//! Files appear whole or not at all.

use std::io::{Seek, SeekFrom, Write};
use std::path::Path;

use pellucid_io::{AtomicFile, IoError};

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

#[test]
fn a_dropped_file_leaves_the_old_one_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.txt");
    std::fs::write(&path, "old").unwrap();
    let mut file = AtomicFile::create(&path).unwrap();
    file.write_all(b"new").unwrap();
    file.flush().unwrap();
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "old");
    assert_eq!(names(folder.path()).len(), 2);
    drop(file);
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "old");
    assert_eq!(names(folder.path()), ["a.txt"]);
}

#[test]
fn a_committed_file_replaces_the_old_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.txt");
    std::fs::write(&path, "old").unwrap();
    let mut file = AtomicFile::create(&path).unwrap();
    assert_eq!(file.destination(), path);
    file.write_all(b"newest").unwrap();
    file.seek(SeekFrom::Start(3)).unwrap();
    file.write_all(b"er!").unwrap();
    file.commit().unwrap();
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "newer!");
    assert_eq!(names(folder.path()), ["a.txt"]);
}

#[test]
fn writers_of_one_name_do_not_meet() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.txt");
    std::thread::scope(|scope| {
        for k in 0..8u8 {
            let path = &path;
            scope.spawn(move || {
                let mut file = AtomicFile::create(path).unwrap();
                file.write_all(&vec![k; 1 << 20]).unwrap();
                file.commit().unwrap();
            });
        }
    });
    let bytes = std::fs::read(&path).unwrap();
    assert!(bytes.len() == 1 << 20 && bytes.iter().all(|&byte| byte == bytes[0]));
    assert_eq!(names(folder.path()), ["a.txt"]);
}

#[test]
fn failures_name_the_file_and_leave_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let error = AtomicFile::create(folder.path().join("absent/a.txt")).unwrap_err();
    assert!(matches!(error, IoError::Io { .. }) && error.to_string().contains("a.txt"), "{error}");
    assert!(AtomicFile::create("/").is_err());
    // The rename itself fails: a folder with something in it is in the way.
    let path = folder.path().join("taken");
    std::fs::create_dir(&path).unwrap();
    std::fs::write(path.join("inside"), "").unwrap();
    let file = AtomicFile::create(&path).unwrap();
    assert!(file.commit().unwrap_err().to_string().contains("taken"));
    assert_eq!(names(folder.path()), ["taken"]);
}

/// A detached header that cannot be put in place takes its data with it.
#[test]
fn a_pair_of_files_appears_together_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("v.nhdr");
    std::fs::create_dir(&path).unwrap();
    let grid = pellucid_field::Grid::new([2, 2, 2]).unwrap();
    let volume = pellucid_field::Volume::new(grid, vec![0u8; 8]).unwrap();
    assert!(pellucid_io::write(&path, &volume, &pellucid_io::WriteOptions::default()).is_err());
    assert_eq!(names(folder.path()), ["v.nhdr"]);
}
