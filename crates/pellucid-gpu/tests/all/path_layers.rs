//! Paths of light through several volumes bring what closed forms say, and what those of the CPU backend bring.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::common::{draw, gpu, sample, with_holes};
use crate::layers::{layered, placed, solid, turned};
use crate::path_trace::{agree, scores};
use glam::{DAffine3, DQuat, DVec3};
use pellucid_field::{Volume, VoxelType};
use pellucid_gpu::{Ceiling, GpuError, Interpolation};
use pellucid_optics::luminance;
use pellucid_scene::{Control, Frame, Stage};

const SIZE: [u32; 2] = [24, 20];

const SUN: &str = "[[lighting.lights]]\nkind.directional.direction = [0.6, 0.7, -0.4]\n";
const LAMP: &str =
    "[[lighting.lights]]\nkind.point = { position = [-20, -15, 18], falloff.inverse_square.reference = 30 }\n";
const DARK: &str = "[lighting]\nlights = []\n";
const SKY: &str = "environment.gradient = { top = \"#a0c0ff\", bottom = \"#403020\" }\n";

/// What a ball looks like that scatters so.
fn ball(scattering: &str) -> String {
    format!(
        "shading = false\nunit_distance = 1\n[volumes.transfer_function]\n\
         colors = [[0, \"#3050e0\"], [1, \"#e0a020\"]]\nopacities = [[0.3, 0], [0.7, 0.3]]\n\
         [volumes.scattering]\n{scattering}\n"
    )
}

/// What waves look like that scatter so.
fn waves(scattering: &str) -> String {
    format!(
        "shading = false\nunit_distance = 1\n[volumes.transfer_function]\n\
         colors = [[80, \"#8090ff\"], [160, \"#f0e0c0\"], [260, \"#ffa080\"]]\n\
         opacities = [[90, 0], [140, 0.1], [170, 0.0], [190, 0.25], [270, 0.9]]\n[volumes.scattering]\n{scattering}\n"
    )
}

/// What a box of one opacity per world unit looks like that scatters so.
fn haze(opacity: f64, scattering: &str) -> String {
    format!(
        "shading = false\nunit_distance = 1\n[volumes.transfer_function]\ncolors = [[0, \"#ffffff\"]]\n\
         opacities = [[0, {opacity:.3}]]\n[volumes.scattering]\n{scattering}\n"
    )
}

/// A part of the document on paths.
fn paths(samples: u32, settings: &str) -> String {
    format!("[technique.path_trace]\nsamples = {samples}\n{settings}")
}

#[test]
fn two_volumes_are_those_of_the_cpu_but_for_noise() {
    let [first, second] = turned();
    let green = "extinction_color = \"#40ff90\"";
    let noisy = "[volumes.perturbation.displacement]\namplitude = 0.1\noctaves = [{ frequency = 0.3 }]\n\
                 [volumes.perturbation.optics]\nopacity = 0.8\ncolor = 0.6\n";
    let disc = "[[lighting.lights]]\nradius = 25\nkind.directional.direction = [0.6, 0.7, -0.4]\n";
    let inside = "[[lighting.lights]]\nradius = 1\n\
                  kind.point = { position = [2, -1, 3], falloff.inverse_square.reference = 15 }\n";
    let cases = [
        ("phase = \"isotropic\"", "albedo.constant = 0.9", format!("{SUN}{}", paths(64, ""))),
        (
            "phase.henyey_greenstein.g = 0.7",
            "phase.schlick.g = 0.4\nanisotropy.values = [[80, 0.8], [200, -0.5]]\nalbedo.constant = 0.8",
            format!("{SUN}{LAMP}{}", paths(64, SKY)),
        ),
        (
            "phase.table.values = [[1, 2, 3], [0.1, 0.5, 0.2], [2, 1, 0.5]]\nphase_normalization = \"renormalised\"",
            "phase.hybrid = { g = 0.6, back.values = [[0, 0, 0], [0.1, 0.2, 0.4]] }",
            format!("{disc}{}[camera]\nprojection.orthographic = {{}}\n", paths(64, &format!("roulette = 1\n{SKY}"))),
        ),
        (
            green,
            "phase.henyey_greenstein.g = 0.8",
            format!("{inside}{}", paths(64, "majorants = \"global\"\nbounces = 4\n")),
        ),
        (
            "albedo.constant = 0.9",
            "phase.henyey_greenstein.g = -0.3",
            format!(
                "{DARK}{}[[clips]]\nplane = {{ point = [1, 0, 0], normal = [0.6, 0.2, -0.7] }}\n",
                paths(64, "aperture = 1.5\nenvironment.image = { source = \"day\", rotation = 130 }\n")
            ),
        ),
        (noisy, "albedo.constant = 0.7", format!("{SUN}{}", paths(64, SKY))),
        (
            "albedo.constant = 0.7",
            "phase = \"isotropic\"",
            format!("{SUN}{}[quality]\nfilter = {{ bc = {{ b = 0.3, c = 0.3 }} }}\n", paths(64, SKY)),
        ),
    ];
    for (one, other, rest) in cases {
        let (own, other) = (ball(one), waves(other));
        let stage = layered(&[(first.clone(), &own), (second.clone(), &other)], &rest, SIZE);
        let [expected, found] = agree(&stage, &format!("{one} {other} {rest}"));
        deep_alike(&expected, &found);
    }
}

