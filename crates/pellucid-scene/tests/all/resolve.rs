//! From a document and its volumes to a stage: what wins, what is chosen, what is refused.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec3};
use pellucid_field::{Grid, ValueMap, Volume};
use pellucid_optics::Frame;
use pellucid_optics::*;
use pellucid_scene::*;
use proptest::prelude::*;

/// 8 x 8 x 8 voxels with the values 0 to 511 times `scale`, on a grid of spacing 1, 2 and 3.
fn ramp(scale: f32) -> Arc<Volume> {
    let grid = Grid::with_spacing([8; 3], [1.0, 2.0, 3.0], [0.0; 3]).unwrap();
    Arc::new(Volume::new(grid, (0..512).map(|k| k as f32 * scale).collect::<Vec<_>>()).unwrap())
}

fn scene(entry: VolumeEntry) -> Scene {
    Scene { volumes: vec![entry], ..Scene::default() }
}

fn entry() -> VolumeEntry {
    VolumeEntry::new(Source::memory())
}

fn resolved(scene: &Scene) -> (Stage, Vec<Choice>) {
    scene.resolve(&[ramp(1.0)]).unwrap()
}

fn optics(entry: VolumeEntry) -> (StageVolume, Vec<Choice>) {
    let (mut stage, choices) = resolved(&scene(entry));
    (stage.volumes.remove(0), choices)
}

fn name(name: &str) -> Option<String> {
    Some(name.to_owned())
}

fn chose<'c>(choices: &'c [Choice], setting: &str) -> Option<&'c str> {
    choices.iter().find(|choice| choice.setting == setting).map(|choice| choice.chosen.as_str())
}

fn own() -> TransferFunction {
    let color = ColorPoint::new(3.0, Color::WHITE);
    TransferFunction::new(vec![color], vec![OpacityPoint::new(1.0, 0.25), OpacityPoint::new(2.0, 0.5)]).unwrap()
}

const WINDOW: [f64; 2] = [100.0, 300.0];

#[test]
fn a_transfer_function_wins_over_everything() {
    let all = VolumeEntry {
        transfer_function: Some(own()),
        preset: name("ct-bone"),
        colormap: name("viridis"),
        opacity: name("linear"),
        window: Some(WINDOW),
        ..entry()
    };
    let (volume, choices) = optics(all);
    let tf = &volume.transfer_function;
    assert_eq!((tf.colors(), tf.opacities()), (own().colors(), own().opacities()));
    // The preset still says how it is shaded.
    assert_eq!(volume.material, Some(Preset::by_name("ct-bone").unwrap().material));
    assert!(chose(&choices, "preset").is_none() && chose(&choices, "window").is_none());
}

#[test]
fn colour_map_and_opacity_shape_win_over_the_preset_part_by_part() {
    let viridis = ColorMap::by_name("viridis").unwrap().points(WINDOW).unwrap();
    let sigmoid = opacity_shape("sigmoid_5", WINDOW).unwrap();
    let preset = Preset::by_name("mr-default").unwrap().transfer_function(WINDOW).unwrap();
    let bone = Preset::by_name("ct-bone").unwrap().transfer_function(WINDOW).unwrap();
    let moved = Preset::by_name("ct-bone").unwrap().transfer_function([0.0, 1.0]).unwrap();
    let moved = moved.clone().remap(moved.hull(), WINDOW).unwrap();
    let gray = ColorMap::by_name("gray").unwrap().points(WINDOW).unwrap();
    let linear = opacity_shape("linear", WINDOW).unwrap();
    let cases = [
        (Some("mr-default"), Some("viridis"), Some("sigmoid_5"), &viridis[..], &sigmoid[..]),
        (Some("mr-default"), Some("viridis"), None, &viridis, preset.opacities()),
        (Some("mr-default"), None, Some("sigmoid_5"), preset.colors(), &sigmoid),
        (Some("mr-default"), None, None, preset.colors(), preset.opacities()),
        (Some("ct-bone"), Some("viridis"), None, &viridis, bone.opacities()),
        // Hounsfield units have values of their own, and are moved to a window that is asked for.
        (Some("ct-bone"), None, None, moved.colors(), moved.opacities()),
        (None, Some("viridis"), None, &viridis, &linear),
        (None, None, Some("sigmoid_5"), &gray, &sigmoid),
        (None, Some("viridis"), Some("sigmoid_5"), &viridis, &sigmoid),
    ];
    for (preset, colormap, opacity, colors, opacities) in cases {
        let [p, c, o] = [preset, colormap, opacity].map(|name| name.map(str::to_owned));
        let (volume, choices) =
            optics(VolumeEntry { preset: p, colormap: c, opacity: o, window: Some(WINDOW), ..entry() });
        let tf = &volume.transfer_function;
        assert_eq!(tf.colors(), colors, "{preset:?} {colormap:?} {opacity:?}");
        assert_eq!(tf.opacities(), opacities, "{preset:?} {colormap:?} {opacity:?}");
        assert!(chose(&choices, "preset").is_none() && chose(&choices, "window").is_none());
    }
}

