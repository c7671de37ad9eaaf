//! Where the transfer function is applied, and what that does to a picture (chapter 4).

use crate::common::{center, render, stage, transfer_function, unit_volume};
use glam::DVec3;
use pellucid_field::Volume;
use pellucid_optics::TransferFunction;
use pellucid_scene::{Classification, Projection, Scene};

fn draw(volume: &Volume, tf: &TransferFunction, classification: Classification, step: f64) -> [f32; 4] {
    center(&render(&stage(volume.clone(), tf.clone(), |scene| {
        scene.quality.classification = classification;
        scene.quality.step = step;
    })))
}

/// Red before blue is not blue before red (1.4-8): a half-opaque layer over an opaque one.
#[test]
fn what_is_nearer_is_in_front() {
    let tf = transfer_function(
        &[(0.0, 0xff0000), (1.5, 0xff0000), (1.5, 0x0000ff), (2.0, 0x0000ff)],
        &[(0.0, 0.0), (0.9, 0.0), (0.9, 0.08), (1.5, 0.08), (1.5, 1.0), (2.0, 1.0)],
    );
    // Red (1) at small y, in front of the camera that looks along +y; blue (2) behind.
    let layered = |flip: bool| unit_volume([9, 21, 9], move |p| if (p.y < 10.0) != flip { 1.0 } else { 2.0 });
    let red_first = draw(&layered(false), &tf, Classification::Post, 0.05);
    let blue_first = draw(&layered(true), &tf, Classification::Post, 0.05);
    // Where values pass 1.5 between the layers, half a voxel past the last red one.
    let through = 0.92f32.powf(9.5);
    assert!((red_first[0] - (1.0 - through)).abs() < 0.01 && (red_first[2] - through).abs() < 0.01, "{red_first:?}");
    assert!(blue_first[0] < 1e-6 && (blue_first[2] - 1.0).abs() < 1e-6, "{blue_first:?}");
}

/// With an affine transfer function classification and interpolation commute (4.3-1).
#[test]
fn pre_equals_post_under_an_affine_transfer_function() {
    // One step is one unit distance, so the opacity of a step is affine as well.
    let tf = transfer_function(&[(0.0, 0x80c0ff)], &[(0.0, 0.02), (1.0, 0.62)]);
    let noise = unit_volume([12; 3], |p| (p.x * 12.9 + p.y * 78.2 + p.z * 37.7).sin().abs());
    let [pre, post] = [Classification::Pre, Classification::Post].map(|c| draw(&noise, &tf, c, 1.0));
    for channel in 0..4 {
        assert!((pre[channel] - post[channel]).abs() < 1e-5, "{pre:?} {post:?}");
    }
}

/// A box transfer function on [0.4, 0.6] and voxels of 0 and 1: interpolated values pass through
/// the box, classified voxels never see it (4.2-1).
#[test]
fn only_post_classification_sees_between_voxels() {
    let tf = transfer_function(
        &[(0.0, 0xffffff)],
        &[(0.0, 0.0), (0.4, 0.0), (0.4, 0.5), (0.6, 0.5), (0.6, 0.0), (1.0, 0.0)],
    );
    let cell = unit_volume([4, 2, 4], |p| p.y);
    assert_eq!(draw(&cell, &tf, Classification::Pre, 0.01)[3], 0.0);
    // A fifth of the way at opacity 1/2 per unit; the table's nodes round the box's edges.
    let exact = 1.0 - 0.5f32.powf(0.2);
    for classification in [Classification::Post, Classification::PreIntegrated] {
        let drawn = draw(&cell, &tf, classification, 0.01)[3];
        assert!((drawn - exact).abs() < 0.01, "{classification:?}: {drawn}, exact {exact}");
    }
}

/// Transparent red beside opaque blue: associated colours keep the red out (3.2-8).
#[test]
fn invisible_colors_do_not_bleed() {
    let tf = transfer_function(&[(0.0, 0xff0000), (1.0, 0x0000ff)], &[(0.0, 0.0), (1.0, 1.0)]);
    // Values vary across the picture only, so every sample of the middle ray has value 1/2.
    let side = unit_volume([2, 2, 2], |p| p.x);
    let ray = |scene: &mut Scene| {
        scene.quality.classification = Classification::Pre;
        scene.quality.step = 1.0;
        scene.image.width = 1;
        scene.image.height = 1;
        scene.camera.projection = Projection::Orthographic { height: Some(0.01) };
    };
    // One unit of (0, 0, 1/2, 1/2): the midpoint of (0, 0, 0, 0) and (0, 0, 1, 1).
    let drawn = render(&stage(side, tf, ray)).color[0];
    for (found, exact) in drawn.into_iter().zip([0.0, 0.0, 0.5, 0.5]) {
        assert!((found - exact).abs() < 1e-6, "{drawn:?}");
    }
}

/// A thin spike over a linear ramp: pre-integration is exact with a handful of samples and
/// wherever they fall, post-classification misses it (4.5-3, 7.2-3, 9.3-2).
#[test]
fn a_thin_spike_needs_preintegration() {
    // Extinction 50 over a hundredth of the ramp.
    let opacity = 1.0 - (-0.5f64).exp();
    let tf = transfer_function(
        &[(0.0, 0xffffff)],
        &[(0.0, 0.0), (0.495, 0.0), (0.495, opacity as f32), (0.505, opacity as f32), (0.505, 0.0), (1.0, 0.0)],
    );
    let tf = tf.with_unit_distance(Some(0.01)).unwrap();
    let ramp = unit_volume([4, 2, 4], |p| p.y);
    let exact = 0.393_469;
    for step in [1.0 / 8.0, 0.1, 0.07] {
        let drawn = draw(&ramp, &tf, Classification::PreIntegrated, step)[3];
        assert!((drawn - exact).abs() < 1e-3, "pre-integrated, step {step}: {drawn}");
    }
    // Samples at odd multiples of 1/18 jump over the spike's 1/100.
    assert_eq!(draw(&ramp, &tf, Classification::Post, 1.0 / 8.0)[3], 0.0);
    let fine = draw(&ramp, &tf, Classification::Post, 1.0 / 100.0)[3];
    assert!((fine - exact).abs() > 1e-3, "even 100 samples depend on luck: {fine}");
}

/// Post-classification has holes where pre-integration has none: spheres of a thin shell.
#[test]
fn a_thin_shell_has_no_holes_when_preintegrated() {
    let tf = transfer_function(&[(0.0, 0xffffff)], &[(0.0, 0.0), (7.9, 0.0), (8.0, 0.9), (8.1, 0.0), (20.0, 0.0)]);
    let shell = unit_volume([24; 3], |p| (p - DVec3::splat(11.5)).length());
    let covered = |classification| {
        let frame = render(&stage(shell.clone(), tf.clone(), |scene| {
            scene.quality.classification = classification;
            scene.quality.step = 1.0;
            scene.image.width = 64;
            scene.image.height = 64;
        }));
        let inside = |pixel: usize| {
            let (x, y) = ((pixel % 64) as f64 - 31.5, (pixel / 64) as f64 - 31.5);
            x.hypot(y) / 64.0 * 24.0 < 6.0
        };
        let pixels: Vec<f32> = (0..64 * 64).filter(|&pixel| inside(pixel)).map(|pixel| frame.color[pixel][3]).collect();
        pixels.iter().filter(|alpha| **alpha > 0.01).count() as f64 / pixels.len() as f64
    };
    assert!(covered(Classification::PreIntegrated) > 0.99, "{}", covered(Classification::PreIntegrated));
    assert!(covered(Classification::Post) < 0.9, "{}", covered(Classification::Post));
}
