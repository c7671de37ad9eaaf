//! The scenes of `scenes/`, and how far two pictures are apart.

#![allow(dead_code)] // Every test file uses its own part.

use std::path::{Path, PathBuf};

use pellucid::gpu::{AdapterChoice, Ceiling, Device, GpuRenderer, Interpolation};
use pellucid::scene::{Control, Format, Frame, Scene, Stage};
use pellucid::{Backend, Renderer, load, load_optics};

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
    scenes
}

/// What a scene, or its picture, is called.
pub fn name_of(path: &Path) -> String {
    path.file_stem().unwrap().to_string_lossy().into_owned()
}

/// A scene, ready to be drawn.
pub fn stage(path: &Path) -> (Scene, Stage) {
    let text = std::fs::read_to_string(path).unwrap();
    let scene = Scene::parse(&text, Format::Toml);
    let mut scene = scene.unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    load_optics(&mut scene, folder()).unwrap();
    let (volumes, _) = load(&scene, folder()).unwrap();
    let (stage, _) = scene.resolve(&volumes).unwrap();
    (scene, stage)
}

/// A GPU renderer on whatever Vulkan driver there is.
pub fn gpu(ceiling: &Ceiling) -> GpuRenderer {
    let open = |choice| Device::open(&choice, ceiling);
    let device = open(AdapterChoice::Hardware).or_else(|_| open(AdapterChoice::Software));
    GpuRenderer::on(device.expect("a Vulkan driver is needed; on Debian: apt-get install mesa-vulkan-drivers"))
}

/// What the processor draws or, by techniques that it has not, a GPU renderer.
pub fn draw(stage: &Stage) -> Frame {
    let mut renderer = if Backend::Cpu.draws(stage) {
        Renderer::new(Backend::Cpu).unwrap()
    } else {
        gpu(&Ceiling::default()).with_interpolation(Interpolation::Exact).into()
    };
    renderer.render(stage, &Control::default()).unwrap()
}

/// Peak signal-to-noise ratio in dB and the largest difference, of 8-bit channels.
pub fn difference(a: &[u8], b: &[u8]) -> (f64, u8) {
    let differences = a.iter().zip(b).map(|(a, b)| a.abs_diff(*b));
    let largest = differences.clone().max().unwrap_or(0);
    let squares: f64 = differences.map(|d| f64::from(d).powi(2)).sum();
    (10.0 * (255.0 * 255.0 * a.len() as f64 / squares).log10(), largest)
}
