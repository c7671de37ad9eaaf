//! Volumes of every type, shape and scale look as on the CPU.

use std::sync::Arc;

use crate::gpu_common::{LEVEL, MODES, device, difference, draw, gpu, sample, stage, with_holes};
use pellucid_cpu::CpuRenderer;
use pellucid_field::{Grid, ValueMap, Volume, VoxelType};
use pellucid_gpu::{Ceiling, GpuRenderer, Interpolation};
use pellucid_scene::{Control, Frame, Stage};

const SIZE: [u32; 2] = [48, 40];

/// What the CPU backend draws.
fn cpu(stage: &Stage) -> Frame {
    CpuRenderer::new().render(stage, &Control::default()).unwrap()
}

/// Draws stages on both backends; returns how far they are apart.
fn apart(gpu: &mut GpuRenderer, stage: &Stage) -> (f32, Frame) {
    let found = draw(gpu, stage);
    (difference(&found, &cpu(stage)), found)
}

fn agree(name: &str, gpu: &mut GpuRenderer, stage: &Stage) {
    let (apart, found) = apart(gpu, stage);
    assert!(apart <= 2.0 * LEVEL, "{name}: {:.2} levels apart", apart / LEVEL);
    assert!(found.statistics.samples_visible > 0, "{name}: nothing is seen");
}

#[test]
fn voxels_of_every_type_and_in_several_components() {
    let mut gpu = gpu(&Ceiling::default());
    for voxel_type in VoxelType::ALL {
        let volume = sample("marschner-lobb", [20, 19, 21], voxel_type);
        for (name, mode) in &MODES[..6] {
            agree(&format!("{voxel_type} {name}"), &mut gpu, &stage(&volume, mode, SIZE));
        }
    }
    // Numbers over the whole range of a signed type, the second component drawn, mapped to other values.
    let grid = Grid::with_spacing([16, 15, 14], [0.1; 3], [0.0; 3]).unwrap();
    let value = |k: usize| ((k as f64 * 0.01).sin() * f64::from(i16::MAX)) as i16;
    let voxels: Vec<i16> = (0..grid.len()).flat_map(|k| [i16::MIN, value(k)]).collect();
    let volume = Volume::with_components(grid, voxels, 2).unwrap();
    let volume = Arc::new(volume.with_value_map(ValueMap { scale: -0.5, offset: 300.0 }).unwrap());
    agree("two components", &mut gpu, &stage(&volume, "component = 1\nshading = true", SIZE));
}

#[test]
fn absent_voxels_in_every_mode() {
    let volume = with_holes("marschner-lobb", [22, 21, 23]);
    let mut gpu = gpu(&Ceiling::default());
    for (name, mode) in MODES {
        let mut stage = stage(&volume, mode, SIZE);
        let found = draw(&mut gpu, &stage);
        // The field jumps at a hole's border: a sample within a rounding of it is there or is not. What the
        // processor draws from a hundred-thousandth of a voxel beside the eye has such samples on the other side.
        let beside = 1e-5 * volume.grid().mean_spacing();
        let eye = stage.viewpoint.eye;
        let mut differ: Vec<usize> = (0..found.color.len()).collect();
        for number in 0..9 {
            // Its own place, and beside it towards the corners of a cube.
            for axis in (0..3).filter(|_| number > 0) {
                stage.viewpoint.eye[axis] = eye[axis] + if (number - 1) >> axis & 1 == 0 { beside } else { -beside };
            }
            let expected = cpu(&stage);
            let apart = |a: &[f32; 4], b: &[f32; 4]| a.iter().zip(b).any(|(a, b)| (a - b).abs() > 2.0 * LEVEL);
            differ.retain(|&pixel| apart(&found.color[pixel], &expected.color[pixel]));
            if number == 0 && !differ.is_empty() {
                println!("{name}: {} pixels of {} depend on roundings", differ.len(), found.color.len());
            }
        }
        assert!(differ.is_empty(), "{name}: {} pixels differ, {:?}", differ.len(), &differ[..differ.len().min(5)]);
    }
    let grid = Grid::new([5; 3]).unwrap();
    for value in [f32::NAN, f32::INFINITY] {
        let nothing = Arc::new(Volume::new(grid, vec![value; grid.len()]).unwrap());
        let drawn = draw(&mut gpu, &stage(&nothing, "preset = \"simulation\"", SIZE));
        assert!(drawn.color.iter().all(|&c| c == [0.0; 4]) && !drawn.warnings.is_empty());
    }
}

#[test]
fn volumes_of_one_voxel_thickness() {
    let mut gpu = gpu(&Ceiling::default());
    for dims in [[24, 1, 20], [1, 1, 24], [1, 1, 1]] {
        let volume = sample("ball", dims, VoxelType::U16);
        for (name, mode) in &MODES[..9] {
            let (apart, _) = apart(&mut gpu, &stage(&volume, mode, SIZE));
            assert!(apart <= 2.0 * LEVEL, "{dims:?} {name}: {:.2} levels apart", apart / LEVEL);
        }
    }
}

#[test]
fn worlds_in_tiny_and_huge_units() {
    let plain = sample("marschner-lobb", [20, 19, 21], VoxelType::F32);
    let mut gpu = gpu(&Ceiling::default());
    for unit in [1e-12, 1e-3, 1e6, 1e12] {
        let grid = Grid::with_spacing([20, 19, 21], [unit, unit * 1.5, unit * 0.7], [unit * 1e3; 3]).unwrap();
        let volume = Arc::new(Volume::clone(&plain).with_grid(grid).unwrap());
        for (name, mode) in &MODES[..2] {
            agree(&format!("{unit} {name}"), &mut gpu, &stage(&volume, mode, SIZE));
        }
    }
}

/// How far the texture unit's interpolation is from the exact one, by format. The software driver of
/// Mesa blends 8-bit texels in 8-bit fixed point, which steep opacities and gradients magnify (27 levels of 255
/// measured with Mesa 22.3), and all others in single precision (0). Hardware has 8 bits between texels for
/// every format.
#[test]
fn the_sampler_of_every_format() {
    let mut exact = gpu(&Ceiling::default());
    let mut failures = Vec::new();
    let mut fast = GpuRenderer::on(device(&Ceiling::default())).with_interpolation(Interpolation::Hardware);
    for (voxel_type, most) in
        [(VoxelType::U8, 30.0), (VoxelType::U16, 0.5), (VoxelType::F16, 0.5), (VoxelType::F32, 0.5)]
    {
        let volume = sample("marschner-lobb", [32, 31, 33], voxel_type);
        let mut worst = 0.0f32;
        for (name, mode) in &MODES[..10] {
            let stage = stage(&volume, mode, SIZE);
            let apart = difference(&draw(&mut fast, &stage), &draw(&mut exact, &stage)) / LEVEL;
            println!("{voxel_type} {name}: {apart:.2} levels");
            worst = worst.max(apart);
        }
        if worst > most {
            failures.push(format!("{voxel_type}: {worst:.2} levels apart, {most} expected"));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
