//! Several volumes in one picture: held to closed forms, and to the CPU backend.

mod half_angle;

use std::sync::Arc;

use crate::common::{LEVEL, difference, draw, gpu, sample};
use glam::{DAffine3, DQuat, DVec3};
use pellucid_cpu::CpuRenderer;
use pellucid_field::{Grid, Volume, VoxelType};
use pellucid_gpu::{Ceiling, GpuError, GpuRenderer, Passes};
use pellucid_scene::{Control, Format, Frame, Scene, Stage};

/// A stage of volumes, each with a part of the document; `rest` is of all.
pub fn layered(layers: &[(Arc<Volume>, &str)], rest: &str, size: [u32; 2]) -> Stage {
    let entries: String = layers.iter().map(|(_, own)| format!("[[volumes]]\nsource = \"memory\"\n{own}\n")).collect();
    // Keys of no table come first.
    let (keys, tables) = rest.split_once('|').unwrap_or(("", rest));
    let document = format!("{keys}\n{entries}{tables}");
    let mut scene = Scene::parse(&document, Format::Toml).unwrap_or_else(|error| panic!("{error} in {document}"));
    [scene.image.width, scene.image.height] = size;
    let volumes: Vec<_> = layers.iter().map(|(volume, _)| volume.clone()).collect();
    scene.resolve(&volumes).unwrap().0
}

/// A box of one value, with a corner and the distances between its voxels.
pub fn solid(dims: [usize; 3], corner: [f64; 3], spacing: [f64; 3]) -> Arc<Volume> {
    let affine = DAffine3::from_translation(corner.into()) * DAffine3::from_scale(spacing.into());
    let grid = Grid::with_affine(dims, affine).unwrap();
    Arc::new(Volume::new(grid, vec![1.0f32; grid.len()]).unwrap())
}

/// The same voxels, elsewhere.
pub fn placed(volume: &Volume, affine: DAffine3) -> Arc<Volume> {
    let grid = *volume.grid();
    let grid = Grid::with_affine(grid.dims(), affine * grid.world_from_index()).unwrap();
    Arc::new(volume.clone().with_grid(grid).unwrap())
}

#[test]
fn extinctions_of_boxes_add() {
    let red = "shading = false\nunit_distance = 1\n[volumes.transfer_function]\ncolors = [[0, \"#ff0000\"]]\nopacities = [[0, 0.12]]";
    let green = "shading = false\nunit_distance = 1\n[volumes.transfer_function]\ncolors = [[0, \"#00ff00\"]]\nopacities = [[0, 0.3]]";
    let layers =
        [(solid([9; 3], [0.0; 3], [1.0; 3]), red), (solid([5, 7, 6], [2.2, 4.37, 1.9], [1.3, 0.91, 0.83]), green)];
    let camera = "[camera]\nprojection.orthographic = {}\nview.orbit = { azimuth = 0, elevation = 0 }\n";
    let kappas = [0.12f64, 0.3].map(|opacity| -(1.0 - opacity).ln());
    let (before, within, behind) = (4.37, 8.0 - 4.37, 4.37 + 6.0 * 0.91 - 8.0);
    let mut renderer = gpu(&Ceiling::default());
    for quality in [
        "step = 0.3",
        "jitter.blue_noise.seed = 3",
        "step = 3.7\nclassification = \"pre\"",
        "step = 3.7\nclassification = \"pre_integrated\"",
        "step = 0.7\n[technique.slicing]",
        "jitter.blue_noise.seed = 3\n[technique.slicing]\norder = \"back_to_front\"\nsamples = 3",
        "step = 3.7\nclassification = \"pre\"\n[technique.slicing]\ngeometry = \"shells\"",
        "step = 3.7\nclassification = \"pre_integrated\"\n[technique.slicing]\ncorrection = \"per_frame\"",
    ] {
        for swapped in [false, true] {
            let mut layers = layers.clone();
            if swapped {
                layers.reverse();
            }
            let rest = format!("[quality]\nearly_termination = 1\n{quality}\n{camera}");
            let stage = layered(&layers, &rest, [24, 24]);
            // Through the middle of both.
            let frame = draw(&mut renderer, &stage);
            let both = frame.color.iter().find(|pixel| pixel[0] > 0.1 && pixel[1] > 0.1).expect("both are seen");
            let [first, second] = kappas;
            let mut color = [0.0; 4];
            for (tau, length) in [([first, 0.0], before), ([first, second], within), ([0.0, second], behind)] {
                let total = tau[0] + tau[1];
                let alpha = -(-total * length).exp_m1();
                let through = 1.0 - color[3];
                color[0] += through * alpha * tau[0] / total;
                color[1] += through * alpha * tau[1] / total;
                color[3] += through * alpha;
            }
            for channel in 0..4 {
                let apart = (f64::from(both[channel]) - color[channel]).abs();
                assert!(apart < 2e-5, "{quality}: {both:?}, exact {color:?}");
            }
        }
    }
}

