//! Half-angle slicing and the scattering of single samples are what the CPU backend draws, whose pictures are held
//! to closed forms there.

use std::sync::Arc;

use crate::common::{LEVEL, device, difference, draw, gpu, sample, stage, with_holes};
use pellucid_cpu::CpuRenderer;
use pellucid_field::{Grid, Volume, VoxelType};
use pellucid_gpu::{Ceiling, GpuError, GpuRenderer, Interpolation};
use pellucid_plan::half_angle::LightError;
use pellucid_scene::{Control, Frame, Stage};

/// What both backends compute in single precision differs by its rounding, in the mean by less; where rays touch a
/// border, and where light grazes the box, by as much as a sample there adds: less than a step of an 8-bit channel.
const ROUNDING: f32 = 5e-5;

/// Lights in front of the volume, beside it, behind it, and near it.
pub const LIGHTS: [(&str, &str); 5] = [
    ("front", "directional.direction = [0.3, 1.0, -0.4]"),
    ("side", "directional.direction = [1.0, 0.05, -0.3]"),
    ("back", "directional.direction = [-0.2, -1.0, -0.2]"),
    ("near", "point = { position = [-26, -20, 22], falloff.inverse_square.reference = 40 }"),
    ("spot", "spot = { position = [5, -60, 30], direction = [0, 1, -0.5], inner_angle = 8, outer_angle = 30 }"),
];

/// A document of clouds in clouds, which goes on after the volume's source.
struct Document<'a> {
    volume: &'a str,
    scattering: &'a str,
    technique: &'a str,
    lights: &'a [&'a str],
    rest: &'a str,
}

const PLAIN: Document = Document {
    volume: "shading = true",
    scattering: "",
    technique: "half_angle.resolution = 48",
    lights: &[LIGHTS[1].1],
    rest: "",
};

impl Document<'_> {
    fn stage(&self, volume: &Arc<Volume>) -> Stage {
        let lights: Vec<_> = self.lights.iter().map(|light| format!("[[lighting.lights]]\nkind.{light}\n")).collect();
        let document = format!(
            "{}\nunit_distance = 1.0\n[volumes.transfer_function]\n\
             colors = [[80, \"#3050e0\"], [160, \"#f0e0c0\"], [260, \"#e04020\"]]\n\
             opacities = [[90, 0], [140, 0.06], [170, 0.0], [190, 0.25], [270, 0.6]]\n\
             [volumes.scattering]\n{}\n{}[technique]\n{}\n{}",
            self.volume,
            self.scattering,
            lights.concat(),
            self.technique,
            self.rest
        );
        stage(volume, &document, [40, 34])
    }
}

