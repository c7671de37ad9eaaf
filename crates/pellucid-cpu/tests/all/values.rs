//! What values become where tables are tempted to be coarse: narrow parts of a transfer function, jumps, values that no
//! voxel has, ends of rays. Against closed forms, and the f64 reference that knows no tables.

#[allow(dead_code, reason = "tables stand for integrals elsewhere")]
use crate::common::{center, render, stage, transfer_function, unit_volume};
use crate::reference::{Reading, Reference};
use glam::DVec3;
use pellucid_field::{Filter, Grid, SincWindow, Volume, VoxelType, Voxels};
use pellucid_optics::TransferFunction;
use pellucid_plan::PlanCache;
use pellucid_scene::{Classification, Framing, Projection, Stage};

const CLASSIFICATIONS: [Classification; 3] = [Classification::Post, Classification::Pre, Classification::PreIntegrated];

/// A volume of any type of voxel.
fn typed(voxel_type: VoxelType, dims: [usize; 3], value: impl Fn(DVec3) -> f64) -> Volume {
    let volume = unit_volume(dims, value);
    let numbers: Vec<f64> = (0..volume.grid().len())
        .map(|k| volume.value([k % dims[0], k / dims[0] % dims[1], k / (dims[0] * dims[1])], 0))
        .collect();
    let voxels = match voxel_type {
        VoxelType::U8 => Voxels::from(numbers.iter().map(|v| *v as u8).collect::<Vec<_>>()),
        VoxelType::U16 => Voxels::from(numbers.iter().map(|v| *v as u16).collect::<Vec<_>>()),
        VoxelType::I16 => Voxels::from(numbers.iter().map(|v| *v as i16).collect::<Vec<_>>()),
        VoxelType::U32 => Voxels::from(numbers.iter().map(|v| *v as u32).collect::<Vec<_>>()),
        _ => Voxels::from(numbers.iter().map(|v| *v as f32).collect::<Vec<_>>()),
    };
    Volume::new(Grid::new(dims).unwrap(), voxels).unwrap()
}

fn classified(volume: Volume, tf: &TransferFunction, classification: Classification, step: f64) -> Stage {
    stage(volume, tf.clone(), |scene| {
        scene.quality.classification = classification;
        scene.quality.step = step;
        scene.camera.projection = Projection::Orthographic { height: Some(1e-3) };
        scene.camera.frame = Framing::Grid;
    })
}

#[test]
fn a_peak_of_a_millionth_of_the_range_is_seen() {
    // All 1 but for a corner with the end of the range.
    let tf = transfer_function(&[(0.0, 0xffffff), (1e6, 0xffffff)], &[(0.5, 0.0), (1.0, 0.5), (1.5, 0.0)]);
    for voxel_type in [VoxelType::F32, VoxelType::U32] {
        let value = |p: DVec3| if p == DVec3::ZERO { 1e6 } else { 1.0 };
        for classification in CLASSIFICATIONS {
            let volume = typed(voxel_type, [9, 3, 9], value);
            let alpha = center(&render(&classified(volume, &tf, classification, 0.3)))[3];
            assert!((alpha - 0.75).abs() < 1e-4, "{voxel_type}, {classification:?}: {alpha}");
        }
    }
}

#[test]
fn beside_a_peak_there_is_no_matter() {
    let tf = transfer_function(
        &[(0.0, 0xffffff)],
        &[(0.0, 0.0), (30_000.0, 0.0), (30_020.0, 0.9), (30_040.0, 0.0), (65_535.0, 0.0)],
    );
    for voxel_type in [VoxelType::U16, VoxelType::F32] {
        for constant in [29_990.0, 30_041.0, 30_060.0, 30_100.0] {
            let value = |p: DVec3| {
                if p == DVec3::ZERO {
                    65_535.0
                } else if p.x == 8.0 && p.z == 8.0 {
                    0.0
                } else {
                    constant
                }
            };
            for classification in CLASSIFICATIONS {
                let volume = typed(voxel_type, [9, 40, 9], value);
                let color = center(&render(&classified(volume, &tf, classification, 0.5)));
                assert_eq!(color, [0.0; 4], "{voxel_type}, {classification:?} of {constant}");
            }
        }
    }
}

/// A ramp through a jump has matter behind it, from the value itself on, at every depth of voxels (8, 16, 32 bits, float).
#[test]
fn jumps_are_where_they_are() {
    for (voxel_type, slope) in
        [(VoxelType::U8, 1.0), (VoxelType::I16, 1.0), (VoxelType::U32, 2.0), (VoxelType::F32, 0.25)]
    {
        for at in [20.0, 20.3, 20.8] {
            let tf = transfer_function(&[(0.0, 0xffffff)], &[(0.0, 0.0), (at, 0.0), (at, 0.05), (250.0, 0.05)]);
            // Values 0 to 60 slopes, and a voxel that widens the range.
            let value = |p: DVec3| if p == DVec3::ZERO { 250.0 } else { 10.0 + slope * p.y };
            let length = 60.0 - (at - 10.0) / slope;
            let exact = 1.0 - 0.95f64.powf(length);
            for (classification, step) in [(Classification::Post, 0.01), (Classification::PreIntegrated, 0.7)] {
                let volume = typed(voxel_type, [9, 61, 9], value);
                let alpha = f64::from(center(&render(&classified(volume, &tf, classification, step)))[3]);
                // A hundredth of a voxel of matter, or a share of a step that crosses the jump.
                assert!(
                    (alpha - exact).abs() < 6e-4,
                    "{voxel_type}, jump at {at}, {classification:?}: {alpha}, {exact}"
                );
            }
        }
    }
}

