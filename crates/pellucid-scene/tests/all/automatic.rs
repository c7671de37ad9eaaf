//! The look and the framing of data nobody has described.

use std::sync::Arc;

use pellucid_field::{Grid, Volume, Voxels};
use pellucid_scene::{Choice, Colors, Mode, RayCast, Scene, Source, Stage, Technique, VolumeEntry};

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
            let (none, constant) = (k < 2, (2..8).contains(&k) || k == 10);
            assert_eq!(chose(&choices, "window").contains("the only value there is"), constant, "{k} {choices:?}");
            assert_eq!(chose(&choices, "window").contains("there is no value"), none, "{k} {choices:?}");
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

/// Values far from 0 that differ by little: the window and the words are as fine as the values.
#[test]
fn values_far_from_0_are_told_apart() {
    use pellucid_field::ValueMap;
    let map = |offset| ValueMap { scale: 1.0, offset };
    let ids = volume(by_radius(|r| u32::from(r < 6.0))).with_value_map(map(1_099_511_627_777.0)).unwrap();
    let times = volume(by_radius(|r| if r < 6.0 { 0.5f32 } else { 0.0 })).with_value_map(map(1e9 + 0.25)).unwrap();
    for (volume, ends) in [(ids, ["1099511627777", "1099511627778"]), (times, ["1000000000.25", "1000000000.75"])] {
        let range = volume.statistics().max - volume.statistics().min;
        let (stage, choices) = resolve(volume, Mode::Composite);
        // The look of micro-CT begins at a tenth of its window.
        let share = (window(&stage)[1] - window(&stage)[0]) / range;
        assert!((0.85..=1.0).contains(&share), "{share} {choices:?}");
        let said = format!("{} {}", chose(&choices, "preset"), chose(&choices, "window"));
        ends.iter().for_each(|end| assert!(said.contains(end), "{said}"));
    }
    // Where doubles are whole numbers, a look does not fit between two of them.
    for power in [50, 52, 53] {
        let offset = f64::from(power).exp2() + 1.0;
        let ids = volume(by_radius(|r| if r < 6.0 { 2u32 } else { 0 })).with_value_map(map(offset)).unwrap();
        let (stage, choices) = resolve(ids, Mode::Composite);
        let [low, high] = window(&stage);
        assert!(low < 0.0 && high > 2.0 && high - low < 300.0, "2^{power}: {low} to {high}, {choices:?}");
    }
}

fn window(stage: &Stage) -> [f64; 2] {
    stage.volumes[0].transfer_function.hull()
}

fn opacity(stage: &Stage, value: f64) -> f32 {
    stage.volumes[0].transfer_function.opacity(value)
}

/// A negative and a positive blob in nothing.
fn blobs(value: impl Fn(f64, usize) -> f64) -> Vec<f64> {
    let blob = |k: usize, x: f64| {
        let d = [k % N, k / N % N, k / (N * N)].map(|c| c as f64);
        ((d[0] - x).powi(2) + (d[1] - 12.0).powi(2) + (d[2] - 12.0).powi(2)).sqrt()
    };
    (0..N * N * N)
        .map(|k| {
            let (a, b) = (blob(k, 6.0), blob(k, 17.0));
            value(
                if a < 4.0 {
                    5.0 - a / 4.0
                } else if b < 4.0 {
                    -3.0 + b / 4.0
                } else {
                    0.0
                },
                k,
            )
        })
        .collect()
}

/// Noise from -1 to 1.
fn noise(k: usize) -> f64 {
    ((k as f64 + 0.5) * 0.754_877_666).fract() + ((k as f64 + 0.5) * 0.569_840_29).fract() - 1.0
}

