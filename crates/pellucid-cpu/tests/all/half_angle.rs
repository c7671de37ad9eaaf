//! Half-angle slicing against closed forms and a brute-force reference in f64 (part K of the sources).

use std::sync::Arc;

use crate::common::{center, homogeneous, render, stage, transfer_function, unit_volume, volume_of};
use glam::{DAffine3, DMat3, DVec3};
use pellucid_cpu::{CpuRenderer, RenderError};
use pellucid_field::{Filter, Sampler, Volume};
use pellucid_optics::{
    Color, ColorPoint, Falloff, Interpolation, Light, LightKind, LightModel, NumberPoint, OpacityPoint, Phase,
    PhaseNormalization, Scattering, ShadowRays, Shadows, SurfaceShare, TransferFunction, srgb_encode,
};
use pellucid_plan::half_angle::LightError;
use pellucid_scene::{
    BlurJitter, BlurScaling, Cancel, Clip, Control, Frame, HalfAngle, InScatter, LightCorrection, LookAt, Orbit,
    Projection, Scene, Stage, Technique, View,
};

fn directional(direction: [f64; 3]) -> Light {
    Light::new(LightKind::Directional { direction })
}

/// Samples that scatter all light evenly, with this share of indirect light getting through a unit.
fn evenly(transport: Option<[f32; 3]>) -> Scattering {
    let point = |linear: [f32; 3]| ColorPoint::new(0.0, Color::new(linear.map(srgb_encode)).unwrap());
    Scattering {
        phase: Phase::Isotropic,
        phase_normalization: PhaseNormalization::Renormalised,
        transport: transport.map(|through| vec![point(through)]),
        ..Scattering::default()
    }
}

fn draw_by(scene: &mut Scene, settings: HalfAngle) {
    scene.technique = Technique::HalfAngle(settings);
    scene.lighting.ambient = 0.0;
}

/// K-10: a slab of 64 slices, lit along the view and against it.
#[test]
fn slabs_have_their_closed_forms() {
    const SLICES: i32 = 64;
    let (alpha, indirect, phase, color) = (0.03f64, 0.01f64, 0.7f64, 0.8f64);
    let unit = |opacity: f64| 1.0 - (1.0 - opacity).powi(2);
    let draw = |direction: [f64; 3], edit: fn(&mut HalfAngle)| {
        let stage = stage(unit_volume([65, 33, 65], |_| 1.0), homogeneous(unit(alpha) as f32), |scene| {
            scene.volumes[0].scattering = evenly(Some([(1.0 - unit(indirect)) as f32; 3]));
            scene.lighting.lights = vec![directional(direction)];
            let mut settings = HalfAngle {
                correction: LightCorrection::None,
                direct: (phase * color) as f32,
                indirect: color as f32,
                ..HalfAngle::default()
            };
            edit(&mut settings);
            draw_by(scene, settings);
            scene.quality.step = 0.5;
        });
        f64::from(center(&render(&stage))[0])
    };
    let (through, q) = (1.0 - alpha, (1.0 - alpha) * (1.0 - indirect));
    let n = f64::from(SLICES);
    let headlight = color
        * alpha
        * (phase * (1.0 - through.powi(2 * SLICES)) / (1.0 - through * through) + (1.0 - q.powi(SLICES)) / (1.0 - q));
    let backlight = color
        * alpha
        * (phase * n * through.powi(SLICES - 1)
            + (through.powi(SLICES) - (1.0 - indirect).powi(SLICES)) / (through - (1.0 - indirect)));
    assert!((headlight - 0.83780297).abs() < 1e-8 && (backlight - 0.61768315).abs() < 1e-8);
    // In an even field a blur changes nothing.
    for edit in [|s: &mut HalfAngle| s.blur_angle = 0.0, |_: &mut HalfAngle| (), |s: &mut HalfAngle| s.taps = 7] {
        let found = draw([0.0, 1.0, 0.0], edit);
        assert!((found - headlight).abs() < 1e-5, "headlight {found}, exact {headlight}");
        let found = draw([0.0, -1.0, 0.0], edit);
        assert!((found - backlight).abs() < 1e-5, "backlight {found}, exact {backlight}");
    }
}

