//! Isosurfaces found along rays: exact roots, right normals, right order.

use crate::common::{center, render, set_mode, stage, transfer_function, unit_volume, volume_of};
use glam::{DAffine3, DMat3, DVec3};
use pellucid_field::Volume;
use pellucid_optics::Color;
use pellucid_scene::{Isosurface, Isovalue, LookAt, Mode, Orbit, Projection, Scene, View};

fn surfaces(levels: &[(f64, u32, f32)]) -> Mode {
    let level = |&(value, color, opacity): &(f64, u32, f32)| Isovalue {
        value,
        color: Some(Color::hex(color)),
        opacity,
        volume: None,
    };
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
        let tf = crate::common::homogeneous(1.0);
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
    let stage =
        stage(ball(), crate::common::homogeneous(1.0), |scene| set_mode(scene, surfaces(&[(6.0, 0xffffff, 1.0)])));
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
        let frame = render(&stage(ball(), crate::common::homogeneous(1.0), |scene| {
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
    let mode = Mode::Isosurface(Isosurface {
        isovalues: vec![Isovalue { value: 6.0, color: None, opacity: 1.0, volume: None }],
    });
    let frame = render(&stage(ball(), tf, |scene| set_mode(scene, mode)));
    assert_eq!(center(&frame), [0.0, 1.0, 0.0, 1.0]);
}

/// Normals are out of the surface towards lower values, whichever side the eye is on: inside a hollow, and where a
/// cut opens the ball from behind.
#[test]
fn normals_point_to_lower_values_from_within_and_without() {
    let middle = DVec3::splat(15.5);
    for (sign, inside) in [(1.0, false), (-1.0, false), (1.0, true), (-1.0, true)] {
        let volume = unit_volume([32; 3], |p| sign * (10.0 - (p - middle).length()));
        let stage = stage(volume, crate::common::homogeneous(1.0), |scene| {
            set_mode(scene, surfaces(&[(0.0, 0xffffff, 1.0)]));
            if inside {
                let (position, target) = ([15.5, 13.0, 15.5], [15.5, 20.0, 15.5]);
                let look = LookAt { position, target, up: [0.0, 0.0, 1.0] };
                scene.camera.view = View::LookAt(look);
                scene.camera.projection = Projection::Perspective { vertical_fov: 60.0 };
            }
        });
        let frame = render(&stage);
        let mut hits = 0;
        for (pixel, depth) in frame.depth.iter().enumerate().filter(|(_, depth)| depth.is_finite()) {
            let ray = stage.viewpoint.ray((pixel % 16) as f64 + 0.5, (pixel / 16) as f64 + 0.5);
            let radial = (ray.at(f64::from(*depth)) - middle).normalize();
            let normal = glam::Vec3::from_array(frame.normal[pixel]).as_dvec3();
            assert!(normal.dot(radial * sign) > 0.999, "sign {sign}, inside {inside}: {normal}, radially {radial}");
            hits += 1;
        }
        assert!(hits > if inside { 250 } else { 30 }, "{hits}");
    }
}

/// The surface of nearest voxels is their faces: hits lie on them and normals are theirs, in every pixel, at any step;
/// voxels here are boxes of a sheared and stretched grid.
#[test]
fn nearest_voxels_have_faces() {
    let matrix3 = DMat3::from_cols(DVec3::new(1.0, 0.0, 0.0), DVec3::new(0.3, 1.4, 0.0), DVec3::new(0.0, -0.2, 0.8));
    let affine = DAffine3 { matrix3, translation: DVec3::ZERO };
    let is_full = |p: [i64; 3]| (p[0] * 7 + p[1] * 5 + p[2] * 3) % 11 < 4 && p.iter().all(|&i| (2..12).contains(&i));
    let volume = volume_of([14; 3], affine, |p| f64::from(u8::from(is_full(p.to_array().map(|x| x as i64)))));
    for step in [0.3, 2.0] {
        let stage = stage(volume.clone(), crate::common::homogeneous(1.0), |scene| {
            set_mode(scene, surfaces(&[(0.5, 0xffffff, 1.0)]));
            scene.quality.filter = pellucid_field::Filter::Nearest;
            scene.quality.step = step;
            scene.camera.view = View::Orbit(Orbit { azimuth: 33.0, elevation: 27.0, ..Orbit::default() });
            (scene.image.width, scene.image.height) = (48, 48);
        });
        let frame = render(&stage);
        let index = affine.inverse();
        let mut hits = 0;
        for (pixel, &depth) in frame.depth.iter().enumerate() {
            let ray = stage.viewpoint.ray((pixel % 48) as f64 + 0.5, (pixel / 48) as f64 + 0.5);
            // The first full voxel, by very small steps.
            let at = |t: f64| (index.transform_point3(ray.at(t)) + 0.5).floor().to_array().map(|x| x as i64);
            let near = (affine.transform_point3(DVec3::splat(6.5)) - ray.origin).dot(ray.direction) - 20.0;
            let first = (0..40_000).map(|k| near + f64::from(k) * 1e-3).find(|&t| is_full(at(t)));
            let Some(first) = first else {
                assert!(depth.is_infinite(), "pixel {pixel}: {depth}");
                continue;
            };
            let (before, after) = (at(first - 2e-3), at(first));
            let crossed: Vec<usize> = (0..3).filter(|&axis| before[axis] != after[axis]).collect();
            // Rays through an edge may meet either face, and pass a corner that steps miss.
            let [axis] = crossed[..] else { continue };
            if (f64::from(depth) - first).abs() > 2e-3 {
                assert!(f64::from(depth) < first, "pixel {pixel}: {depth}, not {first}");
                continue;
            }
            let toward = (before[axis] - after[axis]) as f64;
            let expected = (index.matrix3.transpose().col(axis) * toward).normalize();
            let normal = glam::Vec3::from_array(frame.normal[pixel]).as_dvec3();
            assert!(normal.dot(expected) > 0.9999, "pixel {pixel}, step {step}: {normal}, not {expected}");
            hits += 1;
        }
        assert!(hits > 300, "{hits}");
    }
}