#[test]
fn deviations_from_nothing_are_blue_and_red_and_nothing_is_nothing() {
    let as_f32 =
        |scale: f64, offset: f64| blobs(|v, _| v).into_iter().map(|v| (v * scale + offset) as f32).collect::<Vec<_>>();
    let whole = || blobs(|v, _| (v * 100.0).round()).into_iter().map(|v| v as i16).collect::<Vec<_>>();
    let masked = blobs(|v, k| if k % 3 == 0 { f64::NAN } else { v }).into_iter().map(|v| v as f32).collect::<Vec<_>>();
    for (volume, unit, neutral) in [
        (volume(as_f32(1.0, 0.0)), 1.0, 0.0),
        (volume(as_f32(1e-9, 0.0)), 1e-9, 0.0),
        (volume(as_f32(1e7, 0.0)), 1e7, 0.0),
        (volume(as_f32(1.0, 40.0)), 1.0, 40.0),
        (volume(whole()), 100.0, 0.0),
        (volume(masked), 1.0, 0.0),
    ] {
        let (stage, choices) = resolve(volume, Mode::Composite);
        assert!(chose(&choices, "preset").starts_with("simulation"), "{choices:?}");
        let at = |v: f64| neutral + v * unit;
        assert_eq!((opacity(&stage, at(0.0)), opacity(&stage, at(0.1))), (0.0, 0.0), "{choices:?}");
        assert!(opacity(&stage, at(4.0)) > 0.05 && opacity(&stage, at(-2.8)) > 0.02, "{choices:?}");
        let tf = &stage.volumes[0].transfer_function;
        let ([r, _, b], [s, _, c]) = (tf.color(at(4.5)), tf.color(at(-2.8)));
        assert!(r > 2.0 * b && c > 1.5 * s, "{choices:?}");
        // The same colour on both sides of the same size.
        let [low, high] = window(&stage);
        assert!((low + high - 2.0 * neutral).abs() < 1e-3 * (high - low), "{low} {high}");
    }
}

#[test]
fn continuous_deviations_are_such_and_noise_around_air_is_not() {
    // Vorticity: nowhere exactly 0, to both sides.
    let waves = (0..N * N * N).map(|k| ((k % N) as f32 * 0.7).sin() * ((k / N % N) as f32 * 0.5).cos() * 4.0);
    let (_, choices) = resolve(volume(waves.collect::<Vec<_>>()), Mode::Composite);
    assert!(chose(&choices, "preset").starts_with("simulation"), "{choices:?}");
    // A solid of 1 in air of 0 with noise: reconstructed attenuation.
    let noisy: Vec<f64> = by_radius(|r| if r < 7.0 { 1.0 } else { 0.0 });
    let noisy = noisy.iter().enumerate().map(|(k, v)| (v + 0.1 * noise(k)) as f32).collect::<Vec<_>>();
    let (stage, choices) = resolve(volume(noisy), Mode::Composite);
    assert!(chose(&choices, "preset").starts_with("density"), "{choices:?}");
    assert!(opacity(&stage, 1.0) > 0.08 && opacity(&stage, 0.0) < 0.01 && opacity(&stage, -0.1) == 0.0);
    // Ripples of resampling beside an edge: an eighth of it, in few voxels.
    let rippled = by_radius(|r| {
        if r < 7.0 {
            1000i16
        } else if r < 8.0 {
            -60
        } else {
            0
        }
    });
    let (_, choices) = resolve(volume(rippled), Mode::Composite);
    assert!(chose(&choices, "preset").starts_with("micro-ct"), "{choices:?}");
}

