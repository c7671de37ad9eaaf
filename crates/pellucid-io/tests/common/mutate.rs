//! Ways to spoil files, and what reading them must keep to: no panic, little memory, little time, errors of one line.
//!
//! The same inputs every time, unless `PELLUCID_FUZZ_SECONDS` asks for a longer session (from `PELLUCID_FUZZ_SEED`):
//!
//! ```text
//! PELLUCID_FUZZ_SECONDS=600 cargo test -p pellucid-io --test hostile -- --nocapture
//! ```

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use super::ledger;

/// A file to begin with.
#[derive(Clone)]
pub struct Seed {
    pub path: PathBuf,
    pub bytes: Vec<u8>,
}

/// Small, fast and repeatable (xorshift).
pub struct Random(pub u64);

impl Random {
    pub fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % n.max(1) as u64) as usize
    }
}

/// Words that have broken readers before.
const WORDS: [&str; 22] = [
    "0",
    "-1",
    "1",
    "2",
    "nan",
    "inf",
    "-inf",
    "1e308",
    "1e-320",
    "4294967296",
    "9223372036854775807",
    "18446744073709551615",
    "-9223372036854775808",
    "LIST",
    "LOCAL",
    "%d",
    "none",
    "(",
    ")",
    "\"",
    "\n\n",
    "=",
];

/// Spoils a file in one to four places.
pub fn mutate(bytes: &mut Vec<u8>, others: &[Seed], random: &mut Random) {
    for _ in 0..=random.below(4) {
        let at = random.below(bytes.len());
        match random.below(9) {
            0 if !bytes.is_empty() => bytes[at] ^= 1 << random.below(8),
            1 if !bytes.is_empty() => bytes[at] = [0, 1, 0x7f, 0x80, 0xff, b' ', b'\n'][random.below(7)],
            2 => bytes.truncate(at),
            3 => {
                let end = (at + random.below(32)).min(bytes.len());
                bytes.drain(at..end);
            }
            4 => {
                let end = (at + random.below(64)).min(bytes.len());
                let copy = bytes[at..end].to_vec();
                bytes.splice(at..at, copy);
            }
            5 => {
                // A field of four bytes, as binary headers have them.
                let value = [0, 1, -1, i32::MAX, i32::MIN, 0x7f80_0000, 0x7fff][random.below(7)];
                let order = if random.below(2) == 0 { value.to_le_bytes() } else { value.to_be_bytes() };
                bytes.iter_mut().skip(at).zip(order).for_each(|(byte, new)| *byte = new);
            }
            6 => {
                let other = &others[random.below(others.len())].bytes;
                let from = random.below(other.len());
                let to = (from + random.below(64)).min(other.len());
                bytes.splice(at..at, other[from..to].iter().copied());
            }
            _ => {
                // The word around the place becomes another.
                let is_edge = |byte: &u8| byte.is_ascii_whitespace() || b",()".contains(byte);
                let start = bytes[..at].iter().rposition(is_edge).map_or(0, |edge| edge + 1);
                let end = bytes[at..].iter().position(is_edge).map_or(bytes.len(), |edge| at + edge);
                bytes.splice(start..end, WORDS[random.below(WORDS.len())].bytes());
            }
        }
    }
}

/// Longest time to read a small file, on a machine that is busy with other things.
const SLOWEST: Duration = Duration::from_secs(5);

/// Reads `count` spoilt files. `read` says whether there was something to read, or why not; `most` is the memory that
/// it may reserve on the way, in bytes.
///
/// # Panics
/// If it panics, or takes more memory or time: then the file is kept and named.
pub fn session(
    count: u64,
    seeds: &[Seed],
    most: usize,
    mut spoil: impl FnMut(&Seed, &mut Random) -> Vec<u8>,
    mut read: impl FnMut(&Seed, &[u8]) -> Result<(), String>,
) {
    let number = |name: &str| std::env::var(name).ok().and_then(|text| text.parse::<u64>().ok());
    let (seconds, first) = (number("PELLUCID_FUZZ_SECONDS"), number("PELLUCID_FUZZ_SEED").unwrap_or(1));
    let mut random = Random(first.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
    let began = Instant::now();
    let (mut inputs, mut readable, mut slowest, mut largest) = (0u64, 0u64, Duration::ZERO, 0);
    while seconds.map_or(inputs < count, |seconds| began.elapsed() < Duration::from_secs(seconds)) {
        let seed = &seeds[random.below(seeds.len())];
        let bytes = spoil(seed, &mut random);
        let one = Instant::now();
        let (outcome, reserved) = ledger::peak_of(|| catch_unwind(AssertUnwindSafe(|| read(seed, &bytes))));
        let took = one.elapsed();
        (inputs, slowest, largest) = (inputs + 1, slowest.max(took), largest.max(reserved));
        let finding = match &outcome {
            Err(_) => Some("it panics".to_owned()),
            Ok(Err(text)) if text.contains('\n') || text.len() > 1000 => Some(format!("its error is '{text}'")),
            _ if reserved > most => Some(format!("it reserves {reserved} bytes")),
            _ if took > SLOWEST => Some(format!("it takes {took:?}")),
            _ => None,
        };
        readable += u64::from(matches!(outcome, Ok(Ok(()))));
        if let Some(finding) = finding {
            let name = seed.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let path = std::env::temp_dir().join(format!("finding-{inputs}-{name}"));
            let kept = std::fs::write(&path, &bytes);
            panic!("input {inputs} from {first}: {finding}; kept as {} ({kept:?})", path.display());
        }
    }
    println!("{inputs} inputs from {first}, {readable} readable, at most {slowest:?} and {largest} bytes each");
    assert!(readable > inputs / 100, "only {readable} of {inputs} get past the first checks");
}
