//! Pictures do not depend on how a volume is cut: bricks against the whole (3.3-6).

use crate::common::{LEVEL, MODES, device, difference, draw, sample, side, stage, with_holes};
use pellucid_field::VoxelType;
use pellucid_gpu::{Ceiling, GpuRenderer, Interpolation};
use pellucid_scene::{Jitter, Stage};

const SIZE: [u32; 2] = [48, 40];
const DIMS: [usize; 3] = [33, 29, 35];

const INSIDE: &str = "[camera]\nview.look_at = { position = [0.11, -0.23, 0.35], target = [0.9, 0.4, -0.3] }";
const PARALLEL: &str =
    "[camera]\nprojection.orthographic = { height = 1.4 }\nview.orbit = { azimuth = 35, elevation = -20 }";
const CLIPPED: &str = "[[clips]]\nplane = { point = [0.1, 0, 0], normal = [0.3, 1, -0.4] }\n\
    [[clips]]\nbox = { min = [-0.8, -0.9, -0.7], max = [0.9, 0.95, 0.85] }";

/// Draws stages whole and in bricks, and holds the pictures together.
fn agree(stages: &[(String, Stage)], ceilings: &[Ceiling], interpolation: Interpolation) {
    let with = |ceiling: &Ceiling| GpuRenderer::on(device(ceiling)).with_interpolation(interpolation);
    let mut whole = with(&Ceiling::default());
    let expected: Vec<_> = stages.iter().map(|(_, stage)| draw(&mut whole, stage)).collect();
    let mut failures = Vec::new();
    for ceiling in ceilings {
        let mut bricked = with(ceiling);
        for ((name, stage), expected) in stages.iter().zip(&expected) {
            let plan = bricked.plan(stage).unwrap();
            assert!(plan.bricks > 1, "{name}: {plan}");
            let found = draw(&mut bricked, stage);
            let apart = difference(&found, expected);
            let (a, b) = (&found.statistics, &expected.statistics);
            // What bricks pass on is exact, so every ray takes the samples it took.
            let counts = (a.samples_visible, a.rays_hit) == (b.samples_visible, b.rays_hit);
            if apart > LEVEL || !counts {
                failures.push(format!("{name}, {ceiling:?}: {:.2} levels apart, {a:?} for {b:?}", apart / LEVEL));
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// Every mode with something more in its document.
fn modes(more: &str, alter: impl Fn(&mut Stage)) -> Vec<(String, Stage)> {
    let volume = sample("marschner-lobb", DIMS, VoxelType::F32);
    let stage = |&(name, mode): &(&str, &str)| {
        let mut stage = stage(&volume, &format!("preset = \"simulation\"\n{mode}\n{more}"), SIZE);
        alter(&mut stage);
        (format!("{name} {more}"), stage)
    };
    MODES.iter().map(stage).collect()
}

#[test]
fn every_mode_from_outside() {
    let modes = modes("", |_| ());
    agree(&modes, &[16, 32].map(side), Interpolation::Exact);
    // Bricks of 8 voxels are a thousand: one mode says enough.
    agree(&modes[..1], &[side(8)], Interpolation::Exact);
}

#[test]
fn from_inside_parallel_and_clipped() {
    for more in [INSIDE, PARALLEL, CLIPPED] {
        agree(&modes(more, |_| ()), &[side(12)], Interpolation::Exact);
    }
}

#[test]
fn from_the_border_between_bricks() {
    // Bricks of 11 voxels have 8 cells: their borders are the planes of the voxels 8, 16, 24.
    let at = |voxel: f64, n: usize| -1.0 + 2.0 * voxel / (n - 1) as f64;
    let [x, y, z] = [at(16.0, DIMS[0]), at(8.0, DIMS[1]), at(16.0, DIMS[2])];
    for target in [[x + 0.5, y + 1e-4, z - 1e-5], [x - 1e-4, y, z - 0.5], [x, y - 1.0, z + 1e-5]] {
        let more =
            format!("[camera]\nview.look_at = {{ position = [{x}, {y}, {z}], target = {target:?}, up = [1, 1, 1] }}");
        agree(&modes(&more, |_| ())[..6], &[side(11)], Interpolation::Exact);
    }
}

#[test]
fn with_many_rays_a_pixel_and_noise() {
    let alter = |stage: &mut Stage| {
        stage.quality.supersampling = 2;
        stage.quality.jitter = Jitter::BlueNoise { seed: 3 };
    };
    agree(&modes("", alter), &[side(14)], Interpolation::Exact);
}

#[test]
fn without_leaps_and_with_the_sampler() {
    agree(&modes("", |stage| stage.quality.empty_space_skipping = false), &[side(14)], Interpolation::Exact);
    agree(&modes("", |_| ()), &[side(14)], Interpolation::Hardware);
}

#[test]
fn with_holes_in_the_field() {
    let volume = with_holes("marschner-lobb", DIMS);
    let stage = |&(name, mode): &(&str, &str)| (name.to_owned(), stage(&volume, mode, SIZE));
    let stages: Vec<_> = MODES.iter().map(stage).collect();
    agree(&stages, &[side(14), side(20)], Interpolation::Exact);
}

#[test]
fn when_only_some_bricks_are_there_at_a_time() {
    // 1 MB of voxels in less; a table of pre-integrated segments alone is larger.
    let ceiling = Ceiling { memory: Some(800 << 10), ..Ceiling::default() };
    let volume = sample("marschner-lobb", [64, 60, 66], VoxelType::F32);
    let modes = MODES.iter().filter(|(name, _)| *name != "pre-integrated");
    let stages: Vec<_> = modes.map(|&(name, mode)| (name.to_owned(), stage(&volume, mode, SIZE))).collect();
    agree(&stages, std::slice::from_ref(&ceiling), Interpolation::Exact);
    let plan = GpuRenderer::on(device(&ceiling)).plan(&stages[0].1).unwrap();
    assert!(plan.loaded < plan.bricks && plan.total() <= 800 << 10, "{plan}");
}

#[test]
fn of_flat_and_thin_volumes() {
    for dims in [[40, 1, 30], [1, 1, 40], [1, 37, 2]] {
        let volume = sample("marschner-lobb", dims, VoxelType::U16);
        let stages: Vec<_> =
            MODES.iter().map(|(name, mode)| (format!("{name} {dims:?}"), stage(&volume, mode, SIZE))).collect();
        agree(&stages, &[side(8)], Interpolation::Exact);
    }
}