/// Two volumes on grids that are turned and spaced otherwise, of other voxel types.
pub fn turned() -> [Arc<Volume>; 2] {
    let ball = sample("ball", [20, 24, 22], VoxelType::F32);
    let wavelet = sample("wavelet", [18, 16, 20], VoxelType::U8);
    let turn = |axis: DVec3, angle: f64, scale: f64, to: [f64; 3]| {
        DAffine3::from_scale_rotation_translation(DVec3::splat(scale), DQuat::from_axis_angle(axis, angle), to.into())
    };
    [placed(&ball, turn(DVec3::Z, 0.4, 8.0, [0.0; 3])), placed(&wavelet, turn(DVec3::X, 0.9, 0.7, [1.0, -1.5, 2.0]))]
}

pub const BALL: &str = "unit_distance = 1\n[volumes.transfer_function]\ncolors = [[0, \"#3050e0\"], [1, \"#e0a020\"]]\n\
    opacities = [[0.3, 0], [0.7, 0.2]]";
pub const WAVES: &str = "unit_distance = 1\n[volumes.transfer_function]\ncolors = [[80, \"#30e050\"], [260, \"#e04020\"]]\n\
    opacities = [[90, 0], [140, 0.1], [170, 0.0], [190, 0.25], [270, 0.9]]";
const LIGHTS: &str = "lights = [{ kind.directional.direction = [0.8, 0.4, -0.5] }, \
    { kind.point = { position = [-20, -15, 18], falloff = \"none\" }, intensity = 0.5 }]\n";

pub fn by_cpu(stage: &Stage) -> Frame {
    CpuRenderer::default().render(stage, &Control::default()).unwrap()
}

#[test]
fn layers_are_those_of_the_cpu() {
    let unlit = "shading = false\n";
    let rays = format!("[lighting]\nshadows.rays = {{}}\n{LIGHTS}");
    let lights = format!("[lighting]\n{LIGHTS}");
    let volumes = format!("[lighting]\nshadows.volume.resolution = 0.8\n{LIGHTS}");
    let clouds = format!("[lighting]\nmodel = \"scattering\"\nshadows.volume = {{}}\n{LIGHTS}");
    let cases = [
        ("", unlit, String::new()),
        ("", unlit, "[quality]\nstep = 0.4\nempty_space_skipping = false\n".to_owned()),
        ("", unlit, "[quality]\nsupersampling = 2\njitter.blue_noise.seed = 3\n".to_owned()),
        ("", unlit, "[quality]\nclassification = \"pre\"\n".to_owned()),
        ("", unlit, "[quality]\nclassification = \"pre_integrated\"\nstep = 1.5\n".to_owned()),
        ("overlap = \"maximum\"", unlit, String::new()),
        ("overlap = \"priority\"", unlit, String::new()),
        ("overlap.fused = { color = 1, opacity = 0 }", unlit, String::new()),
        ("", "shading = true\n", lights.clone()),
        ("", "shading = true\ngradient_weight = { low = 0.1, high = 4.0 }\n", lights),
        ("", "shading = true\n", rays.clone()),
        ("", "shading = true\n", volumes.clone()),
        ("overlap = \"maximum\"", "shading = true\n", volumes.clone()),
        ("overlap = \"priority\"", "shading = true\n", volumes),
        ("", unlit, clouds.clone()),
        ("overlap.fused = { color = 1, opacity = 0 }", unlit, clouds),
        ("", unlit, "[quality]\nfilter = { bc = { b = 0.3, c = 0.3 } }\n".to_owned()),
        ("", unlit, "[[clips]]\nplane = { point = [1, 0, 0], normal = [0.6, 0.2, -0.7] }\n".to_owned()),
    ];
    compare(&mut gpu(&Ceiling::default()), &cases);
}

