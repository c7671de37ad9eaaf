#![no_main]

use libfuzzer_sys::fuzz_target;
use pellucid_scene::{Format, Scene};

// What is accepted can be written, and is read as the same.
fuzz_target!(|input: (bool, &str)| {
    let (is_json, text) = input;
    let format = if is_json { Format::Json } else { Format::Toml };
    if let Ok(scene) = Scene::parse(text, format) {
        let again = scene.to_text(format).expect("a scene can be written");
        assert_eq!(Scene::parse(&again, format).expect("and read"), scene);
    }
});
