//! What must not change a picture by a single bit: skipping, tiles, threads; and what must not
//! change it at all: the order of values under a projection.

use std::sync::Arc;

use crate::common::{render, set_mode, stage, transfer_function, unit_volume};
use glam::DVec3;
use pellucid_cpu::CpuRenderer;
use pellucid_field::{Filter, Volume};
use pellucid_scene::{
    Classification, Combine, Control, Frame, Isosurface, Isovalue, Jitter, Mode, Orbit, Projection, Scene, Slice, View,
};
use proptest::prelude::*;

fn same(a: &Frame, b: &Frame) -> bool {
    let bits = |frame: &Frame| -> Vec<u32> {
        let color = frame.color.iter().flatten().chain(&frame.depth).chain(frame.normal.iter().flatten());
        color.map(|v| v.to_bits()).collect()
    };
    bits(a) == bits(b)
}

/// A few blobs in emptiness, with values that a sharp transfer function cuts.
fn blobs(dims: [usize; 3], seed: u64) -> Volume {
    let mut state = seed;
    let mut random = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / (1u64 << 31) as f64
    };
    let size = DVec3::from_array(dims.map(|n| n as f64));
    let blobs: Vec<(DVec3, f64)> =
        (0..4).map(|_| (DVec3::new(random(), random(), random()) * size, 2.0 + 5.0 * random())).collect();
    unit_volume(dims, |p| blobs.iter().map(|(center, r)| (-((p - *center) / *r).length_squared()).exp()).sum())
}

fn modes() -> impl Strategy<Value = (Mode, Classification)> {
    let iso = |value, opacity| Isovalue { value, color: None, opacity, volume: None };
    let surfaces = Isosurface::new(vec![iso(0.3, 0.4), iso(0.6, 1.0)]);
    prop_oneof![
        Just((Mode::Composite, Classification::Post)),
        Just((Mode::Composite, Classification::Pre)),
        Just((Mode::Composite, Classification::PreIntegrated)),
        Just((Mode::Maximum, Classification::Post)),
        Just((Mode::Minimum, Classification::Post)),
        Just((Mode::Additive, Classification::Post)),
        Just((Mode::XRay, Classification::Post)),
        Just((Mode::Isosurface(surfaces), Classification::Post)),
        Just((
            Mode::Slice(Slice { thickness: 6.0, combine: Combine::Maximum, ..Slice::default() }),
            Classification::Post
        )),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(120))]

    #[test]
    fn skipping_tiles_and_threads_never_change_a_bit(
        (mode, classification) in modes(),
        dims in [1usize..40, 1usize..40, 1usize..40],
        seed: u64,
        (azimuth, elevation) in (0.0..360.0f64, -90.0..90.0f64),
        step in 0.2..3.0f64,
        shading: bool,
        blue: bool,
        (tile, threads) in (1usize..40, 1usize..4),
    ) {
        let tf = transfer_function(
            &[(0.0, 0x2040ff), (1.0, 0xffe0c0)],
            &[(0.0, 0.0), (0.25, 0.0), (0.3, 0.5), (0.4, 0.0), (0.7, 0.0), (0.8, 0.9)],
        );
        let setup = |scene: &mut Scene| {
            set_mode(scene, mode.clone());
            scene.volumes[0].shading = Some(shading);
            scene.camera.view = View::Orbit(Orbit { azimuth, elevation, ..Orbit::default() });
            scene.quality.classification = classification;
            scene.quality.step = step;
            scene.quality.early_termination = 0.95;
            if blue {
                scene.quality.jitter = Jitter::BlueNoise { seed: 1 };
            }
        };
        let on = stage(blobs(dims, seed), tf.clone(), setup);
        let off = stage(blobs(dims, seed), tf, |scene| {
            setup(scene);
            scene.quality.empty_space_skipping = false;
        });
        let (on, off) = (
            CpuRenderer::with_threads(threads).unwrap().with_tile_size(tile).render(&on, &Control::default()).unwrap(),
            render(&off),
        );
        prop_assert!(same(&on, &off), "{} samples with skipping, {} without", on.statistics.samples, off.statistics.samples);
        prop_assert!(on.statistics.samples <= off.statistics.samples + off.statistics.rays);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]
    /// A renderer that keeps tables and blocks from other settings draws what a new one does.
    #[test]
    fn what_is_kept_from_frame_to_frame_changes_no_bit(
        edits in prop::collection::vec((modes(), 0usize..3, 0usize..2, 0.2..0.6f64), 12),
    ) {
        let volumes = [3, 8].map(|seed| Arc::new(blobs([26, 19, 22], seed)));
        let filters = [Filter::Linear, Filter::CATMULL_ROM, Filter::BSpline { prefilter: true }];
        let mut kept = CpuRenderer::new();
        for ((mode, classification), filter, volume, from) in edits {
            let opacities = [(0.0, 0.0), (from, 0.0), (from + 0.1, 0.5)];
            let tf = transfer_function(&[(0.0, 0x2040ff), (1.0, 0xffe0c0)], &opacities);
            let mut stage = stage(Volume::clone(&volumes[volume]), tf, |scene| {
                set_mode(scene, mode.clone());
                scene.quality.classification = classification;
                scene.quality.filter = filters[filter];
            });
            stage.volumes[0].volume = volumes[volume].clone();
            let drawn = kept.render(&stage, &Control::default()).unwrap();
            prop_assert!(same(&drawn, &render(&stage)), "{mode:?} {classification:?} {filter} {volume} {from}");
        }
    }
}

