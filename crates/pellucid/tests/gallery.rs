//! Every scene of `scenes/` is drawn and compared with its stored picture.
//!
//! After a change that is meant to be seen: look at the pictures, then store those that changed, and
//! those of new scenes, with `PELLUCID_BLESS=1 cargo test -p pellucid --test gallery`.

mod common;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use pellucid::io::read_png;
use pellucid::save;

use common::{difference, draw, folder, name_of, scenes, stage};

/// The same machine draws the same bits. Another's libm and contraction of a * b + c move single
/// samples across a jump of a transfer function; 50 dB is three such pixels in a hundred changing
/// by one level each, far below what anybody sees.
const LEAST_PSNR: f64 = 50.0;

fn golden() -> PathBuf {
    folder().join("golden")
}

/// How a picture differs from the stored one, if it does.
fn differs(stored: &Path, drawn: &[u8]) -> Option<String> {
    if !stored.is_file() {
        return Some("there is no stored picture".into());
    }
    let golden = read_png(stored).unwrap();
    let golden: Vec<u8> = golden.pixels.iter().flatten().map(|v| (v * 255.0).round() as u8).collect();
    if golden.len() != drawn.len() {
        return Some("the stored picture has another size".into());
    }
    let (psnr, largest) = difference(drawn, &golden);
    (psnr < LEAST_PSNR).then(|| format!("{psnr:.1} dB, largest difference {largest} of 255"))
}

#[test]
fn every_scene_looks_as_stored() {
    let bless = std::env::var_os("PELLUCID_BLESS").is_some();
    let mut failures = Vec::new();
    for path in scenes() {
        let (scene, stage) = stage(&path);
        let frame = draw(&stage);
        let name = name_of(&path);
        assert!(!scene.title.is_empty(), "{name} has no title");
        let stored = golden().join(format!("{name}.png"));
        match differs(&stored, &frame.to_rgba8(&scene.image)) {
            Some(how) if bless => {
                println!("{name}: {how}; stored");
                save(&stored, &frame, &scene.image).unwrap();
            }
            Some(how) => failures.push(format!("{name}: {how}")),
            None => {}
        }
    }
    let next = "look at them, then store them: PELLUCID_BLESS=1 cargo test -p pellucid --test gallery";
    assert!(failures.is_empty(), "not as stored ({next}):\n{}", failures.join("\n"));
}

/// A scene that is gone, or not found any more, is noticed by the picture it leaves behind.
#[test]
fn every_stored_picture_has_a_scene() {
    let drawn: BTreeSet<String> = scenes().iter().map(|path| name_of(path)).collect();
    let pictures = std::fs::read_dir(golden()).unwrap().map(|entry| entry.unwrap().path());
    let left: Vec<String> = pictures.map(|path| name_of(&path)).filter(|name| !drawn.contains(name)).collect();
    assert!(left.is_empty(), "pictures without a scene: {left:?}");
}
