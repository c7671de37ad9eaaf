//! Nothing is leapt over: a wall that begins right behind a block of emptiness, and samples as close
//! behind its surface as f32 can tell.

use crate::common::{set_mode, stage, transfer_function, unit_volume};
use glam::DVec3;
use pellucid_cpu::{CpuRenderer, InstructionSet};
use pellucid_scene::{Classification, Control, Frame, Isosurface, Isovalue, LookAt, Mode, Projection, Stage, View};

/// A wall across an axis, from index 8 on along it or from 16 on against it: where the first block
/// ends. Before it, exactly 0; behind it, the value rises to 1 within a voxel. The eye looks along
/// the axis, and the eleventh sample lies `behind` the surface.
fn wall(axis: usize, forward: bool, behind: f64, mode: Mode, classification: Classification, skipping: bool) -> Stage {
    let mut dims = [4; 3];
    dims[axis] = 25;
    let full = |p: DVec3| if forward { p[axis] > 8.0 } else { p[axis] < 16.0 };
    let volume = unit_volume(dims, |p| f64::from(u8::from(full(p))));
    // A table of segments takes a value for empty only if its next node is, too.
    let [from, to] = if classification == Classification::PreIntegrated { [0.02, 0.1] } else { [0.0, 1e-4] };
    let tf = transfer_function(&[(0.0, 0xffffff)], &[(from, 0.0), (to, 1.0)]);
    stage(volume, tf, |scene| {
        set_mode(scene, mode);
        let target = DVec3::from_array(dims.map(|n| (n - 1) as f64 / 2.0));
        let mut along = DVec3::ZERO;
        along[axis] = if forward { 1.0 } else { -1.0 };
        let (position, up) = (target - 20.0 * along, along.any_orthonormal_vector());
        let [position, target, up] = [position, target, up].map(|v| v.to_array());
        scene.camera.view = View::LookAt(LookAt { position, target, up });
        scene.camera.projection = Projection::Orthographic { height: Some(2.5) };
        scene.quality.step = (8.0 + behind) / 10.5;
        scene.quality.classification = classification;
        scene.quality.empty_space_skipping = skipping;
    })
}

fn draw(set: InstructionSet, stage: &Stage) -> Option<Frame> {
    let mut renderer = CpuRenderer::new().with_instructions(set).ok()?;
    Some(renderer.render(stage, &Control::default()).unwrap())
}

#[test]
fn the_first_sample_behind_an_empty_block_is_seen() {
    let surface = |behind: f64| {
        let isovalues = vec![Isovalue { value: behind / 2.0, color: None, opacity: 1.0, volume: None }];
        Mode::Isosurface(Isosurface::new(isovalues))
    };
    for (axis, forward, set) in (0..3).flat_map(|axis| {
        [true, false].into_iter().flat_map(move |forward| {
            [InstructionSet::Avx512, InstructionSet::Avx2, InstructionSet::Baseline].map(|set| (axis, forward, set))
        })
    }) {
        for behind in [3e-4, 1e-3, 3e-3, 0.05, 0.4] {
            // 12 from the middle to the face, where the eye stands 20 away; then 8 and what is behind.
            let sample = 8.0 + 8.0 + behind;
            let cases = [
                (Mode::Composite, Classification::Post, Some(sample)),
                (Mode::Composite, Classification::PreIntegrated, None),
                (surface(behind), Classification::Post, Some(sample - behind / 2.0)),
            ];
            for (mode, classification, expected) in cases {
                let stage = |skipping| wall(axis, forward, behind, mode.clone(), classification, skipping);
                let Some(frame) = draw(set, &stage(true)) else { continue };
                let what =
                    format!("{set}, axis {axis}, forward {forward}, {behind} behind, {mode:?}, {classification:?}");
                assert!(frame.statistics.samples_skipped > 0, "nothing skipped: {what}");
                let whole = draw(set, &stage(false)).unwrap();
                assert!(frame.color == whole.color && frame.depth == whole.depth, "{what}");
                let Some(expected) = expected else { continue };
                for depth in &frame.depth {
                    assert!((f64::from(*depth) - expected).abs() < 1e-4, "{what}: depth {depth}, exact {expected}");
                }
            }
        }
    }
}