#[test]
fn skipping_saves_samples_where_there_is_nothing() {
    let tf = transfer_function(&[(0.0, 0xffffff)], &[(0.5, 0.0), (1.0, 0.5)]);
    let frame = render(&stage(blobs([64; 3], 7), tf, |_| ()));
    let statistics = frame.statistics;
    assert!(statistics.samples_visible > 0);
    assert!(statistics.samples_skipped > 2 * statistics.samples, "{statistics:?}");
}

/// A projection sees a set of values: walking the ray backwards gives the same picture.
#[test]
fn projections_do_not_depend_on_the_order_of_values() {
    let volume = |flip: bool| {
        unit_volume([9, 11, 10], |p| {
            let y = if flip { 10.0 - p.y } else { p.y };
            (p.x * 3.1 + y * y * 1.7 + p.z * p.x).sin()
        })
    };
    let tf = transfer_function(&[(-1.0, 0x000000), (1.0, 0xffffff)], &[(-1.0, 1.0)]);
    for mode in [Mode::Maximum, Mode::Minimum] {
        // Steps that divide the box put samples at mirrored places.
        let draw = |flip| render(&stage(volume(flip), tf.clone(), |scene| set_mode(scene, mode.clone())));
        for (a, b) in draw(false).color.iter().flatten().zip(draw(true).color.iter().flatten()) {
            // Up to the rounding of positions.
            assert!((a - b).abs() < 2e-6, "{mode:?}: {a} and {b}");
        }
    }
    let draw = |flip| render(&stage(volume(flip), tf.clone(), |scene| set_mode(scene, Mode::Average)));
    for (a, b) in draw(false).color.iter().flatten().zip(draw(true).color.iter().flatten()) {
        assert!((a - b).abs() < 1e-6);
    }
}

/// A view moved by whole pixels is the same picture, moved.
#[test]
fn a_shifted_view_is_a_shifted_picture() {
    let tf = transfer_function(&[(0.0, 0x2040ff), (1.0, 0xffe0c0)], &[(0.1, 0.0), (0.8, 0.5)]);
    for perspective in [true, false] {
        let mut stage = stage(blobs([24; 3], 5), tf.clone(), |scene| {
            if perspective {
                scene.camera.projection = Projection::Perspective { vertical_fov: 40.0 };
            }
        });
        let still = render(&stage);
        stage.viewpoint = stage.viewpoint.shifted(3.0, -2.0);
        let moved = render(&stage);
        for (x, y) in (0..13).flat_map(|x| (2..16).map(move |y| (x, y))) {
            let (from, to) = (still.color[(y - 2) * 16 + x + 3], moved.color[y * 16 + x]);
            assert!((0..4).all(|c| (from[c] - to[c]).abs() < 1e-5), "{x}, {y}: {from:?} and {to:?}");
        }
        assert!(moved.statistics.samples_visible > 0);
    }
}
