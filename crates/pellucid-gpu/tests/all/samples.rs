//! What is asked of samples and pictures on both backends: extremes of the field itself, faces of nearest voxels, cuts
//! lit as such, and colours of a background each held back in its own way.

use std::sync::Arc;

use crate::common::{difference, draw, gpu, sample, stage};
use pellucid_cpu::CpuRenderer;
use pellucid_field::{Grid, Volume, VoxelType};
use pellucid_gpu::Ceiling;
use pellucid_scene::{Control, Frame, Stage};

fn both(stage: &Stage) -> [Frame; 2] {
    let exact = CpuRenderer::new().render(stage, &Control::default()).unwrap();
    [exact, draw(&mut gpu(&Ceiling::default()), stage)]
}

/// How many pixels have other normals or depths, of those that have any.
fn otherwise([a, b]: &[Frame; 2]) -> (usize, usize) {
    let met = a.depth.iter().filter(|depth| depth.is_finite()).count();
    let differs = |pixel: &usize| {
        let along: f32 = a.normal[*pixel].iter().zip(b.normal[*pixel]).map(|(a, b)| a * b).sum();
        let both_none = a.normal[*pixel] == [0.0; 3] && b.normal[*pixel] == [0.0; 3];
        (a.depth[*pixel] - b.depth[*pixel]).abs() > 0.02 || !(both_none || along > 0.99)
    };
    ((0..a.depth.len()).filter(|pixel| a.depth[*pixel].is_finite() && differs(pixel)).count(), met)
}

const LINEAR: &str = "transfer_function = { color_space = \"linear\", colors = [[0, \"#000000\"], [1, \"#ffffff\"]], \
                      opacities = [[0, 1]] }\n";

/// A plane of voxels of 1 among 0.
fn sheet() -> Arc<Volume> {
    let values: Vec<u8> = (0..12 * 12 * 11).map(|i| u8::from(i / 144 == 5)).collect();
    Arc::new(Volume::new(Grid::new([12, 12, 11]).unwrap(), values).unwrap())
}

#[test]
fn a_sheet_is_seen_whole() {
    for view in ["azimuth = 0\nelevation = 90", "azimuth = 30\nelevation = 50", "azimuth = -70\nelevation = 35"] {
        for step in [0.25, 1.0] {
            for mode in [
                "ray_cast]\nmode = \"maximum\"",
                "slicing]\nmode = \"maximum\"",
                "ray_cast.mode.slice]\nthickness = 2.0\nnormal = [0, 0, 1]\npoint = [5.5, 5.5, 5.2]\ncombine = \"maximum\"",
            ] {
                for filter in ["linear", "nearest"] {
                    let document = format!(
                        "{LINEAR}[camera.view.orbit]\n{view}\n[camera.projection.orthographic]\nheight = 4\n\
                         [quality]\nstep = {step}\nfilter = \"{filter}\"\n[technique.{mode}"
                    );
                    let frame = draw(&mut gpu(&Ceiling::default()), &stage(&sheet(), &document, [16, 16]));
                    let seen: Vec<f32> = frame.color.iter().filter(|c| c[3] > 0.9).map(|c| c[0]).collect();
                    assert!(seen.len() > 150, "{document}: {}", seen.len());
                    let least = seen.into_iter().fold(1.0f32, f32::min);
                    // Slices are blended in half precision.
                    assert!(least > 0.999, "{document}: {least}");
                }
            }
        }
    }
}

#[test]
fn nearest_voxels_have_the_same_faces() {
    let volume = sample("marschner-lobb", [17, 19, 15], VoxelType::U8);
    let level = "[[technique.ray_cast.mode.isosurface.isovalues]]\nvalue = 0.5\n";
    for skipping in [true, false] {
        let document = format!(
            "[camera.view.orbit]\nazimuth = 33\nelevation = 27\n[quality]\nfilter = \"nearest\"\n\
             empty_space_skipping = {skipping}\n{level}"
        );
        let frames = both(&stage(&volume, &document, [48, 48]));
        let (other, met) = otherwise(&frames);
        assert!(met > 500 && other * 100 <= met, "{other} of {met}");
    }
}