/// The error of a slab falls with the distance of slices, and with its square where half a slab of light is
/// taken off: the figures of K-06b.
#[test]
fn errors_fall_in_their_order() {
    let (tau, indirect, length) = (2.0f64, 0.7f64, 1.5f64);
    // The figures are of direct light by 0.7.
    let exact = 0.7 * (tau * (1.0 - (-2.0 * tau * length).exp()) / (2.0 * tau))
        + tau * (1.0 - (-(tau + indirect) * length).exp()) / (tau + indirect);
    let error = |slices: usize, correction| {
        let affine = DAffine3::from_scale(DVec3::splat(length / 4.0));
        let volume = volume_of([33, 5, 33], affine, |_| 1.0);
        let tf = homogeneous(-(-tau).exp_m1() as f32);
        let stage = stage(volume, tf, |scene| {
            scene.volumes[0].scattering = evenly(Some([(-indirect).exp() as f32; 3]));
            scene.lighting.lights = vec![directional([0.0, 1.0, 0.0])];
            draw_by(scene, HalfAngle { correction, direct: 0.7, ..HalfAngle::default() });
            scene.quality.step = 4.0 / slices as f64;
        });
        (f64::from(center(&render(&stage))[0]) - exact) / exact
    };
    // K-06b, in percent; the last is at the edge of single precision.
    for (slices, book, half) in [(16, 5.2, 0.22), (64, 1.3, 0.014), (256, 0.33, 0.0009)] {
        let [found_book, found_half] =
            [LightCorrection::None, LightCorrection::HalfSlab].map(|correction| 100.0 * error(slices, correction));
        assert!((found_book - book).abs() < 0.05 * book, "{slices} slices: {found_book} %, {book} % expected");
        assert!(
            (found_half.abs() - half).abs() < 0.1 * half + 2e-3,
            "{slices} slices: {found_half} %, {half} % expected"
        );
    }
}

/// The medium of K.6: two soft balls, by extinction.
fn blobs(p: DVec3) -> f64 {
    let soft = |center: DVec3, radius: f64| {
        let t = (1.0 - p.distance(center) / radius).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    };
    6.0 * soft(DVec3::new(0.15, 0.1, -0.2), 0.55) + 4.0 * soft(DVec3::new(-0.3, -0.25, 0.3), 0.4)
}

const WINDOW: f64 = 1.8;
const PIXELS: usize = 48;
const VOXELS: usize = 121;

fn blob_volume() -> Volume {
    let spacing = 2.0 * WINDOW / (VOXELS - 1) as f64;
    let affine = DAffine3 { matrix3: DMat3::from_diagonal(DVec3::splat(spacing)), translation: DVec3::splat(-WINDOW) };
    volume_of([VOXELS; 3], affine, |index| blobs(index * spacing - WINDOW))
}

/// Opacity per unit from extinction.
fn by_extinction() -> TransferFunction {
    let opacities = (0..=1000).map(|k| {
        let value = f64::from(k) * 0.008;
        OpacityPoint { value, opacity: -(-value).exp_m1() as f32, interpolation: Interpolation::Linear }
    });
    let white = ColorPoint::new(0.0, Color::WHITE);
    TransferFunction::new(vec![white], opacities.collect()).unwrap().with_unit_distance(Some(1.0)).unwrap()
}

fn light_at(degrees: f64) -> DVec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    DVec3::new(sin, 0.0, cos)
}

fn blob_stage(degrees: f64, slices: f64, settings: HalfAngle, edit: impl Fn(&mut Scene)) -> Stage {
    stage(blob_volume(), by_extinction(), |scene| {
        scene.image.width = PIXELS as u32;
        scene.image.height = PIXELS as u32;
        scene.camera.projection = Projection::Orthographic { height: Some(2.0 * WINDOW) };
        let (position, up) = ([0.0, 0.0, -10.0], [0.0, 1.0, 0.0]);
        scene.camera.view = View::LookAt(LookAt { position, target: [0.0; 3], up });
        scene.volumes[0].scattering = evenly(None);
        scene.lighting.lights = vec![directional(light_at(degrees).to_array())];
        draw_by(scene, HalfAngle { indirect: 0.0, ..settings.clone() });
        // So that slices are 2 WINDOW / n apart: a step is what a ray passes of one.
        let half = if degrees > 90.0 { (180.0 - degrees) / 2.0 } else { degrees / 2.0 };
        scene.quality.step = (VOXELS - 1) as f64 / slices / half.to_radians().cos();
        edit(scene);
    })
}