#[test]
fn values_are_shown_in_gray_where_a_mode_shows_values() {
    for mode in [Mode::Maximum, Mode::Minimum, Mode::Average, Mode::Slice(Slice::default())] {
        let mut scene = scene(VolumeEntry { window: Some(WINDOW), ..entry() });
        scene.technique = Technique::RayCast(RayCast { mode });
        let (stage, _) = resolved(&scene);
        let tf = &stage.volumes[0].transfer_function;
        assert_eq!(tf.colors(), ColorMap::by_name("gray").unwrap().points(WINDOW).unwrap());
        assert_eq!((tf.opacity(0.0), tf.opacity(1e3)), (1.0, 1.0));
        assert_eq!(stage.volumes[0].material, None);
    }
}

#[test]
fn a_gradient_weight_is_spread_over_the_same_window_as_its_preset() {
    let with = |transfer_function| VolumeEntry { transfer_function, preset: name("mr-angiography"), ..entry() };
    let ((plain, _), (replaced, choices)) = (optics(with(None)), optics(with(Some(own()))));
    assert_eq!(plain.gradient_weight, replaced.gradient_weight);
    assert!(chose(&choices, "window").is_some());
    // 0.02 to 0.1 windows per mean spacing of 2; the window is near the range, 0 to 511.
    let high = plain.gradient_weight.unwrap().high;
    assert!((20.0..27.0).contains(&high), "{high}");
    let own = GradientWeight { low: 1.0, high: 2.0 };
    let (volume, _) = optics(VolumeEntry { gradient_weight: Some(own), ..with(None) });
    assert_eq!(volume.gradient_weight, Some(own));
}

#[test]
fn shading_and_material() {
    let bone = Preset::by_name("ct-bone").unwrap().material;
    let mine = Material { diffuse: 0.123, ..Material::default() };
    let lit = |preset: Option<&str>, shading, material| {
        optics(VolumeEntry { preset: preset.map(str::to_owned), shading, material, colormap: name("gray"), ..entry() })
            .0
            .material
    };
    assert_eq!(lit(Some("ct-bone"), None, None), Some(bone));
    assert_eq!(lit(Some("ct-bone"), None, Some(mine)), Some(mine));
    assert_eq!(lit(Some("ct-bone"), Some(false), Some(mine)), None);
    assert_eq!(lit(Some("simulation"), None, None), None);
    assert_eq!(lit(Some("simulation"), Some(true), None), Some(Material::default()));
    assert_eq!(lit(None, None, None), None);
    assert_eq!(lit(None, None, Some(mine)), Some(mine));
    assert_eq!(lit(None, Some(true), None), Some(Material::default()));
    // A surface without shading would be a silhouette.
    let mut surface = scene(VolumeEntry { colormap: name("gray"), ..entry() });
    let isovalues = vec![Isovalue { value: 9.0, color: None, opacity: 1.0, volume: None }];
    surface.technique = Technique::RayCast(RayCast { mode: Mode::Isosurface(Isosurface::new(isovalues)) });
    assert_eq!(resolved(&surface).0.volumes[0].material, Some(Material::default()));
}

#[test]
fn unit_distance() {
    let with =
        |preset: Option<&str>, unit| VolumeEntry { preset: preset.map(str::to_owned), unit_distance: unit, ..entry() };
    // The mean of 1, 2 and 3, and said so.
    let (volume, choices) = optics(with(Some("micro-ct"), None));
    assert_eq!(volume.unit_distance(), 2.0);
    assert!(chose(&choices, "unit distance").unwrap().contains("hold for 2 world units (the mean voxel spacing)"));
    // A preset in HU has its own; the entry's wins.
    let (volume, choices) = optics(with(Some("ct-bone"), None));
    assert_eq!((volume.unit_distance(), chose(&choices, "unit distance")), (1.0, None));
    assert_eq!(optics(with(Some("ct-bone"), Some(7.0))).0.unit_distance(), 7.0);
    let own = own().with_unit_distance(Some(5.0)).unwrap();
    let full = VolumeEntry { transfer_function: Some(own), ..entry() };
    assert_eq!(optics(full.clone()).0.unit_distance(), 5.0);
    assert_eq!(optics(VolumeEntry { unit_distance: Some(6.0), ..full }).0.unit_distance(), 6.0);
    // Half the longest side, 3 * 7, of what a radiograph looks through.
    let mut radiograph = scene(entry());
    radiograph.technique = Technique::RayCast(RayCast { mode: Mode::XRay });
    assert_eq!(resolved(&radiograph).0.volumes[0].unit_distance(), 10.5);
    // In the unit the volume states.
    let mut volume = (*ramp(1.0)).clone();
    volume.length_unit = name("mm");
    let (_, choices) = scene(entry()).resolve(&[Arc::new(volume)]).unwrap();
    assert!(chose(&choices, "unit distance").unwrap().contains(" mm "));
}

