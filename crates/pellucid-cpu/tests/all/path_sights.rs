//! Pixels of which blocks tell that they see nothing are not followed, and all others are.

use crate::common::paths::*;
use crate::common::{render, stage, transfer_function, volume_of};
use glam::{DAffine3, DMat3, DVec3};
use pellucid_scene::{Frame, PathTrace, Projection, Quality, Stage, Technique};

const SIDE: usize = 40;

/// Solid balls, one of which is cut by the side of the grid, and a cube that ends where blocks do, under a camera.
fn balls(projection: Projection, shear: f64, technique: Technique) -> Stage {
    let matrix3 = DMat3::from_cols(DVec3::X, DVec3::new(shear, 1.0, 0.0), DVec3::new(0.0, 0.5 * shear, 1.2));
    let affine = DAffine3 { matrix3, translation: DVec3::new(3.0, -2.0, 5.0) };
    let volume = volume_of([80, 66, 74], affine, |p| {
        let ball = |x: f64, y: f64, z: f64, r: f64| r - (p - DVec3::new(x, y, z)).length();
        let cube = 5.85 - (p - DVec3::new(50.0, 30.0, 14.0)).abs().max_element();
        cube.max(ball(22.0, 24.0, 18.0, 8.0)).max(ball(60.0, 40.0, 60.0, 6.0)).max(ball(79.0, 30.0, 24.0, 5.0))
    });
    stage(volume, transfer_function(&[(0.0, 0xffffff)], &[(-0.1, 0.0), (0.1, 0.4)]), |scene| {
        scene.lighting = DARK;
        scene.camera.projection = projection;
        scene.quality = Quality { supersampling: 4, step: 0.25, ..scene.quality.clone() };
        (scene.image.width, scene.image.height) = (SIDE as u32, SIDE as u32);
        scene.technique = technique;
    })
}

#[test]
fn pixels_that_see_nothing_are_not_followed() {
    const SAMPLES: u32 = 64;
    let settings = PathTrace { samples: SAMPLES, ..PathTrace::default() };
    for projection in [Projection::Orthographic { height: None }, Projection::Perspective { vertical_fov: 50.0 }] {
        for shear in [0.0, 0.6] {
            let traced = render(&balls(projection, shear, Technique::PathTrace(settings.clone())));
            let cast = render(&balls(projection, shear, Technique::default()));
            let rays = traced.statistics.rays as usize;
            // The balls are framed tightly: more than a third of the pixels sees nothing all the same.
            assert!(
                (SIDE * SIDE * 2..SIDE * SIDE * SAMPLES as usize * 2 / 3).contains(&rays),
                "{projection:?}: {rays}"
            );
            assert!(traced.statistics.rays_hit > 0 && traced.statistics.rays_hit <= traced.statistics.rays);
            let alpha = |frame: &Frame, k: usize| f64::from(frame.color[k][3]);
            let (mut difference, mut variance) = (0.0, 0.0);
            for k in 0..SIDE * SIDE {
                let (found, expected) = (alpha(&traced, k), alpha(&cast, k));
                // Of 64 paths none collides with a chance of 0.7^64.
                assert!(expected < 0.3 || found > 0.0, "{projection:?}: pixel {k} has {expected} and no path");
                assert!(expected > 0.0 || found < 0.2, "{projection:?}: pixel {k} has {found}");
                difference += found - expected;
                variance += expected * (1.0 - expected) / f64::from(SAMPLES);
            }
            // Rays at the edges of balls are fewer than a step of a quarter voxel tells: a thousandth of all.
            let room = 1e-3 * (0..SIDE * SIDE).map(|k| alpha(&cast, k)).sum::<f64>();
            assert!(difference.abs() < 4.0 * variance.sqrt() + room, "{projection:?}: {difference} of {room}");
        }
    }
}

#[test]
fn lenses_and_wide_pixels_are_followed_whole() {
    let rays = |settings: PathTrace, side: usize| {
        let mut stage = balls(Projection::default(), 0.0, Technique::PathTrace(settings));
        stage.viewpoint = stage.viewpoint.with_rows(side);
        render(&stage).statistics.rays as usize
    };
    let settings = PathTrace { samples: 4, ..PathTrace::default() };
    assert_eq!(rays(PathTrace { aperture: 1.0, ..settings.clone() }, SIDE), SIDE * SIDE * 4);
    assert_eq!(rays(settings.clone(), 8), 8 * 8 * 4);
    assert!(rays(settings, SIDE) < SIDE * SIDE * 3);
}
