//! A homogeneous medium has a closed-form transmittance, whatever the step, the spacing, the
//! rotation and the mirror (1.3-2, 1.4-13; USERS theme A).

use crate::common::{center, homogeneous, render, set_mode, stage, transfer_function, volume_of};
use glam::{DAffine3, DMat3, DVec3};
use pellucid_scene::{Classification, Jitter, LookAt, Mode, Projection, Scene, View};

const OPACITY: f64 = 0.12;

/// Looks along `direction` at the middle of a constant block with these cell vectors, and gives
/// the opacity of the middle pixel and the length of that ray in the block.
fn slab(linear: DMat3, direction: DVec3, edit: impl FnOnce(&mut Scene)) -> (f64, f64) {
    let affine = DAffine3 { matrix3: linear, translation: DVec3::new(3.0, -5.0, 11.0) };
    let volume = volume_of([7, 6, 5], affine, |_| 1.0);
    let target = volume.grid().center();
    let through = volume.grid().index_from_world().transform_vector3(direction);
    let half = DVec3::new(3.0, 2.5, 2.0) / through.abs();
    let length = 2.0 * half.min_element();
    let stage = stage(volume, homogeneous(OPACITY as f32), |scene| {
        scene.camera.projection = Projection::Orthographic { height: Some(1e-6) };
        scene.camera.view = View::LookAt(LookAt {
            position: (target - direction * 100.0).to_array(),
            target: target.to_array(),
            up: direction.any_orthonormal_vector().to_array(),
        });
        edit(scene);
    });
    (f64::from(center(&render(&stage))[3]), length)
}

#[test]
fn a_slab_is_exact_at_any_step_spacing_rotation_and_mirror() {
    let rotations = [DMat3::IDENTITY, DMat3::from_euler(glam::EulerRot::XYZ, 0.4, -1.1, 2.3)];
    let spacings = [DVec3::ONE, DVec3::new(1.0, 1.0, 5.0), DVec3::new(0.2, 3.0, 1.0), DVec3::new(-1.0, 0.5, -2.0)];
    let directions = [DVec3::Y, -DVec3::X, DVec3::new(0.3, 0.8, -0.5).normalize()];
    for rotation in rotations {
        for spacing in spacings {
            for direction in directions {
                for step in [0.25, 0.5, 1.0, 2.0, 4.0, 0.37] {
                    let linear = rotation * DMat3::from_diagonal(spacing);
                    let (opacity, length) = slab(linear, direction, |scene| scene.quality.step = step);
                    let exact = 1.0 - (1.0 - OPACITY).powf(length);
                    let case = format!("spacing {spacing}, direction {direction}, step {step}");
                    assert!((opacity - exact).abs() < 1e-5, "{case}: {opacity}, exact {exact}");
                }
            }
        }
    }
}

#[test]
fn every_classification_and_jitter_gives_the_same_slab() {
    for classification in [Classification::Post, Classification::Pre, Classification::PreIntegrated] {
        for jitter in [Jitter::Centered, Jitter::BlueNoise { seed: 3 }] {
            let (opacity, length) = slab(DMat3::IDENTITY, DVec3::new(0.6, 0.8, 0.0), |scene| {
                scene.quality.classification = classification;
                scene.quality.jitter = jitter;
            });
            let exact = 1.0 - (1.0 - OPACITY).powf(length);
            assert!((opacity - exact).abs() < 1e-5, "{classification:?} {jitter:?}: {opacity}, exact {exact}");
        }
    }
}

/// The medium inside an isosurface of a distance field: chords of a sphere (1.2-7, 7.2-1).
#[test]
fn a_ball_has_the_transmittance_of_its_chords() {
    let middle = DVec3::splat(15.5);
    let radius = 12.0;
    let volume = crate::common::unit_volume([32; 3], |p| radius - (p - middle).length());
    let tf = transfer_function(&[(0.0, 0xffffff)], &[(0.0, 0.0), (0.0, 0.05)]);
    let stage = stage(volume, tf, |scene| {
        scene.image.width = 33;
        scene.image.height = 33;
        scene.quality.step = 0.02;
        scene.camera.projection = Projection::Orthographic { height: Some(33.0) };
    });
    let frame = render(&stage);
    for (pixel, color) in frame.color.iter().enumerate() {
        let ray = stage.viewpoint.ray((pixel % 33) as f64 + 0.5, (pixel / 33) as f64 + 0.5);
        let offset = ray.origin - middle;
        let miss = (offset - ray.direction * offset.dot(ray.direction)).length();
        // Near the silhouette the chord's end moves fast with the trilinear field's own error.
        if (miss - radius).abs() < 1.0 {
            continue;
        }
        let chord = 2.0 * (radius * radius - miss * miss).max(0.0).sqrt();
        let exact = 1.0 - 0.95f64.powf(chord);
        assert!((f64::from(color[3]) - exact).abs() < 1.0 / 255.0, "at {miss} from the axis: {} and {exact}", color[3]);
    }
}

#[test]
fn a_radiograph_holds_back_what_a_slab_absorbs() {
    let (opacity, length) = slab(DMat3::IDENTITY, DVec3::Y, |scene| set_mode(scene, Mode::XRay));
    assert!((opacity - (1.0 - (1.0 - OPACITY).powf(length))).abs() < 1e-5);
}

/// Emission only: a slab shines with its extinction times its length, at any step (1.2-7).
#[test]
fn additive_light_grows_with_length() {
    for step in [0.3, 1.0, 2.5] {
        let volume = crate::common::unit_volume([5, 6, 5], |_| 1.0);
        let stage = stage(volume, homogeneous(OPACITY as f32), |scene| {
            set_mode(scene, Mode::Additive);
            scene.quality.step = step;
        });
        let color = center(&render(&stage));
        let exact = -(1.0 - OPACITY).ln() * 5.0;
        assert!((f64::from(color[0]) - exact).abs() < 1e-5, "{} and {exact}", color[0]);
        assert_eq!(color[3], 0.0, "additive light covers nothing");
    }
}