/// Whether half of the light is lost at the same depths: of paths, and of an integral.
fn deep_alike(expected: &Frame, found: &Frame) {
    let pairs = || expected.depth.iter().zip(&found.depth).filter(|(a, b)| a.is_finite() && b.is_finite());
    let near = pairs().filter(|(a, b)| (*a - *b).abs() < 2.0).count();
    assert!(near > 20 && near * 10 > pairs().count() * 8, "{near} of {}", pairs().count());
}

/// Positions in the world are too long for single precision there, but those in volumes are not; also where voxels are
/// absent.
#[test]
fn volumes_far_from_the_origin_are_those_of_the_cpu() {
    let far = DAffine3::from_translation(DVec3::new(4e6, -1e6, 2e6));
    let [first, second] = [turned()[0].clone(), with_holes("wavelet", [18, 16, 20])].map(|volume| placed(&volume, far));
    let (one, other) = (ball("albedo.constant = 0.9"), waves("phase.henyey_greenstein.g = 0.5"));
    let stage = layered(&[(first, &*one), (second, &*other)], &format!("{SUN}{}", paths(256, SKY)), SIZE);
    agree(&stage, "far from the origin");
}

#[test]
fn three_volumes_are_those_of_the_cpu_but_for_noise() {
    let [first, second] = turned();
    let third = placed(
        &solid([4, 5, 6], [-1.0, -9.0, -2.0], [1.7, 2.3, 1.1]),
        DAffine3::from_rotation_translation(DQuat::from_rotation_z(0.3), DVec3::new(0.0, 3.0, 1.0)),
    );
    let looks = [
        ball("phase.henyey_greenstein.g = 0.6"),
        waves("albedo.constant = 0.8"),
        haze(0.15, "phase.schlick.g = -0.4\nalbedo.constant = 0.5"),
    ];
    let layers = [(first, &*looks[0]), (second, &*looks[1]), (third, &*looks[2])];
    let stage = layered(&layers, &format!("{SUN}{LAMP}{}", paths(64, SKY)), SIZE);
    agree(&stage, "three volumes");
    // The order of the list changes no bit.
    let [a, b, c] = layers;
    let swapped = layered(&[c, a, b], &format!("{SUN}{LAMP}{}", paths(64, SKY)), SIZE);
    let mut renderer = gpu(&Ceiling::default());
    let bits = |frame: Frame| {
        let numbers = [frame.color.as_flattened(), &frame.depth, frame.normal.as_flattened(), &frame.noise].concat();
        numbers.iter().map(|number| number.to_bits()).collect::<Vec<_>>()
    };
    assert!(bits(draw(&mut renderer, &stage)) == bits(draw(&mut renderer, &swapped)), "the order changes the picture");
}

