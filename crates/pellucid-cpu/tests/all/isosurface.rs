//! Isosurfaces found along rays: exact roots, right normals, right order.

use crate::common::{center, render, set_mode, stage, transfer_function, unit_volume, volume_of};
use glam::{DAffine3, DMat3, DVec3};
use pellucid_field::Volume;
use pellucid_optics::Color;
use pellucid_scene::{Isosurface, Isovalue, LookAt, Mode, Orbit, Projection, Scene, SurfaceSearch, View};

fn surfaces(levels: &[(f64, u32, f32)]) -> Mode {
    let level = |&(value, color, opacity): &(f64, u32, f32)| Isovalue {
        value,
        color: Some(Color::hex(color)),
        opacity,
        volume: None,
    };
    Mode::Isosurface(Isosurface::new(levels.iter().map(level).collect()))
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
    let mode =
        Mode::Isosurface(Isosurface::new(vec![Isovalue { value: 6.0, color: None, opacity: 1.0, volume: None }]));
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

/// A wall thinner than a step, and in its middle than a voxel: both its sides lie between two samples, or within a cell.
/// Rays meet them all the same, where the field is the level.
#[test]
fn both_sides_of_thin_walls_are_met_at_any_step() {
    let wall = |thin: f64| unit_volume([24; 3], move |p| if p.x == 12.0 { 0.5 + thin } else { 0.0 });
    for (thin, step) in [(0.5, 0.7), (0.5, 3.0), (0.01, 0.7), (0.01, 3.0)] {
        let volume = wall(thin);
        let count = |search| {
            let frame = render(&stage(volume.clone(), crate::common::homogeneous(1.0), |scene| {
                let isovalues = vec![Isovalue { value: 0.5, color: None, opacity: 0.5, volume: None }];
                set_mode(scene, Mode::Isosurface(Isosurface { search, ..Isosurface::new(isovalues) }));
                scene.volumes[0].shading = Some(false);
                scene.quality.step = step;
                scene.camera.view = View::Orbit(Orbit { azimuth: 77.0, elevation: 8.0, ..Orbit::default() });
            }));
            let through = |pixel: usize| 0.75 - frame.color[pixel][3];
            let inner = (4..12).flat_map(|row| (5..11).map(move |column| row * 16 + column));
            inner.filter(|&pixel| through(pixel).abs() < 1e-6).count()
        };
        assert_eq!(count(SurfaceSearch::Exact), 48, "{thin}, step {step}");
        if (thin, step) == (0.01, 3.0) {
            assert!(count(SurfaceSearch::Sampled) < 24, "samples find both sides, too");
        }
    }
}

/// Rays through noise, whose trilinear cells have surfaces of all shapes, meet the first one where a march in f64 by 1/500
/// voxel does.
#[test]
fn no_surface_of_a_cell_is_missed() {
    let noise = |p: DVec3| ((p.x * 12.9898 + p.y * 78.233 + p.z * 37.719).sin() * 43_758.547).rem_euclid(1.0);
    let volume = unit_volume([7; 3], noise);
    let sampler = pellucid_field::Sampler::new(&volume, 0, pellucid_field::Filter::Linear).unwrap();
    let (mut told, mut wrong) = (0, 0);
    for azimuth in [0.0, 13.0, 51.0, 90.0, 200.0] {
        for level in [0.2, 0.5, 0.83] {
            let stage = stage(volume.clone(), crate::common::homogeneous(1.0), |scene| {
                set_mode(scene, surfaces(&[(level, 0xffffff, 1.0)]));
                scene.camera.view = View::Orbit(Orbit { azimuth, elevation: azimuth / 3.0, ..Orbit::default() });
                scene.camera.projection = Projection::Orthographic { height: None };
                (scene.image.width, scene.image.height) = (48, 48);
                scene.quality.step = 2.0;
            });
            let frame = render(&stage);
            for (pixel, depth) in frame.depth.iter().enumerate() {
                let ray = stage.viewpoint.ray((pixel % 48) as f64 + 0.5, (pixel / 48) as f64 + 0.5);
                let value = |t: f64| sampler.value_world(ray.at(t)) - level;
                let grid = volume.grid();
                let inside = |t: f64| {
                    let p = grid.index_from_world().transform_point3(ray.at(t));
                    p.min_element() >= 0.0 && p.max_element() <= 6.0
                };
                let far = stage.viewpoint.eye.distance(DVec3::splat(3.0)) + 8.0;
                let places = (0..8000).map(|i| far * f64::from(i) / 8000.0).filter(|&t| inside(t));
                let values: Vec<(f64, f64)> = places.map(|t| (t, value(t))).collect();
                let first = values.windows(2).find(|pair| pair[0].1 * pair[1].1 < 0.0).map(|pair| pair[0].0);
                // Where the field comes so close to the level before, it may pass it between two of these places.
                let before = values.iter().take_while(|place| first.is_none_or(|first| place.0 < first - 0.02));
                if before.map(|place| place.1.abs()).fold(f64::INFINITY, f64::min) < 4e-3 {
                    continue;
                }
                told += 1;
                let depth = f64::from(*depth);
                let is_right = first.map_or(depth.is_infinite(), |first| (depth - first).abs() < 3e-3);
                wrong += usize::from(!is_right);
            }
        }
    }
    assert!(told > 30_000, "{told} rays");
    assert_eq!(wrong, 0);
}