#[test]
fn misfits_are_refused_with_what_was_found_and_what_there_is() {
    let refused = |entry: VolumeEntry| scene(entry).resolve(&[ramp(1.0)]).unwrap_err().to_string();
    let component = scene(VolumeEntry { component: Some(1), ..entry() }).resolve(&[ramp(1.0)]).unwrap_err();
    assert_eq!(component, ResolveError::Component { volume: 0, found: 1, components: 1 });
    assert!(component.to_string().contains("volumes[0].component is 1"));
    for (entry, key, known) in [
        (VolumeEntry { preset: name("ct-bones"), ..entry() }, "volumes[0].preset", "ct-lung"),
        (VolumeEntry { colormap: name("virdis"), ..entry() }, "volumes[0].colormap", "viridis"),
        (VolumeEntry { opacity: name("ramp"), ..entry() }, "volumes[0].opacity", "sigmoid_5"),
    ] {
        let message = refused(entry);
        assert!(message.contains(key) && message.contains("known are") && message.contains(known), "{message}");
    }
    assert!(refused(VolumeEntry { window: Some([3.0, 2.0]), ..entry() }).contains("volumes[0].window"));
    assert!(refused(VolumeEntry { window: Some([f64::NAN, 2.0]), ..entry() }).contains("volumes[0].window"));
    for (listed, loaded) in [(0, 0), (1, 0), (0, 1), (1, 2), (2, 1)] {
        let scene = Scene { volumes: vec![entry(); listed], ..Scene::default() };
        let error = scene.resolve(&vec![ramp(1.0); loaded]).unwrap_err();
        assert_eq!(error, ResolveError::Volumes { listed, loaded });
    }
}

/// A rotated, mirrored and sheared grid.
fn skewed(dims: [usize; 3]) -> Grid {
    let turn = DMat3::from_quat(DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7));
    let shear = DMat3::from_cols(DVec3::X, DVec3::new(0.3, 1.0, 0.0), DVec3::new(0.0, -0.2, 1.0));
    let scale = DMat3::from_diagonal(DVec3::new(-0.5, 2.0, 3.0));
    Grid::with_affine(dims, DAffine3 { matrix3: turn * shear * scale, translation: DVec3::new(10.0, -20.0, 5.0) })
        .unwrap()
}

#[test]
fn another_spacing_keeps_axes_and_origin() {
    let volume = Volume::new(skewed([8; 3]), vec![0u8; 512]).unwrap();
    let (old, wanted) = (*volume.grid(), [4.0, 0.25, 1.5]);
    let scene = scene(VolumeEntry { spacing: Some(wanted), ..entry() });
    let (stage, _) = scene.resolve(&[Arc::new(volume)]).unwrap();
    let new = stage.volumes[0].volume.grid();
    assert_eq!(new.world_from_index().translation, old.world_from_index().translation);
    for axis in 0..3 {
        assert!((new.spacing()[axis] - wanted[axis]).abs() < 1e-12);
        let (a, b) = (old.world_from_index().matrix3.col(axis), new.world_from_index().matrix3.col(axis));
        assert!((a.normalize() - b.normalize()).length() < 1e-12);
    }
    assert!((stage.step - 0.5 * 0.25).abs() < 1e-12);
    assert!((stage.volumes[0].unit_distance() - 5.75 / 3.0).abs() < 1e-12);
}

