//! Every scene of `scenes/` is drawn and compared with its stored picture.
//!
//! After a change that is meant to be seen: look at the pictures, then store them anew with
//! `PELLUCID_BLESS=1 cargo test -p pellucid --test gallery`.

use std::path::{Path, PathBuf};

use pellucid::io::read_png;
use pellucid::scene::{Control, Format, Frame, Scene};
use pellucid::{Backend, Renderer, load, save};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes")
}

fn draw(path: &Path) -> (Scene, Frame) {
    let text = std::fs::read_to_string(path).unwrap();
    let scene = Scene::parse(&text, Format::Toml).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let (volumes, _) = load(&scene, folder()).unwrap();
    let (stage, _) = scene.resolve(&volumes).unwrap();
    let frame = Renderer::new(Backend::Cpu).unwrap().render(&stage, &Control::default()).unwrap();
    (scene, frame)
}

/// Peak signal-to-noise ratio in dB and the largest difference, of 8-bit channels.
fn difference(a: &[u8], b: &[u8]) -> (f64, u8) {
    let differences = a.iter().zip(b).map(|(a, b)| a.abs_diff(*b));
    let largest = differences.clone().max().unwrap_or(0);
    let squares: f64 = differences.map(|d| f64::from(d).powi(2)).sum();
    (10.0 * (255.0 * 255.0 * a.len() as f64 / squares).log10(), largest)
}

#[test]
fn every_scene_looks_as_stored() {
    let bless = std::env::var_os("PELLUCID_BLESS").is_some();
    let mut scenes: Vec<PathBuf> = std::fs::read_dir(folder())
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
        .collect();
    scenes.sort();
    assert!(scenes.len() >= 18, "{} scenes", scenes.len());
    let mut failures = Vec::new();
    for path in scenes {
        let (scene, frame) = draw(&path);
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