#[test]
fn a_hot_voxel_changes_nothing() {
    let clean: Vec<f64> = by_radius(|r| if r < 8.0 { 1000.0 - r * 60.0 } else { 100.0 });
    let tiny = |n: usize| {
        let grid = Grid::new([n; 3]).unwrap();
        let middle = (n - 1) as f64 / 2.0;
        let square = |k: usize| (k as f64 - middle).powi(2);
        let radius = |k: usize| (square(k % n) + square(k / n % n) + square(k / (n * n))).sqrt();
        (
            grid,
            (0..n * n * n)
                .map(|k| if radius(k) < n as f64 / 3.0 { 1000.0 - radius(k) * 50.0 } else { 100.0 })
                .collect::<Vec<f64>>(),
        )
    };
    let (small, smaller) = (tiny(12), tiny(7));
    type Make = fn(Grid, &[f64]) -> Volume;
    let types: [(Make, f64); 5] = [
        (|grid, v| Volume::new(grid, v.iter().map(|v| *v as u16).collect::<Vec<_>>()).unwrap(), 65_535.0),
        (|grid, v| Volume::new(grid, v.iter().map(|v| *v as i16).collect::<Vec<_>>()).unwrap(), 32_767.0),
        (|grid, v| Volume::new(grid, v.iter().map(|v| (*v / 8.0) as u8).collect::<Vec<_>>()).unwrap(), 2047.0),
        (|grid, v| Volume::new(grid, v.iter().map(|v| *v as f32).collect::<Vec<_>>()).unwrap(), 1e30),
        (|grid, v| Volume::new(grid, v.iter().map(|v| *v as i32).collect::<Vec<_>>()).unwrap(), 2e9),
    ];
    for (make, hot) in types {
        for (grid, values) in [(Grid::new([N; 3]).unwrap(), &clean), (small.0, &small.1), (smaller.0, &smaller.1)] {
            let mut few = vec![1, values.len() / 2];
            if values.len() > 1000 {
                few.extend([values.len() / 3, values.len() - 1]);
            }
            let clean = window(&resolve(make(grid, values), Mode::Composite).0);
            for count in 1..=few.len().min(if values.len() > 1000 { 4 } else { 1 }) {
                let mut values = values.clone();
                few[..count].iter().for_each(|k| values[*k] = hot);
                for mode in [Mode::Composite, Mode::Maximum] {
                    let (stage, choices) = resolve(make(grid, &values), mode);
                    let found = window(&stage);
                    let same = (0..2).all(|end| (found[end] - clean[end]).abs() < 0.1 * (clean[1] - clean[0]));
                    assert!(same || matches!(stage.mode(), Mode::Maximum), "{found:?}, not {clean:?}: {choices:?}");
                    assert!(found[1] < 2.0 * clean[1], "{found:?}, not {clean:?}: {choices:?}");
                }
            }
        }
    }
    // A dead one below is none the less.
    let mut dead: Vec<f32> = by_radius(|r| if r < 8.0 { 1000.0 - r as f32 * 60.0 } else { 100.0 });
    dead[7] = -3e38;
    let (stage, choices) = resolve(volume(dead), Mode::Composite);
    assert!(window(&stage)[0] >= 99.0, "{choices:?}");
}

#[test]
fn rare_and_bright_is_not_an_outlier() {
    // One voxel in a thousand, or in ten thousand, is all there is.
    for radius in [1.5, 2.5] {
        let (stage, choices) = resolve(volume(by_radius(|r| if r < radius { 3.0f32 } else { 0.0 })), Mode::Composite);
        assert!(opacity(&stage, 3.0) > 0.1 && opacity(&stage, 0.0) == 0.0, "{choices:?}");
    }
    // What is twice as bright as the rest, with everything between, is kept.
    let (stage, choices) =
        resolve(volume(by_radius(|r| if r < 9.0 { 900.0 / (r + 1.0) } else { 0.0 } as f32)), Mode::Composite);
    assert!(window(&stage)[1] > 400.0, "{choices:?}");
}

