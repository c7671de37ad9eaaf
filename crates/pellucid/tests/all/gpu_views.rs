//! Every camera, light and output looks as on the CPU, and the work can be watched and stopped.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use crate::gpu_common::{LEVEL, MODES, difference, draw, gpu, sample, stage};
use pellucid_cpu::CpuRenderer;
use pellucid_field::VoxelType;
use pellucid_gpu::{Ceiling, GpuError};
use pellucid_scene::{Cancel, Control, Frame, Jitter, Stage};

const SIZE: [u32; 2] = [56, 44];
const DIMS: [usize; 3] = [33, 29, 35];

/// What the CPU backend draws.
fn cpu(stage: &Stage) -> Frame {
    CpuRenderer::new().render(stage, &Control::default()).unwrap()
}

/// Depth and normals are those of the other frame, but where a ray's opacity crosses one half within a
/// rounding of it and takes the sample before or after.
fn surfaces_agree(name: &str, a: &Frame, b: &Frame, step: f32) {
    let (mut differ, mut seen) = (0, 0);
    for (k, (&da, &db)) in a.depth.iter().zip(&b.depth).enumerate() {
        if da.is_finite() != db.is_finite() {
            differ += 1;
        } else if da.is_finite() {
            seen += 1;
            let along: f32 = a.normal[k].iter().zip(b.normal[k]).map(|(a, b)| a * b).sum();
            let both_none = a.normal[k] == [0.0; 3] && b.normal[k] == [0.0; 3];
            let near = (da - db).abs() <= step * 1e-2 + db.abs() * 1e-5;
            differ += usize::from(!near || !(both_none || along > 0.999));
        }
    }
    assert!(differ * 100 <= a.depth.len(), "{name}: {differ} of {seen} depths or normals differ");
}

#[test]
fn cameras_everywhere() {
    let volume = sample("marschner-lobb", DIMS, VoxelType::F32);
    let spacing = 2.0 / 34.0;
    let far = 1e6 * spacing;
    let cameras = [
        ("inside", "view.look_at = { position = [0.1, -0.2, 0.3], target = [1, 0.4, -0.3] }".to_owned()),
        ("in a corner", "view.look_at = { position = [-1, -1, -1], target = [1, 1, 1] }".to_owned()),
        ("parallel", "projection.orthographic = {}\nview.orbit = { azimuth = 35, elevation = -20 }".to_owned()),
        (
            "along an axis",
            "projection.orthographic = {}\nview.look_at = { position = [0, -5, 0], target = [0, 0, 0] }".to_owned(),
        ),
        (
            "far away",
            format!(
                "projection.perspective.vertical_fov = {}\nview.look_at = {{ position = [{far}, {far}, {far}], target = [0, 0, 0] }}",
                (4.0 / (far * 3f64.sqrt())).to_degrees()
            ),
        ),
    ];
    let mut gpu = gpu(&Ceiling::default());
    for (name, camera) in cameras {
        for (mode, document) in [MODES[0], MODES[1], MODES[4], MODES[5], MODES[10], MODES[11]] {
            let stage = stage(&volume, &format!("preset = \"simulation\"\n{document}\n[camera]\n{camera}"), SIZE);
            let (found, expected) = (draw(&mut gpu, &stage), cpu(&stage));
            let apart = difference(&found, &expected) / LEVEL;
            assert!(expected.statistics.rays_hit > 500, "{name}: {:?}", expected.statistics);
            assert!(apart <= 2.0, "{name} {mode}: {apart:.2} levels apart");
            // Along an axis of symmetry the same largest value is met at several depths.
            if (name, mode) != ("along an axis", "maximum") {
                surfaces_agree(&format!("{name} {mode}"), &found, &expected, stage.step as f32);
            }
        }
    }
}

