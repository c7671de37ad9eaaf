//! How long half-angle slicing takes beside the unlit ray caster at equal steps, the least of a few frames in
//! turns, on `benches/light.toml`: `cargo run --release -p pellucid-cpu --example measure_half_angle`. On one
//! thread, unless told another number: threads wait for each other at every slab, so that beside other work the
//! figures tell little.

use std::sync::Arc;
use std::time::Instant;

use pellucid_cpu::CpuRenderer;
use pellucid_field::{VoxelType, closed_form};
use pellucid_scene::{Control, Format, HalfAngle, Scene, Source, Stage, Technique};

const FRAMES: usize = 7;

fn main() {
    let threads = std::env::args().nth(1).and_then(|number| number.parse().ok()).unwrap_or(1);
    let scene = Scene::parse(include_str!("../../../benches/light.toml"), Format::Toml).expect("a scene");
    let field = closed_form::by_name("cloud").expect("a built-in field");
    let volume = closed_form::sample_field(field.as_ref(), [192, 192, 134], VoxelType::U8).expect("a few megabytes");
    let volume = [Arc::new(volume)];
    let stage = |technique: Technique| -> Stage {
        let mut scene = scene.clone();
        scene.volumes[0].source = Source::memory();
        scene.technique = technique;
        scene.resolve(&volume).expect("a stage").0
    };
    let mut stages = vec![("ray caster, unlit".to_owned(), stage(Technique::default()))];
    for resolution in [256, 512] {
        for (indirect, what) in [(0.0, "direct"), (1.0, "direct and indirect")] {
            let settings = HalfAngle { indirect, resolution, ..HalfAngle::default() };
            stages.push((format!("half-angle, {resolution} texels, {what}"), stage(Technique::HalfAngle(settings))));
        }
    }
    let mut renderer = CpuRenderer::with_threads(threads).expect("a number of threads");
    let mut least = vec![f64::INFINITY; stages.len()];
    for _ in 0..FRAMES {
        for ((_, stage), least) in stages.iter().zip(&mut least) {
            let started = Instant::now();
            renderer.render(stage, &Control::default()).expect("a frame");
            *least = least.min(started.elapsed().as_secs_f64());
        }
    }
    println!("512 x 512 pixels, {threads} threads");
    for ((what, _), seconds) in stages.iter().zip(&least) {
        println!("  {what:<44} {:7.1} ms  {:5.2} times", seconds * 1e3, seconds / least[0]);
    }
}