/// Direct light by view rays of 192 and shadow rays of 96 steps, in f64, on the same voxels.
fn brute_force(stage: &Stage, light: DVec3) -> Vec<f64> {
    let volume: &Arc<Volume> = &stage.volumes[0].volume;
    let sampler = Sampler::new(volume, 0, Filter::Linear).unwrap();
    let index_from_world = volume.grid().index_from_world();
    let tau = |p: DVec3| {
        if p.abs().max_element() > WINDOW { 0.0 } else { sampler.value(index_from_world.transform_point3(p)) }
    };
    let step = 2.0 * WINDOW / 192.0;
    let pixel = |number: usize| {
        let ray = stage.viewpoint.ray((number % PIXELS) as f64 + 0.5, (number / PIXELS) as f64 + 0.5);
        let (mut color, mut through) = (0.0, 1.0);
        for k in 0..192 {
            let p = ray.at(10.0 - WINDOW + (f64::from(k) + 0.5) * step);
            let alpha = 1.0 - (-tau(p) * step).exp();
            if alpha > 1e-7 {
                let depth: f64 = (0..96).map(|j| tau(p - light * ((f64::from(j) + 0.5) * 2.0 / 96.0))).sum();
                color += through * alpha * (-depth * 2.0 / 96.0).exp();
            }
            through *= 1.0 - alpha;
        }
        color
    };
    (0..PIXELS * PIXELS).map(pixel).collect()
}

fn rmse(frame: &Frame, exact: &[f64]) -> f64 {
    let squares = frame.color.iter().zip(exact).map(|(color, exact)| (f64::from(color[0]) - exact).powi(2));
    (squares.sum::<f64>() / exact.len() as f64).sqrt()
}

/// The oracle scene of K.6: errors of the book's form, and of half-slab light.
#[test]
fn two_blobs_converge_to_the_reference() {
    let table: [(f64, f64, [f64; 3], [f64; 3]); 6] = [
        (20.0, 0.568, [0.0068, 0.0033, 0.0016], [0.0003, 0.0001, 0.0001]),
        (60.0, 0.632, [0.0075, 0.0036, 0.0018], [0.0008, 0.0002, 0.0001]),
        (89.0, 0.636, [0.0087, 0.0042, 0.0021], [0.0008, 0.0002, 0.0001]),
        (91.0, 0.635, [0.0085, 0.0041, 0.0020], [0.0008, 0.0002, 0.0001]),
        (120.0, 0.603, [0.0063, 0.0030, 0.0015], [0.0008, 0.0002, 0.0001]),
        (160.0, 0.463, [0.0049, 0.0023, 0.0011], [0.0007, 0.0002, 0.0001]),
    ];
    for (degrees, peak, book, half) in table {
        let exact = brute_force(&blob_stage(degrees, 64.0, HalfAngle::default(), |_| ()), light_at(degrees));
        let brightest = exact.iter().copied().fold(0.0, f64::max);
        assert!((brightest - peak).abs() < 3e-3, "{degrees} degrees: peak {brightest}, {peak} expected");
        for (round, slices) in [64.0, 128.0, 256.0].into_iter().enumerate() {
            let found = |correction| {
                let settings = HalfAngle { correction, resolution: (1.4 * slices) as u32, ..HalfAngle::default() };
                rmse(&render(&blob_stage(degrees, slices, settings, |_| ())), &exact)
            };
            let (found_book, found_half) = (found(LightCorrection::None), found(LightCorrection::HalfSlab));
            println!("{degrees} degrees, {slices} slices: {found_book:.5} {found_half:.5}");
            assert!((0.9..1.1).contains(&(found_book / book[round])), "{degrees}, {slices}: {found_book} {book:?}");
            // The reference itself is good to 1e-4.
            assert!(found_half < half[round] * 1.1 + 1e-4, "{degrees}, {slices}: {found_half} {half:?}");
        }
    }
}