#[test]
fn surfaces_turn_to_lower_values_from_within() {
    let volume = sample("ball", [24; 3], VoxelType::F32);
    let middle = volume.statistics();
    let value = (middle.min + middle.max) / 2.0;
    let center = volume.grid().center();
    let document = format!(
        "[camera.view.look_at]\nposition = [{}, {}, {}]\ntarget = [{}, {}, {}]\n\
         [[technique.ray_cast.mode.isosurface.isovalues]]\nvalue = {value}\n",
        center.x,
        center.y,
        center.z,
        center.x + 1.0,
        center.y + 0.3,
        center.z
    );
    let frames = both(&stage(&volume, &document, [32, 32]));
    let (other, met) = otherwise(&frames);
    assert!(met > 900 && other * 100 <= met, "{other} of {met}");
}

/// Solid integer matter with noise of one level.
fn solid() -> Arc<Volume> {
    let noise = |i: usize| (i.wrapping_mul(2_654_435_761) >> 13) % 3;
    let values: Vec<u8> = (0..32 * 32 * 32).map(|i| 199 + noise(i) as u8).collect();
    Arc::new(Volume::new(Grid::new([32; 3]).unwrap(), values).unwrap())
}

#[test]
fn cuts_are_lit_as_on_the_cpu() {
    let techniques = ["", "[technique.half_angle]\n", "[quality]\nclassification = \"pre_integrated\"\n"];
    for technique in techniques {
        let document = format!(
            "transfer_function = {{ colors = [[0, \"#ffffff\"]], opacities = [[100, 0], [150, 0.9]] }}\nshading = true\n\
             [[clips]]\nplane = {{ point = [15.5, 15.5, 15.5], normal = [-0.3, 0.9, -0.3] }}\n\
             [[lighting.lights]]\nkind.directional.direction = [0.2, 1.0, 0.1]\n{technique}"
        );
        let frames = both(&stage(&solid(), &document, [32, 32]));
        let (other, met) = otherwise(&frames);
        assert!(met > 300 && other * 50 <= met, "{technique}: {other} of {met}");
        let apart = difference(&frames[0], &frames[1]);
        assert!(apart < 0.02, "{technique}: {apart}");
    }
}

#[test]
fn each_colour_of_a_background_comes_through_as_on_the_cpu() {
    let volume = sample("ball", [24; 3], VoxelType::U8);
    for (technique, tolerance) in [
        ("", 0.01),
        ("[technique.half_angle]\n", 0.01),
        ("[technique.path_trace]\nsamples = 1024\nnoise = 0\nbounces = 0\n", 0.12),
    ] {
        let document = format!(
            "transfer_function = {{ colors = [[0, \"#000000\"]], opacities = [[0, 0.1]] }}\nshading = false\n\
             scattering = {{ extinction_color = \"#ff8020\" }}\n\
             [[lighting.lights]]\nkind.directional.direction = [0.2, 1.0, 0.1]\n\
             [image]\nbackground = {{ color = \"#f0ffe0\" }}\n[quality]\nsupersampling = {}\n{technique}",
            if technique.contains("path") { 1 } else { 2 }
        );
        let stage = stage(&volume, &document, [24, 24]);
        let [exact, found] = both(&stage);
        assert_eq!((exact.opacities.len(), found.opacities.len()), (576, 576), "{technique}");
        for pixel in 0..576 {
            let [a, b] = [&exact, &found].map(|frame| frame.composited(pixel, &stage.image));
            for channel in 0..3 {
                let apart = (a[channel] - b[channel]).abs();
                assert!(apart < tolerance, "{technique}, {pixel}, {channel}: {} and {}", a[channel], b[channel]);
            }
        }
        // Blue is held back least.
        let [r, _, b] = exact.opacities[12 * 24 + 12];
        assert!(r > b + 0.2, "{technique}: {r} and {b}");
    }
}
