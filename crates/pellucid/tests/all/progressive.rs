//! Progressive pictures: what comes first, what they tend to, and how they stop.

use std::sync::Arc;
use std::time::{Duration, Instant};

use pellucid::field::{Grid, Volume, Voxels};
use pellucid::optics::{Color, ColorPoint, Interpolation, OpacityPoint, TransferFunction};
use pellucid::scene::{
    Camera, Cancel, Control, Frame, GlobalIllumination, Illumination, Isosurface, Isovalue, Jitter, Mode, Orbit,
    Projection, RayCast, SampleSource, Scene, Source, Stage, Technique, View,
};
use pellucid::{Backend, Picture, Progressive, RenderError, Renderer, load};

const FIRST: Picture = Picture::Full { frames: 1 };

/// A 17^3 box of side 16 with the value y, white where it is above `from`, seen along +y: one unit a
/// pixel, unlit.
fn white_box(from: f64, opacity: f32, side: u32, edit: impl FnOnce(&mut Scene)) -> Stage {
    let values: Vec<f32> = (0..17 * 17 * 17).map(|k| (k / 17 % 17) as f32).collect();
    let volume = Volume::new(Grid::new([17; 3]).unwrap(), Voxels::from(values)).unwrap();
    let interpolation = Interpolation::Linear;
    let colors = vec![ColorPoint { value: 0.0, color: Color::WHITE, interpolation }];
    let opacities = [(from, 0.0), (from, opacity)];
    let opacities = opacities.map(|(value, opacity)| OpacityPoint { value, opacity, interpolation }).to_vec();
    let tf = TransferFunction::new(colors, opacities).unwrap().with_unit_distance(Some(1.0)).unwrap();
    let mut scene = Scene::of(Source::memory());
    scene.volumes[0].transfer_function = Some(tf);
    scene.volumes[0].shading = Some(false);
    scene.camera = Camera {
        projection: Projection::Orthographic { height: Some(f64::from(side)) },
        view: View::Orbit(Orbit { azimuth: 0.0, elevation: 0.0, ..Orbit::default() }),
        ..Camera::default()
    };
    (scene.image.width, scene.image.height) = (side, side);
    scene.quality.early_termination = 1.0;
    edit(&mut scene);
    scene.resolve(&[Arc::new(volume)]).unwrap().0
}

fn head(edit: impl FnOnce(&mut Scene)) -> Stage {
    let head = SampleSource { name: "head".into(), dims: Some([48; 3]), voxel_type: None };
    let mut scene = Scene::of(Source::Sample(head));
    (scene.image.width, scene.image.height) = (64, 64);
    edit(&mut scene);
    scene.resolve(&load(&scene, "").unwrap().0).unwrap().0
}

fn renderer() -> Renderer {
    Renderer::new(Backend::Auto).unwrap()
}

fn render(stage: &Stage) -> Frame {
    renderer().render(stage, &Control::default()).unwrap()
}

