//! Extremes of the field itself, not of samples of it.

use crate::common::{render, set_mode, stage, transfer_function, unit_volume};
use glam::DVec3;
use pellucid_field::{Filter, Volume};
use pellucid_optics::{ColorSpace, TransferFunction};
use pellucid_scene::{Combine, Frame, Mode, Orbit, Projection, Scene, Slice, View};

/// Data values from 0 to 1 as grey.
fn gray() -> TransferFunction {
    transfer_function(&[(0.0, 0x000000), (1.0, 0xffffff)], &[(0.0, 1.0)]).with_color_space(ColorSpace::Linear)
}

fn turned(scene: &mut Scene, azimuth: f64, elevation: f64, step: f64) {
    scene.camera.view = View::Orbit(Orbit { azimuth, elevation, ..Orbit::default() });
    scene.camera.projection = Projection::Orthographic { height: Some(4.0) };
    scene.quality.step = step;
}

/// One plane of voxels that is 1 (or 0) among others that are 0 (or 1).
fn sheet(inverted: bool) -> Volume {
    unit_volume([11, 12, 13], |p| if (p.z == 6.0) == inverted { 0.0 } else { 1.0 })
}

fn drawn(frame: &Frame) -> Vec<f32> {
    frame.color.iter().filter(|color| color[3] > 0.0).map(|color| color[0]).collect()
}

/// Every ray through the sheet passes its voxels' plane, at any step and orientation.
#[test]
fn a_sheet_is_seen_whole_at_any_step_and_angle() {
    for filter in [Filter::Linear, Filter::Nearest] {
        for (azimuth, elevation) in [(0.0, 90.0), (30.0, 50.0), (-70.0, 35.0), (11.0, -67.0)] {
            for step in [0.25, 0.5, 1.0, 3.7] {
                for (mode, inverted, expected) in [(Mode::Maximum, false, 1.0), (Mode::Minimum, true, 0.0)] {
                    let frame = render(&stage(sheet(inverted), gray(), |scene| {
                        turned(scene, azimuth, elevation, step);
                        scene.quality.filter = filter;
                        set_mode(scene, mode.clone());
                    }));
                    let values = drawn(&frame);
                    assert!(values.len() > 100, "{} pixels", values.len());
                    for value in values {
                        assert!((value - expected).abs() < 1e-5, "{mode:?}, {filter:?}, step {step}: {value}");
                    }
                }
            }
        }
    }
}

/// A slab holds the planes that are in it: none of them has more than its maximum, nor less than its minimum.
#[test]
fn a_slab_is_no_less_than_a_plane_in_it() {
    let value = |p: DVec3| 0.5 + 0.5 * (p.x * 2.3 + p.y * 1.9 + p.z * 2.7 + 0.4 * p.x * p.y).sin();
    for normal in [[0.0, 0.0, 1.0], [0.3, 0.5, 0.9], [1.0, -0.2, 0.6]] {
        let draw = |thickness: f64, shift: f64, combine: Combine| {
            render(&stage(unit_volume([9, 10, 11], value), gray(), |scene| {
                turned(scene, 25.0, 65.0, 0.5);
                scene.camera.frame = pellucid_scene::Framing::Grid;
                let point = (DVec3::new(4.0, 4.5, 5.0) + DVec3::from(normal).normalize() * shift).to_array();
                let slice = Slice { point: Some(point), normal: Some(normal), thickness, combine };
                set_mode(scene, Mode::Slice(slice));
            }))
        };
        let slabs = [Combine::Maximum, Combine::Minimum].map(|combine| draw(2.0, 0.0, combine));
        let mut seen = 0;
        for shift in [-0.95, -0.6, -0.31, 0.0, 0.17, 0.5, 0.99] {
            let plane = draw(0.0, shift, Combine::Maximum);
            for (pixel, color) in plane.color.iter().enumerate().filter(|(_, color)| color[3] > 0.0) {
                let [most, least] = [&slabs[0], &slabs[1]].map(|slab| slab.color[pixel][0]);
                assert!(color[0] <= most + 1e-5, "{normal:?}, {shift}: {} in {most}", color[0]);
                assert!(color[0] >= least - 1e-5, "{normal:?}, {shift}: {} in {least}", color[0]);
                seen += 1;
            }
        }
        assert!(seen > 500, "{seen}");
    }
}

/// Along a diagonal of a cell the interpolation is a curve that is largest in the middle: with two opposite edges
/// of 1 and the others 0 it is `t (1 - t) * 2` at most one half, on no plane of voxels.
#[test]
fn what_is_largest_within_a_cell_is_found() {
    let value = |p: DVec3| f64::from(u8::from((p.x as i32 + p.y as i32) % 2 == 1));
    let middle = |azimuth: f64| {
        let frame = render(&stage(unit_volume([2, 2, 5], value), gray(), |scene| {
            turned(scene, azimuth, 0.0, 5.0);
            scene.image.width = 65;
            scene.image.height = 65;
            set_mode(scene, Mode::Maximum);
        }));
        frame.color[32 * 65 + 32][0]
    };
    // One diagonal runs from 0 to 0, the other one from 1 to 1.
    let (a, b) = (middle(45.0), middle(-45.0));
    assert!((a.min(b) - 0.5).abs() < 1e-4 && (a.max(b) - 1.0).abs() < 1e-4, "{a} and {b}");
}