#[test]
fn ct_numbers_are_recognised_as_floats_too() {
    let patient = |k: usize, r: f64| -> f64 {
        let value = if r < 3.0 {
            1200.0
        } else if r < 9.0 {
            40.0
        } else {
            -1000.0
        };
        value + 30.0 * noise(k)
    };
    let radii: Vec<f64> = by_radius(|r| r);
    let values = || radii.iter().enumerate().map(|(k, r)| patient(k, *r));
    let float = volume(values().map(|v| v as f32).collect::<Vec<_>>());
    let (stage, choices) = resolve(float, Mode::Composite);
    assert!(chose(&choices, "preset").starts_with("ct-bone"), "{choices:?}");
    assert!(opacity(&stage, -1000.0) == 0.0 && opacity(&stage, 40.0) == 0.0 && opacity(&stage, 1200.0) > 0.8);
    // Neither deviations that reach as far, nor a field that is spread over the same range.
    let signed = blobs(|v, _| v * 220.0).into_iter().map(|v| v as f32).collect::<Vec<_>>();
    let ramp = (0..N * N * N).map(|k| -1000.0 + 2000.0 * k as f32 / (N * N * N) as f32).collect::<Vec<_>>();
    for (other, name) in [(volume(signed), "simulation"), (volume(ramp), "simulation")] {
        let (_, choices) = resolve(other, Mode::Composite);
        assert!(chose(&choices, "preset").starts_with(name), "{choices:?}");
    }
    let signed = blobs(|v, _| (v * 300.0).round()).into_iter().map(|v| v as i16).collect::<Vec<_>>();
    assert!(!chose(&resolve(volume(signed), Mode::Composite).1, "preset").starts_with("ct-bone"));
}

#[test]
fn a_bright_background_is_a_background() {
    // A dark object on white paper, and a wake in a free stream.
    let paper = by_radius(|r| if r < 8.0 { (r * 20.0) as u8 } else { 255 });
    let wake = by_radius(|r| if r < 6.0 { (r / 6.0) as f32 } else { 1.0 });
    for (volume, back, inside) in [(volume(paper), 255.0, 20.0), (volume(wake), 1.0, 0.1)] {
        let (stage, choices) = resolve(volume, Mode::Composite);
        assert!(opacity(&stage, back) == 0.0 && opacity(&stage, inside) > 0.3, "{choices:?}");
    }
}

#[test]
fn a_window_that_is_asked_for_counts_whatever_the_data_are() {
    let seen = |window: Option<[f64; 2]>, preset: Option<&str>| {
        let mut scene = Scene::of(Source::memory());
        (scene.volumes[0].window, scene.volumes[0].preset) = (window, preset.map(str::to_owned));
        let (stage, _) = scene.resolve(&[Arc::new(patient())]).unwrap();
        [500.0, 900.0, 1900.0].map(|value| opacity(&stage, value))
    };
    for preset in [None, Some("ct-bone")] {
        let [plain, moved] = [None, Some([800.0, 2000.0])].map(|window| seen(window, preset));
        assert!(plain[0] > 0.3 && moved[0] == 0.0, "{preset:?} {plain:?} {moved:?}");
        assert!(moved[1] < 0.3 && moved[2] > 0.5, "{preset:?} {moved:?}");
    }
}

/// Three components with their own ranges.
fn colors<T: Clone>(of: impl Fn(f64) -> [T; 3]) -> Vec<T> {
    by_radius(of).concat()
}