#[test]
fn isovalues_ascend_and_the_step_is_in_world_units() {
    let value = |value| Isovalue { value, color: None, opacity: 1.0, volume: None };
    let isovalues = vec![value(30.0), value(-10.0), value(20.0)];
    let mut scene = scene(entry());
    scene.technique = Technique::RayCast(RayCast { mode: Mode::Isosurface(Isosurface::new(isovalues)) });
    scene.quality.step = 0.25;
    let (stage, _) = resolved(&scene);
    let Technique::RayCast(RayCast { mode: Mode::Isosurface(surfaces) }) = &stage.technique else { panic!() };
    assert_eq!(surfaces.isovalues.iter().map(|iso| iso.value).collect::<Vec<_>>(), [-10.0, 20.0, 30.0]);
    assert_eq!(stage.step, 0.25);
}

#[test]
fn a_headlight_follows_the_camera_and_a_lamp_does_not() {
    let lamp = Light::new(LightKind::Directional { direction: [0.0, 0.0, -1.0] });
    for azimuth in [0.0, 40.0, 200.0] {
        let mut scene = scene(entry());
        scene.camera.view = View::Orbit(Orbit { azimuth, elevation: 30.0, roll: 10.0, ..Orbit::default() });
        scene.lighting.lights.push(lamp);
        let (stage, _) = resolved(&scene);
        let towards = |k: usize| stage.lights[k].incident(glam::Vec3::ZERO).to_light.as_dvec3();
        assert!((towards(0) + stage.viewpoint.forward).length() < 1e-6);
        assert!((towards(1) - DVec3::Z).length() < 1e-6);
        assert_eq!(stage.ambient, 0.3);
    }
    // A lamp at the camera's side: 2 to the right, 3 up, 5 ahead.
    let mut scene = scene(entry());
    let kind = LightKind::Point { position: [2.0, 3.0, -5.0], falloff: Falloff::None };
    scene.lighting.lights = vec![Light { frame: Frame::Camera, ..Light::new(kind) }];
    let (stage, _) = resolved(&scene);
    let view = stage.viewpoint;
    let lamp = view.eye + view.right * 2.0 + view.up * 3.0 + view.forward * 5.0;
    let to_light = stage.lights[0].incident(glam::Vec3::ZERO).to_light.as_dvec3();
    assert!((to_light - lamp.normalize()).length() < 1e-5);
}

#[test]
fn looking_from_elsewhere_is_resolving_with_another_camera() {
    let mut scene = scene(entry());
    scene.lighting.lights.push(Light::new(LightKind::Directional { direction: [0.0, 0.0, -1.0] }));
    let (mut stage, _) = resolved(&scene);
    let mut elsewhere = scene.clone();
    elsewhere.camera.view = View::LookAt(LookAt { position: [9.0; 3], target: [0.0; 3], up: [0.0, 0.0, 1.0] });
    let (expected, _) = resolved(&elsewhere);
    assert_ne!(stage.lights[0], expected.lights[0], "the headlight moves");
    stage.look_from(expected.viewpoint, &scene.lighting).unwrap();
    assert_eq!((stage.viewpoint, &stage.lights), (expected.viewpoint, &expected.lights));
}

#[test]
fn the_camera_chosen_is_said_and_a_given_one_is_not() {
    let (_, choices) = resolved(&scene(entry()));
    assert!(chose(&choices, "camera").unwrap().contains("azimuth 30 and elevation 20 degrees"));
    let choice = choices.iter().find(|choice| choice.setting == "camera").unwrap();
    assert!(choice.to_string().starts_with("camera: azimuth"));
    let mut given = scene(entry());
    given.camera.view = View::LookAt(LookAt { position: [9.0; 3], target: [0.0; 3], up: [0.0, 0.0, 1.0] });
    assert!(chose(&resolved(&given).1, "camera").is_none());
}

#[test]
fn windows_are_in_data_values() {
    // Stored 0 to 511 mean -1000 to 21: the same look as for a volume that stores the values.
    let mapped = (*ramp(1.0)).clone().with_value_map(ValueMap { scale: 2.0, offset: -1000.0 }).unwrap();
    let values: Vec<f32> = (0..512).map(|k| k as f32 * 2.0 - 1000.0).collect();
    let stored = Volume::new(*mapped.grid(), values).unwrap();
    let [mapped, stored] = [mapped, stored].map(|volume| {
        let (stage, _) =
            scene(VolumeEntry { colormap: name("viridis"), ..entry() }).resolve(&[Arc::new(volume)]).unwrap();
        stage.volumes[0].transfer_function.hull()
    });
    assert!((0..2).all(|k| (mapped[k] - stored[k]).abs() < 1.0), "{mapped:?} {stored:?}");
}

