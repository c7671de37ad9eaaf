//! Paths traced in passes: the picture they tend to, the noise they claim, and what is left of them when they stop.

use pellucid::optics::luminance;
use pellucid::scene::{Cancel, Control, Format, Frame, PathTrace, RenderWarning, Scene, Stage};
use pellucid::{Backend, Passes, RenderError, Renderer, load};

/// A white ball under a white sky.
fn ball(settings: &str) -> (Stage, PathTrace) {
    let document = format!(
        "[[volumes]]\nsource.sample = {{ name = \"ball\", dims = [16, 16, 16] }}\nscattering.phase = \"isotropic\"\n\
         [image]\nwidth = 40\nheight = 32\n[technique.path_trace]\n\
         environment.constant = {{ color = \"white\" }}\n{settings}\n"
    );
    let scene = Scene::parse(&document, Format::Toml).unwrap();
    let (stage, _) = scene.resolve(&load(&scene, "").unwrap().0).unwrap();
    let settings = stage.path_trace().unwrap().clone();
    (stage, settings)
}

fn cpu() -> Renderer {
    Renderer::new(Backend::Cpu).unwrap()
}

/// All passes, and how many paths a pixel each made there be.
fn drawn(settings: &str, frames: u32) -> (Frame, Vec<u32>) {
    let (stage, settings) = ball(settings);
    let mut passes = Passes::new(cpu(), stage, settings).with_frames(frames);
    let mut taken = Vec::new();
    while passes.step(&Control::default()).unwrap() {
        taken.push(passes.taken());
    }
    assert_eq!(taken.last(), Some(&passes.asked()));
    (passes.into_frame(&Control::default()).unwrap(), taken)
}

fn brightness(frame: &Frame, pixel: usize) -> f64 {
    let [r, g, b, _] = frame.color[pixel];
    f64::from(luminance([r, g, b]))
}

/// Differences of two pictures over their standard errors, squared: the mean over pixels, 1 if they are of the same
/// light.
fn squares(a: &Frame, b: &Frame) -> f64 {
    let variance = |pixel: usize| f64::from(a.noise[pixel]).powi(2) + f64::from(b.noise[pixel]).powi(2);
    let noisy: Vec<usize> = (0..a.color.len()).filter(|pixel| variance(*pixel) > 0.0).collect();
    assert!(noisy.len() > 200, "only {} pixels", noisy.len());
    let score = |pixel: &usize| (brightness(a, *pixel) - brightness(b, *pixel)).powi(2) / variance(*pixel);
    noisy.iter().map(score).sum::<f64>() / noisy.len() as f64
}

#[test]
fn passes_tend_to_the_picture_of_one() {
    let (frame, taken) = drawn("samples = 300", 1);
    // Few paths at first, then a quarter of what there is, and no small rest.
    assert_eq!(taken, [2, 4, 8, 16, 32, 48, 64, 80, 100, 125, 156, 195, 243, 300]);
    let (stage, _) = ball("samples = 300\nseed = 5");
    let whole = cpu().render(&stage, &Control::default()).unwrap();
    let found = squares(&frame, &whole);
    assert!((0.75..1.3).contains(&found), "{found}");
    // The noise that is claimed is that of so many paths, too.
    let noise = |frame: &Frame| frame.noise.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>();
    assert!((0.9..1.1).contains(&(noise(&frame) / noise(&whole))), "{} and {}", noise(&frame), noise(&whole));
    let paths = |frame: &Frame| frame.statistics.rays;
    // Pixels that see nothing take one look a pass.
    assert!(paths(&frame).abs_diff(paths(&whole)) < 14 * 40 * 32, "{} and {}", paths(&frame), paths(&whole));
    // Depths are of the largest pass.
    let far = |pixel: &usize| (frame.depth[*pixel] - whole.depth[*pixel]).abs() > 1.0;
    let opaque: Vec<usize> = (0..40 * 32).filter(|pixel| whole.color[*pixel][3] > 0.9).collect();
    assert!(opaque.len() > 100 && opaque.iter().filter(|pixel| far(pixel)).count() < opaque.len() / 10);
    // Frames to be averaged are as many more paths.
    assert_eq!(drawn("samples = 3", 5).1, [2, 4, 8, 15]);
    assert_eq!(drawn("samples = 1", 1).1, [1]);
}

#[test]
fn noise_targets_are_met_in_passes() {
    let (frame, taken) = drawn("samples = 4096\nnoise = 0.04", 1);
    assert_eq!(taken, [64, 256, 1024, 4096]);
    // At the rim, which most paths miss, chance ends passes early, as it does a whole picture.
    let covered: Vec<usize> = (0..frame.color.len()).filter(|pixel| frame.color[*pixel][3] > 0.3).collect();
    let ratio = |pixel: usize| f64::from(frame.noise[pixel]) / brightness(&frame, pixel);
    // Each pass judges by its own mean: a few pixels miss the target of the whole by a little.
    let missed = covered.iter().filter(|pixel| ratio(**pixel) > 0.042).count();
    assert!(covered.len() > 100 && missed * 50 < covered.len(), "{missed} of {}", covered.len());
    assert!(frame.statistics.rays < 40 * 32 * 4096 / 3, "{}", frame.statistics.rays);
}

#[test]
fn what_stops_keeps_the_passes_before() {
    let (stage, settings) = ball("samples = 64\ndenoise = true");
    let mut passes = Passes::new(cpu(), stage, settings);
    while passes.taken() < 16 {
        assert!(passes.step(&Control::default()).unwrap());
    }
    let cancel = Cancel::default();
    cancel.cancel();
    let control = Control { cancel: Some(&cancel), ..Control::default() };
    assert_eq!(passes.step(&control), Err(RenderError::Cancelled));
    assert_eq!(passes.taken(), 16);
    let kept = passes.into_frame(&Control::default()).unwrap();
    assert_eq!(kept.color, drawn("samples = 16\ndenoise = true", 1).0.color);
    // What is smooth has lost no light.
    let noisy = drawn("samples = 16", 1).0;
    let sum = |frame: &Frame| (0..40 * 32).map(|pixel| brightness(frame, pixel)).sum::<f64>();
    assert!((sum(&kept) / sum(&noisy) - 1.0).abs() < 1e-5 && kept.color != noisy.color);
}

#[test]
fn what_a_clamp_holds_back_is_told_of_all_passes() {
    let (frame, _) = drawn("samples = 64\nfirefly_clamp = 0.5", 1);
    let [brought, held_back] = frame.statistics.light;
    assert!(held_back > 0.0 && held_back < brought);
    let said: Vec<_> = frame.warnings.iter().filter(|said| matches!(said, RenderWarning::Bias { .. })).collect();
    let share = format!("{:.2} %", 100.0 * held_back / brought);
    assert!(said.len() == 1 && said[0].to_string().contains(&share), "{said:?}, not {share}");
}
