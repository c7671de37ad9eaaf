#![no_main]

use libfuzzer_sys::fuzz_target;
use pellucid_io::{Limits, read_picture_bytes};

// What the first byte says, EXR or PNG. Panics of the decoders become errors, but libFuzzer's hook sees them first and
// stops: they are worth knowing of.
fuzz_target!(|bytes: &[u8]| {
    let name = if bytes.starts_with(&[0x76]) { "fuzz.exr" } else { "fuzz.png" };
    let limits = Limits { bytes: Some(1 << 26), ..Limits::default() };
    if let Ok(picture) = read_picture_bytes(name, bytes, &limits) {
        assert_eq!(picture.pixels.len(), picture.width as usize * picture.height as usize);
    }
});