/// Weights that are no densities tell nothing of lights with a size: paths look for them if another volume has densities.
#[test]
fn lights_are_looked_for_if_any_volume_lets_paths_find_them() {
    let [first, second] = turned();
    let disc = "[[lighting.lights]]\nradius = 60\nkind.directional.direction = [0.6, 0.7, -0.4]\n";
    let (physical, other) =
        ("phase.henyey_greenstein.g = 0.5", "phase.henyey_greenstein.g = 0.5\nphase_normalization = \"renormalised\"");
    for (one, other) in [(physical, other), (other, physical)] {
        let (own, other) = (ball(one), waves(other));
        let layers = [(first.clone(), &*own), (second.clone(), &*other)];
        agree(&layered(&layers, &format!("{disc}{}", paths(256, "")), SIZE), one);
    }
}

/// Texture units interpolate otherwise, by less than the noise.
#[test]
fn two_volumes_are_interpolated_by_hardware() {
    let [first, second] = turned();
    let (one, other) = (ball("albedo.constant = 0.9"), waves("phase.henyey_greenstein.g = 0.5"));
    let layers = [(first, &*one), (second, &*other)];
    let stage = layered(&layers, &format!("{SUN}{}", paths(64, SKY)), SIZE);
    let exact = draw(&mut gpu(&Ceiling::default()), &stage);
    let found = draw(&mut gpu(&Ceiling::default()).with_interpolation(Interpolation::Hardware), &stage);
    assert!(exact.color != found.color);
    let (squares, mean) = scores(&exact, &found);
    assert!(squares < 1.5 && mean.abs() < 4.0, "{squares}, {mean}");
}

#[test]
fn surfaces_among_volumes_reflect_as_on_the_cpu() {
    let place = DAffine3::from_scale_rotation_translation(DVec3::splat(14.0), DQuat::from_rotation_z(0.4), DVec3::ZERO);
    let solid_ball = placed(&sample("ball", [24, 24, 24], VoxelType::F32), place);
    let [_, cloud] = turned();
    let cloud = placed(&cloud, DAffine3::from_translation(DVec3::new(7.0, 2.0, 3.0)));
    let surface = "shading = true\nmaterial = { diffuse = 0.7, specular = 0.5, shininess = 20, emission = 0.05 }\n\
         unit_distance = 1\n[volumes.transfer_function]\ncolors = [[0, \"#ffc080\"]]\n\
         opacities = [[0.4, 0], [0.6, 0.95]]\n[volumes.scattering]\nphase.henyey_greenstein.g = 0.3\n\
         surface.gradient = { low = 0.01, high = 0.1 }\n";
    let other = waves("albedo.constant = 0.9");
    for (lights, settings) in [
        (SUN, "environment.constant.color = \"#808080\"\n"),
        ("[[lighting.lights]]\nradius = 15\nkind.directional.direction = [0.6, 0.7, -0.4]\n", "surface_depth = 0.5\n"),
    ] {
        let layers = [(solid_ball.clone(), surface), (cloud.clone(), &*other)];
        let stage = layered(&layers, &format!("{lights}{}", paths(256, settings)), [36, 30]);
        let [expected, found] = agree(&stage, settings);
        deep_alike(&expected, &found);
        // Where the ball is in front, both tell how it faces; clouds face nowhere.
        let facing = |k: usize| (0..3).map(|c| expected.normal[k][c] * found.normal[k][c]).sum::<f32>();
        let has_normal = |frame: &Frame, k: usize| frame.normal[k] != [0.0; 3];
        let both: Vec<_> =
            (0..found.color.len()).filter(|k| has_normal(&expected, *k) && has_normal(&found, *k)).collect();
        let alike = both.iter().filter(|k| facing(**k) > 0.95).count();
        assert!(both.len() > 60 && alike * 10 > both.len() * 8, "{alike} of {}", both.len());
        assert!((0..found.color.len()).any(|k| found.depth[k].is_finite() && !has_normal(&found, k)));
    }
}

/// Two boxes that overlap, the second on a grid that is turned around the view and spaced otherwise, with where they
/// begin and end along it.
struct Boxes {
    volumes: [Arc<Volume>; 2],
    ends: [[f64; 2]; 2],
}