#[test]
fn colours_are_drawn_in_them_and_other_components_said() {
    let grid = || Grid::new([N; 3]).unwrap();
    let green =
        || Volume::with_components(grid(), colors(|r| if r < 7.0 { [0u8, 200, 0] } else { [0; 3] }), 3).unwrap();
    let (stage, choices) = resolve(green(), Mode::Composite);
    assert!(chose(&choices, "component").contains("3 components are drawn as colours"), "{choices:?}");
    // Opacity is by brightness: Rec. 709 gives green 0.7152.
    let drawn = &stage.volumes[0];
    assert_eq!((drawn.volume.components(), drawn.volume.value([12; 3], drawn.component)), (1, 143.0));
    assert_eq!(drawn.colors.as_ref().map(|colors| colors.components()), Some(3));
    assert!(opacity(&stage, 143.0) > 0.5 && opacity(&stage, 0.0) == 0.0, "{choices:?}");
    assert_eq!(drawn.transfer_function.color(143.0), [1.0; 3]);
    // Values have no place, and a preset or a colour map colours of its own.
    let (stage, choices) = resolve(green(), Mode::Maximum);
    assert!(stage.volumes[0].colors.is_none());
    assert!(chose(&choices, "component").contains("volumes[0].component 0 to 2"), "{choices:?}");
    for edit in [
        |entry: &mut VolumeEntry| entry.preset = Some("density".to_owned()),
        |entry: &mut VolumeEntry| entry.colormap = Some("plasma".to_owned()),
        |entry: &mut VolumeEntry| entry.component = Some(1),
        |entry: &mut VolumeEntry| entry.colors = Some(Colors::TransferFunction),
    ] {
        let mut scene = Scene::of(Source::memory());
        edit(&mut scene.volumes[0]);
        assert!(scene.resolve(&[Arc::new(green())]).unwrap().0.volumes[0].colors.is_none());
    }
    // Asked for where they cannot be drawn, they leave the look as it is.
    let mut scene = Scene::of(Source::memory());
    scene.technique = Technique::RayCast(RayCast { mode: Mode::Maximum });
    let plain = scene.resolve(&[Arc::new(green())]).unwrap().0;
    scene.volumes[0].colors = Some(Colors::Data);
    let asked = scene.resolve(&[Arc::new(green())]).unwrap().0;
    assert!(asked.volumes[0].colors.is_none());
    assert_eq!(asked.volumes[0].transfer_function, plain.volumes[0].transfer_function);
    // An alpha that varies is the opacity; one that does not tells nothing.
    let rgba = |outside: u16| {
        let voxels = by_radius(|r| [0u16, 20_000, 0, if r < 7.0 { 32_768 } else { outside }]).concat();
        resolve(Volume::with_components(grid(), voxels, 4).unwrap(), Mode::Composite).0
    };
    let (cut, whole) = (rgba(0), rgba(32_768));
    assert_eq!((cut.volumes[0].component, cut.volumes[0].volume.value([12; 3], 0)), (0, 32_768.0));
    assert!((opacity(&cut, 32_768.0) - 0.5).abs() < 1e-4);
    assert_eq!((whole.volumes[0].component, whole.volumes[0].volume.value([12; 3], 0)), (0, 7152.0));
    // Vectors are no colours.
    let vectors = || colors(|r| if r < 7.0 { [1.0f32, 1e6, -1e6] } else { [0.0; 3] });
    let vectors = || Volume::with_components(grid(), vectors(), 3).unwrap();
    let (stage, choices) = resolve(vectors(), Mode::Composite);
    assert!(chose(&choices, "component").contains("3 components, only number 0 is drawn"), "{choices:?}");
    assert_eq!(window(&stage), [0.0, 1.0]);
    let mut scene = Scene::of(Source::memory());
    scene.volumes[0].colors = Some(Colors::Data);
    let refused = scene.resolve(&[Arc::new(vectors())]).unwrap_err().to_string();
    assert!(refused.contains("volumes[0].colors") && refused.contains("3 x f32"), "{refused}");
}

#[test]
fn each_component_has_a_window_and_a_preset_of_its_own() {
    let grid = || Grid::new([N; 3]).unwrap();
    let values = || colors(|r| if r < 7.0 { [7.0f32, -1000.0, 5e5] } else { [1.0, 1000.0, 0.0] });
    for (component, expected) in [(0, [1.0, 7.0]), (2, [0.0, 5e5])] {
        let mut scene = Scene::of(Source::memory());
        scene.volumes[0].component = Some(component);
        let volume = Volume::with_components(grid(), values(), 3).unwrap();
        let (stage, choices) = scene.resolve(&[Arc::new(volume)]).unwrap();
        assert_eq!(window(&stage), expected, "{choices:?}");
        assert!(chose(&choices, "component").is_empty() && chose(&choices, "preset").starts_with("density"));
    }
}

#[test]
fn a_minimum_of_a_background_is_said_to_be_one() {
    let (_, choices) = resolve(patient(), Mode::Minimum);
    assert!(chose(&choices, "background").contains("-1000") && chose(&choices, "background").contains("crop"));
    let (_, choices) = resolve(volume(by_radius(|r| r as f32)), Mode::Minimum);
    assert!(chose(&choices, "background").is_empty(), "{choices:?}");
}