/// Where the order of blending turns, pictures go on (K-05): the two axes differ less the finer the slices are.
#[test]
fn nothing_pops_where_the_light_passes_the_side() {
    let difference = |slices: f64| {
        let [before, after] = [89.999, 90.001].map(|degrees| {
            let settings = HalfAngle { indirect: 1.0, ..HalfAngle::default() };
            render(&blob_stage(degrees, slices, settings, |_| ()))
        });
        let pairs = before.color.iter().zip(&after.color);
        pairs.map(|(a, b)| f64::from((a[0] - b[0]).abs())).fold(0.0, f64::max)
    };
    // K-05: 2.5e-3, 6e-4 and 1.5e-4 in the book's form.
    let found = [64.0, 128.0, 256.0].map(difference);
    println!("{found:?}");
    for (found, bound) in found.into_iter().zip([2.6e-3, 7e-4, 2e-4]) {
        assert!(found < bound, "{found}");
    }
}

/// Half-angle slicing and a ray caster with shadow rays draw the same light, in perspective, with a point light,
/// with phase functions, surfaces and clips.
#[test]
fn shadow_rays_draw_the_same_direct_light() {
    let surface = SurfaceShare::Values(vec![NumberPoint::new(0.0, 0.0), NumberPoint::new(5.0, 1.0)]);
    let henyey = Phase::HenyeyGreenstein { g: 0.4 };
    let point = |position, falloff| Light::new(LightKind::Point { position, falloff });
    let lights = [
        vec![directional([1.0, -0.4, 0.3])],
        vec![point([2.5, 1.0, -2.0], Falloff::InverseSquare { reference: 3.0 })],
        vec![point([-1.5, 2.2, 2.6], Falloff::None), directional([0.2, 1.0, -0.8])],
    ];
    let clip = Clip::Plane { point: [0.1, 0.0, 0.0], normal: [0.6, 0.3, 0.4] };
    for (lights, clips) in lights.into_iter().zip([vec![], vec![], vec![clip]]) {
        let edit = |scene: &mut Scene| {
            scene.camera.projection = Projection::Perspective { vertical_fov: 50.0 };
            let view = LookAt { position: [0.6, 0.4, -3.6], target: [0.0; 3], up: [0.0, 1.0, 0.0] };
            scene.camera.view = View::LookAt(view);
            scene.volumes[0].shading = Some(true);
            scene.volumes[0].scattering =
                Scattering { phase: henyey.clone(), surface: surface.clone(), ..evenly(None) };
            scene.lighting.lights = lights.clone();
            scene.clips = clips.clone();
        };
        let half_angle = render(&blob_stage(60.0, 256.0, HalfAngle::default(), edit));
        let rays = render(&blob_stage(60.0, 256.0, HalfAngle::default(), |scene| {
            edit(scene);
            scene.technique = Technique::default();
            scene.lighting.model = LightModel::Scattering;
            scene.lighting.shadows = Shadows::Rays(ShadowRays { step: 0.5 });
        }));
        let exact: Vec<f64> = rays.color.iter().map(|color| f64::from(color[0])).collect();
        let (error, peak) = (rmse(&half_angle, &exact), exact.iter().copied().fold(0.0, f64::max));
        println!("{error:.5} of {peak:.3}");
        assert!(peak > 0.15, "{peak}");
        assert!(error < 2e-3 * peak, "{error} of {peak}");
        let opacity = |frame: &Frame| frame.color.iter().map(|color| color[3]).collect::<Vec<f32>>();
        let farthest = opacity(&rays).iter().zip(opacity(&half_angle)).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(farthest < 2e-3, "{farthest}");
        let met = |frame: &Frame| frame.depth.iter().filter(|depth| depth.is_finite()).count();
        println!("{} {} surfaces", met(&rays), met(&half_angle));
        assert!(met(&rays) > 20 && met(&rays).abs_diff(met(&half_angle)) < 8);
        let near = rays.depth.iter().zip(&half_angle.depth).filter(|(a, _)| a.is_finite());
        let far = near.filter(|(a, b)| b.is_finite() && (*a - *b).abs() > 0.05).count();
        assert!(far < 8, "{far} depths differ");
    }
}

