//! Several volumes in one picture have closed forms, and no order.

mod half_angle;

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3};
use pellucid_cpu::{CpuRenderer, InstructionSet, RenderError};
use pellucid_field::{Filter, Sampler, Volume};
use pellucid_optics::{
    Color, Environment, Falloff, Light, LightKind, LightModel, Phase, PhaseNormalization, Scattering, ShadowRays,
    ShadowVolume, Shadows, TransferFunction,
};
use pellucid_scene::{
    Camera, Classification, Combine, Control, Frame, HalfAngle, Isosurface, Isovalue, Jitter, Mode, Orbit, Overlap,
    PathTrace, Projection, RayCast, Scene, Slice, SliceGeometry, Slicing, Source, Stage, StageVolume, Technique, View,
    VolumeEntry,
};

use crate::common::{center, homogeneous, render, set_mode, transfer_function, volume_of};

/// An orthographic picture along +y of volumes with transfer functions, unlit; edited before it is resolved.
fn stage(layers: &[(Arc<Volume>, TransferFunction)], edit: impl FnOnce(&mut Scene)) -> Stage {
    let entry = |(_, tf): &(_, TransferFunction)| VolumeEntry {
        transfer_function: Some(tf.clone()),
        shading: Some(false),
        ..VolumeEntry::new(Source::memory())
    };
    let mut scene = Scene { volumes: layers.iter().map(entry).collect(), ..Scene::default() };
    scene.camera = Camera {
        projection: Projection::Orthographic { height: None },
        view: View::Orbit(Orbit { azimuth: 0.0, elevation: 0.0, ..Orbit::default() }),
        ..Camera::default()
    };
    (scene.image.width, scene.image.height) = (24, 24);
    scene.quality.early_termination = 1.0;
    edit(&mut scene);
    let volumes: Vec<Arc<Volume>> = layers.iter().map(|(volume, _)| volume.clone()).collect();
    scene.resolve(&volumes).unwrap().0
}

/// A box of one value, with a corner and the distances between its voxels.
fn solid(dims: [usize; 3], corner: DVec3, spacing: DVec3) -> Arc<Volume> {
    Arc::new(volume_of(dims, DAffine3::from_translation(corner) * DAffine3::from_scale(spacing), |_| 1.0))
}

/// Red, and something of green.
const COLORS: [(u32, [f32; 3]); 2] = [(0xff0000, [1.0, 0.0, 0.0]), (0x00ff00, [0.0, 1.0, 0.0])];

fn colored(number: usize, opacity: f32) -> TransferFunction {
    transfer_function(&[(0.0, COLORS[number].0)], &[(0.0, opacity)])
}

/// Two boxes that overlap, the second with edges off the first's lattice.
fn boxes(opacities: [f32; 2]) -> [(Arc<Volume>, TransferFunction); 2] {
    let first = solid([9, 9, 9], DVec3::ZERO, DVec3::ONE);
    let second = solid([5, 7, 6], DVec3::new(2.2, 4.37, 1.9), DVec3::new(1.3, 0.91, 0.83));
    [(first, colored(0, opacities[0])), (second, colored(1, opacities[1]))]
}

