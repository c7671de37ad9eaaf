//! Whatever is written can be read, under any name.

use std::path::Path;

use pellucid_field::{Grid, Volume};
use pellucid_io::{IoError, ReadOptions, WriteOptions, read, write};
use proptest::prelude::*;

/// Writes a volume under a name and reads it again. Refused names leave nothing behind.
fn try_name(name: &str) -> Result<(), IoError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    let volume = Volume::new(Grid::new([3, 2, 2]).unwrap(), (0..12).collect::<Vec<u8>>()).unwrap();
    let entries = |folder: &Path| std::fs::read_dir(folder).unwrap().count();
    match write(&path, &volume, &WriteOptions::default()) {
        Ok(_) => {
            let found = read(&path, &ReadOptions::default());
            let found = found.unwrap_or_else(|error| panic!("'{name}' was written and cannot be read: {error}"));
            assert_eq!(found.volume.voxels().as_bytes(), volume.voxels().as_bytes(), "{name}");
            Ok(())
        }
        Err(error) => {
            assert_eq!(entries(folder.path()), 0, "'{name}' was refused ({error}) and something lies there");
            Err(error)
        }
    }
}

#[test]
fn names_that_headers_cannot_hold_are_refused() {
    for extension in ["nhdr", "mhd"] {
        for stem in [" a ", "LIST a", "LIST", "e\nv", "e\rv", "tab\tinside", "\u{a0}wide", "s%03d", "50%", "a%d 1 9 1 "]
        {
            let name = format!("{stem}.{extension}");
            // A name of its own is not a word of a longer one.
            let is_held = stem == "LIST";
            let done = try_name(&name);
            assert_eq!(done.is_ok(), is_held, "{name:?}: {done:?}");
            assert!(is_held || matches!(done, Err(IoError::Unsupported { .. })), "{name:?}: {done:?}");
        }
        for stem in ["a b", "-", "#", "a:b", "a=b", "LOCAL", "list a", "LISTa", "\"quoted\"", "\u{e9}\u{4e00}", "a "] {
            try_name(&format!("{stem}.{extension}")).unwrap();
        }
        // Names have at most 255 bytes: that of the data file, longer than its header's, and of temporary files.
        for (length, fits) in [(120, true), (251, true), (252, false), (255, false)] {
            let done = try_name(&format!("{}.{extension}", "n".repeat(length - extension.len() - 1)));
            assert_eq!(done.is_ok(), fits, "{length}: {done:?}");
        }
    }
    // With the data inside, any name will do.
    for name in [" a .nrrd", "LIST a.mha", "e\nv.nrrd", "s%03d.nii", &format!("{}.nii.gz", "n".repeat(248))] {
        try_name(name).unwrap();
    }
}

#[cfg(target_os = "linux")]
#[test]
fn names_that_are_no_text_are_refused_in_headers() {
    use std::os::unix::ffi::OsStrExt;
    let folder = tempfile::tempdir().unwrap();
    let volume = Volume::new(Grid::new([2; 3]).unwrap(), vec![0u8; 8]).unwrap();
    let path = |name: &[u8]| folder.path().join(std::ffi::OsStr::from_bytes(name));
    let error = write(path(b"\xff.nhdr"), &volume, &WriteOptions::default()).unwrap_err();
    assert!(matches!(error, IoError::Unsupported { .. }), "{error}");
    write(path(b"\xff.nrrd"), &volume, &WriteOptions::default()).unwrap();
    read(path(b"\xff.nrrd"), &ReadOptions::default()).unwrap();
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

proptest! {
    #[test]
    fn what_is_written_under_odd_names_can_be_read(
        stem in "([ \t\r\n%:=#\"'\\\\a-c1L\u{e9}\u{a0}\u{85}\u{2028}-]|LIST|LOCAL|%0?[0-9]?[diu]){1,12}",
        extension in prop::sample::select(vec!["nhdr", "mhd", "nrrd", "mha", "nii"]),
    ) {
        let done = try_name(&format!("{stem}.{extension}"));
        prop_assert!(matches!(done, Ok(()) | Err(IoError::Unsupported { .. })), "{:?}", done);
    }
}