fn bits(frame: &Frame) -> Vec<u32> {
    let all = frame.color.iter().flatten().chain(&frame.depth).chain(frame.normal.iter().flatten());
    all.map(|v| v.to_bits()).collect()
}

fn settings_of_all_kinds() -> Vec<HalfAngle> {
    let base = HalfAngle { resolution: 150, ..HalfAngle::default() };
    vec![
        base.clone(),
        HalfAngle { jitter: BlurJitter::Fixed, in_scatter: InScatter::Direct, blur_angle: 50.0, ..base.clone() },
        HalfAngle { in_scatter: InScatter::DirectFromMatter, initial_indirect: 0.0, ..base.clone() },
        HalfAngle { in_scatter: InScatter::BothFromMatter, blur_scaling: BlurScaling::PerDistance, ..base.clone() },
        HalfAngle { indirect: 0.0, correction: LightCorrection::None, ..base },
    ]
}

/// Threads, tiles, and blocks that are left out change no bit; nor does what was drawn before.
#[test]
fn the_picture_is_the_same_to_the_bit() {
    let mut kept = CpuRenderer::new();
    let point = Light::new(LightKind::Point { position: [1.0, 3.0, -2.5], falloff: Falloff::None });
    for light in [directional([0.3, -1.0, 0.2]), directional([0.5, 0.3, -1.0]), point] {
        for settings in settings_of_all_kinds() {
            let draw = |skip: bool| {
                let mut stage = blob_stage(70.0, 60.0, HalfAngle::default(), |scene| {
                    scene.lighting.lights = vec![light];
                    scene.volumes[0].scattering = evenly(Some([0.7, 0.5, 0.3]));
                    scene.quality.empty_space_skipping = skip;
                    scene.quality.early_termination = 0.9;
                    scene.camera.projection = Projection::Perspective { vertical_fov: 30.0 };
                });
                stage.technique = Technique::HalfAngle(settings.clone());
                stage
            };
            let (stage, plain) = (draw(true), draw(false));
            let expected = bits(&render(&stage));
            assert!(bits(&render(&plain)) == expected, "skipping: {settings:?} {light:?}");
            assert!(bits(&kept.render(&stage, &Control::default()).unwrap()) == expected, "kept: {settings:?}");
            for (threads, tile) in [(1, 7), (3, 48)] {
                let mut other = CpuRenderer::with_threads(threads).unwrap().with_tile_size(tile);
                assert!(bits(&other.render(&stage, &Control::default()).unwrap()) == expected, "{threads} {tile}");
            }
        }
    }
}

/// A black light, and none at all, leave attenuation (K-16).
#[test]
fn a_black_light_leaves_attenuation() {
    for lights in [vec![Light { intensity: 0.0, ..directional([0.0, -1.0, 0.3]) }], vec![]] {
        let stage = blob_stage(60.0, 128.0, HalfAngle::default(), |scene| scene.lighting.lights = lights.clone());
        let frame = render(&stage);
        assert!(frame.color.iter().all(|[r, g, b, _]| [*r, *g, *b] == [0.0; 3]));
        let plain =
            render(&blob_stage(60.0, 128.0, HalfAngle::default(), |scene| scene.technique = Technique::default()));
        let pairs = frame.color.iter().zip(&plain.color);
        let farthest = pairs.map(|(a, b)| (a[3] - b[3]).abs()).fold(0.0, f32::max);
        assert!(farthest < 2e-3, "{farthest}");
    }
}