/// What a settled scene draws is what was drawn, whatever the automatic choices are.
#[test]
fn a_settled_scene_draws_the_same_and_leaves_nothing_to_choose() {
    let views = [Mode::Composite, Mode::Maximum, Mode::XRay, Mode::Slice(pellucid_scene::Slice::default())];
    let data = || {
        let signed = blobs(|v, _| v).into_iter().map(|v| v as f32).collect::<Vec<_>>();
        let paper = by_radius(|r| if r < 8.0 { (r * 20.0) as u8 } else { 255 });
        [patient(), volume(signed), volume(paper), volume(by_radius(|r| r as f32))]
    };
    for mode in views {
        for (k, volume) in data().into_iter().enumerate() {
            for orthographic in [false, true] {
                let volumes = [Arc::new(volume.clone())];
                let mut scene = Scene::of(Source::memory());
                scene.technique = Technique::RayCast(RayCast { mode: mode.clone() });
                if orthographic {
                    scene.camera.projection = pellucid_scene::Projection::Orthographic { height: None };
                }
                let (stage, _) = scene.resolve(&volumes).unwrap();
                let settled = scene.settled(&volumes).unwrap();
                let (again, choices) = settled.resolve(&volumes).unwrap();
                assert_eq!(again.viewpoint, stage.viewpoint, "{k} {mode:?}");
                assert_eq!(again.volumes[0].transfer_function, stage.volumes[0].transfer_function, "{k} {mode:?}");
                assert_eq!(again.volumes[0].material, stage.volumes[0].material);
                assert!(choices.is_empty(), "{k} {mode:?} {choices:?}");
                // It is a document.
                let text = settled.to_text(pellucid_scene::Format::Toml).unwrap();
                assert_eq!(Scene::parse(&text, pellucid_scene::Format::Toml).unwrap(), settled);
            }
        }
    }
    // Beside a transfer function in full, names and windows have no effect.
    let mut scene = Scene::of(Source::memory());
    let volumes = [Arc::new(patient())];
    scene.volumes[0].transfer_function = Some(scene.resolve(&volumes).unwrap().0.volumes[0].transfer_function.clone());
    scene.volumes[0].window = Some([0.0, 1.0]);
    scene.volumes[0].colormap = Some("gray".to_owned());
    let settled = scene.settled(&volumes).unwrap();
    assert_eq!((settled.volumes[0].window, &settled.volumes[0].colormap), (None, &None));
}

#[test]
fn an_environment_is_light_enough() {
    use pellucid_optics::{Environment, Light, LightKind, Lighting};
    let mut scene = Scene::of(Source::memory());
    let paths = |environment| Technique::PathTrace(pellucid_scene::PathTrace { environment, ..Default::default() });
    let white = Environment::Constant { color: pellucid_optics::Color::WHITE, intensity: 1.0 };
    let volumes = [Arc::new(patient())];
    let lights = |scene: &Scene| scene.resolve(&volumes).unwrap().0.lights.len();
    scene.technique = paths(Environment::Dark);
    assert_eq!(lights(&scene), 1);
    scene.technique = paths(white);
    assert_eq!((lights(&scene), scene.settled(&volumes).unwrap().lighting.lights.len()), (0, 0));
    let (mut stage, choices) = scene.resolve(&volumes).unwrap();
    assert!(chose(&choices, "lights").contains("environment"));
    stage.look_from(stage.viewpoint.turntable(10.0), &scene.lighting).unwrap();
    assert!(stage.lights.is_empty());
    // A light of the scene's own stays.
    let lamp = Light::new(LightKind::Directional { direction: [0.0, 0.0, -1.0] });
    scene.lighting = Lighting { lights: vec![lamp], ..Lighting::default() };
    assert_eq!(lights(&scene), 1);
}
