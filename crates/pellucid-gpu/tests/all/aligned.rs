//! Lights and views along axes, edges and diagonals of the box, and matter on all of its sides: light on its way is
//! what the CPU backend finds, which is held to closed forms there.

use std::sync::Arc;

use crate::common::{LEVEL, difference, draw, gpu, stage};
use pellucid_cpu::CpuRenderer;
use pellucid_field::{Grid, Volume};
use pellucid_gpu::Ceiling;
use pellucid_scene::{Control, Frame, RenderWarning, Stage};

/// A homogeneous box around the origin: pixels are a unit apart, and some of their rays lie on its sides.
fn block() -> Arc<Volume> {
    let dims = [9, 7, 11];
    let grid = Grid::with_spacing(dims, [1.0; 3], [-4.0, -3.0, -5.0]).unwrap();
    Arc::new(Volume::new(grid, vec![1.0f32; dims.iter().product()]).unwrap())
}

fn lit(volume: &Arc<Volume>, direction: [f64; 3], [azimuth, elevation]: [f64; 2], rest: &str) -> Stage {
    let document = format!(
        "shading = false\nunit_distance = 1.0\n[volumes.transfer_function]\ncolors = [[0, \"#ffffff\"]]\n\
         opacities = [[0, 0.1]]\n[volumes.scattering]\nphase_normalization = \"renormalised\"\n\
         transport = [[0, \"#f0f0f0\"]]\n[camera]\nprojection.orthographic.height = 13\n\
         view.orbit = {{ azimuth = {azimuth:?}, elevation = {elevation:?}, target = [0, 0, 0], distance = 50 }}\n\
         [[lighting.lights]]\nkind.directional.direction = {direction:?}\n{rest}"
    );
    stage(volume, &document, [13, 13])
}

fn of_cpu(stage: &Stage) -> Frame {
    CpuRenderer::default().render(stage, &Control::default()).unwrap_or_else(|error| panic!("{error}"))
}

const VIEWS: [[f64; 2]; 7] =
    [[0.0, 0.0], [90.0, 0.0], [180.0, 0.0], [-90.0, 0.0], [0.0, 90.0], [0.0, -90.0], [45.0, 0.0]];

#[test]
fn aligned_lights_are_held_back_as_on_the_cpu() {
    let volume = block();
    let mut gpu = gpu(&Ceiling::default());
    let parts = |k: usize| [k % 3, k / 3 % 3, k / 9].map(|part| part as f64 - 1.0);
    for (number, direction) in (0..27).map(parts).filter(|direction| *direction != [0.0; 3]).enumerate() {
        // Zeros of either sign.
        let direction = direction.map(|x| if x == 0.0 && number % 2 == 1 { -0.0 } else { x });
        let view = VIEWS[number % VIEWS.len()];
        for view in [view, [0.0, 0.0]] {
            let dark = draw(&mut gpu, &lit(&volume, direction, view, "[lighting]\nmodel = \"scattering\"\n"));
            for technique in [
                "[lighting]\nmodel = \"scattering\"\nshadows.rays = {}\n",
                "[lighting]\nmodel = \"scattering\"\nshadows.volume = {}\n",
                "[technique.half_angle]\nresolution = 40\nblur_angle = 40\n",
                "[technique.half_angle]\nresolution = 41\nin_scatter = \"direct\"\n",
                "[technique.half_angle]\nresolution = 64\nin_scatter = \"both_from_matter\"\n",
            ] {
                let stage = lit(&volume, direction, view, technique);
                let (expected, found) = (of_cpu(&stage), draw(&mut gpu, &stage));
                let apart = difference(&expected, &found);
                assert!(apart < LEVEL, "{direction:?} from {view:?}, {technique}: {apart}");
                let shown = found.color.iter().filter(|color| color[3] > 0.0).count();
                assert!(shown > 60, "{direction:?} from {view:?}, {technique}: {shown}");
                if technique.contains("shadows") {
                    assert!(difference(&dark, &found) > 0.05, "{direction:?} from {view:?}, {technique}: no shadow");
                }
            }
        }
    }
}

#[test]
fn paths_along_axes_are_held_back_as_on_the_cpu() {
    let volume = block();
    let mut gpu = gpu(&Ceiling::default());
    for direction in [[0.0, 0.0, -1.0], [-0.0, 1.0, -0.0], [1.0, 0.0, -0.0], [0.0, -1.0, 1.0]] {
        for view in [[0.0, 0.0], [90.0, 0.0]] {
            let stage = lit(&volume, direction, view, "[technique.path_trace]\nsamples = 256\nbounces = 1\n");
            let (expected, found) = (of_cpu(&stage), draw(&mut gpu, &stage));
            let sum = |frame: &Frame| frame.color.iter().map(|color| f64::from(color[0])).sum::<f64>();
            let variance = |frame: &Frame| frame.noise.iter().map(|noise| f64::from(*noise).powi(2)).sum::<f64>();
            let error = (variance(&expected) + variance(&found)).sqrt();
            let apart = sum(&found) - sum(&expected);
            assert!(error > 0.0 && apart.abs() < 4.0 * error, "{direction:?} from {view:?}: {apart} with {error}");
        }
    }
}

/// 6.1-2, 6.3: the cost of thin voxels is bounded, and what was done is said.
#[test]
fn thin_voxels_are_swept_in_fewer_slabs() {
    let grid = Grid::with_spacing([5, 4, 6], [0.35, 0.74, 3000.0], [0.0; 3]).unwrap();
    let volume = Arc::new(Volume::new(grid, (0..120).map(|k| (k % 7) as f32).collect::<Vec<_>>()).unwrap());
    for technique in ["[lighting]\nshadows.volume = {}\n", "[technique.half_angle]\nresolution = 32\n"] {
        let document =
            format!("shading = true\n[[lighting.lights]]\nkind.directional.direction = [0.15, 0.26, 0.3]\n{technique}");
        let stage = stage(&volume, &document, [9, 9]);
        let (expected, found) = (of_cpu(&stage), draw(&mut gpu(&Ceiling::default()), &stage));
        let said = |frame: &Frame| {
            let slabs = |warning: &RenderWarning| matches!(warning, RenderWarning::Fallback { reason } if reason.contains("in 2048 slabs"));
            frame.warnings.iter().any(slabs)
        };
        assert!(said(&expected) && said(&found), "{:?} {:?}", expected.warnings, found.warnings);
        assert!(difference(&expected, &found) < 2.0 * LEVEL, "{technique}: {}", difference(&expected, &found));
    }
}
