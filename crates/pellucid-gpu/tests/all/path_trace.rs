//! Paths of light bring what those of the CPU backend bring, but for their noise, and what closed forms say.

use std::sync::Arc;

use crate::common::{device, draw, gpu, sample, stage};
use pellucid_cpu::CpuRenderer;
use pellucid_field::{Grid, Volume, VoxelType};
use pellucid_gpu::{Ceiling, GpuError, GpuRenderer};
use pellucid_optics::{Color, ColorSpace, Environment, SkyImage, SkyMap, SkySource, luminance};
use pellucid_scene::{Cancel, Control, Frame, Stage, Technique, denoise};

const SIZE: [u32; 2] = [24, 20];

fn clouds(scattering: &str, rest: &str) -> Stage {
    let volume = sample("wavelet", [20, 20, 20], VoxelType::F32);
    let document = format!(
        "shading = false\nunit_distance = 2.0\n[volumes.transfer_function]\n\
         colors = [[80, \"#8090ff\"], [160, \"#f0e0c0\"], [260, \"#ffa080\"]]\n\
         opacities = [[90, 0], [140, 0.1], [170, 0.0], [190, 0.3], [270, 0.9]]\n\
         [volumes.scattering]\n{scattering}\n{rest}"
    );
    stage(&volume, &document, SIZE)
}

/// Whether both backends draw a stage alike, but for noise.
pub fn agree(stage: &Stage, what: &str) -> [Frame; 2] {
    let (expected, found) = (of_cpu(stage), draw(&mut gpu(&Ceiling::default()), stage));
    let (squares, mean) = scores(&expected, &found);
    // Of some 300 pixels, four standard errors of a mean of squares; tails are heavier than normal ones.
    assert!((0.6..1.5).contains(&squares) && mean.abs() < 4.0, "{what}: {squares}, {mean}");
    [expected, found]
}