/// Root mean square over pixels of a measure at the means of 1 to `most` frames; `[0]` belongs to
/// one frame.
fn errors(stage: &Stage, most: u32, error: impl Fn(usize, [f32; 4]) -> Option<f64>) -> Vec<f64> {
    let mut progressive = Progressive::new(renderer(), stage.clone()).with_preview(None).with_frames(most);
    let mut found = Vec::new();
    loop {
        let step = progressive.step(&Control::default()).unwrap();
        let errors: Vec<f64> =
            progressive.frame().color.iter().enumerate().filter_map(|(pixel, color)| error(pixel, *color)).collect();
        found.push((errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt());
        assert_eq!(step.picture, Picture::Full { frames: found.len() as u32 });
        if !step.more {
            return found;
        }
    }
}

/// What of the unit square at (x, y) lies in a square of side 16 around the middle of a picture of
/// `side` pixels, turned clockwise: the pixel is cut by its four edges (Sutherland and Hodgman).
fn coverage(x: usize, y: usize, side: u32, degrees: f64) -> f64 {
    let middle = f64::from(side) / 2.0;
    let (left, top) = (x as f64 - middle, y as f64 - middle);
    let mut polygon = vec![[left, top], [left + 1.0, top], [left + 1.0, top + 1.0], [left, top + 1.0]];
    for quarter in 0..4 {
        let (sin, cos) = (degrees + 90.0 * f64::from(quarter)).to_radians().sin_cos();
        let inside = |p: [f64; 2]| 8.0 - (p[0] * cos + p[1] * sin);
        let corners = std::mem::take(&mut polygon);
        for (k, &from) in corners.iter().enumerate() {
            let to = corners[(k + 1) % corners.len()];
            let (a, b) = (inside(from), inside(to));
            if a >= 0.0 {
                polygon.push(from);
            }
            if (a < 0.0) != (b < 0.0) {
                let t = a / (a - b);
                polygon.push([from[0] + (to[0] - from[0]) * t, from[1] + (to[1] - from[1]) * t]);
            }
        }
    }
    let n = polygon.len();
    (0..n).map(|k| polygon[k][0] * polygon[(k + 1) % n][1] - polygon[(k + 1) % n][0] * polygon[k][1]).sum::<f64>() / 2.0
}

/// The error falls faster than that of as many random rays, whose variance in a pixel is c (1 - c) for
/// its coverage c: with one ray a pixel, and with four, which the shifts must not carry into others.
#[test]
fn edges_tend_to_their_coverage() {
    const ROLL: f64 = 17.0;
    let is_edge = |exact: f64| (1e-9..1.0 - 1e-9).contains(&exact);
    let exact: Vec<f64> = (0..26 * 26).map(|pixel| coverage(pixel % 26, pixel / 26, 26, ROLL)).collect();
    let edges: Vec<f64> = exact.iter().copied().filter(|&c| is_edge(c)).collect();
    let deviation = (edges.iter().map(|c| c * (1.0 - c)).sum::<f64>() / edges.len() as f64).sqrt();
    for supersampling in [1, 2] {
        let stage = white_box(-1.0, 1.0, 26, |scene| {
            scene.camera.view = View::Orbit(Orbit { azimuth: 0.0, elevation: 0.0, roll: ROLL, ..Orbit::default() });
            scene.quality.supersampling = supersampling;
        });
        let found = errors(&stage, 64, |pixel, color| {
            let (found, exact) = (f64::from(color[3]), exact[pixel]);
            assert!(is_edge(exact) || (found - exact).abs() < 1e-6, "pixel {pixel}: {found}, not {exact}");
            is_edge(exact).then_some(found - exact)
        });
        for frames in [1, 4, 16, 64] {
            let bound = deviation / f64::from(frames * supersampling * supersampling).sqrt();
            let error = found[frames as usize - 1];
            println!("{supersampling}x{supersampling} rays, {frames} frames: {error:.4}, random rays {bound:.4}");
            assert!(error < bound, "{supersampling}: {error} after {frames} frames, {bound} for random rays");
        }
    }
}

/// A slab from 5.35 to 16 in steps of 3: a ray finds 3 or 4 samples in it, and the last unit of its
/// way. Light without absorption is linear in the samples, so the mean of jittered frames is without
/// bias (9.1-4) and its error that of independent numbers.
#[test]
fn jittered_light_tends_to_the_integral_along_the_ray() {
    let stage = white_box(5.35, 0.1, 64, |scene| {
        scene.technique = Technique::RayCast(RayCast { mode: Mode::Additive });
        scene.camera.projection = Projection::Orthographic { height: Some(8.0) };
        scene.quality.step = 3.0;
    });
    let extinction = -(0.9f64).ln();
    let found = errors(&stage, 64, |_, color| Some(f64::from(color[0]) - extinction * (16.0 - 5.35)));
    // Without jitter every ray has 3 whole samples and one unit.
    assert!((found[0] - extinction * 0.65).abs() < 1e-3, "{}", found[0]);
    let share: f64 = 0.65 / 3.0;
    let deviation = extinction * 3.0 * (share * (1.0 - share)).sqrt();
    for frames in [4, 16, 64] {
        let bound = 1.2 * deviation / (frames as f64).sqrt();
        assert!(found[frames - 1] < bound, "{} after {frames} frames, expected {bound}", found[frames - 1]);
    }
}

/// The same slab, absorbing (1.4-6).
#[test]
fn jittered_slabs_tend_to_their_transmittance() {
    let stage = white_box(5.35, 0.02, 64, |scene| {
        scene.camera.projection = Projection::Orthographic { height: Some(8.0) };
        scene.quality.step = 3.0;
    });
    let exact = 1.0 - 0.98f64.powf(16.0 - 5.35);
    let found = errors(&stage, 64, |_, color| Some(f64::from(color[3]) - exact));
    assert!(found[0] > 2.0 / 255.0 && found[63] < 1.0 / 255.0, "{} after one frame, {} after 64", found[0], found[63]);
}

#[test]
fn means_approach_the_picture_of_many_rays_and_small_steps() {
    let reference = render(&head(|scene| {
        scene.quality.supersampling = 8;
        scene.quality.step = 0.125;
    }));
    let found = errors(&head(|_| {}), 64, |pixel, color| {
        let off = (0..4).map(|c| f64::from(color[c] - reference.color[pixel][c]).powi(2)).sum::<f64>();
        Some((off / 4.0).sqrt())
    });
    let psnr = [1, 4, 16, 64].map(|frames| -20.0 * found[frames - 1].log10());
    println!("PSNR after 1, 4, 16, 64 frames: {psnr:.1?} dB");
    assert!(psnr.windows(2).all(|pair| pair[1] > pair[0] + 2.0), "{psnr:?}");
}

#[test]
fn the_first_full_frame_is_the_plain_one() {
    for (supersampling, jitter) in [(1, Jitter::Centered), (2, Jitter::BlueNoise { seed: 9 })] {
        let stage = head(|scene| (scene.quality.supersampling, scene.quality.jitter) = (supersampling, jitter));
        let plain = render(&stage);
        let mut progressive = Progressive::new(renderer(), stage).with_frames(2);
        assert!(matches!(progressive.step(&Control::default()).unwrap().picture, Picture::Preview { .. }));
        assert_eq!(progressive.step(&Control::default()).unwrap().picture, FIRST);
        let frame = progressive.frame();
        assert!(frame.color == plain.color && frame.depth == plain.depth && frame.normal == plain.normal);
        assert!(frame.samples == plain.samples && frame.statistics.samples == plain.statistics.samples);
        // The second has other colours, the samples of both, and the same surface.
        let step = progressive.step(&Control::default()).unwrap();
        assert_eq!((step.picture, step.more), (Picture::Full { frames: 2 }, false));
        let frame = progressive.frame();
        assert!(frame.color != plain.color && frame.depth == plain.depth && frame.normal == plain.normal);
        let samples: u64 = frame.samples.iter().map(|&samples| u64::from(samples)).sum();
        assert!(samples == frame.statistics.samples && frame.statistics.rays == 2 * plain.statistics.rays);
        // It is as good as it gets.
        let color = frame.color.clone();
        assert_eq!(progressive.step(&Control::default()).unwrap(), step);
        assert_eq!(progressive.frame().color, color);
    }
}

#[test]
fn a_preview_of_what_is_the_same_everywhere_is_the_full_picture() {
    let stage = white_box(-1.0, 0.1, 50, |scene| {
        scene.camera.projection = Projection::Orthographic { height: Some(8.0) };
        scene.image.height = 33;
    });
    let mut progressive = Progressive::new(renderer(), stage);
    let step = progressive.step(&Control::default()).unwrap();
    assert_eq!((step.picture, step.more), (Picture::Preview { reduction: 4 }, true));
    assert_eq!(progressive.frame().statistics.rays, 14 * 9);
    let preview = progressive.frame().clone();
    assert_eq!(progressive.step(&Control::default()).unwrap().picture, FIRST);
    let full = progressive.frame();
    assert_eq!((preview.width, preview.height), (full.width, full.height));
    let same = |a: f32, b: f32| (a - b).abs() < 1e-6;
    for (a, b) in preview.color.iter().flatten().zip(full.color.iter().flatten()) {
        assert!(same(*a, *b), "{a} and {b}");
    }
    assert!(preview.samples == full.samples && preview.depth.iter().zip(&full.depth).all(|(a, b)| same(*a, *b)));
}

#[test]
fn a_new_view_starts_again() {
    let scene = Scene::of(Source::memory());
    let stage = head(|_| {});
    let other = stage.viewpoint.turned(stage.viewpoint.up, 40.0);
    let mut progressive = Progressive::new(renderer(), stage.clone()).with_preview(Some(Duration::ZERO));
    let step = |progressive: &mut Progressive| progressive.step(&Control::default()).unwrap().picture;
    assert_eq!([step(&mut progressive), step(&mut progressive)], [Picture::Preview { reduction: 4 }, FIRST]);
    assert_eq!(step(&mut progressive), Picture::Full { frames: 2 });
    let shown = progressive.frame().color.clone();
    progressive.look_from(other, &scene.lighting).unwrap();
    // What was there is there until there is something new.
    assert_eq!(progressive.frame().color, shown);
    assert_eq!([step(&mut progressive), step(&mut progressive)], [Picture::Preview { reduction: 16 }, FIRST]);
    let mut expected = stage.clone();
    expected.look_from(other, &scene.lighting).unwrap();
    assert_eq!(progressive.frame().color, render(&expected).color);
    // So does a new stage, here of another size; and where all is fast enough there is no preview.
    let large = head(|scene| (scene.image.width, scene.image.height) = (90, 70));
    progressive.set_stage(large.clone());
    let mut progressive = progressive.with_preview(Some(Duration::from_secs(3600)));
    assert_eq!(step(&mut progressive), FIRST);
    assert_eq!((progressive.frame().width, progressive.frame().height), (90, 70));
    assert_eq!(progressive.into_frame().color, render(&large).color);
}

#[test]
fn a_cancelled_step_returns_at_once_and_leaves_the_last_picture() {
    let stage = white_box(-1.0, 1e-6, 512, |scene| {
        scene.camera.projection = Projection::Orthographic { height: Some(8.0) };
        scene.quality.step = 0.01;
        scene.quality.supersampling = 4;
        scene.quality.empty_space_skipping = false;
    });
    let mut progressive = Progressive::new(renderer(), stage);
    progressive.step(&Control::default()).unwrap();
    let preview = progressive.frame().clone();
    let mut wait = || {
        let cancel = Cancel::default();
        let (outcome, waited) = std::thread::scope(|scope| {
            let step = scope.spawn(|| progressive.step(&Control { cancel: Some(&cancel), ..Control::default() }));
            std::thread::sleep(Duration::from_millis(200));
            assert!(!step.is_finished(), "the scene is too easy for this test");
            let asked = Instant::now();
            cancel.cancel();
            (step.join().unwrap(), asked.elapsed())
        });
        assert_eq!(outcome.unwrap_err(), RenderError::Cancelled);
        waited
    };
    // On a busy machine a thread may not run for longer, but hardly three times in a row.
    let waited = (0..3).map(|_| wait()).min().unwrap();
    assert!(waited < Duration::from_millis(50), "{waited:?}");
    let frame = progressive.frame();
    assert!(frame.color == preview.color && frame.depth == preview.depth && frame.samples == preview.samples);
    // A mean is not touched by the frame that was cancelled, either, and goes on after it.
    let mut progressive = Progressive::new(renderer(), head(|_| {})).with_preview(None);
    while progressive.step(&Control::default()).unwrap().picture != (Picture::Full { frames: 3 }) {}
    let mean = progressive.frame().color.clone();
    let cancel = Cancel::default();
    cancel.cancel();
    assert_eq!(
        progressive.step(&Control { cancel: Some(&cancel), ..Control::default() }).unwrap_err(),
        RenderError::Cancelled
    );
    assert_eq!(progressive.frame().color, mean);
    assert_eq!(progressive.step(&Control::default()).unwrap().picture, Picture::Full { frames: 4 });
}

/// Light of surfaces comes bit by bit, and is in the end that of a picture that waits for all of it.
#[test]
fn light_of_surfaces_comes_while_pictures_do() {
    let sponge = SampleSource { name: "sponge".into(), dims: Some([40; 3]), voxel_type: None };
    let mut scene = Scene::of(Source::Sample(sponge));
    let illumination = Illumination::Global(GlobalIllumination { samples: 400, ..Default::default() });
    let iso = Isovalue { value: 0.5, color: None, opacity: 1.0, volume: None };
    let surfaces = Isosurface { illumination, ..Isosurface::new(vec![iso]) };
    scene.technique = Technique::RayCast(RayCast { mode: Mode::Isosurface(surfaces) });
    (scene.image.width, scene.image.height) = (96, 96);
    let (volumes, _) = load(&scene, "").unwrap();
    let (stage, _) = scene.resolve(&volumes).unwrap();
    let expected = Renderer::default().render(&stage, &Control::default()).unwrap();
    let view = stage.viewpoint;
    // Whoever wants no previews has it in one step.
    let mut patient = Progressive::new(Renderer::default(), stage.clone()).with_preview(None).with_frames(1);
    let step = patient.step(&Control::default()).unwrap();
    assert!(step == pellucid::Step { picture: FIRST, more: false } && patient.frame().color == expected.color);
    let mut progressive = Progressive::new(Renderer::default(), stage).with_frames(1);
    let (mut steps, mut waited) = (0, 0);
    for round in 0..2 {
        let began = Instant::now();
        loop {
            let step = progressive.step(&Control::default()).unwrap();
            steps += 1;
            waited += usize::from(progressive.frame().statistics.waiting > 0);
            println!("round {round}: {:?} after {:?}", step.picture, began.elapsed());
            if !step.more {
                break;
            }
        }
        assert_eq!(progressive.frame().statistics.waiting, 0);
        assert!(progressive.frame().color == expected.color, "round {round}");
        // Back again, and it is all known.
        progressive.look_from(view.turntable(20.0), &scene.lighting).unwrap();
        progressive.step(&Control::default()).unwrap();
        progressive.look_from(view, &scene.lighting).unwrap();
    }
    assert!(steps >= 6 && waited > 0, "{steps} steps, {waited} of them without all light");
}