/// Where nothing is blurred, lights of several directions add up: each sweep brings its own, and opacity once.
#[test]
fn lights_add_up() {
    let lights = [directional([0.3, -1.0, 0.2]), directional([0.5, 0.3, -1.0])];
    let draw = |chosen: Option<usize>| {
        render(&blob_stage(60.0, 128.0, HalfAngle::default(), |scene| {
            scene.lighting.lights = lights.to_vec();
            draw_by(scene, HalfAngle { light: chosen, ..HalfAngle::default() });
        }))
    };
    let (both, one, other) = (draw(None), draw(Some(0)), draw(Some(1)));
    for ((both, one), other) in both.color.iter().zip(&one.color).zip(&other.color) {
        for channel in 0..3 {
            assert!((both[channel] - one[channel] - other[channel]).abs() < 1e-6);
        }
        assert!((both[3] - (one[3] + other[3]) / 2.0).abs() < 1e-6 && (one[3] - other[3]).abs() < 2e-3);
    }
}

/// Indirect light reaches deeper than direct light, and redder where blue is held back (6.3-3, 6.3-12).
#[test]
fn indirect_light_reaches_deeper() {
    let column = |settings: HalfAngle| {
        // Looking along y at a block lit from above: the picture's column shows depth.
        let stage = stage(unit_volume([33, 9, 65], |_| 1.0), homogeneous(0.2), |scene| {
            scene.volumes[0].scattering = evenly(Some([0.95, 0.9, 0.8]));
            scene.lighting.lights = vec![directional([0.0, 0.0, -1.0])];
            // Nothing comes in from the sides.
            draw_by(scene, HalfAngle { blur_angle: 0.0, ..settings });
            scene.image.width = 9;
            scene.image.height = 64;
            scene.camera.projection = Projection::Orthographic { height: Some(64.0) };
        });
        let frame = render(&stage);
        (0..64).map(|row| frame.color[row * 9 + 4]).collect::<Vec<[f32; 4]>>()
    };
    let (both, direct) = (column(HalfAngle::default()), column(HalfAngle { indirect: 0.0, ..HalfAngle::default() }));
    let depth = |column: &[[f32; 4]]| column.iter().position(|color| color[0] < 0.1 * column[0][0]).unwrap_or(64);
    assert!(depth(&both) > 2 * depth(&direct), "{} and {}", depth(&both), depth(&direct));
    let redness: Vec<f32> = both[2..60].iter().map(|color| color[0] / color[2]).collect();
    assert!(redness.windows(2).all(|pair| pair[0] < pair[1]), "{redness:?}");
    let brightness = |column: &[[f32; 4]]| column.iter().map(|color| color[0]).sum::<f32>();
    assert!(brightness(&both) > brightness(&direct));
}

/// S = 0 never looks at gradients, and S = 1 is a surface in its shadow (K-11).
#[test]
fn surfaces_mix_in() {
    let draw = |share: f32, shading: bool| {
        bits(&render(&blob_stage(60.0, 64.0, HalfAngle::default(), |scene| {
            scene.volumes[0].shading = Some(shading);
            let surface = SurfaceShare::Values(vec![NumberPoint::new(0.0, share)]);
            scene.volumes[0].scattering = Scattering { surface, ..evenly(None) };
        })))
    };
    let plain = bits(&render(&blob_stage(60.0, 64.0, HalfAngle::default(), |_| ())));
    assert!(draw(0.0, true) == plain && draw(1.0, true) != plain);
    let shaded = |technique: Technique| {
        render(&blob_stage(60.0, 256.0, HalfAngle::default(), |scene| {
            scene.volumes[0].shading = Some(true);
            let surface = SurfaceShare::Values(vec![NumberPoint::new(0.0, 1.0)]);
            scene.volumes[0].scattering = Scattering { surface, ..evenly(None) };
            scene.lighting.shadows = Shadows::Rays(ShadowRays { step: 0.5 });
            scene.technique = technique.clone();
        }))
    };
    let half_angle = HalfAngle { indirect: 0.0, ..HalfAngle::default() };
    let exact = shaded(Technique::default()).color.iter().map(|color| f64::from(color[0])).collect::<Vec<f64>>();
    let error = rmse(&shaded(Technique::HalfAngle(half_angle)), &exact);
    assert!(error < 1e-3 && exact.iter().copied().fold(0.0, f64::max) > 0.2, "{error}");
}