/// Where a ray along y at a pixel is in each of the boxes.
fn intervals(stage: &Stage, pixel: usize) -> [Option<[f64; 2]>; 2] {
    let width = stage.viewpoint.width;
    intervals_at(stage, (pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5)
}

/// The same at a position of the picture, in pixels.
fn intervals_at(stage: &Stage, x: f64, y: f64) -> [Option<[f64; 2]>; 2] {
    let ray = stage.viewpoint.ray(x, y);
    let inside = |volume: &Arc<Volume>| {
        let corners = volume.grid().world_corners();
        let (low, high) = (corners[0], corners[7]);
        let within = |axis: usize| (low[axis]..=high[axis]).contains(&ray.origin[axis]);
        (within(0) && within(2)).then_some([low.y, high.y])
    };
    COLORS.map(|(_, color)| {
        let of = |volume: &&StageVolume| volume.transfer_function.color(1.0) == color;
        inside(&stage.volumes.iter().find(of).unwrap().volume)
    })
}

/// What a ray through intervals of constant matter sends to the eye: of each the extinction, where it lies, as merged by
/// a rule on the extinctions there.
fn closed_form(intervals: [Option<[f64; 2]>; 2], kappas: [f64; 2], rule: impl Fn([f64; 2]) -> [f64; 2]) -> [f64; 4] {
    let mut borders: Vec<f64> = intervals.iter().flatten().flatten().copied().collect();
    borders.sort_by(f64::total_cmp);
    let mut color = [0.0; 4];
    for pair in borders.windows(2) {
        let (middle, length) = ((pair[0] + pair[1]) / 2.0, pair[1] - pair[0]);
        let there = |k: usize| intervals[k].is_some_and(|[from, to]| from < middle && middle < to);
        let kappa = rule([0, 1].map(|k| if there(k) { kappas[k] } else { 0.0 }));
        let total = kappa[0] + kappa[1];
        if total > 0.0 {
            let alpha = -(-total * length).exp_m1();
            let through = 1.0 - color[3];
            for k in 0..2 {
                color[k] += through * alpha * kappa[k] / total;
            }
            color[3] += through * alpha;
        }
    }
    color
}

fn assert_closed(stage: &Stage, rule: impl Fn([f64; 2]) -> [f64; 2] + Copy, kappas: [f64; 2], what: &str) {
    let frame = render(stage);
    let mut both = 0;
    for (pixel, found) in frame.color.iter().enumerate() {
        let intervals = intervals(stage, pixel);
        both += usize::from(intervals.iter().all(Option::is_some));
        let expected = closed_form(intervals, kappas, rule);
        for channel in 0..4 {
            let difference = (f64::from(found[channel]) - expected[channel]).abs();
            assert!(difference < 2e-5, "{what}, pixel {pixel}: {found:?}, exact {expected:?}");
        }
    }
    assert!(both > 50, "{what}: only {both} rays meet both boxes");
}

fn kappas(opacities: [f32; 2]) -> [f64; 2] {
    opacities.map(|a| -(1.0 - f64::from(a)).ln())
}

#[test]
fn extinctions_of_boxes_add() {
    let opacities = [0.12, 0.3];
    for (step, jitter) in [(0.3, Jitter::Centered), (1.0, Jitter::BlueNoise { seed: 3 }), (3.7, Jitter::Centered)] {
        for classification in [Classification::Post, Classification::Pre, Classification::PreIntegrated] {
            for swapped in [false, true] {
                let mut layers = boxes(opacities);
                if swapped {
                    layers.reverse();
                }
                let stage = stage(&layers, |scene| {
                    (scene.quality.step, scene.quality.jitter) = (step, jitter);
                    scene.quality.classification = classification;
                });
                assert_closed(&stage, |kappa| kappa, kappas(opacities), &format!("{step} {classification:?}"));
            }
        }
    }
}

#[test]
fn rules_choose_where_boxes_overlap() {
    let opacities = [0.12, 0.3];
    let larger = |[a, b]: [f64; 2]| if a > b { [a, 0.0] } else { [0.0, b] };
    let first = |[a, b]: [f64; 2]| if a > 0.0 { [a, 0.0] } else { [0.0, b] };
    let second = |[a, b]: [f64; 2]| if b > 0.0 { [0.0, b] } else { [a, 0.0] };
    let draw = |overlap, swapped: bool| {
        let mut layers = boxes(opacities);
        if swapped {
            layers.reverse();
        }
        stage(&layers, |scene| scene.overlap = overlap)
    };
    assert_closed(&draw(Overlap::Maximum, false), larger, kappas(opacities), "maximum");
    assert_closed(&draw(Overlap::Maximum, true), larger, kappas(opacities), "maximum, swapped");
    assert_closed(&draw(Overlap::Priority, false), first, kappas(opacities), "first");
    assert_closed(&draw(Overlap::Priority, true), second, kappas(opacities), "second");
}

#[test]
fn one_volume_gives_its_colors_to_another() {
    // Colours of one whose own opacity is nothing, on matter of the other; where only that is it stays white.
    let [(first, _), (second, _)] = boxes([0.5; 2]);
    let layers = [(first, homogeneous(0.2)), (second, transfer_function(&[(0.0, 0x00ff00)], &[(0.0, 0.0)]))];
    for (overlap, swapped) in
        [(Overlap::Fused { color: 1, opacity: 0 }, false), (Overlap::Fused { color: 0, opacity: 1 }, true)]
    {
        let mut layers = layers.clone();
        if swapped {
            layers.reverse();
        }
        let stage = stage(&layers, |scene| scene.overlap = overlap);
        let found = center(&render(&stage));
        let kappa = -(0.8f64).ln();
        let (before, within) = (4.37, 8.0 - 4.37);
        let [outside, inside] = [before, within].map(|length| -(-kappa * length).exp_m1());
        let through = 1.0 - outside;
        let expected = [outside, outside + through * inside, outside, outside + through * inside];
        for channel in 0..4 {
            assert!((f64::from(found[channel]) - expected[channel]).abs() < 2e-5, "{found:?}, exact {expected:?}");
        }
    }
}

/// Light from the eye is scattered evenly by the one that holds it back, once; the other is seen in no light of its own.
#[test]
fn volumes_that_give_colors_scatter_no_light() {
    let [(first, _), (second, _)] = boxes([0.5; 2]);
    let layers = [(first, homogeneous(0.2)), (second, transfer_function(&[(0.0, 0x00ff00)], &[(0.0, 0.3)]))];
    let kappa = -(0.8f64).ln();
    // What is in its own shadow is lessened twice.
    let shadows = Shadows::Rays(ShadowRays { step: 0.1 });
    for (shadows, lessened, most) in [(Shadows::None, kappa, 2e-5), (shadows, 2.0 * kappa, 2e-4)] {
        let stage = stage(&layers, |scene| {
            for entry in &mut scene.volumes {
                entry.scattering = Scattering { phase: Phase::Isotropic, ..Scattering::default() };
            }
            scene.overlap = Overlap::Fused { color: 1, opacity: 0 };
            scene.lighting.lights = vec![Light::new(LightKind::Directional { direction: [0.0, 1.0, 0.0] })];
            (scene.lighting.model, scene.lighting.shadows) = (LightModel::Scattering, shadows);
            (scene.lighting.ambient, scene.quality.step) = (0.0, 0.1);
        });
        let found = center(&render(&stage));
        // A quarter of what a white surface sends.
        let sent = |from: f64, to: f64| 0.25 * kappa / lessened * ((-lessened * from).exp() - (-lessened * to).exp());
        let (white, green) = (sent(0.0, 4.37), sent(4.37, 8.0));
        let expected = [white, white + green, white, -(-kappa * 8.0).exp_m1()];
        for channel in 0..4 {
            let difference = (f64::from(found[channel]) - expected[channel]).abs();
            assert!(difference < most, "{shadows:?}: {found:?}, exact {expected:?}");
        }
    }
}

/// Two balls, one in the other, on grids that are turned and spaced otherwise.
fn balls() -> [(Arc<Volume>, TransferFunction); 2] {
    let ball = |turn: DQuat, spacing: DVec3, n: usize, radius: f64| {
        let middle = DVec3::splat((n - 1) as f64 / 2.0);
        let affine = DAffine3::from_quat(turn) * DAffine3::from_scale(spacing) * DAffine3::from_translation(-middle);
        Arc::new(volume_of([n; 3], affine, |p| {
            let squared = (affine.transform_point3(p) / radius).length_squared();
            (-squared).exp()
        }))
    };
    let outer = transfer_function(&[(0.0, 0x4060ff), (1.0, 0xffffff)], &[(0.1, 0.0), (0.9, 0.25)]);
    let inner = transfer_function(&[(0.0, 0xff8020)], &[(0.2, 0.0), (1.0, 0.6)]);
    [
        (ball(DQuat::from_rotation_z(0.4), DVec3::new(0.9, 0.7, 0.8), 33, 6.0), outer),
        (ball(DQuat::from_rotation_x(0.9) * DQuat::from_rotation_y(0.3), DVec3::splat(0.45), 29, 2.5), inner),
    ]
}

/// The same in double precision and very small steps: sums of extinctions, and of what they emit.
fn fine(stage: &Stage, pixel: usize) -> [f64; 4] {
    const STEP: f64 = 0.01;
    let view = &stage.viewpoint;
    let ray = view.ray((pixel % view.width) as f64 + 0.5, (pixel / view.width) as f64 + 0.5);
    let fields: Vec<_> = stage.volumes.iter().map(|v| Sampler::new(&v.volume, 0, Filter::Linear).unwrap()).collect();
    let mut color = [0.0; 4];
    for k in 0..100_000 {
        let p = ray.origin + ray.direction * (k as f64 + 0.5) * STEP;
        let (mut total, mut emitted) = (0.0, [0.0; 3]);
        for (volume, field) in stage.volumes.iter().zip(&fields) {
            let grid = volume.volume.grid();
            let index = grid.index_from_world().transform_point3(p);
            let (low, high) = grid.index_bounds();
            if index.cmpge(low).all() && index.cmple(high).all() {
                let value = pellucid_field::Reconstruct::value(field, index);
                let kappa = -(1.0 - f64::from(volume.transfer_function.opacity(value))).ln();
                total += kappa;
                for (sum, channel) in emitted.iter_mut().zip(volume.transfer_function.color(value)) {
                    *sum += kappa * f64::from(channel);
                }
            }
        }
        if total > 0.0 {
            let alpha = -(-total * STEP).exp_m1();
            for channel in 0..3 {
                color[channel] += (1.0 - color[3]) * alpha * emitted[channel] / total;
            }
            color[3] += (1.0 - color[3]) * alpha;
        }
    }
    color
}

#[test]
fn turned_balls_are_the_fine_integral() {
    let stage = stage(&balls(), |scene| {
        scene.camera.view =
            View::Orbit(Orbit { azimuth: 40.0, elevation: 25.0, distance: Some(60.0), ..Orbit::default() });
        scene.camera.projection = Projection::Perspective { vertical_fov: 20.0 };
        (scene.image.width, scene.image.height, scene.quality.step) = (12, 12, 0.1);
    });
    let frame = render(&stage);
    let mut most = 0.0f32;
    for pixel in (0..144).step_by(5) {
        let (found, expected) = (frame.color[pixel], fine(&stage, pixel));
        most = most.max(found[3]);
        for channel in 0..4 {
            let difference = (f64::from(found[channel]) - expected[channel]).abs();
            assert!(difference < 1e-3, "pixel {pixel}: {found:?}, fine {expected:?}");
        }
    }
    assert!(most > 0.9, "hardly anything is seen: {most}");
}

/// A third volume that reaches out of both balls.
fn three() -> Vec<(Arc<Volume>, TransferFunction)> {
    let third = (solid([4, 5, 6], DVec3::new(-1.0, -9.0, -2.0), DVec3::new(1.7, 2.3, 1.1)), homogeneous(0.08));
    balls().into_iter().chain([third]).collect()
}

fn same(a: &Frame, b: &Frame, what: &str) {
    let bits = |frame: &Frame| {
        let planes = [frame.color.as_flattened(), &frame.depth, frame.normal.as_flattened()].concat();
        planes.iter().map(|number| number.to_bits()).collect::<Vec<_>>()
    };
    assert!(bits(a) == bits(b), "{what} is another picture");
}

fn modes() -> Vec<Mode> {
    let iso = |value, opacity| Isovalue { value, color: None, opacity, volume: None };
    let slice = |combine, thickness| Mode::Slice(Slice { combine, thickness, ..Slice::default() });
    vec![
        Mode::Composite,
        Mode::Maximum,
        Mode::Minimum,
        Mode::Average,
        Mode::Additive,
        Mode::XRay,
        Mode::Isosurface(Isosurface::new(vec![iso(0.3, 0.5), iso(0.6, 0.7)])),
        slice(Combine::Average, 0.0),
        slice(Combine::Maximum, 3.0),
    ]
}

/// Lit, and in each other's shadow.
fn lit(scene: &mut Scene) {
    scene.volumes.iter_mut().for_each(|entry| entry.shading = Some(true));
    scene.lighting.shadows = Shadows::Rays(ShadowRays { step: 2.0 });
    scene.lighting.lights = vec![
        Light::new(LightKind::Directional { direction: [-0.3, 0.4, -1.0] }),
        Light::new(LightKind::Point { position: [5.0, -30.0, 12.0], falloff: Falloff::None }),
    ];
}

#[test]
fn the_order_of_the_list_changes_no_bit() {
    let layers = three();
    for mode in modes() {
        for overlap in [Overlap::Add, Overlap::Maximum] {
            for shadows in [false, true] {
                let draw = |order: [usize; 3]| {
                    let layers: Vec<_> = order.iter().map(|&k| layers[k].clone()).collect();
                    render(&stage(&layers, |scene| {
                        set_mode(scene, mode.clone());
                        scene.overlap = overlap;
                        scene.camera.view = View::Orbit(Orbit { azimuth: 20.0, elevation: 15.0, ..Orbit::default() });
                        if shadows {
                            lit(scene);
                        }
                    }))
                };
                let first = draw([0, 1, 2]);
                assert!(first.color.iter().any(|pixel| pixel[0] > 0.05), "{mode:?} shows nothing");
                for order in [[1, 0, 2], [2, 1, 0], [1, 2, 0]] {
                    same(&draw(order), &first, &format!("{mode:?}, {overlap:?}, {order:?}"));
                }
            }
        }
    }
}

#[test]
fn skipping_tiles_and_threads_change_no_bit() {
    for mode in modes() {
        let draw = |skipping, tile, threads| {
            let stage = stage(&three(), |scene| {
                set_mode(scene, mode.clone());
                lit(scene);
                scene.quality.empty_space_skipping = skipping;
                scene.camera.view = View::Orbit(Orbit { azimuth: 30.0, elevation: 20.0, ..Orbit::default() });
            });
            let renderer = CpuRenderer::with_threads(threads).unwrap();
            renderer.with_tile_size(tile).render(&stage, &Control::default()).unwrap()
        };
        let first = draw(true, 32, 1);
        same(&draw(false, 32, 1), &first, &format!("{mode:?} without skipping"));
        same(&draw(true, 7, 2), &first, &format!("{mode:?} in other tiles"));
    }
}

/// Samples lie elsewhere in pieces that borders cut, and anywhere where they are jittered.
#[test]
fn skipping_knows_where_samples_are() {
    let classifications = [Classification::Post, Classification::Pre, Classification::PreIntegrated];
    for (classification, jitter) in classifications.into_iter().flat_map(|how| [(how, false), (how, true)]) {
        for (azimuth, step) in [(0.0, 1.0), (90.0, 0.7), (31.0, 2.3), (200.0, 0.31)] {
            let draw = |skipping| {
                render(&stage(&three(), |scene| {
                    scene.quality.empty_space_skipping = skipping;
                    scene.quality.classification = classification;
                    scene.quality.step = step;
                    if jitter {
                        scene.quality.jitter = Jitter::BlueNoise { seed: 5 };
                    }
                    scene.camera.view = View::Orbit(Orbit { azimuth, elevation: azimuth / 5.0, ..Orbit::default() });
                }))
            };
            let (skipped, whole) = (draw(true), draw(false));
            same(&skipped, &whole, &format!("{classification:?}, {jitter}, {azimuth}, {step}, without skipping"));
            let [some, all] = [&skipped, &whole].map(|frame| frame.statistics.samples);
            assert!(some < all - all / 25, "hardly anything is skipped: {some} of {all} samples are taken");
        }
    }
}

/// Whatever instructions follow the rays: they differ by the rounding of fused products.
#[test]
fn every_set_of_instructions_merges_alike() {
    for mode in modes() {
        for classification in [Classification::Post, Classification::Pre, Classification::PreIntegrated] {
            let stage = stage(&three(), |scene| {
                set_mode(scene, mode.clone());
                lit(scene);
                scene.quality.classification = classification;
                scene.camera.view = View::Orbit(Orbit { azimuth: 30.0, elevation: 20.0, ..Orbit::default() });
            });
            let draw = |set| {
                let mut renderer = CpuRenderer::new().with_instructions(set).ok()?;
                Some(renderer.render(&stage, &Control::default()).unwrap())
            };
            let baseline = draw(InstructionSet::Baseline).unwrap();
            for set in [InstructionSet::Avx2, InstructionSet::Avx512] {
                let Some(frame) = draw(set) else { continue };
                let pairs = frame.color.as_flattened().iter().zip(baseline.color.as_flattened());
                let far = pairs.filter(|(a, b)| (*a - *b).abs() > 1e-4).count();
                assert_eq!(far, 0, "{set} and baseline, {mode:?}, {classification:?}");
            }
        }
    }
}

/// A volume without opacity, within the box of another or far from it, takes nothing and adds nothing.
#[test]
fn what_is_not_seen_changes_nothing() {
    let [ball, _] = balls();
    for corner in [DVec3::splat(-2.0), DVec3::new(0.0, 40.0, 0.0)] {
        let nothing = (solid([4; 3], corner, DVec3::ONE), homogeneous(0.0));
        let alone = |scene: &mut Scene| {
            scene.quality.step = 0.2;
            scene.camera.view = View::Orbit(Orbit {
                azimuth: 0.0,
                elevation: 0.0,
                target: Some([0.0; 3]),
                distance: Some(100.0),
                ..Orbit::default()
            });
            scene.camera.projection = Projection::Orthographic { height: Some(16.0) };
        };
        let one = render(&stage(std::slice::from_ref(&ball), alone));
        // Steps are as long as the finest of all grids asks for.
        let two = render(&stage(&[ball.clone(), nothing], alone));
        let pairs = one.color.as_flattened().iter().zip(two.color.as_flattened());
        let most = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(most < 1e-3, "at {corner}: {most}");
    }
}

/// A thin plate, seen from the side, half of which is under a black box.
#[test]
fn volumes_cast_shadows_on_each_other() {
    let plate = solid([17, 17, 3], DVec3::ZERO, DVec3::ONE);
    let above = solid([9, 9, 5], DVec3::new(4.0, 4.0, 6.0), DVec3::ONE);
    let (thin, dense) = (1e-4, 0.25);
    let layers = [(plate, homogeneous(thin)), (above, transfer_function(&[(0.0, 0x000000)], &[(0.0, dense)]))];
    let volume = Shadows::Volume(ShadowVolume { resolution: 2.0 });
    // Between the points of a volume light leaks.
    let shadows = [(Shadows::Rays(ShadowRays { step: 0.5 }), 3e-3), (volume, 2.5e-2)];
    for (swapped, (shadows, most)) in [false, true].into_iter().flat_map(|swapped| shadows.map(|own| (swapped, own))) {
        let mut layers = layers.clone();
        if swapped {
            layers.reverse();
        }
        let stage = stage(&layers, |scene| {
            for entry in &mut scene.volumes {
                let phase_normalization = PhaseNormalization::Renormalised;
                entry.scattering = Scattering { phase: Phase::Isotropic, phase_normalization, ..Scattering::default() };
            }
            scene.lighting.lights = vec![Light::new(LightKind::Directional { direction: [0.0, 0.0, -1.0] })];
            scene.lighting.ambient = 0.0;
            scene.lighting.model = LightModel::Scattering;
            scene.lighting.shadows = shadows;
            scene.quality.step = 0.5;
            let target = Some([8.0, 8.0, 1.0]);
            scene.camera.view =
                View::Orbit(Orbit { azimuth: 0.0, elevation: 0.0, target, distance: Some(60.0), ..Orbit::default() });
            scene.camera.projection = Projection::Orthographic { height: Some(0.5) };
        });
        let found = center(&render(&stage))[0];
        let shadow = (1.0 - dense).powi(4);
        let expected = 16.0 * thin * (0.5 + 0.5 * shadow);
        assert!((found / expected - 1.0).abs() < most, "{shadows:?}: {found}, exact {expected}");
    }
}

/// Lit through volumes of light with so many points to a voxel.
fn lit_by_volumes(scene: &mut Scene, overlap: Overlap, resolution: f64) {
    lit(scene);
    (scene.overlap, scene.lighting.shadows) = (overlap, Shadows::Volume(ShadowVolume { resolution }));
    scene.camera.view = View::Orbit(Orbit { azimuth: 20.0, elevation: 15.0, ..Orbit::default() });
}

#[test]
fn light_volumes_hold_what_rays_to_lights_find() {
    for overlap in [Overlap::Add, Overlap::Maximum, Overlap::Priority] {
        let draw = |edit: &dyn Fn(&mut Scene)| {
            let stage = stage(&three(), |scene| {
                lit_by_volumes(scene, overlap, 1.0);
                edit(scene);
            });
            render(&stage)
        };
        let found = draw(&|_| ());
        let rays = draw(&|scene| scene.lighting.shadows = Shadows::Rays(ShadowRays::default()));
        let bare = draw(&|scene| scene.lighting.shadows = Shadows::None);
        let apart = |other: &Frame| {
            let pairs = found.color.as_flattened().iter().zip(other.color.as_flattened());
            pairs.map(|(a, b)| f64::from((a - b).abs())).sum::<f64>() / (4 * found.color.len()) as f64
        };
        let (own, other) = (apart(&rays), apart(&bare));
        assert!(own < 2e-3 && other > 10.0 * own, "{overlap:?}: {own} from rays, {other} from no shadows");
    }
}

#[test]
fn light_volumes_know_no_order_and_are_made_anew() {
    let [a, b, c] = <[_; 3]>::try_from(three()).unwrap();
    let [layers, other] = [[a.clone(), b.clone(), c.clone()], [c, a, b]];
    let stage = |layers: &[_], overlap, skipping| {
        stage(layers, |scene| {
            lit_by_volumes(scene, overlap, 0.5);
            scene.quality.empty_space_skipping = skipping;
        })
    };
    let mut kept = CpuRenderer::new();
    for overlap in [Overlap::Add, Overlap::Maximum] {
        let first = render(&stage(&layers, overlap, true));
        same(&render(&stage(&other, overlap, true)), &first, &format!("another order of {overlap:?}"));
        same(&render(&stage(&layers, overlap, false)), &first, &format!("{overlap:?} without skipping"));
        for _ in 0..2 {
            let again = kept.render(&stage(&layers, overlap, true), &Control::default()).unwrap();
            same(&again, &first, &format!("{overlap:?} in the light of a frame before"));
        }
    }
}

#[test]
fn nested_surfaces_are_seen_through_each_other() {
    let ball = |radius: f64, spacing: f64| {
        let affine = DAffine3::from_scale(DVec3::splat(spacing)) * DAffine3::from_translation(DVec3::splat(-10.0));
        Arc::new(volume_of([21; 3], affine, |p| radius - affine.transform_point3(p).length()))
    };
    let layers = [(ball(6.0, 0.8), colored(0, 1.0)), (ball(3.0, 0.5), colored(1, 1.0))];
    for swapped in [false, true] {
        let mut layers = layers.clone();
        if swapped {
            layers.reverse();
        }
        let (outer, inner) = (usize::from(swapped), usize::from(!swapped));
        let iso = |opacity, volume| Isovalue { value: 0.0, color: None, opacity, volume: Some(volume) };
        let stage = stage(&layers, |scene| {
            let isovalues = vec![iso(0.4, outer), iso(1.0, inner)];
            set_mode(scene, Mode::Isosurface(Isosurface::new(isovalues)));
            (scene.image.width, scene.image.height) = (25, 25);
        });
        let frame = render(&stage);
        let found = center(&frame);
        for (found, expected) in found.into_iter().zip([0.4, 0.6, 0.0, 1.0]) {
            assert!((found - expected).abs() < 1e-5, "{found}, exact {expected}");
        }
        let depth = f64::from(frame.depth[12 * 25 + 12]);
        let eye = stage.viewpoint.ray(12.5, 12.5).origin;
        assert!((depth - (eye.length() - 6.0)).abs() < 1e-2, "{depth} from {eye}");
    }
}

#[test]
fn techniques_for_one_volume_say_so() {
    let stacked = Slicing { geometry: SliceGeometry::ObjectAligned, ..Slicing::default() };
    let stage = stage(&balls(), |scene| scene.technique = Technique::Slicing(stacked));
    let refused = CpuRenderer::new().render(&stage, &Control::default());
    assert_eq!(refused.unwrap_err(), RenderError::Volumes { found: 2, technique: "slicing" });
    assert!(!CpuRenderer::draws(&stage));
}

/// Paths of so many samples, in white light from everywhere.
fn by_paths(scene: &mut Scene, samples: u32, environment: Environment) {
    let settings = PathTrace { samples, environment, bounces: 200, roulette: 200, ..PathTrace::default() };
    scene.technique = Technique::PathTrace(settings);
    for entry in &mut scene.volumes {
        entry.scattering.phase = Phase::Isotropic;
    }
    (scene.image.width, scene.image.height) = (6, 6);
}

/// What does not take anything in white light is as bright as that light, however its matter overlaps.
#[test]
fn white_matter_in_white_light_is_not_seen() {
    let white = |opacity| transfer_function(&[(0.0, 0xffffff)], &[(0.0, 0.0), (0.2, 0.0), (0.9, opacity)]);
    let [(outer, _), (inner, _)] = balls();
    let layers = [(outer, white(0.2)), (inner, white(0.4)), (solid([5; 3], DVec3::ZERO, DVec3::ONE), homogeneous(0.3))];
    let stage = stage(&layers, |scene| {
        let environment = Environment::Constant { color: Color::WHITE, intensity: 1.0 };
        by_paths(scene, 2000, environment);
        scene.lighting.lights.clear();
    });
    let frame = render(&stage);
    let (mut mean, mut seen) = (0.0, 0);
    for (pixel, color) in frame.color.iter().enumerate() {
        // Light from behind comes through where nothing is met.
        let light = color[0] + 1.0 - color[3];
        let noise = frame.noise[pixel] + 1e-3;
        assert!((light - 1.0).abs() < 6.0 * noise, "pixel {pixel}: {light} +- {noise}");
        mean += f64::from(light) / frame.color.len() as f64;
        seen += usize::from(color[3] > 0.5);
    }
    assert!((mean - 1.0).abs() < 5e-3 && seen > 4, "{mean} in the mean, {seen} pixels are dense");
}

#[test]
fn paths_collide_with_the_sum_of_all_matter() {
    const SAMPLES: u32 = 2000;
    let opacities = [0.12, 0.3];
    let draw = |swapped: bool| {
        let mut layers = boxes(opacities);
        if swapped {
            layers.reverse();
        }
        stage(&layers, |scene| {
            by_paths(scene, SAMPLES, Environment::Dark);
            (scene.image.width, scene.image.height) = (16, 16);
        })
    };
    let (stage, swapped) = (draw(false), draw(true));
    let frame = render(&stage);
    same(&render(&swapped), &frame, "the other order");
    let (mut both, mut one) = (0, 0);
    for (pixel, color) in frame.color.iter().enumerate() {
        // Paths begin all over a pixel: its middle tells of all of them where its corners meet the same.
        let (x, y) = ((pixel % frame.width) as f64, (pixel / frame.width) as f64);
        let met = intervals(&stage, pixel);
        let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)];
        if !corners.iter().all(|(dx, dy)| intervals_at(&stage, x + dx, y + dy) == met) {
            continue;
        }
        let exact = closed_form(met, kappas(opacities), |kappa| kappa)[3];
        let error = (exact * (1.0 - exact) / f64::from(SAMPLES)).sqrt();
        let found = f64::from(color[3]);
        assert!((found - exact).abs() <= 5.0 * error, "pixel {pixel}: {found}, exact {exact} +- {error}");
        match met {
            [Some(_), Some(_)] => both += 1,
            [None, None] => {}
            _ => one += 1,
        }
    }
    assert!(both >= 4 && one >= 4, "{both} pixels see both boxes, {one} one of them");
}

/// Surfaces and paths meet all volumes, whatever rule is asked for: those of a pair that would be fused are themselves.
#[test]
fn what_heeds_no_overlap_draws_volumes_as_they_are() {
    let modes = [
        Technique::PathTrace(PathTrace { samples: 4, ..PathTrace::default() }),
        Technique::RayCast(RayCast {
            mode: Mode::Isosurface(Isosurface::new(vec![Isovalue {
                value: 0.5,
                color: None,
                opacity: 0.5,
                volume: None,
            }])),
        }),
    ];
    for technique in modes {
        let draw = |overlap| {
            render(&stage(&balls(), |scene| {
                (scene.technique, scene.overlap) = (technique.clone(), overlap);
                (scene.image.width, scene.image.height) = (8, 8);
            }))
        };
        let plain = draw(Overlap::Add);
        assert!(plain.color.iter().any(|pixel| pixel[3] > 0.1));
        same(&draw(Overlap::Fused { color: 0, opacity: 1 }), &plain, technique.name());
    }
}
