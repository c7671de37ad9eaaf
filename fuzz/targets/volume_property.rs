#![no_main]

use libfuzzer_sys::fuzz_target;
use pellucid_optics::VolumeProperty;

// The `.vp.json` of 3D Slicer.
fuzz_target!(|text: &str| {
    let _ = VolumeProperty::from_slicer(text);
});
