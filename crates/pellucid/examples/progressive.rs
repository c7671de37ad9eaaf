//! How soon a preview comes, and how soon the full picture: an orbit around the head, from which the
//! camera moves on after the first full picture of every view.
//!
//! `cargo run --release -p pellucid --example progressive`

use std::time::Instant;

use pellucid::scene::{Control, SampleSource, Scene, Source};
use pellucid::{Backend, Picture, Progressive, Renderer, load};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    const VIEWS: u32 = 12;
    let mut scene = Scene::of(Source::Sample(SampleSource { name: "head".into(), dims: None, voxel_type: None }));
    (scene.image.width, scene.image.height) = (1024, 1024);
    let (stage, _) = scene.resolve(&load(&scene, "")?.0)?;
    let view = stage.viewpoint;
    let mut progressive = Progressive::new(Renderer::new(Backend::Auto)?, stage).with_frames(2);

    println!("| view | preview: 1 ray per | preview ms | of it rays ms | full ms | one more frame ms |");
    println!("|---:|---:|---:|---:|---:|---:|");
    for k in 0..VIEWS {
        progressive.look_from(view.turntable(f64::from(360 * k / VIEWS)), &scene.lighting)?;
        let mut line = [const { String::new() }; 5];
        loop {
            let started = Instant::now();
            let step = progressive.step(&Control::default())?;
            let took = ms(started.elapsed().as_secs_f64());
            match step.picture {
                Picture::Preview { reduction } => {
                    line[0] = format!("{reduction}x{reduction}");
                    line[1] = took;
                    line[2] = ms(progressive.frame().statistics.render_seconds);
                }
                Picture::Full { frames } => line[frames as usize + 2] = took,
            }
            if !step.more {
                break;
            }
        }
        println!("| {k} | {} |", line.join(" | "));
    }
    Ok(())
}

fn ms(seconds: f64) -> String {
    format!("{:.1}", seconds * 1e3)
}
