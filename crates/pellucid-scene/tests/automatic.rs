//! The look and the framing of data nobody has described.

use std::sync::Arc;

use pellucid_field::{Grid, Volume, Voxels};
use pellucid_scene::{Choice, Mode, RayCast, Scene, Source, Stage, Technique};

const N: usize = 24;

fn volume(voxels: impl Into<Voxels>) -> Volume {
    Volume::new(Grid::new([N; 3]).unwrap(), voxels).unwrap()
}

/// Voxels from their distance to the middle, in voxels.
fn by_radius<T>(value: impl Fn(f64) -> T) -> Vec<T> {
    let middle = (N - 1) as f64 / 2.0;
    let square = |k: usize| (k as f64 - middle).powi(2);
    (0..N * N * N).map(|k| value((square(k % N) + square(k / N % N) + square(k / (N * N))).sqrt())).collect()
}

fn resolve(volume: Volume, mode: Mode) -> (Stage, Vec<Choice>) {
    let mut scene = Scene::of(Source::memory());
    scene.technique = Technique::RayCast(RayCast { mode });
    scene.resolve(&[Arc::new(volume)]).unwrap()
}

fn chose<'c>(choices: &'c [Choice], setting: &str) -> &'c str {
    choices.iter().find(|choice| choice.setting == setting).map_or("", |choice| choice.chosen.as_str())
}

/// Bone in tissue in air.
fn patient() -> Volume {
    volume(by_radius(|r| {
        if r < 5.0 {
            1200i16
        } else if r < 9.0 {
            40
        } else {
            -1000
        }
    }))
}

#[test]
fn hounsfield_units_are_recognised() {
    let (stage, choices) = resolve(patient(), Mode::Composite);
    assert!(chose(&choices, "preset").starts_with("ct-bone"), "{choices:?}");
    let tf = &stage.volumes[0].transfer_function;
    assert_eq!((tf.opacity(-1000.0), tf.opacity(40.0)), (0.0, 0.0));
    assert!(tf.opacity(1200.0) > 0.5 && stage.volumes[0].material.is_some());
    let mut stated = volume(by_radius(|r| if r < 5.0 { 300.0f32 } else { 0.0 }));
    stated.value_unit = Some("HU".to_owned());
    let (_, choices) = resolve(stated, Mode::Composite);
    assert!(chose(&choices, "preset").contains("values are in HU"));
}

#[test]
fn the_window_leaves_the_background_out() {
    // Noise around 20 outside, an object of 100 to 200 inside.
    let noisy = |r: f64| if r < 8.0 { 200.0 - r * 12.0 } else { 18.0 + (r * 7919.0).fract() * 4.0 };
    let (stage, choices) = resolve(volume(by_radius(|r| noisy(r) as u8)), Mode::Composite);
    assert!(chose(&choices, "preset").starts_with("micro-ct"), "{choices:?}");
    assert!(chose(&choices, "window").contains("from the background"), "{choices:?}");
    let tf = &stage.volumes[0].transfer_function;
    assert!(tf.opacity(20.0) < 0.01 && tf.opacity(150.0) > 0.3, "{tf:?}");
}

#[test]
fn the_camera_frames_what_can_be_seen() {
    // Bone within the middle block of 8 voxels of three per axis.
    let is_bone = |k: usize| [k % N, k / N % N, k / (N * N)].iter().all(|x| (10..14).contains(x));
    let speck = || volume((0..N * N * N).map(|k| if is_bone(k) { 1200i16 } else { -1000 }).collect::<Vec<_>>());
    let away = |mode| {
        let view = resolve(speck(), mode).0.viewpoint;
        (view.eye - glam::DVec3::splat(11.5)).length()
    };
    let (bone, whole) = (away(Mode::Composite), away(Mode::Maximum));
    assert!(bone < 0.5 * whole, "{bone} {whole}");
}

/// Data that have nothing to choose from: still a look that a backend can draw.
#[test]
fn hopeless_data_have_a_look() {
    let modes = [Mode::Composite, Mode::Maximum, Mode::XRay, Mode::Additive];
    let make = || {
        let count = N * N * N;
        let mut one = vec![f32::NAN; count];
        one[5] = 3.0;
        vec![
            volume(vec![f32::NAN; count]),
            volume(vec![f32::INFINITY; count]),
            volume(one),
            volume(vec![0u8; count]),
            volume(vec![-1000i16; count]),
            volume(vec![i32::MIN; count]),
            volume(vec![1e30f32; count]),
            volume(vec![-1e-30f32; count]),
            volume(by_radius(|r| if r < 3.0 { f32::NAN } else { r as f32 })),
            volume(by_radius(|r| if r < 3.0 { 3e38f32 } else { -3e38 })),
            Volume::new(Grid::new([1; 3]).unwrap(), vec![7u16]).unwrap(),
        ]
    };
    for mode in modes {
        for (k, volume) in make().into_iter().enumerate() {
            let (stage, choices) = resolve(volume, mode.clone());
            let constant = k < 8 || k == 10;
            assert_eq!(chose(&choices, "window").contains("the only value there is"), constant, "{k} {choices:?}");
            let [low, high] = stage.volumes[0].transfer_function.hull();
            assert!(low.is_finite() && high.is_finite() && low <= high, "{k} {mode:?}");
            assert!(stage.volumes[0].unit_distance() > 0.0 && stage.step > 0.0, "{k} {mode:?}");
            let view = stage.viewpoint;
            assert!(
                view.eye.is_finite() && view.half_height > 0.0 && view.ray(3.0, 5.0).direction.is_finite(),
                "{k} {mode:?}"
            );
            assert!(
                choices.iter().all(|choice| !choice.chosen.contains("NaN") && !choice.chosen.contains("inf")),
                "{k} {choices:?}"
            );
        }
    }
}
