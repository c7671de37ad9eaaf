//! A changed part of a volume is uploaded alone, and looks as if all of it had been.

mod common;

use std::sync::Arc;
use std::time::Instant;

use common::{MODES, draw, gpu, sample, side, stage};
use pellucid_field::{Grid, Volume, VoxelType};
use pellucid_gpu::{Ceiling, GpuError, Part};

const SIZE: [u32; 2] = [48, 40];

/// The volume with other numbers in a part.
fn changed(volume: &Volume, part: Part) -> Arc<Volume> {
    let grid = *volume.grid();
    let mut values: Vec<f32> = (0..grid.len()).map(|k| volume.voxels().get(k) as f32).collect();
    for z in part.low[2]..part.high[2] {
        for y in part.low[1]..part.high[1] {
            for x in part.low[0]..part.high[0] {
                let value = &mut values[grid.linear_index([x, y, z])];
                *value = 1.0 - *value;
            }
        }
    }
    Arc::new(Volume::new(grid, values).unwrap())
}

#[test]
fn a_part_that_changed_is_there_in_the_next_frame() {
    let old = sample("marschner-lobb", [33, 29, 35], VoxelType::F32);
    for ceiling in
        [Ceiling::default(), side(12), Ceiling { memory: Some((4 << 20) + (200 << 10)), ..Ceiling::default() }]
    {
        let (mut updated, mut fresh) = (gpu(&ceiling), gpu(&ceiling));
        let mut volume = old.clone();
        for (k, part) in [
            Part { low: [3, 5, 7], high: [20, 6, 30] },
            Part { low: [0, 0, 0], high: [33, 29, 35] },
            Part { low: [32, 28, 34], high: [33, 29, 35] },
            Part { low: [8, 8, 8], high: [8, 20, 20] },
        ]
        .into_iter()
        .enumerate()
        {
            let document = MODES[[1, 4, 5, 10][k]].1;
            draw(&mut updated, &stage(&volume, document, SIZE));
            let new = changed(&volume, part);
            updated.update(&new, part).unwrap();
            let stage = stage(&new, document, SIZE);
            assert_eq!(draw(&mut updated, &stage).color, draw(&mut fresh, &stage).color, "{part:?} {ceiling:?}");
            volume = new;
        }
    }
}

#[test]
fn voxels_outside_the_part_stay() {
    // Only the part is sent: what the new volume has elsewhere is not seen.
    let old = sample("marschner-lobb", [20; 3], VoxelType::F32);
    let all = changed(&old, Part { low: [0; 3], high: [20; 3] });
    let document = "transfer_function = { colors = [{ value = 0.0, color = [1, 0, 0] }, { value = 1.0, color = [0, 1, 0] }], \
        opacities = [{ value = 0.0, opacity = 0.5 }] }\n[technique.ray_cast]\nmode = \"average\"\n[camera]\nframe = \"grid\"";
    let mut gpu = gpu(&Ceiling::default());
    let before = draw(&mut gpu, &stage(&old, document, SIZE));
    gpu.update(&all, Part { low: [0; 3], high: [1; 3] }).unwrap();
    let after = draw(&mut gpu, &stage(&all, document, SIZE));
    // Tables over the range of other values round otherwise.
    let near = |(a, b): &(&[f32; 4], &[f32; 4])| a.iter().zip(*b).all(|(a, b)| (a - b).abs() < 1e-5);
    let same = before.color.iter().zip(&after.color).filter(near).count();
    assert!(same > before.color.len() / 2, "{same}");
}

#[test]
fn parts_and_volumes_that_do_not_fit() {
    let old = sample("marschner-lobb", [20; 3], VoxelType::F32);
    let mut gpu = gpu(&Ceiling::default());
    // Nothing was drawn yet: nothing to do.
    gpu.update(&old, Part { low: [0; 3], high: [20; 3] }).unwrap();
    draw(&mut gpu, &stage(&old, "", SIZE));
    let error = gpu.update(&old, Part { low: [0; 3], high: [21, 20, 20] }).unwrap_err();
    assert!(matches!(error, GpuError::Part { .. }), "{error}");
    // Another type and shape: uploaded anew when it is drawn.
    let other = sample("marschner-lobb", [20, 10, 20], VoxelType::U8);
    gpu.update(&other, Part { low: [0; 3], high: [1; 3] }).unwrap();
    let stage = stage(&other, "", SIZE);
    assert_eq!(draw(&mut gpu, &stage).color, draw(&mut common::gpu(&Ceiling::default()), &stage).color);
}

/// `cargo test -p pellucid-gpu --test updates -- --nocapture` prints what uploads take.
#[test]
fn uploads_are_measured() {
    let grid = Grid::new([128; 3]).unwrap();
    let mut gpu = gpu(&Ceiling::default());
    let all = Part { low: [0; 3], high: [128; 3] };
    let volumes = [
        Volume::new(grid, vec![7u8; grid.len()]),
        Volume::new(grid, vec![7u16; grid.len()]),
        Volume::new(grid, vec![7f32; grid.len()]),
    ];
    for volume in volumes {
        let volume = Arc::new(volume.unwrap());
        draw(&mut gpu, &stage(&volume, "preset = \"simulation\"", [8, 8]));
        let started = Instant::now();
        gpu.update(&volume, all).unwrap();
        let sent = started.elapsed();
        gpu.device().wait().unwrap();
        let bytes = volume.voxels().as_bytes().len() as f64;
        println!(
            "{} 128^3: sent in {sent:.1?}, there after {:.1?}, {:.2} GB/s",
            volume.voxels().voxel_type(),
            started.elapsed(),
            bytes / started.elapsed().as_secs_f64() / 1e9
        );
    }
}