/// Draws cases of the two volumes: keys of the whole document, of each volume, and its tables.
fn compare(renderer: &mut GpuRenderer, cases: &[(&str, &str, String)]) {
    let [ball, waves] = turned();
    let mut seen = 0;
    for (keys, each, rest) in cases {
        let (first, second) = (format!("{each}{BALL}"), format!("{each}{WAVES}"));
        let layers = [(ball.clone(), &*first), (waves.clone(), &*second)];
        let stage = layered(&layers, &format!("{keys}|{rest}"), [40, 36]);
        let (expected, found) = (by_cpu(&stage), draw(renderer, &stage));
        let pairs = expected.color.as_flattened().iter().zip(found.color.as_flattened());
        let far = pairs.filter(|(a, b)| (*a - *b).abs() > LEVEL).count();
        let apart = difference(&expected, &found);
        assert!(far <= 4 && apart < 0.05, "{keys} {each} {rest}: {far} farther than a level, {apart}");
        let off = |(a, b): (&f32, &f32)| a.is_finite() != b.is_finite() || (a - b).abs() > 0.1 * a.min(*b);
        let deep = expected.depth.iter().zip(&found.depth).filter(|pair| off(*pair)).count();
        assert!(deep <= 4, "{keys} {each} {rest}: {deep} depths differ");
        seen += expected.color.iter().filter(|pixel| pixel.iter().any(|c| *c > 0.02)).count();
    }
    assert!(seen > 80 * cases.len(), "{cases:?}: only {seen} pixels show anything");
}

#[test]
fn projections_are_those_of_the_cpu() {
    let unlit = "shading = false\n";
    let mut renderer = gpu(&Ceiling::default());
    for mode in ["\"maximum\"", "\"minimum\"", "\"average\"", "\"additive\"", "\"x_ray\"", "{ slice = {} }"] {
        let rules =
            ["", "overlap = \"maximum\"", "overlap = \"priority\"", "overlap.fused = { color = 1, opacity = 0 }"];
        let cases = rules.map(|keys| (keys, unlit, format!("[technique.ray_cast]\nmode = {mode}\n")));
        // The smallest values are those outside the ball, where nothing is seen of it.
        compare(&mut renderer, if mode.contains("minimum") { &cases[..2] } else { &cases });
    }
    let mut cases = Vec::new();
    let rest = "[technique.ray_cast]\nmode = \"maximum\"\n[quality]\n";
    cases.push(("", unlit, format!("{rest}supersampling = 2\njitter.blue_noise.seed = 3\n")));
    cases.push(("", unlit, format!("{rest}filter = {{ bc = {{ b = 0.3, c = 0.3 }} }}\n")));
    cases.push(("", unlit, format!("{rest}empty_space_skipping = false\n")));
    let slab = "{ slice = { normal = [0.3, 0.2, 1], thickness = 4, combine = \"average\" } }";
    cases.push(("", unlit, format!("[technique.ray_cast]\nmode = {slab}\n")));
    compare(&mut renderer, &cases);
    compare(&mut gpu(&Ceiling::default()).with_passes(Passes::Wavefront), &cases[..1]);
}

