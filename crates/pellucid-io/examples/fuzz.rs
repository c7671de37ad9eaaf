//! Spoils small files of every format and reads them, for as long as you like:
//!
//! ```text
//! cargo run --release -p pellucid-io --example fuzz -- --seconds 30 [--seed 1]
//! ```
//!
//! A panic, or a read that takes longer than a second, is a finding: its file is kept and the
//! program ends with status 1. The targets in `fuzz/` do the same under cargo-fuzz, which learns
//! from coverage but needs a nightly compiler.

#[path = "../tests/common/mod.rs"]
mod common;

use std::io::Read;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use common::seeds::{Random, Seed, mutate, seeds};
use pellucid_io::{IoError, PngPixels, ReadOptions, Transfer, read_bytes, read_png, write_png};

const SLOW: Duration = Duration::from_secs(1);

fn main() {
    let argument = |name: &str, otherwise: u64| {
        let mut arguments = std::env::args().skip_while(|argument| argument != name);
        arguments.nth(1).map_or(otherwise, |text| text.parse().expect("a number"))
    };
    let (seconds, start) = (argument("--seconds", 30), argument("--seed", 1));
    let folder = tempfile::tempdir().expect("a folder for temporary files");
    let mut seeds = seeds(folder.path());
    let picture = folder.path().join("picture.png");
    let pixels: Vec<u8> = (0..192).collect();
    write_png(&picture, 8, 8, PngPixels::U8(&pixels), Transfer::Srgb).expect("a picture");
    seeds.push(Seed { path: picture.clone(), bytes: std::fs::read(&picture).expect("the picture") });

    let mut random = Random(start.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
    let began = Instant::now();
    let (mut executions, mut volumes, mut findings) = (0u64, 0u64, 0u64);
    let mut slowest = Duration::ZERO;
    // The findings are reported below, with the files that cause them.
    std::panic::set_hook(Box::new(|_| {}));
    while began.elapsed() < Duration::from_secs(seconds) {
        let seed = &seeds[random.below(seeds.len())];
        let bytes = spoil(seed, &seeds, &mut random);
        let kept = bytes.clone();
        let one = Instant::now();
        let outcome = catch_unwind(AssertUnwindSafe(|| try_reading(seed, bytes)));
        let took = one.elapsed();
        slowest = slowest.max(took);
        executions += 1;
        volumes += u64::from(matches!(outcome, Ok(Ok(()))));
        if outcome.is_err() || took > SLOW {
            let name = seed.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let path = std::env::temp_dir().join(format!("finding-{executions}-{name}"));
            let saved = std::fs::write(&path, kept);
            println!(
                "{}: {took:?}, kept as {} ({saved:?})",
                if outcome.is_err() { "panic" } else { "slow" },
                path.display()
            );
            findings += 1;
        }
    }
    println!(
        "{executions} executions from seed {start}, {volumes} of them readable, slowest {slowest:?}, {findings} findings"
    );
    std::process::exit(i32::from(findings > 0));
}

/// Spoils the file, or what is inside if it is packed as a whole.
fn spoil(seed: &Seed, seeds: &[Seed], random: &mut Random) -> Vec<u8> {
    let mut bytes = seed.bytes.clone();
    if bytes.starts_with(&[0x1f, 0x8b]) && random.below(4) > 0 {
        let mut inner = Vec::new();
        flate2::read::GzDecoder::new(bytes.as_slice()).read_to_end(&mut inner).expect("a valid seed");
        mutate(&mut inner, seeds, random);
        return common::gzip(&inner);
    }
    mutate(&mut bytes, seeds, random);
    bytes
}

fn try_reading(seed: &Seed, bytes: Vec<u8>) -> Result<(), IoError> {
    if seed.path.extension().is_some_and(|extension| extension == "png") {
        std::fs::write(&seed.path, bytes).map_err(|source| IoError::Io { path: seed.path.clone(), source })?;
        return read_png(&seed.path).map(drop);
    }
    let loaded = read_bytes(&seed.path, bytes, &ReadOptions::default())?;
    loaded.volume.statistics();
    Ok(())
}
