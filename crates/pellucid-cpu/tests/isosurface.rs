//! Isosurfaces found along rays: exact roots, right normals, right order.

mod common;

use common::{center, render, set_mode, stage, transfer_function, unit_volume};
use glam::DVec3;
use pellucid_field::Volume;
use pellucid_optics::Color;
use pellucid_scene::{Isosurface, Isovalue, Mode, Scene};

fn surfaces(levels: &[(f64, u32, f32)]) -> Mode {
    let level =
        |&(value, color, opacity): &(f64, u32, f32)| Isovalue { value, color: Some(Color::hex(color)), opacity };
    Mode::Isosurface(Isosurface { isovalues: levels.iter().map(level).collect() })
}

fn ball() -> Volume {
    let middle = DVec3::splat(15.5);
    unit_volume([32; 3], |p| 16.0 - (p - middle).length())
}

/// The hit of every pixel lies on the trilinear field's own surface to 1e-4 voxel, at any step.
#[test]
fn roots_are_exact_at_any_step() {
    for step in [0.2, 1.0, 3.0] {
        let volume = ball();
        let tf = common::homogeneous(1.0);
        let stage = stage(volume.clone(), tf, |scene| {
            set_mode(scene, surfaces(&[(6.0, 0xffffff, 1.0)]));
            scene.quality.step = step;
        });
        let frame = render(&stage);
        let sampler = pellucid_field::Sampler::new(&volume, 0, pellucid_field::Filter::Linear).unwrap();
        let mut hits = 0;
        for (pixel, depth) in frame.depth.iter().enumerate().filter(|(_, depth)| depth.is_finite()) {
            let ray = stage.viewpoint.ray((pixel % 16) as f64 + 0.5, (pixel / 16) as f64 + 0.5);
            let value = |t: f64| sampler.value_world(ray.at(t)) - 6.0;
            let depth = f64::from(*depth);
            // The sign changes within 1e-4 voxel around the hit (and f32's rounding of the depth).
            assert!(value(depth - 1e-4) * value(depth + 1e-4) < 0.0, "step {step}, pixel {pixel}: {}", value(depth));
            hits += 1;
        }
        assert!(hits > 30, "{hits} hits");
    }
}

/// Against the sphere itself: within the interpolation bound 1 / (4 r) voxel (5.5-8), and normals
/// within a degree of the radial direction.
#[test]
fn a_ball_has_its_radius_and_its_normals() {
    let stage = stage(ball(), common::homogeneous(1.0), |scene| set_mode(scene, surfaces(&[(6.0, 0xffffff, 1.0)])));
    let frame = render(&stage);
    for (pixel, depth) in frame.depth.iter().enumerate().filter(|(_, depth)| depth.is_finite()) {
        let ray = stage.viewpoint.ray((pixel % 16) as f64 + 0.5, (pixel / 16) as f64 + 0.5);
        let radial = ray.at(f64::from(*depth)) - DVec3::splat(15.5);
        assert!((radial.length() - 10.0).abs() < 1.0 / 40.0 + 1e-4, "radius {}", radial.length());
        let normal = glam::Vec3::from_array(frame.normal[pixel]).as_dvec3();
        let angle = normal.angle_between(radial).to_degrees();
        assert!(angle < 1.0, "normal off by {angle} degrees");
    }
}

#[test]
fn the_nearer_surface_is_in_front_and_shines_through() {
    let unlit = |scene: &mut Scene| scene.volumes[0].shading = Some(false);
    let draw = |levels: &[(f64, u32, f32)]| {
        let frame = render(&stage(ball(), common::homogeneous(1.0), |scene| {
            unlit(scene);
            set_mode(scene, surfaces(levels));
        }));
        center(&frame)
    };
    // Larger values lie inside. The order in the document does not matter.
    for levels in [[(4.0, 0xff0000, 0.25), (10.0, 0x0000ff, 1.0)], [(10.0, 0x0000ff, 1.0), (4.0, 0xff0000, 0.25)]] {
        assert_eq!(draw(&levels), [0.25, 0.0, 0.75, 1.0]);
    }
    // An opaque outer surface hides the inner one; the far side of the outer one is seen through.
    assert_eq!(draw(&[(4.0, 0xff0000, 1.0), (10.0, 0x0000ff, 1.0)]), [1.0, 0.0, 0.0, 1.0]);
    assert_eq!(draw(&[(4.0, 0xff0000, 0.5)]), [0.75, 0.0, 0.0, 0.75]);
}

#[test]
fn a_surface_takes_the_transfer_function_for_its_color() {
    let tf = transfer_function(&[(0.0, 0x000000), (6.0, 0x00ff00), (16.0, 0x000000)], &[(0.0, 0.0)]);
    let mode = Mode::Isosurface(Isosurface { isovalues: vec![Isovalue { value: 6.0, color: None, opacity: 1.0 }] });
    let frame = render(&stage(ball(), tf, |scene| set_mode(scene, mode)));
    assert_eq!(center(&frame), [0.0, 1.0, 0.0, 1.0]);
}
