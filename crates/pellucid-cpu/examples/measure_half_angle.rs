//! How long half-angle slicing takes beside the unlit ray caster at equal steps, the least of a few frames in
//! turns: `cargo run --release -p pellucid-cpu --example measure_half_angle`. On one thread, unless told another
//! number: threads wait for each other at every slab, so that beside other work the figures tell little.

use std::sync::Arc;
use std::time::Instant;

use pellucid_cpu::CpuRenderer;
use pellucid_field::{VoxelType, closed_form};
use pellucid_scene::{Control, Format, HalfAngle, Scene, Stage, Technique};

const FRAMES: usize = 5;

fn main() {
    let threads = std::env::args().nth(1).and_then(|number| number.parse().ok()).unwrap_or(1);
    println!(
        "512 x 512 pixels, light buffer 512 x 512, step 0.5 voxels, directional light from the side, {threads} threads"
    );
    for (name, dims, opacity) in [("cloud", [160, 160, 112], 0.2), ("ball", [160; 3], 0.05), ("ball", [160; 3], 0.8)] {
        let field = closed_form::by_name(name).expect("a built-in field");
        let volume = closed_form::sample_field(field.as_ref(), dims, VoxelType::U8).expect("a few megabytes");
        let volume = [Arc::new(volume)];
        let stage = |technique: Technique| -> Stage {
            let text = format!(
                "[[volumes]]\nsource = 'memory'\nshading = false\n[volumes.transfer_function]\ncolors = [[0, '#ffffff']]\n\
                 opacities = [[0.1, 0], [0.6, {opacity}]]\n[volumes.scattering]\ntransport = [[0, '#fff0e0']]\n\
                 [[lighting.lights]]\nkind.directional.direction = [1, 0.5, -0.5]\n[image]\nwidth = 512\nheight = 512\n"
            );
            let mut scene = Scene::parse(&text, Format::Toml).expect("a scene");
            scene.technique = technique;
            scene.resolve(&volume).expect("a stage").0
        };
        let direct = HalfAngle { indirect: 0.0, ..HalfAngle::default() };
        let stages = [
            ("ray caster, unlit", stage(Technique::default())),
            ("half-angle, direct", stage(Technique::HalfAngle(direct))),
            ("half-angle, direct and indirect", stage(Technique::HalfAngle(HalfAngle::default()))),
        ];
        let mut renderer = CpuRenderer::with_threads(threads).expect("a number of threads");
        let mut least = [f64::INFINITY; 3];
        for _ in 0..FRAMES {
            for ((_, stage), least) in stages.iter().zip(&mut least) {
                let started = Instant::now();
                renderer.render(stage, &Control::default()).expect("a frame");
                *least = least.min(started.elapsed().as_secs_f64());
            }
        }
        println!("{name} {dims:?}, opacity {opacity}:");
        for ((what, _), seconds) in stages.iter().zip(least) {
            println!("  {what:<32} {:7.1} ms  {:5.2} times", seconds * 1e3, seconds / least[0]);
        }
    }
}