#[test]
fn lights_that_cannot_be_followed_are_refused() {
    let refused = |light: Light, chosen: Option<usize>| {
        let stage = blob_stage(60.0, 32.0, HalfAngle::default(), |scene| {
            scene.lighting.lights = vec![light];
            draw_by(scene, HalfAngle { light: chosen, ..HalfAngle::default() });
        });
        CpuRenderer::new().render(&stage, &Control::default()).unwrap_err()
    };
    let inside = Light::new(LightKind::Point { position: [0.1, 0.0, 0.0], falloff: Falloff::None });
    assert_eq!(refused(inside, None), RenderError::Light(LightError::Inside { light: 0 }));
    assert_eq!(
        refused(directional([0.0, 0.0, 1.0]), Some(3)),
        RenderError::Light(LightError::Absent { found: 3, lights: 1 })
    );
}

#[test]
fn progress_rises_and_cancelling_stops_within_50_ms() {
    let seen = std::sync::Mutex::new(Vec::new());
    let progress = |share: f64| seen.lock().unwrap().push(share);
    let stage = blob_stage(60.0, 128.0, HalfAngle { indirect: 1.0, ..HalfAngle::default() }, |_| ());
    CpuRenderer::new().render(&stage, &Control { progress: Some(&progress), ..Control::default() }).unwrap();
    let seen = seen.into_inner().unwrap();
    assert!(seen.len() > 5 && seen.windows(2).all(|pair| pair[0] < pair[1]), "{seen:?}");
    assert_eq!(seen.last(), Some(&1.0));
    let mut stage = stage;
    stage.technique = Technique::HalfAngle(HalfAngle { resolution: 2048, taps: 16, ..HalfAngle::default() });
    stage.step /= 20.0;
    stage.quality.supersampling = 4;
    let wait = || {
        let cancel = Cancel::default();
        let control = Control { cancel: Some(&cancel), ..Control::default() };
        let (outcome, waited) = std::thread::scope(|scope| {
            let drawing = scope.spawn(|| CpuRenderer::new().render(&stage, &control));
            std::thread::sleep(std::time::Duration::from_millis(700));
            assert!(!drawing.is_finished(), "the scene is too easy for this test");
            let asked = std::time::Instant::now();
            cancel.cancel();
            (drawing.join().unwrap(), asked.elapsed())
        });
        assert_eq!(outcome.unwrap_err(), RenderError::Cancelled);
        waited
    };
    // On a busy machine a thread may not run for longer than that, but hardly three times in a row.
    let waited = (0..3).map(|_| wait()).min().unwrap();
    assert!(waited < std::time::Duration::from_millis(50), "{waited:?}");
}

/// What is absent and what is cut off holds no light back: the same picture as a volume without it.
#[test]
fn holes_and_clips_are_empty() {
    let draw = |hole: bool| {
        let tf = transfer_function(&[(0.0, 0xffffff)], &[(0.5, 0.0), (0.5, 0.3)]);
        let value = |p: DVec3| {
            let inside = (p - DVec3::splat(12.0)).abs().max_element() < 5.0;
            if inside {
                1.0
            } else if hole {
                f64::NAN
            } else {
                0.0
            }
        };
        let stage = stage(unit_volume([25; 3], value), tf, |scene| {
            scene.volumes[0].scattering = evenly(Some([0.9; 3]));
            scene.lighting.lights = vec![directional([1.0, 1.0, -1.0])];
            draw_by(scene, HalfAngle::default());
            scene.clips = vec![Clip::Box { min: [8.1; 3], max: [15.9; 3] }];
            scene.camera.view = View::Orbit(Orbit { azimuth: 20.0, elevation: 30.0, ..Orbit::default() });
        });
        render(&stage)
    };
    let (whole, holed) = (draw(false), draw(true));
    let pairs = whole.color.iter().zip(&holed.color);
    // Inside of the clip no cell has a hole.
    let farthest = pairs.flat_map(|(a, b)| (0..4).map(move |c| (a[c] - b[c]).abs())).fold(0.0, f32::max);
    assert!(farthest < 1e-5 && center(&whole)[3] > 0.5, "{farthest}");
}