/// Voxels with colours and an opacity of their own, alone and among others, in every light that composites them.
#[test]
fn colored_voxels_are_those_of_the_cpu() {
    let [ball, _] = turned();
    let dims = [11, 9, 10];
    let voxel = |k: usize| [k * 37 % 256, k * 91 % 128, k / 11 * 53 % 256, k * 17 % 90].map(|channel| channel as u8);
    let voxels: Vec<u8> = (0..dims.iter().product()).flat_map(voxel).collect();
    let affine = DAffine3::from_axis_angle(DVec3::Y, 0.5) * DAffine3::from_scale(DVec3::new(0.9, 1.2, 1.0));
    let colors = Arc::new(Volume::with_components(Grid::with_affine(dims, affine).unwrap(), voxels, 4).unwrap());
    let half_angle = format!("[technique.half_angle]\nresolution = 48\n[lighting]\n{LIGHTS}");
    let mut renderer = gpu(&Ceiling::default());
    for (own, rest) in [
        ("", String::new()),
        ("", "[quality]\nclassification = \"pre\"\n".to_owned()),
        ("", "[quality]\nclassification = \"pre_integrated\"\nstep = 1.5\n".to_owned()),
        ("shading = true\n", format!("[lighting]\nshadows.rays = {{}}\n{LIGHTS}")),
        ("perturbation.optics = { color = 0.5, opacity = 0.4 }\n", String::new()),
        ("", half_angle),
    ] {
        let one = [(colors.clone(), own)];
        let two = [one[0].clone(), (ball.clone(), BALL)];
        for layers in [&one[..], &two] {
            let stage = layered(layers, &rest, [40, 36]);
            assert!(stage.volumes[0].colors.is_some());
            let (expected, found) = (by_cpu(&stage), draw(&mut renderer, &stage));
            let pairs = || expected.color.as_flattened().iter().zip(found.color.as_flattened());
            let far = pairs().filter(|(a, b)| (*a - *b).abs() > LEVEL).count();
            assert!(far <= 4, "{own} {rest}: {far} of {} farther than a level", layers.len());
            let [r, g] = [0, 1].map(|channel| expected.color.iter().map(|pixel| pixel[channel]).sum::<f32>());
            assert!(r > 20.0 && (r - g).abs() > 1.0, "{own} {rest}: {r} and {g}");
        }
    }
}

#[test]
fn surfaces_are_those_of_the_cpu() {
    let unlit = "shading = false\n";
    let surfaces = |opacities: [f64; 2]| {
        let [first, second] = opacities;
        format!(
            "[technique.ray_cast.mode.isosurface]\nisovalues = [{{ value = 0.5, color = \"#e0c080\", opacity = {first}, \
             volume = 0 }}, {{ value = 0.7, opacity = 0.4, volume = 0 }}, {{ value = 190, opacity = {second}, volume = 1 }}, \
             {{ value = 120, opacity = 0.3, volume = 1 }}]\n"
        )
    };
    let (glass, solid) = (surfaces([0.3, 0.4]), surfaces([1.0, 1.0]));
    let (lights, rays) = (format!("[lighting]\n{LIGHTS}"), format!("[lighting]\nshadows.rays = {{}}\n{LIGHTS}"));
    let cases = [
        ("", unlit, glass.clone()),
        ("", unlit, solid.clone()),
        ("", unlit, format!("{glass}[quality]\nstep = 0.4\nempty_space_skipping = false\n")),
        ("", unlit, format!("{glass}[quality]\nsupersampling = 2\njitter.blue_noise.seed = 3\n")),
        ("", unlit, format!("{glass}[quality]\nfilter = {{ bc = {{ b = 0.3, c = 0.3 }} }}\n")),
        ("", unlit, format!("{glass}[quality]\nfilter = \"nearest\"\n")),
        ("", "shading = true\n", format!("{glass}{lights}")),
        ("", "shading = true\n", format!("{solid}{rays}")),
    ];
    compare(&mut gpu(&Ceiling::default()), &cases);
    compare(&mut gpu(&Ceiling::default()).with_passes(Passes::Wavefront), &cases[..2]);
}

#[test]
fn any_number_of_volumes_is_projected() {
    let [_, waves] = turned();
    let layers: Vec<_> = (0..12)
        .map(|k| (placed(&waves, DAffine3::from_translation(DVec3::new(f64::from(k), 0.0, 0.0))), WAVES))
        .collect();
    let stage = layered(&layers, "[technique.ray_cast]\nmode = \"x_ray\"\n", [24, 20]);
    let mut renderer = gpu(&Ceiling { guaranteed: true, ..Ceiling::default() });
    let (expected, found) = (by_cpu(&stage), draw(&mut renderer, &stage));
    assert!(difference(&expected, &found) < 0.01);
    assert!(expected.color.iter().filter(|pixel| pixel[3] > 0.2).count() > 100);
}

