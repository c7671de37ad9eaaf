//! Truncated, lying and spoiled files: always an error or a volume, never a panic.

use crate::common::mutate::{Random, Seed, mutate};
use crate::common::seeds::seeds;
use crate::common::{gzip, load, message};
use pellucid_io::{IoError, ReadOptions, read, read_bytes};
use proptest::prelude::*;

#[test]
fn every_seed_is_valid_and_every_shorter_file_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    for seed in seeds(folder.path()) {
        let options = ReadOptions::default();
        let name = seed.path.display();
        read_bytes(&seed.path, seed.bytes.clone(), &options).unwrap_or_else(|error| panic!("{name}: {error}"));
        // The end of the last line may be missing from text.
        let text = seed.bytes.ends_with(b"\n") || seed.bytes.ends_with(b" ");
        for length in 0..seed.bytes.len() - usize::from(text) {
            let result = read_bytes(&seed.path, seed.bytes[..length].to_vec(), &options);
            assert!(result.is_err(), "{name} cut to {length} of {} bytes", seed.bytes.len());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6000))]

    #[test]
    fn spoiled_files_never_panic(start in 1u64.., pick in 0usize..64) {
        thread_local! {
            static FOLDER: tempfile::TempDir = tempfile::tempdir().unwrap();
        }
        FOLDER.with(|folder| {
            let seeds = seeds_once(folder.path());
            let seed = &seeds[pick % seeds.len()];
            let mut random = Random(start);
            let mut bytes = seed.bytes.clone();
            mutate(&mut bytes, &seeds, &mut random);
            match read_bytes(&seed.path, bytes, &ReadOptions::default()) {
                Ok(loaded) => prop_assert!(loaded.volume.statistics().finite <= loaded.volume.voxels().len() as u64),
                Err(error) => {
                    let text = error.to_string();
                    prop_assert!(!text.contains('\n') && text.len() < 1000, "{}", text);
                }
            }
            Ok(())
        })?;
    }
}

fn seeds_once(folder: &std::path::Path) -> std::rc::Rc<Vec<Seed>> {
    use std::cell::OnceCell;
    use std::rc::Rc;
    thread_local! {
        static SEEDS: OnceCell<Rc<Vec<Seed>>> = const { OnceCell::new() };
    }
    SEEDS.with(|cell| Rc::clone(cell.get_or_init(|| Rc::new(seeds(folder)))))
}

#[test]
fn damaged_compression_is_reported() {
    let header = b"NRRD0004\ntype: uint8\ndimension: 1\nsizes: 1000\nencoding: gzip\n\n";
    let packed = gzip(&(0..1000).map(|k| (k * k % 251) as u8).collect::<Vec<_>>());
    let with = |packed: &[u8]| load("a.nrrd", [header.as_slice(), packed].concat());
    assert!(with(&packed).is_ok());
    // The checksum is the first of the last eight bytes.
    let mut wrong = packed.clone();
    let n = wrong.len();
    wrong[n - 8] ^= 1;
    assert!(matches!(with(&wrong), Err(IoError::Damaged { .. })));
    let half = message(with(&packed[..n / 2]));
    assert!(half.contains("expected 1000"), "{half}");
    assert!(message(with(b"this is certainly not gzip")).contains("gzip"));
}

#[test]
fn odd_files_are_errors_of_their_own_kind() {
    let folder = tempfile::tempdir().unwrap();
    let error = |name: &str| message(read(folder.path().join(name), &ReadOptions::default()));
    assert!(error("absent.nrrd").contains("absent.nrrd"));
    std::fs::write(folder.path().join("empty.nrrd"), "").unwrap();
    assert!(error("empty.nrrd").contains("magic"));
    std::fs::write(folder.path().join("empty"), "").unwrap();
    assert!(error("empty").contains("format without an extension"));
    assert!(error(".").contains("regular file") || error(".").contains("directory"));
    let long = [b"NRRD0004\n# ".as_slice(), &vec![b'x'; 2 << 20]].concat();
    assert!(message(load("a.nrrd", long)).contains("at most 1048576 bytes"));
}
