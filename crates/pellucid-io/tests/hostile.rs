//! Spoilt files of every format: a volume, a picture or an error, in bounded memory and time.

mod common;

use common::ledger::Ledger;
use common::mutate::session;
use common::seeds::{pictures, seeds, spoil};
use pellucid_io::{Limits, ReadOptions, read_bytes, read_picture_bytes};

#[global_allocator]
static LEDGER: Ledger = Ledger;

/// As the command does.
fn hear_no_caught_panics() {
    static ONCE: std::sync::Once = std::sync::Once::new();
    ONCE.call_once(|| {
        let tell = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            if !pellucid_io::is_guarded() {
                tell(panic)
            }
        }));
    });
}

/// What a reader needs beside the bytes it may decode to: buffers, and a copy of the header.
const OVERHEAD: usize = 1 << 20;

#[test]
fn volumes() {
    let folder = tempfile::tempdir().unwrap();
    let seeds = seeds(folder.path());
    let limits = Limits { bytes: Some(1 << 20), ..Limits::default() };
    let options = ReadOptions { limits, ..ReadOptions::default() };
    // Bytes that were packed, values, and values again where they lie in planes.
    let most = OVERHEAD + (3 << 20);
    session(
        20_000,
        &seeds,
        most,
        |seed, random| spoil(seed, &seeds, random),
        |seed, bytes| {
            let loaded = read_bytes(&seed.path, bytes.to_vec(), &options).map_err(|error| error.to_string())?;
            let statistics = loaded.volume.statistics();
            assert!(statistics.finite <= loaded.volume.voxels().len() as u64);
            Ok(())
        },
    );
}

#[test]
fn picture_files() {
    hear_no_caught_panics();
    let folder = tempfile::tempdir().unwrap();
    let seeds = pictures(folder.path());
    let limits = Limits { bytes: Some(1 << 20), ..Limits::default() };
    session(
        20_000,
        &seeds,
        OVERHEAD + (3 << 20),
        |seed, random| spoil(seed, &seeds, random),
        |seed, bytes| {
            let picture = read_picture_bytes(&seed.path, bytes, &limits).map_err(|error| error.to_string())?;
            assert_eq!(picture.pixels.len(), picture.width as usize * picture.height as usize);
            Ok(())
        },
    );
}
