//! Every scene of `scenes/` is drawn and compared with its stored picture.
//!
//! After a change that is meant to be seen: look at the pictures, then store them anew with
//! `PELLUCID_BLESS=1 cargo test -p pellucid --test gallery`.

#[path = "common/gallery.rs"]
mod common;

use pellucid::io::read_png;
use pellucid::save;

use common::{difference, draw, folder, scenes, stage};

#[test]
fn every_scene_looks_as_stored() {
    let bless = std::env::var_os("PELLUCID_BLESS").is_some();
    let mut failures = Vec::new();
    for path in scenes() {
        let (scene, stage) = stage(&path);
        let frame = draw(&stage);
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        assert!(!scene.title.is_empty(), "{name} has no title");
        let stored = folder().join("golden").join(format!("{name}.png"));
        if bless {
            save(&stored, &frame, &scene.image).unwrap();
            continue;
        }
        let golden = read_png(&stored).unwrap();
        let golden: Vec<u8> = golden.pixels.iter().flatten().map(|v| (v * 255.0).round() as u8).collect();
        let drawn = frame.to_rgba8(&scene.image);
        assert_eq!(golden.len(), drawn.len(), "{name} has another size than its stored picture");
        let (psnr, largest) = difference(&drawn, &golden);
        // The same machine draws the same bits. Another's libm and contraction of a * b + c move
        // single samples across a jump of a transfer function; 50 dB is three such pixels in a
        // hundred changing by one level each, far below what anybody sees.
        if psnr < 50.0 {
            failures.push(format!("{name}: {psnr:.1} dB, largest difference {largest} of 255"));
        }
    }
    assert!(failures.is_empty(), "differs from the stored picture:\n{}", failures.join("\n"));
}