proptest! {
    #[test]
    fn a_crop_keeps_exactly_its_indices(
        from in [-1.0f64..4.0, -1.0f64..4.0, -1.0f64..4.0],
        size in [0.1f64..4.0, 0.1f64..4.0, 0.1f64..4.0],
        p in [-2.0f64..9.0, -2.0f64..9.0, -2.0f64..9.0],
    ) {
        let to: [f64; 3] = std::array::from_fn(|axis| from[axis] + size[axis]);
        let volume = Arc::new(Volume::new(skewed([8; 3]), vec![7u8; 512]).unwrap());
        let scene = scene(VolumeEntry { crop: Some(Crop { from, to }), preset: name("ct-bone"), ..entry() });
        let (stage, _) = scene.resolve(std::slice::from_ref(&volume)).unwrap();
        let inside = stage.volumes[0].region.contains(volume.grid().world_from_index().transform_point3(DVec3::from_array(p)));
        let near = (0..3).any(|axis| (p[axis] - from[axis]).abs() < 1e-9 || (p[axis] - to[axis]).abs() < 1e-9);
        prop_assert!(near || inside == (0..3).all(|axis| from[axis] <= p[axis] && p[axis] <= to[axis]));
    }
}

/// Labels beyond 2^24 that are close to each other are drawn as differences, and so is all that speaks of values;
/// those too far apart are warned of.
#[test]
fn large_integers_count_from_the_smallest() {
    let grid = || Grid::new([4, 2, 2]).unwrap();
    let labels = |values: [u32; 2]| (0..16).map(|k| values[k % 2]).collect::<Vec<u32>>();
    let tf = |at: [f64; 2]| {
        let colors = vec![ColorPoint::new(at[0], Color::BLACK), ColorPoint::new(at[1], Color::WHITE)];
        TransferFunction::new(colors, vec![OpacityPoint::new(at[0], 1.0)]).unwrap()
    };
    let draw = |volume: Volume, at: [f64; 2]| {
        let mut scene = scene(VolumeEntry { transfer_function: Some(tf(at)), ..entry() });
        let isovalues = vec![Isovalue { value: at[1], color: None, opacity: 1.0, volume: None }];
        scene.technique = Technique::RayCast(RayCast { mode: Mode::Isosurface(Isosurface::new(isovalues)) });
        scene.resolve(&[Arc::new(volume)]).unwrap()
    };
    let large = [4_000_000_001u32, 4_000_000_003];
    let ids = large.map(f64::from);
    let wide = |offset: f64| ValueMap { scale: 1.0, offset };
    for (volume, at) in [
        (Volume::new(grid(), labels(large)).unwrap(), ids),
        (Volume::new(grid(), labels([1, 3])).unwrap().with_value_map(wide(1e15)).unwrap(), [1e15 + 1.0, 1e15 + 3.0]),
        (
            Volume::new(grid(), (0..16).map(|k| [-7i16, -5][k % 2]).collect::<Vec<i16>>())
                .unwrap()
                .with_value_map(wide(-1e9))
                .unwrap(),
            [-1e9 - 7.0, -1e9 - 5.0],
        ),
        (
            Volume::new(grid(), (0..16).map(|k| [0.5f32, 2.5][k % 2]).collect::<Vec<f32>>())
                .unwrap()
                .with_value_map(wide(1e12))
                .unwrap(),
            [1e12 + 0.5, 1e12 + 2.5],
        ),
    ] {
        let (stage, choices) = draw(volume, at);
        let drawn = &stage.volumes[0];
        assert_eq!(drawn.origin, at[0]);
        let values = [0, 1].map(|x| drawn.volume.value([x, 0, 0], 0));
        assert_eq!(values, [0.0, 2.0]);
        assert_eq!(drawn.transfer_function.hull(), [0.0, 2.0]);
        let Mode::Isosurface(surfaces) = stage.mode() else { panic!() };
        assert_eq!(surfaces.isovalues[0].value, 2.0);
        assert!(chose(&choices, "values").is_some_and(|chosen| chosen.contains(&at[0].to_string())), "{choices:?}");
        assert_eq!(stage.fallbacks().count(), 0);
    }
    // Small ones are as they are, and far ones are told of with their numbers.
    let (stage, choices) = draw(Volume::new(grid(), labels([1, 1 << 24])).unwrap(), [1.0, 2.0]);
    assert_eq!((stage.volumes[0].origin, chose(&choices, "values"), stage.fallbacks().count()), (0.0, None, 0));
    let (stage, _) = draw(Volume::new(grid(), labels([1, 4_000_000_003])).unwrap(), [1.0, 2.0]);
    let warning = stage.fallbacks().next().unwrap().to_string();
    assert!(warning.contains("4000000003") && warning.contains("from 256 on"), "{warning}");
}
