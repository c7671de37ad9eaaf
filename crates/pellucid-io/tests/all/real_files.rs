//! Real scans against the table that came with them. The folder is `$PELLUCID_DATA`, or
//! `shared/data` beside the repository; without it there is nothing to test.

use std::path::{Path, PathBuf};

use pellucid_io::{ReadOptions, WriteOptions, read, write};

fn data() -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let stated = std::env::var_os("PELLUCID_DATA").map(PathBuf::from);
    stated.into_iter().chain([beside]).find(|folder| folder.join("MANIFEST.md").is_file())
}

#[test]
fn real_files_match_their_manifest() {
    let Some(folder) = data() else {
        println!("skipped: no folder with MANIFEST.md; set PELLUCID_DATA");
        return;
    };
    let manifest = std::fs::read_to_string(folder.join("MANIFEST.md")).unwrap();
    let rows = manifest.lines().filter(|line| line.starts_with("| ")).skip(1);
    let mut seen = 0;
    for row in rows {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let [_, name, _, dims, kind, spacing, range, _, bytes, ..] = cells[..] else { panic!("{row}") };
        let loaded = read(folder.join(name).with_extension("nrrd"), &ReadOptions::default()).unwrap();
        let volume = &loaded.volume;
        assert_eq!(volume.grid().dims().map(|n| n.to_string()).join("x"), dims, "{name}");
        assert_eq!(volume.voxels().voxel_type().name(), kind.replace("uint", "u"), "{name}");
        let statistics = volume.statistics();
        assert_eq!(format!("{}..{}", statistics.min, statistics.max), range, "{name}");
        for (found, expected) in volume.grid().spacing().iter().zip(spacing.split('x')) {
            assert!((found - expected.parse::<f64>().unwrap()).abs() < 1e-4, "{name}: {found} is not {expected}");
        }
        assert_eq!(volume.voxels().as_bytes().len().to_string(), bytes, "{name}");
        assert_eq!((volume.name.as_str(), loaded.warnings.as_slice()), (name, [].as_slice()));

        let folder = tempfile::tempdir().unwrap();
        for again in ["a.nrrd", "a.mha", "a.nii"] {
            let path = folder.path().join(again);
            write(&path, volume, &WriteOptions::default()).unwrap();
            let again = read(&path, &ReadOptions::default()).unwrap().volume;
            assert_eq!(again.voxels().as_bytes(), volume.voxels().as_bytes(), "{name}");
        }
        seen += 1;
    }
    assert!(seen > 0, "the manifest has no rows");
}