fn boxes() -> Boxes {
    let turn = DAffine3::from_translation(DVec3::new(4.0, 0.0, 4.0))
        * DAffine3::from_rotation_y(0.5)
        * DAffine3::from_translation(DVec3::new(-4.0, 0.0, -4.0));
    let second = placed(&solid([5, 7, 6], [2.2, 4.37, 1.9], [1.3, 0.91, 0.83]), turn);
    Boxes { volumes: [solid([9; 3], [0.0; 3], [1.0; 3]), second], ends: [[0.0, 8.0], [4.37, 4.37 + 6.0 * 0.91]] }
}

impl Boxes {
    /// A stage that looks along their common axis.
    fn stage(&self, looks: [&str; 2], rest: &str) -> Stage {
        let [first, second] = &self.volumes;
        let camera = "[camera]\nprojection.orthographic = {}\nview.orbit = { azimuth = 0, elevation = 0 }\n";
        layered(&[(first.clone(), looks[0]), (second.clone(), looks[1])], &format!("{camera}{rest}"), [16, 16])
    }

    /// Which boxes all rays of a pixel meet, if those are the same.
    fn met(&self, stage: &Stage, pixel: usize) -> Option<[bool; 2]> {
        let (x, y) = ((pixel % 16) as f64, (pixel / 16) as f64);
        let at = |(dx, dy): (f64, f64)| {
            let origin = stage.viewpoint.ray(x + dx, y + dy).origin;
            self.volumes.each_ref().map(|volume| {
                let grid = volume.grid();
                let p = grid.index_from_world().transform_point3(origin);
                let (low, high) = grid.index_bounds();
                [0, 2].into_iter().all(|axis| low[axis] < p[axis] && p[axis] < high[axis])
            })
        };
        let [first, rest @ ..] = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(at);
        rest.iter().all(|corner| *corner == first).then_some(first)
    }

    /// Stretches along the view with which of the boxes that are met lie there.
    fn stretches(&self, met: [bool; 2]) -> Vec<(f64, [bool; 2])> {
        let mut borders: Vec<f64> = self.ends.as_flattened().to_vec();
        borders.sort_by(f64::total_cmp);
        let inside = |k: usize, y: f64| met[k] && self.ends[k][0] < y && y < self.ends[k][1];
        let stretch = |ends: &[f64]| {
            let middle = (ends[0] + ends[1]) / 2.0;
            (ends[1] - ends[0], [0, 1].map(|k| inside(k, middle)))
        };
        borders.windows(2).map(stretch).collect()
    }

    /// Compares pixels with what is expected where boxes are met, within five standard errors; and their mean.
    fn compare(
        &self,
        stage: &Stage,
        found: impl Fn(usize) -> (f64, f64),
        expected: impl Fn(&[(f64, [bool; 2])]) -> f64,
    ) {
        let (mut both, mut one, mut difference, mut variance) = (0, 0, 0.0, 0.0);
        for pixel in 0..256 {
            let Some(met) = self.met(stage, pixel) else { continue };
            let exact = expected(&self.stretches(met));
            let (found, error) = found(pixel);
            assert!((found - exact).abs() <= 5.0 * error, "pixel {pixel}: {found}, exact {exact} +- {error}");
            if met == [true; 2] {
                (both, difference, variance) = (both + 1, difference + found - exact, variance + error * error);
            }
            one += usize::from(met[0] != met[1]);
        }
        assert!(both >= 20 && one >= 20, "{both} pixels see both boxes, {one} one of them");
        let (mean, error) = (difference / f64::from(both), variance.sqrt() / f64::from(both));
        assert!(mean.abs() <= 4.0 * error, "{mean} off in the mean +- {error}");
    }
}

const OPACITIES: [f64; 2] = [0.12, 0.3];

/// Extinctions of what lies somewhere.
fn extinctions(inside: [bool; 2]) -> [f64; 2] {
    [0, 1].map(|k| if inside[k] { -(1.0 - OPACITIES[k]).ln() } else { 0.0 })
}

