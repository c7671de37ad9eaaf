//! Clips and crops are part of the field: length, surfaces and gradients see them alike.

use crate::common::{center, homogeneous, render, set_mode, stage, transfer_function, unit_volume};
use glam::DVec3;
use pellucid_optics::Color;
use pellucid_scene::{Clip, Crop, Isosurface, Isovalue, Mode};

fn opacity(length: f64) -> f64 {
    1.0 - 0.9f64.powf(length)
}

#[test]
fn planes_boxes_and_crops_cut_the_same_length() {
    let draw = |edit: &dyn Fn(&mut pellucid_scene::Scene)| {
        let stage = stage(unit_volume([16, 21, 16], |_| 1.0), homogeneous(0.1), |scene| edit(scene));
        f64::from(center(&render(&stage))[3])
    };
    let everything = draw(&|_| ());
    assert!((everything - opacity(20.0)).abs() < 1e-5);
    let plane = draw(&|scene| scene.clips = vec![Clip::Plane { point: [0.0, 13.0, 0.0], normal: [0.0, 3.0, 0.0] }]);
    let boxed = draw(&|scene| scene.clips = vec![Clip::Box { min: [-9.0, 13.0, -9.0], max: [99.0, 99.0, 99.0] }]);
    let crop = draw(&|scene| scene.volumes[0].crop = Some(Crop { from: [0.0, 13.0, 0.0], to: [15.0, 20.0, 15.0] }));
    for drawn in [plane, boxed, crop] {
        assert!((drawn - opacity(7.0)).abs() < 1e-5, "{drawn}");
    }
    // The other side, and both sides together: transparencies multiply (C-23's identity).
    let other = draw(&|scene| scene.clips = vec![Clip::Plane { point: [0.0, 13.0, 0.0], normal: [0.0, -1.0, 0.0] }]);
    assert!(((1.0 - plane) * (1.0 - other) - (1.0 - everything)).abs() < 1e-5);
}

/// A cut through a ramp that rises across the cut: the gradient at the face is the ramp's own, not
/// the difference to something beyond the cut (USERS theme G: dark cut faces).
#[test]
fn the_gradient_at_a_cut_is_that_of_what_is_left() {
    let gradient = DVec3::new(0.3, 1.0, 0.2);
    // Beyond the cut the field jumps; a gradient that looked there would be turned around.
    let volume = unit_volume([16, 24, 16], |p| if p.y < 12.0 { 1000.0 - 80.0 * p.y } else { gradient.dot(p) });
    let stage = stage(volume, transfer_function(&[(0.0, 0xffffff)], &[(0.0, 1.0)]), |scene| {
        scene.clips = vec![Clip::Plane { point: [0.0, 12.2, 0.0], normal: [0.0, 1.0, 0.0] }];
        scene.quality.step = 0.05;
    });
    let frame = render(&stage);
    let normal = glam::Vec3::from_array(frame.normal[8 * 16 + 8]).as_dvec3();
    let angle = normal.angle_between(-gradient).to_degrees();
    assert!(angle < 0.1, "the normal is off by {angle} degrees: {normal}");
}

#[test]
fn an_isosurface_is_clipped() {
    let ball = unit_volume([32; 3], |p| 16.0 - (p - DVec3::splat(15.5)).length());
    let isovalues = vec![Isovalue { value: 6.0, color: Some(Color::WHITE), opacity: 1.0, volume: None }];
    let stage = stage(ball, homogeneous(0.0), |scene| {
        set_mode(scene, Mode::Isosurface(Isosurface::new(isovalues)));
        scene.clips = vec![Clip::Plane { point: [0.0, 15.5, 0.0], normal: [0.0, 1.0, 0.0] }];
        scene.image.width = 17;
        scene.image.height = 17;
    });
    let frame = render(&stage);
    let pixel = 8 * 17 + 8;
    let hit = stage.viewpoint.ray(8.5, 8.5).at(f64::from(frame.depth[pixel]));
    // The front half is gone: the ray meets the back of the ball from inside.
    assert!((hit.y - 25.5).abs() < 0.1, "{hit}");
}