/// A ramp of colour in constant extinction (4.5-1): the closed form at any step, of which the ends of rays have parts.
#[test]
fn ends_of_rays_have_the_color_of_their_length() {
    for depth in [0.5, 2.0, 6.0f64] {
        let opacity = 1.0 - (-depth / 2.0).exp();
        // Linear light from 0 to 1 as the ramp goes from 0 to 2 along the ray.
        let mut tf = transfer_function(&[(0.0, 0x000000), (2.0, 0xffffff)], &[(0.0, opacity as f32)]);
        tf = tf.with_color_space(pellucid_optics::ColorSpace::Linear);
        let transparency = (-depth).exp();
        let exact = (1.0 - (1.0 + depth) * transparency) / depth;
        for (reversed, exact) in [(false, exact), (true, 1.0 - transparency - exact)] {
            for step in [0.1, 0.37, 1.0, 1.5, 2.0] {
                let volume = unit_volume([5, 3, 5], |p| if reversed { 2.0 - p.y } else { p.y });
                let color = center(&render(&classified(volume, &tf, Classification::PreIntegrated, step)));
                let [red, alpha] = [f64::from(color[0]), f64::from(color[3])];
                let what = format!("depth {depth}, step {step}, reversed {reversed}");
                assert!((alpha - (1.0 - transparency)).abs() < 1e-5, "{what}: {alpha}");
                assert!((red - exact).abs() < 1e-4 + 2e-3 * exact, "{what}: {red}, exact {exact}");
            }
        }
    }
}

/// Filters that overshoot make values beyond the data's, which have their own colours.
#[test]
fn values_beyond_those_of_voxels_are_classified_as_what_they_are() {
    let tf = transfer_function(
        &[(0.0, 0xff0000), (100.0, 0xff0000), (101.0, 0x0000ff), (140.0, 0x00ffff)],
        &[(-20.0, 0.9), (0.0, 0.05), (100.0, 0.05), (105.0, 0.8), (130.0, 0.2)],
    );
    let lanczos = Filter::Sinc { window: SincWindow::Lanczos, half_width: 3 };
    for filter in [Filter::CATMULL_ROM, Filter::BSpline { prefilter: true }, lanczos, Filter::MITCHELL] {
        for voxel_type in [VoxelType::U8, VoxelType::U16, VoxelType::F32] {
            let edge = typed(voxel_type, [12, 12, 12], |p| if p.y < 5.0 || p.x > 8.0 { 0.0 } else { 100.0 });
            for classification in [Classification::Post, Classification::PreIntegrated] {
                let stage = stage(edge.clone(), tf.clone(), |scene| {
                    scene.quality.filter = filter;
                    scene.quality.classification = classification;
                    scene.quality.step = 0.21;
                });
                let range = PlanCache::default().tables(&stage, 0).unwrap().range;
                assert!(range.low < -1.0 && range.high > 101.0, "{filter:?}: {range:?}");
                let frame = render(&stage);
                let reference = Reference::new(&stage, Reading::default());
                for pixel in (0..256).step_by(7) {
                    let exact = reference.pixel(pixel % 16, pixel / 16).unwrap().color;
                    for (found, exact) in frame.color[pixel].into_iter().zip(exact) {
                        // Slices of the reference's segments are as coarse.
                        let near = (f64::from(found) - exact).abs() < 6e-3;
                        assert!(near, "{filter:?}, {voxel_type}, {classification:?}, {pixel}: {found}, exact {exact}");
                    }
                }
            }
        }
    }
}

/// Absent voxels, several types: voxels are classified as the reference does it.
#[test]
fn classified_voxels_are_interpolated() {
    let tf =
        transfer_function(&[(0.0, 0xff2010), (30.0, 0x10ff40)], &[(2.0, 0.0), (9.0, 0.6), (9.0, 0.1), (25.0, 0.9)]);
    let value = |p: DVec3| (15.0 + 14.0 * (p.x * 1.9 + p.y * 0.8).sin() * (p.z * 1.3 - p.y).cos()).round();
    let holes =
        unit_volume([7, 8, 9], |p| if (p.x + 2.0 * p.y + 3.0 * p.z) % 11.0 == 0.0 { f64::NAN } else { value(p) });
    let volumes = [VoxelType::U8, VoxelType::I16, VoxelType::U32, VoxelType::F32].map(|t| typed(t, [7, 8, 9], value));
    for volume in volumes.into_iter().chain([holes]) {
        let stage = stage(volume.clone(), tf.clone(), |scene| {
            scene.quality.classification = Classification::Pre;
            scene.quality.step = 0.4;
        });
        let (frame, reference) = (render(&stage), Reference::new(&stage, Reading::default()));
        for pixel in 0..256 {
            let exact = reference.pixel(pixel % 16, pixel / 16).unwrap().color;
            for (found, exact) in frame.color[pixel].into_iter().zip(exact) {
                assert!((f64::from(found) - exact).abs() < 1e-4, "{pixel}: {found}, exact {exact}");
            }
        }
    }
}