#[test]
fn paths_collide_with_the_sum_of_all_matter() {
    const SAMPLES: u32 = 400;
    let boxes = boxes();
    let black = OPACITIES.map(|opacity| haze(opacity, "albedo.constant = 0.0"));
    let stage = boxes.stage([&black[0], &black[1]], &format!("{DARK}{}", paths(SAMPLES, "")));
    let frame = draw(&mut gpu(&Ceiling::default()), &stage);
    let exact = |stretches: &[(f64, [bool; 2])]| {
        let depth: f64 =
            stretches.iter().map(|(length, inside)| length * extinctions(*inside).iter().sum::<f64>()).sum();
        -(-depth).exp_m1()
    };
    let found = |pixel: usize| {
        let found = f64::from(frame.color[pixel][3]);
        // At least of a path: where all collide, there is no spread to tell.
        (found, ((found * (1.0 - found)).max(1.0 / f64::from(SAMPLES)) / f64::from(SAMPLES)).sqrt())
    };
    boxes.compare(&stage, found, exact);
}

/// Light along the view that is scattered once, by each of two media in its own way, and held back by both.
#[test]
fn light_is_scattered_by_either_of_two_media() {
    let (albedos, g) = ([0.2, 0.9], [0.0, -0.4]);
    let boxes = boxes();
    let looks = [0, 1].map(|k| {
        haze(OPACITIES[k], &format!("phase.henyey_greenstein.g = {:.1}\nalbedo.constant = {}", g[k], albedos[k]))
    });
    let light = "[[lighting.lights]]\nkind.directional.direction = [0, 1, 0]\n";
    let stage = boxes.stage([&looks[0], &looks[1]], &format!("{light}{}", paths(600, "bounces = 1\n")));
    let frame = draw(&mut gpu(&Ceiling::default()), &stage);
    // What comes straight back of a light that brings pi.
    let back = g.map(|g: f64| PI * (1.0 - g * g) / (4.0 * PI * (1.0 + g).powi(3)));
    let exact = |stretches: &[(f64, [bool; 2])]| {
        let (mut light, mut depth) = (0.0, 0.0f64);
        for (length, inside) in stretches {
            let kappas = extinctions(*inside);
            let kappa: f64 = kappas.iter().sum();
            if kappa > 0.0 {
                let scattered: f64 = [0, 1].map(|k| kappas[k] * albedos[k] * back[k]).iter().sum();
                light += (-2.0 * depth).exp() * scattered / (2.0 * kappa) * -(-2.0 * kappa * length).exp_m1();
                depth += kappa * length;
            }
        }
        light
    };
    boxes.compare(&stage, |pixel| (f64::from(frame.color[pixel][0]), f64::from(frame.noise[pixel]) + 1e-6), exact);
}

/// A lamp in the second of two media, behind the one that is lit: light crosses what is in front of the lamp.
#[test]
fn light_crosses_what_is_before_a_lamp() {
    let layers = [solid([9, 2, 9], [0.0; 3], [1.0; 3]), solid([9, 7, 9], [0.0, 2.0, 0.0], [1.0; 3])];
    let looks = [haze(0.2, "albedo.constant = 1.0"), haze(0.5, "albedo.constant = 0.0")];
    let [lit, dark] = layers;
    let rest = format!(
        "[[lighting.lights]]\nkind.point = {{ position = [4, 3, 4], falloff = \"none\" }}\n{}[camera]\n\
         projection.orthographic.height = 0.01\n\
         view.orbit = {{ azimuth = 0, elevation = 0, target = [4, 2, 4], distance = 30 }}\n",
        paths(400, "bounces = 1\n")
    );
    let stage = layered(&[(lit, &looks[0]), (dark, &looks[1])], &rest, [16, 16]);
    let frame = draw(&mut gpu(&Ceiling::default()), &stage);
    // Wherever light of a lamp that brings pi is scattered on its way, it crosses one unit of the first and one of the
    // second to the eye.
    let kappa = -(0.8f64).ln();
    let exact = kappa * 0.8 * 0.5 / 4.0;
    let (mut mean, mut variance) = (0.0, 0.0);
    for (color, noise) in frame.color.iter().zip(&frame.noise) {
        mean += f64::from(color[0]) / 256.0;
        variance += (f64::from(*noise) / 256.0).powi(2);
    }
    let error = variance.sqrt();
    assert!(error < 0.02 * exact && (mean - exact).abs() < 4.0 * error, "{mean}, exact {exact} +- {error}");
}