#[test]
fn neither_the_order_of_the_list_nor_turns_change_a_bit() {
    let [ball, waves] = turned();
    let third = solid([4, 5, 6], [-1.0, -9.0, -2.0], [1.7, 2.3, 1.1]);
    let haze = "unit_distance = 1\n[volumes.transfer_function]\ncolors = [[0, \"#ffffff\"]]\nopacities = [[0, 0.02]]";
    let layers = [(ball, BALL), (waves, WAVES), (third, haze)];
    let lit = format!("[lighting]\nshadows.rays = {{}}\n{LIGHTS}");
    let surfaces = "[technique.ray_cast.mode.isosurface]\nisovalues = [{ value = 0.6, opacity = 0.4 }, \
        { value = 130, opacity = 0.3 }, { value = 180, opacity = 0.5 }]\n";
    let (mut renderer, mut turns) = (gpu(&Ceiling::default()), gpu(&Ceiling::default()).with_passes(Passes::Wavefront));
    let volumes = format!("[lighting]\nshadows.volume = {{}}\n{LIGHTS}");
    for rest in [lit, volumes, surfaces.to_owned(), "[technique.ray_cast]\nmode = \"x_ray\"\n".to_owned()] {
        let bits = |renderer: &mut GpuRenderer, layers: &[(Arc<Volume>, &str)]| {
            let frame = draw(renderer, &layered(layers, &rest, [24, 20]));
            let numbers = [frame.color.as_flattened(), &frame.depth, frame.normal.as_flattened()].concat();
            numbers.iter().map(|number| number.to_bits()).collect::<Vec<_>>()
        };
        let first = bits(&mut renderer, &layers);
        let [a, b, c] = layers.clone();
        assert!(bits(&mut renderer, &[c, a, b]) == first, "the order changes the picture of {rest}");
        assert!(bits(&mut turns, &layers) == first, "turns change the picture of {rest}");
    }
}

#[test]
fn lights_that_are_faces_are_lacking_for_several_volumes_too() {
    let [ball, waves] = turned();
    let face = "lights = [{ kind.rectangle = { center = [-6, -9, 12], edges = [[0, 24, 0], [16, 0, 12]] } }]\n";
    let surfaces = "[technique.ray_cast.mode.isosurface]\nisovalues = [{ value = 0.6 }]\n";
    let lacks = |technique: &str, lights: &str| {
        let layers = [(ball.clone(), BALL), (waves.clone(), WAVES)];
        GpuRenderer::lacks(&layered(&layers, &format!("{technique}[lighting]\n{lights}"), [8, 8]))
    };
    for technique in ["", surfaces, "[technique.half_angle]\n"] {
        let told = lacks(technique, face);
        assert!(told.as_ref().is_some_and(|what| what.contains("rectangle")), "{technique}: {told:?}");
        assert_eq!(lacks(technique, LIGHTS), None, "{technique}");
    }
}

#[test]
fn more_volumes_than_a_pass_takes_are_counted() {
    let haze = "unit_distance = 1\n[volumes.transfer_function]\ncolors = [[0, \"#ffffff\"]]\nopacities = [[0, 0.02]]";
    let layers: Vec<_> = (0..9).map(|k| (solid([3; 3], [f64::from(k), 0.0, 0.0], [1.0; 3]), haze)).collect();
    let mut renderer = gpu(&Ceiling { guaranteed: true, ..Ceiling::default() });
    let refused = renderer.render(&layered(&layers, "", [8, 8]), &Control::default()).unwrap_err();
    let GpuError::Volumes { found: 9, most } = refused else { panic!("{refused}") };
    assert!((1..9).contains(&most), "{refused}");
    draw(&mut renderer, &layered(&layers[..most], "", [8, 8]));
}
