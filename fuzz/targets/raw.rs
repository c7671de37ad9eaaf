#![no_main]

use libfuzzer_sys::fuzz_target;
use pellucid_io::{Endian, RawLayout, ReadOptions, StoredType, read_bytes};

// The first bytes are the layout, the rest is the file.
fuzz_target!(|input: ([u16; 3], u8, u8, bool, Option<u16>, &[u8])| {
    let (dims, stored, components, big, skip, bytes) = input;
    let stored = StoredType::ALL[stored as usize % StoredType::ALL.len()];
    let layout = RawLayout {
        components: components.into(),
        endian: if big { Endian::Big } else { Endian::Little },
        skip: skip.map(u64::from),
        ..RawLayout::new(dims.map(usize::from), stored)
    };
    let options = ReadOptions { raw: Some(layout), ..Default::default() };
    if let Ok(loaded) = read_bytes("fuzz.raw", bytes.to_vec(), &options) {
        loaded.volume.statistics();
    }
});
