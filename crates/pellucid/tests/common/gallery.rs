//! The scenes of `scenes/`, and how far two pictures are apart.

use std::path::{Path, PathBuf};

use pellucid::load;
use pellucid::scene::{Format, Scene, Stage};

/// Where the scenes are.
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes")
}

/// All scenes, by name.
pub fn scenes() -> Vec<PathBuf> {
    let mut scenes: Vec<PathBuf> = std::fs::read_dir(folder())
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
        .collect();
    scenes.sort();
    assert!(scenes.len() >= 18, "{} scenes", scenes.len());
    scenes
}

/// A scene, ready to be drawn.
pub fn stage(path: &Path) -> (Scene, Stage) {
    let text = std::fs::read_to_string(path).unwrap();
    let scene = Scene::parse(&text, Format::Toml).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let (volumes, _) = load(&scene, folder()).unwrap();
    let (stage, _) = scene.resolve(&volumes).unwrap();
    (scene, stage)
}

/// Peak signal-to-noise ratio in dB and the largest difference, of 8-bit channels.
pub fn difference(a: &[u8], b: &[u8]) -> (f64, u8) {
    let differences = a.iter().zip(b).map(|(a, b)| a.abs_diff(*b));
    let largest = differences.clone().max().unwrap_or(0);
    let squares: f64 = differences.map(|d| f64::from(d).powi(2)).sum();
    (10.0 * (255.0 * 255.0 * a.len() as f64 / squares).log10(), largest)
}