fn of_cpu(stage: &Stage) -> Frame {
    CpuRenderer::default().render(stage, &Control::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// Draws with both backends and compares.
fn agree(volume: &Arc<Volume>, document: &Document, what: &str) -> (Frame, Frame) {
    are_alike(&mut gpu(&Ceiling::default()), &document.stage(volume), what)
}

/// Draws a stage with both backends and compares.
pub fn are_alike(renderer: &mut GpuRenderer, stage: &Stage, what: &str) -> (Frame, Frame) {
    let (expected, found) = (of_cpu(stage), draw(renderer, stage));
    let apart = difference(&expected, &found);
    let brightest = expected.color.as_flattened().iter().copied().fold(0.0, f32::max);
    let pairs = expected.color.as_flattened().iter().zip(found.color.as_flattened());
    let mean = pairs.map(|(a, b)| (a - b).abs()).sum::<f32>() / (4 * expected.color.len()) as f32;
    assert!(mean < ROUNDING && apart < LEVEL * brightest.max(1.0), "{what}: {mean}, {apart} of {brightest}");
    assert!(brightest > 0.02, "{what} shows nothing: {brightest}");
    (expected, found)
}

fn wavelet() -> Arc<Volume> {
    sample("wavelet", [24, 20, 28], VoxelType::F32)
}

#[test]
fn pictures_are_those_of_the_cpu_from_all_sides() {
    let volume = wavelet();
    for (name, light) in LIGHTS {
        for projection in ["perspective.vertical_fov = 30", "orthographic = {}"] {
            let document = Document {
                scattering: "transport = [[0, \"#f0c080\"]]",
                technique: "half_angle = { resolution = 48, blur_angle = 40 }",
                lights: &[light],
                rest: &format!("[camera.projection]\n{projection}\n"),
                ..PLAIN
            };
            let (expected, found) = agree(&volume, &document, name);
            assert_eq!(expected.samples, found.samples, "{name}");
            assert_eq!(expected.statistics.samples_visible, found.statistics.samples_visible, "{name}");
            // Where half of the opacity is reached; a ray on the edge between two samples may find either.
            let pairs = expected.depth.iter().zip(&found.depth).filter(|(a, b)| a.is_finite() || b.is_finite());
            let near = pairs.clone().filter(|(a, b)| (*a - *b).abs() < 1e-2).count();
            let count = pairs.count();
            assert!(count > 100 && (count - near) * 100 <= count, "{name}: {near} of {count} depths agree");
        }
    }
}

#[test]
fn every_setting_means_the_same() {
    let volume = wavelet();
    let techniques = [
        "half_angle = { resolution = 40, indirect = 0.0 }",
        "half_angle = { resolution = 40, correction = \"none\", direct = 0.3 }",
        "half_angle = { resolution = 40, in_scatter = \"direct\", initial_indirect = 0.0 }",
        "half_angle = { resolution = 40, in_scatter = \"direct_from_matter\", initial_indirect = 0.5 }",
        "half_angle = { resolution = 40, in_scatter = \"both_from_matter\", taps = 7 }",
        "half_angle = { resolution = 40, in_scatter = \"both_from_matter\", taps = 1 }",
        "half_angle = { resolution = 40, jitter = \"fixed\", blur_scaling = \"per_distance\" }",
        "half_angle = { resolution = 40, seed = 7, taps = 16, blur_angle = 90, ambient = true }",
    ];
    for technique in techniques {
        for transport in ["", "transport = [[0, \"#f0c080\"], [200, \"#e0e0ff\"]]"] {
            for light in [LIGHTS[2].1, LIGHTS[3].1] {
                let document = Document { technique, scattering: transport, lights: &[light], ..PLAIN };
                agree(&volume, &document, &format!("{technique} {transport} {light}"));
            }
        }
    }
}

/// K-13: towards the eye, from the light and into the cone.
#[test]
fn each_colour_is_held_back_as_on_the_cpu() {
    let volume = wavelet();
    for in_scatter in ["indirect", "direct", "direct_from_matter"] {
        let technique = format!("half_angle = {{ resolution = 40, in_scatter = \"{in_scatter}\" }}");
        for scattering in [
            "extinction_color = \"#ff8020\"",
            "extinction_color = \"#00bcff\"\ntransport = [[0, \"#f0c080\"]]",
            "extinction_color = \"#808080\"\nsurface.values = [[80, 0.5]]",
        ] {
            for light in [LIGHTS[0].1, LIGHTS[2].1, LIGHTS[3].1] {
                let document = Document { technique: &technique, scattering, lights: &[light], ..PLAIN };
                agree(&volume, &document, &format!("{technique} {scattering} {light}"));
            }
        }
    }
}

#[test]
fn samples_scatter_and_reflect_as_on_the_cpu() {
    let volume = wavelet();
    let clouds = [
        "phase = \"rayleigh\"",
        "phase.henyey_greenstein.g = 0.7",
        "phase.henyey_greenstein.g = 0.5\nanisotropy = \"cloud\"\nphase_normalization = \"renormalised\"",
        "phase.double_henyey_greenstein = { first = 0.8, second = -0.4, share = 0.7 }",
        "phase.schlick.g = -0.6\nanisotropy.values = [[80, 0.8], [200, -0.5]]",
        "phase.table.values = [[1, 2, 3], [0.1, 0.5, 0.2], [2, 1, 0.5]]\nphase_normalization = \"renormalised\"",
        "phase.hybrid = { g = 0.8, back.values = [[0, 0, 0], [0.1, 0.2, 0.4], [0.5, 0.1, 0.1]] }",
        "phase.hybrid = { g = 0.8, back.values = [[0, 0, 0], [1, 2, 4]] }\nphase_normalization = \"renormalised\"\n\
         anisotropy.values = [[80, 0.8], [200, 0.3]]",
        "surface.values = [[100, 0], [220, 1]]",
        "surface.gradient = { low = 2, high = 20 }",
        "albedo.constant = 0.6",
        "albedo.colors = [[80, \"#ff0000\"], [200, \"#00ff00\"]]\nsurface.values = [[80, 0.5]]",
    ];
    let casts =
        ["", "[quality]\nclassification = \"pre\"", "[quality]\nclassification = \"pre_integrated\"\nstep = 1.5"];
    for scattering in clouds {
        agree(&volume, &Document { scattering, lights: &[LIGHTS[0].1, LIGHTS[3].1], ..PLAIN }, scattering);
        for cast in casts {
            let technique = "ray_cast.mode = \"composite\"";
            let rest = format!("{cast}\n[lighting]\nmodel = \"scattering\"\n");
            // The lights' tables would end that of the lighting.
            let rest = format!("{rest}lights = [{{ kind.{} }}, {{ kind.{} }}]\n", LIGHTS[2].1, LIGHTS[4].1);
            agree(&volume, &Document { scattering, technique, lights: &[], rest: &rest, ..PLAIN }, scattering);
        }
    }
}

#[test]
fn clips_holes_filters_and_several_rays_a_pixel_are_seen_by_light_and_eye() {
    let (whole, holes) = (wavelet(), with_holes("wavelet", [20, 22, 18]));
    let rests = [
        "[[clips]]\nplane = { point = [1, 0, 0], normal = [0.6, 0.2, -0.7] }",
        "[quality]\nsupersampling = 2\njitter.blue_noise.seed = 3",
        "[quality]\nfilter = { bc = { b = 0.3333, c = 0.3333 } }\ngradient = \"sobel\"",
        "[quality]\nempty_space_skipping = false\nstep = 0.7",
        "[quality]\nearly_termination = 0.6\nclassification = \"pre_integrated\"",
    ];
    for rest in rests {
        for (volume, name) in [(&whole, "whole"), (&holes, "holes")] {
            let document = Document {
                scattering: "surface.gradient = { low = 2, high = 20 }",
                lights: &[LIGHTS[0].1, LIGHTS[3].1],
                rest,
                ..PLAIN
            };
            agree(volume, &document, &format!("{name} {rest}"));
        }
    }
}

#[test]
fn one_light_of_several_and_none() {
    let volume = wavelet();
    let lights = [LIGHTS[0].1, LIGHTS[1].1, LIGHTS[4].1];
    let document = |technique, lights| Document { technique, lights, ..PLAIN };
    let (second, _) = agree(&volume, &document("half_angle = { resolution = 40, light = 1 }", &lights), "the second");
    let (alone, _) = agree(&volume, &document("half_angle.resolution = 40", &lights[1..2]), "alone");
    assert_eq!(second.color, alone.color);
    let mut renderer = gpu(&Ceiling::default());
    let mut dark = document("half_angle.resolution = 40", &[]).stage(&volume);
    dark.lights.clear();
    let (expected, found) = (of_cpu(&dark), draw(&mut renderer, &dark));
    assert!(difference(&expected, &found) < LEVEL / 2.0 && found.color.iter().all(|color| color[0] == 0.0));
    let mut stage =
        |technique, lights| renderer.render(&document(technique, lights).stage(&volume), &Control::default());
    assert_eq!(
        stage("half_angle.light = 3", &lights).unwrap_err(),
        GpuError::Light(LightError::Absent { found: 3, lights: 3 })
    );
    let inside = ["directional.direction = [0, 1, 0]", "point = { position = [1, 2, 3], falloff = \"none\" }"];
    assert_eq!(stage("half_angle = {}", &inside).unwrap_err(), GpuError::Light(LightError::Inside { light: 1 }));
}

/// K-15: a frame after others is the frame of a renderer that has drawn nothing yet, bit for bit, whatever has
/// changed in between.
#[test]
fn frames_leave_nothing_behind() {
    let volume = wavelet();
    let mut kept = gpu(&Ceiling::default());
    let documents = [
        PLAIN,
        Document { lights: &[LIGHTS[3].1], ..PLAIN },
        Document { scattering: "transport = [[0, \"#f0c080\"]]\nphase.schlick.g = 0.5", ..PLAIN },
        Document { technique: "half_angle = { resolution = 90, in_scatter = \"both_from_matter\" }", ..PLAIN },
        Document { technique: "ray_cast.mode = \"composite\"", ..PLAIN },
        PLAIN,
    ];
    for document in documents {
        let stage = document.stage(&volume);
        assert_eq!(draw(&mut kept, &stage).color, draw(&mut gpu(&Ceiling::default()), &stage).color);
    }
}

#[test]
fn texture_units_come_near() {
    let volume = wavelet();
    let stage = PLAIN.stage(&volume);
    let mut hardware = GpuRenderer::on(device(&Ceiling::default())).with_interpolation(Interpolation::Hardware);
    let apart = difference(&of_cpu(&stage), &draw(&mut hardware, &stage));
    assert!(apart < 2.0 * LEVEL, "{apart}");
}

#[test]
fn a_volume_in_bricks_is_refused_with_advice() {
    let stage = PLAIN.stage(&wavelet());
    let refused = gpu(&crate::common::side(16)).render(&stage, &Control::default()).unwrap_err();
    assert!(matches!(&refused, GpuError::Budget { advice, .. } if advice.contains("cpu")), "{refused}");
}

/// Two plates that fill blocks of their own, the first beside the way of light to the second: only what spreads
/// darkens that.
fn two_plates() -> Arc<Volume> {
    const DIMS: [usize; 3] = [64, 40, 40];
    let grid = Grid::with_spacing(DIMS, [0.05; 3], [-1.6, -1.0, -1.0]).unwrap();
    let value = |i: usize| {
        let [x, y, z] = [i % DIMS[0], i / DIMS[0] % DIMS[1], i / (DIMS[0] * DIMS[1])];
        let is_in = (1..8).contains(&x) && (9..16).contains(&y) || (49..56).contains(&x) && (25..32).contains(&y);
        if is_in && (9..32).contains(&z) { 255u8 } else { 0 }
    };
    Arc::new(Volume::new(grid, (0..DIMS.iter().product()).map(value).collect::<Vec<_>>()).unwrap())
}

#[test]
fn what_is_empty_changes_no_bit() {
    let (cloud, plates) = (sample("cloud", [40, 40, 28], VoxelType::U8), two_plates());
    let mut renderer = gpu(&Ceiling::default());
    let lights = [
        "directional.direction = [0.8, -0.6, -0.5]",
        "directional.direction = [1, 0, 0]",
        "point = { position = [-3, 1.5, 1], falloff = \"none\" }",
    ];
    let techniques = ["indirect = 0.0", "taps = 6\nblur_angle = 80", "in_scatter = \"both_from_matter\""];
    for (volume, top) in [(&cloud, 1), (&plates, 255)] {
        for (light, technique) in lights.iter().flat_map(|light| techniques.map(|technique| (light, technique))) {
            let mut draw = |skipping: bool| {
                let document = format!(
                    "shading = false\n[volumes.transfer_function]\ncolors = [[0, \"#ffffff\"]]\n\
                     opacities = [[{}, 0], [{top}, 0.6]]\nunit_distance = 0.1\n\
                     [[lighting.lights]]\nkind.{light}\n[technique.half_angle]\nresolution = 90\n{technique}\n\
                     [quality]\nempty_space_skipping = {skipping}\n",
                    f64::from(top) * 0.3
                );
                draw(&mut renderer, &stage(volume, &document, [60, 60]))
            };
            let (with, without) = (draw(true), draw(false));
            assert!(with.statistics.samples < without.statistics.samples, "{technique}");
            assert!(with.color.iter().any(|color| color[3] > 0.5), "{technique} shows nothing");
            assert!(with.color == without.color, "{technique} {light}: {}", difference(&with, &without));
        }
    }
}