#[test]
fn lights_of_every_kind() {
    let lights = "[[lighting.lights]]\nkind.spot = { position = [-3, -4, 4], direction = [3, 4, -4], inner_angle = 6, outer_angle = 20 }\n\
        [[lighting.lights]]\nkind.point = { position = [0.3, -2, 0.1], falloff = { inverse_square = { reference = 2.0 } } }\ncolor = \"#60c0ff\"\n\
        [[lighting.lights]]\nkind.directional.direction = [-1, 0.6, 0.2]\nspecular = false\nintensity = 0.5";
    let volume = sample("ball", DIMS, VoxelType::U16);
    let mut gpu = gpu(&Ceiling::default());
    for material in
        ["", "material = { ambient = 0.1, diffuse = 0.7, specular = 0.6, shininess = 20, two_sided = false }\n"]
    {
        let stage = stage(&volume, &format!("shading = true\n{material}{lights}"), SIZE);
        let (found, expected) = (draw(&mut gpu, &stage), cpu(&stage));
        let apart = difference(&found, &expected) / LEVEL;
        assert!(apart <= 2.0, "{apart:.2} levels apart");
    }
}

#[test]
fn counts_are_those_of_the_processor() {
    let volume = sample("marschner-lobb", DIMS, VoxelType::F32);
    let mut gpu = gpu(&Ceiling::default());
    for (name, document) in MODES {
        let mut stage = stage(&volume, document, SIZE);
        stage.quality.empty_space_skipping = false;
        stage.quality.early_termination = 1.0;
        stage.quality.supersampling = 2;
        stage.quality.jitter = Jitter::BlueNoise { seed: 5 };
        let (found, expected) = (draw(&mut gpu, &stage), cpu(&stage));
        let apart = difference(&found, &expected) / LEVEL;
        assert!(apart <= 2.0, "{name}: {apart:.2} levels apart");
        let (a, b) = (&found.statistics, &expected.statistics);
        // Entries are rounded to single precision: a ray in a thousand has a sample more or less, or one
        // whose opacity is 0 or just above it.
        let near = |a: u64, b: u64| a.abs_diff(b) <= b / 200 + 2;
        assert_eq!(a.rays, b.rays, "{name}");
        assert!(near(a.rays_hit, b.rays_hit), "{name}: {a:?} for {b:?}");
        // A ray that enters by a plane of voxels begins in the piece on either side of it.
        let entries = if ["maximum", "minimum", "slab", "isosurface"].contains(&name) { b.rays_hit } else { 0 };
        assert!(near(a.samples, b.samples) || a.samples.abs_diff(b.samples) <= entries, "{name}: {a:?} for {b:?}");
        assert!(near(a.samples_visible, b.samples_visible), "{name}: {a:?} for {b:?}");
        assert_eq!(found.samples.iter().map(|&n| u64::from(n)).sum::<u64>(), a.samples, "{name}");
    }
}

#[test]
fn progress_never_falls_and_cancelling_takes_no_time() {
    let volume = sample("marschner-lobb", [64; 3], VoxelType::U8);
    let mut stage = stage(&volume, "shading = true", [400, 300]);
    let mut gpu = gpu(&Ceiling::default());
    let shares = Mutex::new(vec![0.0]);
    let tell = |share| shares.lock().unwrap().push(share);
    let first = gpu.render(&stage, &Control { progress: Some(&tell), ..Control::default() }).unwrap();
    let shares = shares.into_inner().unwrap();
    assert!(shares.is_sorted() && shares.len() > 3 && shares.last() == Some(&1.0), "{shares:?}");

    // Far more work than is waited for.
    stage.quality.step *= 0.1;
    stage.quality.supersampling = 4;
    let cancel = Cancel::default();
    let mut frame = first.clone();
    let (stopped, at) = std::thread::scope(|scope| {
        let at = scope.spawn(|| {
            std::thread::sleep(Duration::from_millis(300));
            cancel.cancel();
            Instant::now()
        });
        let stopped = gpu.render_into(&stage, &Control { cancel: Some(&cancel), ..Control::default() }, &mut frame);
        (stopped, at.join().unwrap().elapsed())
    });
    assert_eq!(stopped, Err(GpuError::Cancelled));
    assert_eq!(frame.color, first.color);
    // Of 50 ms, and as much again for a machine that has other things to do.
    assert!(at < Duration::from_millis(100), "{at:?}");
}
