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
    let path = folder.path().join("taken");
    std::fs::create_dir(&path).unwrap();
    assert!(AtomicFile::create(&path).unwrap_err().to_string().contains("taken: a folder"));
    // The rename itself fails: a folder with something in it has come in the way.
    let path = folder.path().join("late");
    let file = AtomicFile::create(&path).unwrap();
    std::fs::create_dir(&path).unwrap();
    std::fs::write(path.join("inside"), "").unwrap();
    assert!(file.commit().unwrap_err().to_string().contains("late"));
    assert_eq!(sorted(names(folder.path())), ["late", "taken"]);
}

fn sorted(mut names: Vec<String>) -> Vec<String> {
    names.sort();
    names
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

/// Overwriting where the header cannot be replaced leaves the old pair as it was.
#[test]
fn a_pair_of_files_that_cannot_be_replaced_stays() {
    use pellucid_field::{Grid, Volume};
    use pellucid_io::{ReadOptions, WriteOptions, read, write};
    let folder = tempfile::tempdir().unwrap();
    let volume = |n: usize, value: u8| Volume::new(Grid::new([n; 3]).unwrap(), vec![value; n * n * n]).unwrap();
    for (name, extension) in [("a.nhdr", "raw.gz"), ("b.mhd", "zraw")] {
        let path = folder.path().join(name);
        write(&path, &volume(4, 1), &WriteOptions::default()).unwrap();
        // The data of the new pair would lie where a folder is; those of the old one are elsewhere.
        std::fs::create_dir(path.with_added_extension(extension)).unwrap();
        let before = sorted(names(folder.path()));
        let options = WriteOptions { compression: Some(6), ..WriteOptions::default() };
        assert!(write(&path, &volume(5, 2), &options).unwrap_err().to_string().contains("a folder has this name"));
        assert_eq!(sorted(names(folder.path())), before);
        let found = read(&path, &ReadOptions::default()).unwrap().volume;
        assert_eq!(found.voxels().as_bytes(), [1; 64]);
    }
}

#[cfg(unix)]
#[test]
fn links_and_permissions_of_what_is_replaced_stay() {
    use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let rewrite = |name: &str, text: &str| {
        let mut file = AtomicFile::create(path(name))?;
        file.write_all(text.as_bytes()).unwrap();
        file.commit()
    };
    let mode = |name: &str| std::fs::metadata(path(name)).unwrap().mode() & 0o7777;
    // A new file has what the user's mask leaves, as every other file.
    std::fs::write(path("plain"), "").unwrap();
    rewrite("new", "").unwrap();
    assert_eq!(mode("new"), mode("plain"));
    for bits in [0o600, 0o640, 0o444, 0o400, 0o755, 0o000] {
        std::fs::set_permissions(path("plain"), std::fs::Permissions::from_mode(bits)).unwrap();
        rewrite("plain", "secret").unwrap();
        assert_eq!(mode("plain"), bits);
    }
    // Through a chain of links, one of them relative from another folder, and to what is not there yet.
    std::fs::create_dir(path("inner")).unwrap();
    std::fs::write(path("real"), "old").unwrap();
    symlink("../real", path("inner/second")).unwrap();
    symlink(path("inner/second"), path("first")).unwrap();
    symlink("later", path("dangling")).unwrap();
    for (link, real) in [("first", "real"), ("dangling", "later")] {
        rewrite(link, "through a link").unwrap();
        assert_eq!(std::fs::read_to_string(path(real)).unwrap(), "through a link");
        for name in [link, "inner/second"] {
            assert!(path(name).symlink_metadata().unwrap().is_symlink(), "{name}");
        }
    }
    // What is no file is left alone: the null device was once replaced by a picture.
    symlink("/dev/null", path("null.png")).unwrap();
    symlink("loop", path("loop")).unwrap();
    for (name, told) in [("null.png", "not a regular file"), ("loop", "too many symbolic links")] {
        let error = rewrite(name, "").unwrap_err().to_string();
        assert!(error.contains(name) && error.contains(told), "{error}");
    }
    // The owner stays where this user may give files away.
    if std::os::unix::fs::chown(path("real"), Some(12), Some(13)).is_ok() {
        rewrite("first", "owned").unwrap();
        let found = std::fs::metadata(path("real")).unwrap();
        assert_eq!((found.uid(), found.gid()), (12, 13));
    }
    assert!(names(folder.path()).iter().all(|name| !name.ends_with(".tmp")));
}
