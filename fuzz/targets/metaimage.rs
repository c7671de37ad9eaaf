#![no_main]

use libfuzzer_sys::fuzz_target;
use pellucid_io::{ReadOptions, read_bytes};

fuzz_target!(|bytes: &[u8]| {
    if let Ok(loaded) = read_bytes("fuzz.mha", bytes.to_vec(), &ReadOptions::default()) {
        loaded.volume.statistics();
    }
});