pub fn of_cpu(stage: &Stage) -> Frame {
    CpuRenderer::default().render(stage, &Control::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// Differences over their standard errors, squared: their mean over pixels, which is about 1 for the same picture,
/// and the difference of the pictures' mean brightness over its own.
pub fn scores(a: &Frame, b: &Frame) -> (f64, f64) {
    let brightness = |frame: &Frame, k: usize| f64::from(luminance([0, 1, 2].map(|c| frame.color[k][c])));
    let (mut squares, mut count, mut difference, mut variance) = (0.0, 0, 0.0, 0.0);
    for k in 0..a.color.len() {
        let error = f64::from(a.noise[k]).powi(2) + f64::from(b.noise[k]).powi(2);
        if error == 0.0 {
            continue;
        }
        let d = brightness(a, k) - brightness(b, k);
        squares += d * d / error;
        count += 1;
        difference += d;
        variance += error;
    }
    assert!(count > 100, "only {count} pixels with anything in them");
    (squares / f64::from(count), difference / variance.sqrt())
}

#[test]
fn pictures_are_those_of_the_cpu_but_for_noise() {
    let sun = "[[lighting.lights]]\nkind.directional.direction = [0.6, 0.7, -0.4]\n";
    let lamp =
        "[[lighting.lights]]\nkind.point = { position = [-20, -15, 18], falloff.inverse_square.reference = 30 }\n";
    let sky = "environment.gradient = { top = \"#a0c0ff\", bottom = \"#403020\" }";
    let cases = [
        ("phase = \"isotropic\"", format!("{sun}[technique.path_trace]\nsamples = 256\n")),
        ("phase.henyey_greenstein.g = 0.7", format!("{sun}{lamp}[technique.path_trace]\nsamples = 256\n{sky}\n")),
        (
            "phase.schlick.g = 0.4\nanisotropy.values = [[80, 0.8], [200, -0.5]]\nalbedo.constant = 0.8",
            format!("{lamp}[technique.path_trace]\nsamples = 256\nmajorants = \"global\"\n{sky}\n"),
        ),
        (
            "phase.table.values = [[1, 2, 3], [0.1, 0.5, 0.2], [2, 1, 0.5]]\nphase_normalization = \"renormalised\"",
            format!("{sun}[technique.path_trace]\nsamples = 256\nbounces = 3\n{sky}\n"),
        ),
        (
            "phase.hybrid = { g = 0.6, back.values = [[0, 0, 0], [0.1, 0.2, 0.4]] }",
            format!(
                "{lamp}[technique.path_trace]\nsamples = 256\nroulette = 1\n{sky}\n[camera]\nprojection.orthographic = {{}}\n"
            ),
        ),
        (
            "phase.double_henyey_greenstein = { first = 0.8, second = -0.4, share = 0.7 }",
            format!(
                "{sun}[technique.path_trace]\nsamples = 256\naperture = 1.5\n{sky}\n\
                 [[clips]]\nplane = {{ point = [1, 0, 0], normal = [0.6, 0.2, -0.7] }}\n"
            ),
        ),
        (
            "albedo.constant = 0.9",
            format!(
                "[volumes.perturbation.displacement]\namplitude = 0.1\noctaves = [{{ frequency = 0.3 }}]\n\
                 [volumes.perturbation.optics]\nopacity = 0.8\ncolor = 0.6\n\
                 {sun}[technique.path_trace]\nsamples = 256\n{sky}\n"
            ),
        ),
        (
            "phase.henyey_greenstein.g = 0.5\nextinction_color = \"#ff9040\"",
            format!("{sun}{lamp}[technique.path_trace]\nsamples = 256\n{sky}\n"),
        ),
    ];
    for (scattering, rest) in cases {
        let [_, found] = agree(&clouds(scattering, &rest), scattering);
        assert!(found.statistics.rays > 0 && found.statistics.rays.is_multiple_of(256), "{scattering}");
    }
}

/// Lights that are found by choice and by chance: where the phase function is narrow, mostly by chance.
#[test]
fn lights_with_a_size_shine_as_on_the_cpu() {
    let sun = "radius = 25\nkind.directional.direction = [0.6, 0.7, -0.4]\n";
    let half = "radius = 90\nkind.directional.direction = [0.6, 0.7, -0.4]\n";
    let small = "radius = 0.001\nkind.directional.direction = [0.6, 0.7, -0.4]\n";
    // In the volume itself, where nothing hides behind it.
    let ball = "radius = 3\nkind.point = { position = [2, -1, 3], falloff.inverse_square.reference = 15 }\n";
    let spot = "radius = 6\nkind.spot = { position = [-15, -12, 14], direction = [1, 0.8, -1], inner_angle = 10, \
                outer_angle = 30, falloff.inverse_square.reference = 25 }\n";
    let face = |two_sided: bool| {
        format!(
            "kind.rectangle = {{ center = [-6, -9, 12], edges = [[0, 24, 0], [16, 0, 12]], two_sided = {two_sided}, \
             falloff.inverse_square.reference = 15 }}\n"
        )
    };
    let (front, both, unmet) = (face(false), face(true), format!("specular = false\n{ball}"));
    let cases: [&[&str]; 8] =
        [&[sun], &[half], &[small], &[ball], &[spot], &[&front], &[&both, sun], &[&unmet, &front, ball]];
    for (number, lights) in cases.into_iter().enumerate() {
        let lights: String = lights.iter().map(|light| format!("[[lighting.lights]]\n{light}")).collect();
        for g in [0.0, 0.8] {
            let phase = format!("phase.henyey_greenstein.g = {g}");
            agree(
                &clouds(&phase, &format!("{lights}[technique.path_trace]\nsamples = 128\n")),
                &format!("{number}, {g}"),
            );
        }
    }
}

/// A picture of the sky in place of a stage's own.
fn under(mut stage: Stage, map: SkyMap) -> Stage {
    let Technique::PathTrace(settings) = &mut stage.technique else { panic!("no paths") };
    let source = SkySource::File("memory".into());
    settings.environment =
        Environment::Image(SkyImage { source, rotation: -70.0, intensity: 1.5, map: Some(Arc::new(map)) });
    stage
}

/// A dim sky in which one texel is a lamp.
fn lamp(width: usize, height: usize) -> SkyMap {
    let texel = |k: usize| if k == width + 2 { [200.0, 160.0, 90.0] } else { [0.1, 0.2, 0.1 * (k % 5) as f32] };
    SkyMap::new(width, height, (0..width * height).map(texel).collect()).unwrap()
}

#[test]
fn a_picture_of_the_sky_shines_as_on_the_cpu() {
    let path = "[technique.path_trace]\nsamples = 128\n";
    let none = "[lighting]\nlights = []\n";
    let sun = "[[lighting.lights]]\nradius = 20\nkind.directional.direction = [0.6, 0.7, -0.4]\n";
    for g in [0.0, 0.8] {
        let phase = format!("phase.henyey_greenstein.g = {g}");
        for lights in [none, sun] {
            let day =
                format!("{lights}{path}environment.image = {{ source = \"day\", rotation = 130, intensity = 0.7 }}\n");
            agree(&clouds(&phase, &day), &format!("day, {g}, {lights}"));
        }
        agree(&under(clouds(&phase, &format!("{none}{path}")), lamp(9, 4)), &format!("a lamp, {g}"));
    }
}

#[test]
fn skies_follow_one_another() {
    let settings = "[technique.path_trace]\nsamples = 16\n";
    let plain = || clouds("", settings);
    let gradient = "environment.gradient = { top = \"#a0c0ff\", bottom = \"#403020\" }\n";
    let stages = [
        under(plain(), lamp(9, 4)),
        under(plain(), lamp(16, 8)),
        clouds("", &format!("{settings}{gradient}")),
        under(plain(), lamp(9, 4)),
        plain(),
    ];
    let mut renderer = gpu(&Ceiling::default());
    for stage in &stages {
        assert_eq!(draw(&mut renderer, stage).color, draw(&mut gpu(&Ceiling::default()), stage).color);
    }
    // The memory of a picture counts, and so does how large a texture can be.
    let little = gpu(&Ceiling { memory: Some(4 << 20), ..Ceiling::default() });
    let mut device = device(&Ceiling::default());
    // Of 512 x 512 texels, 16 bytes each.
    device.capabilities.limits.max_texture_dimension_2d = 512;
    for (mut renderer, allowed) in [(little, 4 << 20), (GpuRenderer::on(device), 512 * 512 * 16)] {
        draw(&mut renderer, &stages[0]);
        let error = renderer.render(&under(plain(), lamp(1024, 512)), &Control::default()).unwrap_err();
        let is_told = matches!(error, GpuError::Budget { needed, budget, .. } if needed > 8 << 20 && budget == allowed);
        assert!(is_told, "{error}");
    }
}

#[test]
fn surfaces_reflect_as_on_the_cpu() {
    let volume = sample("ball", [24, 24, 24], VoxelType::F32);
    let document = "shading = true\nmaterial = { diffuse = 0.7, specular = 0.5, shininess = 20, emission = 0.05 }\n\
         [volumes.transfer_function]\ncolors = [[0, \"#ffc080\"]]\n\
         opacities = [[0.4, 0], [0.6, 0.95]]\nunit_distance = 0.1\n\
         [volumes.scattering.surface]\ngradient = { low = 0.1, high = 0.8 }\n\
         [[lighting.lights]]\nkind.directional.direction = [0.6, 0.7, -0.4]\n\
         [technique.path_trace]\nsamples = 400\nenvironment.constant.color = \"#808080\"\n";
    let [expected, found] = agree(&stage(&volume, document, [48, 40]), "a ball");
    // Both say where half of the light has collided.
    let near = expected.depth.iter().zip(&found.depth).filter(|(a, b)| (*a - *b).abs() < 0.1).count();
    let both = expected.depth.iter().zip(&found.depth).filter(|(a, b)| a.is_finite() && b.is_finite()).count();
    assert!(both > 100 && near * 10 > both * 9, "{near} of {both}");
    // And how what is there faces: where the ball is opaque at once, they look at the same place.
    let facing = |k: usize| (0..3).map(|c| expected.normal[k][c] * found.normal[k][c]).sum::<f32>();
    let solid: Vec<usize> = (0..found.color.len()).filter(|k| found.color[*k][3] > 0.99).collect();
    let alike = solid.iter().filter(|k| facing(**k) > 0.99).count();
    assert!(solid.len() > 100 && alike * 50 > solid.len() * 49, "{alike} of {}", solid.len());
    assert!((0..found.color.len()).all(|k| found.depth[k].is_finite() || found.normal[k] == [0.0; 3]));
    // Highlights of lights with a size are found by chance; and surfaces in front of their matter, where that is thin
    // and where it is so thick that a voxel is the most.
    let sun = "kind.directional.direction = [0.6, 0.7, -0.4]\n";
    for (instead, surface_depth) in
        [(format!("{sun}radius = 15\n"), 0.0), (sun.to_owned(), 0.5), (sun.to_owned(), 50.0)]
    {
        let document = format!("{}surface_depth = {surface_depth:.1}\n", document.replace(sun, &instead));
        agree(&stage(&volume, &document, [36, 30]), &document);
    }
}

/// Noise is taken out as on the CPU: by the same denoiser, from the depths and normals of this backend.
#[test]
fn noise_goes_as_on_the_cpu() {
    let volume = sample("ball", [24, 24, 24], VoxelType::F32);
    let document = |settings: &str| {
        format!(
            "shading = true\n[volumes.transfer_function]\ncolors = [[0, \"#ffc080\"]]\n\
             opacities = [[0.4, 0], [0.6, 0.95]]\nunit_distance = 0.1\n\
             [volumes.scattering.surface]\ngradient = {{ low = 0.1, high = 0.8 }}\n\
             [[lighting.lights]]\nkind.directional.direction = [0.6, 0.7, -0.4]\nradius = 20\n\
             [technique.path_trace]\nenvironment.constant.color = \"#808080\"\n{settings}\n"
        )
    };
    let stage = |settings: &str| stage(&volume, &document(settings), [48, 40]);
    let truth = of_cpu(&stage("samples = 1024"));
    let mut renderer = gpu(&Ceiling::default());
    let noisy = draw(&mut renderer, &stage("samples = 16"));
    let smooth = draw(&mut renderer, &stage("samples = 16\ndenoise = true"));
    let mut expected = noisy.clone();
    denoise(&mut expected, 16, &Control::default()).unwrap();
    assert_eq!(smooth.color, expected.color);
    assert_eq!((&smooth.normal, &smooth.noise), (&noisy.normal, &noisy.noise));
    let rmse = |frame: &Frame| {
        let pairs = frame.color.iter().flatten().zip(truth.color.iter().flatten());
        pairs.map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>().sqrt()
    };
    let of_the_cpu = of_cpu(&stage("samples = 16\ndenoise = true"));
    assert!(rmse(&smooth) * 1.3 < rmse(&noisy), "{} to {}", rmse(&noisy), rmse(&smooth));
    assert!(rmse(&smooth) < 1.2 * rmse(&of_the_cpu), "{}, not {}", rmse(&smooth), rmse(&of_the_cpu));
}

/// A white medium in a white sky is not seen: what collides brings as much light as what does not.
#[test]
fn a_furnace_is_white() {
    let white = "albedo.constant = 1.0\nphase.henyey_greenstein.g = 0.5";
    let stage = clouds(
        white,
        "[lighting]\nlights = []\n[technique.path_trace]\nsamples = 200\nenvironment.constant.color = \"#ffffff\"\n",
    );
    let found = draw(&mut gpu(&Ceiling::default()), &stage);
    let (mut difference, mut variance) = (0.0, 0.0);
    for (color, noise) in found.color.iter().zip(&found.noise) {
        difference += f64::from(luminance([color[0], color[1], color[2]]) - color[3]);
        variance += f64::from(*noise).powi(2);
    }
    assert!(found.color.iter().any(|color| color[3] > 0.7));
    assert!(difference.abs() < 4.0 * variance.sqrt().max(1e-3), "{difference} with {}", variance.sqrt());
}

/// A slab that absorbs lets `exp(-extinction length)` through.
#[test]
fn what_collides_is_what_beers_law_says() {
    let grid = Grid::new([9, 5, 9]).unwrap();
    let volume = Arc::new(Volume::new(grid, vec![1.0f32; 9 * 5 * 9]).unwrap());
    let document = "[volumes.transfer_function]\ncolors = [[0, \"#ffffff\"]]\nopacities = [[0, 0.3], [2, 0.3]]\n\
         unit_distance = 1.0\n[volumes.scattering.albedo]\nconstant = 0.0\n[camera]\nprojection.orthographic = {}\n\
         view.orbit = { azimuth = 0, elevation = 0 }\n[technique.path_trace]\nsamples = 500\n";
    let found = draw(&mut gpu(&Ceiling::default()), &stage(&volume, document, [16, 16]));
    let opacities: Vec<f64> = found.color.iter().map(|color| f64::from(color[3])).filter(|a| *a > 0.0).collect();
    let inner: Vec<f64> = opacities.iter().copied().filter(|a| *a > 0.6).collect();
    let mean = inner.iter().sum::<f64>() / inner.len() as f64;
    let expected = 1.0 - 0.7f64.powi(4);
    let error = (expected * (1.0 - expected) / (500.0 * inner.len() as f64)).sqrt();
    assert!(inner.len() > 50 && (mean - expected).abs() < 4.0 * error, "{mean}, not {expected} within {error}");
}

/// The same where colours have extinctions of their own (K-13): what is left is their mean.
#[test]
fn colors_collide_by_extinctions_of_their_own() {
    let grid = Grid::new([9, 5, 9]).unwrap();
    let volume = Arc::new(Volume::new(grid, vec![1.0f32; 9 * 5 * 9]).unwrap());
    let document = "[volumes.transfer_function]\ncolors = [[0, \"#ffffff\"]]\nopacities = [[0, 0.6], [2, 0.6]]\n\
         unit_distance = 1.0\n[volumes.scattering]\nalbedo.constant = 0.0\nextinction_color = \"#ffc090\"\n\
         [camera]\nprojection.orthographic = {}\nview.orbit = { azimuth = 0, elevation = 0 }\n\
         [quality]\nstep = 0.1\n[technique.path_trace]\nsamples = 500\n";
    let stage = stage(&volume, document, [16, 16]);
    let found = draw(&mut gpu(&Ceiling::default()), &stage);
    let factors = Color::hex(0xffc090).to_linear(ColorSpace::Srgb);
    let left = |depth: f64| factors.iter().map(|factor| 0.4f64.powf(depth * f64::from(*factor))).sum::<f64>() / 3.0;
    let inner: Vec<usize> = (0..found.color.len()).filter(|k| found.color[*k][3] > 0.6).collect();
    let mean = inner.iter().map(|k| f64::from(found.color[*k][3])).sum::<f64>() / inner.len() as f64;
    let expected = 1.0 - left(4.0);
    let error = (expected * (1.0 - expected) / (500.0 * inner.len() as f64)).sqrt();
    assert!(inner.len() > 50 && (mean - expected).abs() < 4.0 * error, "{mean}, not {expected} within {error}");
    // Half of it is lost within a step of the depth.
    let entry = -stage.viewpoint.eye.y;
    for k in inner {
        let depth = f64::from(found.depth[k]) - entry;
        assert!(left(depth - stage.step) > 0.5 && left(depth + stage.step) < 0.5, "{depth}: {}", left(depth));
    }
}

#[test]
fn paths_end_at_the_noise_asked_for_or_when_told_to() {
    let sun = "[[lighting.lights]]\nkind.directional.direction = [0.6, 0.7, -0.4]\n";
    let stage = clouds("", &format!("{sun}[technique.path_trace]\nsamples = 4000\nnoise = 0.2\n"));
    let mut renderer = gpu(&Ceiling::default());
    let found = draw(&mut renderer, &stage);
    let brightness = |color: &[f32; 4]| luminance([color[0], color[1], color[2]]).max(1e-3);
    let done = found.color.iter().zip(&found.noise).filter(|(color, noise)| **noise <= 0.2 * brightness(color));
    assert!(done.count() * 100 >= found.color.len() * 99);
    assert!(found.statistics.rays < 4000 * u64::from(SIZE[0] * SIZE[1]) / 4, "{}", found.statistics.rays);
    // The same seed draws the same picture.
    assert_eq!(draw(&mut renderer, &stage).color, found.color);
    let cancel = Cancel::default();
    cancel.cancel();
    let stopped = renderer.render(&stage, &Control { cancel: Some(&cancel), ..Control::default() });
    assert_eq!(stopped.unwrap_err(), GpuError::Cancelled);
}
