//! The engine against the plain f64 reference, on random scenes.

mod common;
mod reference;

use common::{render, stage, transfer_function, unit_volume, volume_of};
use glam::{DAffine3, DMat3, DVec3};
use pellucid_optics::{Material, TransferFunction};
use pellucid_scene::{Orbit, Projection, Stage, View};
use proptest::prelude::*;

/// Largest difference of a channel over all pixels.
fn largest_difference(stage: &Stage) -> f64 {
    let frame = render(stage);
    let mut largest = 0.0f64;
    for (pixel, color) in frame.color.iter().enumerate() {
        let ray = stage.viewpoint.ray((pixel % 16) as f64 + 0.5, (pixel / 16) as f64 + 0.5);
        let exact = reference::composite(&ray, stage);
        for channel in 0..4 {
            largest = largest.max((f64::from(color[channel]) - exact[channel]).abs());
        }
    }
    largest
}

fn smooth_tf(peak: f64, opacity: f32) -> TransferFunction {
    transfer_function(
        &[(-1.0, 0x1030a0), (peak, 0xf0e0d0), (1.0, 0xc02010)],
        &[(-1.0, 0.0), (-0.2, 0.02), (peak, opacity), (1.0, 0.3)],
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn compositing_is_what_the_reference_says(
        dims in [2usize..14, 2usize..14, 2usize..14],
        (azimuth, elevation, fov) in (0.0..360.0f64, -80.0..80.0f64, 5.0..90.0f64),
        spacing in [0.3..3.0f64, 0.3..3.0f64, 0.3..3.0f64],
        angles in [0.0..6.0f64, 0.0..6.0f64, 0.0..6.0f64],
        (peak, opacity) in (0.0..0.9f64, 0.0..0.9f32),
        step in 0.2..2.0f64,
    ) {
        let rotation = DMat3::from_euler(glam::EulerRot::XYZ, angles[0], angles[1], angles[2]);
        let linear = rotation * DMat3::from_diagonal(DVec3::from_array(spacing));
        let affine = DAffine3 { matrix3: linear, translation: DVec3::new(1.0, 2.0, 3.0) };
        let volume = volume_of(dims, affine, |p| (p.x * 0.9 + p.y * 0.5).sin() * (p.z * 0.7 + 0.3).cos());
        let stage = stage(volume, smooth_tf(peak, opacity), |scene| {
            scene.camera.projection = Projection::Perspective { vertical_fov: fov };
            scene.camera.view = View::Orbit(Orbit { azimuth, elevation, ..Orbit::default() });
            scene.quality.step = step;
        });
        let largest = largest_difference(&stage);
        prop_assert!(largest < 1e-4, "largest difference {largest}");
    }
}

/// Shading away from the borders, where the reference and the engine take the same six taps (at a
/// border the reference clamps and the engine's gradients are one-sided).
#[test]
fn shading_is_what_the_reference_says() {
    let middle = DVec3::splat(11.5);
    let volume = unit_volume([24; 3], |p| 1.0 - (p - middle).length() / 9.0);
    let material = Material::default();
    let stage = stage(volume, transfer_function(&[(0.0, 0xc08040)], &[(0.0, 0.0), (1.0, 0.4)]), |scene| {
        scene.volumes[0].shading = Some(true);
        scene.volumes[0].material = Some(material);
    });
    let largest = largest_difference(&stage);
    assert!(largest < 1e-4, "largest difference {largest}");
}
