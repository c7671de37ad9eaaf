//! The bits of every scene's frame, on both backends: what a change of the code's shape must leave as it is.
//!
//! `cargo run -p pellucid --example fingerprints -- [PART..] > before.txt`, and again after the change: the same lines,
//! on the same machine. A PART takes scenes whose name has it.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};

use pellucid::gpu::{AdapterChoice, Ceiling, Device, GpuRenderer, Interpolation};
use pellucid::scene::{Control, Format, Frame, Scene, Stage};
use pellucid::{Backend, Renderer, load, load_optics};

type Error = Box<dyn std::error::Error>;

fn main() -> Result<(), Error> {
    let parts: Vec<String> = std::env::args().skip(1).collect();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let entries =
        std::fs::read_dir(&folder)?.map(|entry| Ok(entry?.path())).collect::<Result<Vec<PathBuf>, Error>>()?;
    let is_scene = |path: &PathBuf| path.extension().is_some_and(|extension| extension == "toml");
    let mut scenes: Vec<PathBuf> = entries.into_iter().filter(is_scene).collect();
    scenes.sort();
    for path in scenes {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        if !parts.is_empty() && !parts.iter().any(|part| name.contains(part)) {
            continue;
        }
        let mut scene = Scene::parse(&std::fs::read_to_string(&path)?, Format::Toml)?;
        load_optics(&mut scene, &folder)?;
        let (stage, _) = scene.resolve(&load(&scene, &folder)?.0)?;
        if Backend::Cpu.draws(&stage) {
            tell(&name, "cpu", &mut Renderer::new(Backend::Cpu)?, &stage)?;
        }
        for (kind, interpolation) in [("gpu", Interpolation::Exact), ("gpu, units", Interpolation::Hardware)] {
            let device = Device::open(&AdapterChoice::Software, &Ceiling::default())?;
            let gpu: Renderer = GpuRenderer::on(device).with_interpolation(interpolation).into();
            if gpu.backend().draws(&stage) {
                tell(&name, kind, &mut { gpu }, &stage)?;
            }
        }
    }
    Ok(())
}

fn tell(name: &str, backend: &str, renderer: &mut Renderer, stage: &Stage) -> Result<(), Error> {
    let frame = renderer.render(stage, &Control::default())?;
    println!("{:016x} {} samples  {name}, {backend}", fingerprint(&frame), frame.statistics.samples);
    Ok(())
}

/// A hash of every number of a frame.
fn fingerprint(frame: &Frame) -> u64 {
    let mut hasher = DefaultHasher::new();
    let mut add = |numbers: &[f32]| numbers.iter().for_each(|number| number.to_bits().hash(&mut hasher));
    add(frame.color.as_flattened());
    add(frame.opacities.as_flattened());
    add(&frame.depth);
    add(frame.normal.as_flattened());
    add(frame.backdrop.as_flattened());
    add(&frame.noise);
    frame.samples.hash(&mut hasher);
    hasher.finish()
}