/// White media in a white sky are not seen, however they overlap.
#[test]
fn white_matter_in_white_light_is_not_seen() {
    let [first, second] = turned();
    let third = solid([5; 3], [-3.0; 3], [1.5; 3]);
    let looks = [
        ball("albedo.constant = 1.0\nphase.henyey_greenstein.g = 0.5"),
        waves("albedo.constant = 1.0"),
        haze(0.2, "albedo.constant = 1.0\nphase.schlick.g = -0.5"),
    ];
    let layers = [(first, &*looks[0]), (second, &*looks[1]), (third, &*looks[2])];
    let sky = "bounces = 500\nroulette = 500\nenvironment.constant.color = \"#ffffff\"\n";
    let found = draw(&mut gpu(&Ceiling::default()), &layered(&layers, &format!("{DARK}{}", paths(200, sky)), SIZE));
    let (mut difference, mut variance) = (0.0, 0.0);
    for (pixel, (color, noise)) in found.color.iter().zip(&found.noise).enumerate() {
        // Light from behind comes through where nothing is met.
        let light = luminance([color[0], color[1], color[2]]) + 1.0 - color[3];
        assert!((light - 1.0).abs() < 6.0 * noise + 1e-2, "pixel {pixel}: {light} +- {noise}");
        difference += f64::from(light - 1.0);
        variance += f64::from(*noise).powi(2);
    }
    assert!(found.color.iter().filter(|color| color[3] > 0.7).count() > 60);
    assert!(difference.abs() < 4.0 * variance.sqrt().max(1e-3), "{difference} with {}", variance.sqrt());
}

/// Volumes that nothing is seen of change nothing but random numbers.
#[test]
fn what_is_not_seen_changes_no_more_than_the_noise() {
    let [first, _] = turned();
    let look = ball("albedo.constant = 0.9\nphase.henyey_greenstein.g = 0.4");
    // The camera and the step are those that are said.
    let rest = format!(
        "{SUN}{}[camera]\nview.look_at = {{ position = [0, -26, 4], target = [0, 0, 0] }}\n[quality]\nstep = 0.5\n",
        paths(64, SKY)
    );
    let mut renderer = gpu(&Ceiling::default());
    let alone = draw(&mut renderer, &layered(&[(first.clone(), &look)], &rest, SIZE));
    let clear = haze(0.0, "albedo.constant = 1.0");
    let dense = haze(0.3, "albedo.constant = 1.0");
    for (what, second, look_of_it, squares_of) in [
        ("a clear one", solid([6; 3], [-5.0; 3], [2.0; 3]), &clear, 0.6..1.5),
        // Which paths do not meet: their random numbers are the same.
        ("one far behind the eye", solid([3; 3], [0.0, -4000.0, 0.0], [1.0; 3]), &dense, 0.0..0.1),
    ] {
        let stage = layered(&[(first.clone(), &look), (second, look_of_it)], &rest, SIZE);
        let found = draw(&mut renderer, &stage);
        let (squares, mean) = scores(&alone, &found);
        assert!(squares_of.contains(&squares) && mean.abs() < 4.0, "{what}: {squares}, {mean}");
    }
    // Beside each other, in one picture and one light.
    let beside = solid([4, 6, 5], [12.0, -4.0, -3.0], [1.0, 1.3, 1.2]);
    agree(&layered(&[(first, &look), (beside, &dense)], &rest, SIZE), "beside each other");
}

#[test]
fn more_volumes_than_a_pass_takes_are_counted() {
    let look = haze(0.02, "");
    let layers: Vec<_> = (0..12).map(|k| (solid([3; 3], [f64::from(k), 0.0, 0.0], [1.0; 3]), &*look)).collect();
    let rest = format!("{SUN}{}", paths(4, ""));
    let mut renderer = gpu(&Ceiling { guaranteed: true, ..Ceiling::default() });
    let refused = renderer.render(&layered(&layers, &rest, [8, 8]), &Control::default()).unwrap_err();
    let GpuError::Volumes { found: 12, most } = refused else { panic!("{refused}") };
    assert!((2..12).contains(&most), "{refused}");
    draw(&mut renderer, &layered(&layers[..most], &rest, [8, 8]));
}
