//! Projections against what they mean, column by column.

use crate::common::{render, set_mode, stage, transfer_function, unit_volume};
use glam::DVec3;
use pellucid_scene::{Combine, Mode, Projection, Scene, Slice};

fn field(p: DVec3) -> f64 {
    0.5 + 0.5 * (p.x * 1.3 + p.y * 2.9 + p.z * 0.7).sin()
}

/// One pixel per voxel column along y, samples on the voxels.
fn columns(scene: &mut Scene) {
    scene.image.width = 8;
    scene.image.height = 8;
    scene.camera.projection = Projection::Orthographic { height: Some(8.0) };
    // Eleven voxels, ten steps: with the sample in the middle of a step of 1 the voxels would lie
    // between samples; a step of 1/8 has a sample near every voxel.
    scene.quality.step = 0.125;
}

#[test]
fn the_extremes_are_those_of_the_columns() {
    let gray = transfer_function(&[(0.0, 0x000000), (1.0, 0xffffff)], &[(0.0, 1.0)])
        .with_color_space(pellucid_optics::ColorSpace::Linear);
    for (mode, pick) in [(Mode::Maximum, f64::max as fn(f64, f64) -> f64), (Mode::Minimum, f64::min)] {
        let volume = unit_volume([8, 11, 8], field);
        let frame = render(&stage(volume, gray.clone(), |scene| {
            columns(scene);
            set_mode(scene, mode.clone());
        }));
        for (x, z) in (0..8).flat_map(|z| (0..8).map(move |x| (x, z))) {
            let along = (0..11).map(|y| field(DVec3::new(x as f64, y as f64, z as f64)));
            let extreme = along.reduce(pick).unwrap();
            let drawn = f64::from(frame.color[(7 - z) * 8 + x][0]);
            // Linear interpolation never exceeds the voxels; the nearest sample is 1/16 voxel away.
            assert!((drawn - extreme).abs() < 0.07, "{mode:?} at {x}, {z}: {drawn}, {extreme}");
            assert!(if mode == Mode::Maximum { drawn <= extreme + 1e-6 } else { drawn >= extreme - 1e-6 });
        }
    }
}

#[test]
fn the_average_is_the_integral_over_the_length() {
    let gray = transfer_function(&[(0.0, 0x000000), (1.0, 0xffffff)], &[(0.0, 1.0)])
        .with_color_space(pellucid_optics::ColorSpace::Linear);
    let volume = unit_volume([8, 11, 8], field);
    let frame = render(&stage(volume, gray, |scene| {
        columns(scene);
        set_mode(scene, Mode::Average);
    }));
    for (x, z) in (0..8).flat_map(|z| (0..8).map(move |x| (x, z))) {
        let value = |y: usize| field(DVec3::new(x as f64, y as f64, z as f64));
        let trapezoid = (0..10).map(|y| (value(y) + value(y + 1)) / 2.0).sum::<f64>() / 10.0;
        let drawn = f64::from(frame.color[(7 - z) * 8 + x][0]);
        assert!((drawn - trapezoid).abs() < 1e-5, "at {x}, {z}: {drawn}, {trapezoid}");
    }
}

/// A plane through a linear field shows it exactly, at any orientation.
#[test]
fn a_slice_of_a_ramp_is_the_ramp_at_the_plane() {
    let gray = transfer_function(&[(0.0, 0x000000), (30.0, 0xffffff)], &[(0.0, 0.0)])
        .with_color_space(pellucid_optics::ColorSpace::Linear);
    let normal = DVec3::new(0.3, -0.9, 0.4);
    let point = DVec3::new(4.0, 5.0, 4.5);
    let ramp = |p: DVec3| p.x + 2.0 * p.y + 0.5 * p.z;
    let stage = stage(unit_volume([9, 11, 10], ramp), gray, |scene| {
        let slice = Slice { point: Some(point.to_array()), normal: Some(normal.to_array()), ..Slice::default() };
        set_mode(scene, Mode::Slice(slice));
    });
    let frame = render(&stage);
    let mut seen = 0;
    for (pixel, color) in frame.color.iter().enumerate().filter(|(_, color)| color[3] > 0.0) {
        let ray = stage.viewpoint.ray((pixel % 16) as f64 + 0.5, (pixel / 16) as f64 + 0.5);
        let hit = ray.at(f64::from(frame.depth[pixel]));
        assert!((hit - point).dot(normal).abs() < 1e-4, "the hit lies on the plane");
        assert!((f64::from(color[0]) * 30.0 - ramp(hit)).abs() < 1e-3);
        assert_eq!(color[3], 1.0, "a slice is opaque whatever the transfer function");
        seen += 1;
    }
    assert!(seen > 60, "{seen} pixels");
}

/// A slab takes only what lies within its thickness.
#[test]
fn a_thick_slab_projects_its_own_values() {
    let gray = transfer_function(&[(0.0, 0x000000), (20.0, 0xffffff)], &[(0.0, 1.0)])
        .with_color_space(pellucid_optics::ColorSpace::Linear);
    for (combine, expected) in [(Combine::Maximum, 7.0), (Combine::Minimum, 3.0), (Combine::Average, 5.0)] {
        let slice = Slice { point: Some([4.0, 5.0, 4.0]), normal: Some([0.0, 2.0, 0.0]), thickness: 4.0, combine };
        let stage = stage(unit_volume([9, 11, 9], |p| p.y), gray.clone(), |scene| {
            set_mode(scene, Mode::Slice(slice));
            scene.quality.step = 0.01;
        });
        let drawn = f64::from(crate::common::center(&render(&stage))[0]) * 20.0;
        assert!((drawn - expected).abs() < 0.01, "{combine:?}: {drawn}");
    }
}
