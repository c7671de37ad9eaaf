//! What the denoiser and the firefly clamp are worth: scenes of paths against themselves with many paths.
//!
//! `cargo run --release -p pellucid --example denoise -- SCENE.toml SIDE SAMPLES [CLAMP,CLAMP..]` draws a scene, SIDE
//! pixels square, with 4 to 256 samples a pixel, with and without noise; with clamps it prints those instead.
//! The reference is two pictures of SAMPLES samples a pixel: of the products of what a picture differs from the one and
//! the other by, the reference's own noise is gone.

use std::path::Path;
use std::time::Instant;

use pellucid::scene::{Control, Format, Frame, PathTrace, Scene, Technique, denoise};
use pellucid::{Backend, Renderer, load};

type Error = Box<dyn std::error::Error>;

fn main() -> Result<(), Error> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [path, side, most, clamps @ ..] = args.as_slice() else {
        return Err("SCENE.toml SIDE SAMPLES [CLAMP,CLAMP..]".into());
    };
    let side: u32 = side.parse()?;
    let mut scene = Scene::parse(&std::fs::read_to_string(path)?, Format::Toml)?;
    (scene.image.width, scene.image.height) = (side, side);
    let (volumes, _) = load(&scene, Path::new(path).parent().unwrap_or(Path::new("")))?;
    let Technique::PathTrace(own) = scene.technique.clone() else { return Err("the scene traces no paths".into()) };
    let mut draw = |change: &dyn Fn(&mut PathTrace)| -> Result<Frame, Error> {
        let mut settings = PathTrace { denoise: false, firefly_clamp: 0.0, ..own.clone() };
        change(&mut settings);
        scene.technique = Technique::PathTrace(settings);
        let (stage, _) = scene.resolve(&volumes)?;
        Ok(Renderer::new(Backend::Cpu)?.render(&stage, &Control::default())?)
    };
    let most = most.parse()?;
    let reference = [
        draw(&|settings| (settings.samples, settings.seed) = (most, 1001))?,
        draw(&|settings| (settings.samples, settings.seed) = (most, 1002))?,
    ];
    let whole = (mean(&reference[0]) + mean(&reference[1])) / 2.0;
    if let [clamps] = clamps {
        println!("| clamp | samples | mean radiance, share of the reference's | PSNR | PSNR, denoised |");
        println!("|---:|---:|---:|---:|---:|");
        for clamp in clamps.split(',') {
            let clamp: f32 = clamp.parse()?;
            for samples in [16, 64] {
                let mut frame = draw(&|settings| (settings.samples, settings.firefly_clamp) = (samples, clamp))?;
                let (share, noisy) = (mean(&frame) / whole, psnr(&frame, &reference));
                denoise(&mut frame, samples, &Control::default())?;
                println!("| {clamp} | {samples} | {share:.4} | {noisy:.2} | {:.2} |", psnr(&frame, &reference));
            }
        }
        return Ok(());
    }
    println!("| samples | PSNR | denoised | light kept | seconds of denoising |");
    println!("|---:|---:|---:|---:|---:|");
    for samples in [4, 16, 64, 256] {
        let mut frame = draw(&|settings| settings.samples = samples)?;
        let (before, noisy) = (mean(&frame), psnr(&frame, &reference));
        let started = Instant::now();
        denoise(&mut frame, samples, &Control::default())?;
        let seconds = started.elapsed().as_secs_f64();
        let (smooth, kept) = (psnr(&frame, &reference), mean(&frame) / before);
        println!("| {samples} | {noisy:.2} | {smooth:.2} | {kept:.6} | {seconds:.3} |");
    }
    Ok(())
}

fn mean(frame: &Frame) -> f64 {
    frame.color.iter().flat_map(|color| &color[..3]).map(|v| f64::from(*v)).sum::<f64>()
}

/// Of the picture over black, as screens show it, in dB.
fn psnr(frame: &Frame, [one, two]: &[Frame; 2]) -> f64 {
    let shown = |frame: &Frame, k: usize, c: usize| match f64::from(frame.color[k][c]).clamp(0.0, 1.0) {
        v if v <= 0.003_130_8 => 12.92 * v,
        v => 1.055 * v.powf(1.0 / 2.4) - 0.055,
    };
    let places = (0..frame.color.len()).flat_map(|k| (0..3).map(move |c| (k, c)));
    let product = |(k, c)| {
        let found = shown(frame, k, c);
        (found - shown(one, k, c)) * (found - shown(two, k, c))
    };
    let squares: f64 = places.map(product).sum();
    -10.0 * (squares / (3 * frame.color.len()) as f64).log10()
}
