//! Absent data, odd shapes, and a camera inside: nothing turns into NaN, nothing panics.

use crate::common::{render, set_mode, stage, transfer_function, unit_volume};
use glam::DVec3;
use pellucid_field::{Grid, Volume, Voxels};
use pellucid_optics::{Falloff, Light, LightKind};
use pellucid_scene::{
    Classification, Frame, Isosurface, Isovalue, LookAt, Mode, Projection, RenderWarning, Scene, Slice, SurfaceSearch,
    View,
};

fn finite(frame: &Frame) -> bool {
    let numbers = || frame.color.iter().flatten().chain(frame.normal.iter().flatten());
    numbers().all(|v| v.is_finite()) && frame.depth.iter().all(|depth| !depth.is_nan())
}

fn opaque_above(value: f64) -> pellucid_optics::TransferFunction {
    transfer_function(&[(0.0, 0xffd0a0)], &[(value, 0.0), (value + 1.0, 0.7)])
}

fn every_mode() -> Vec<Mode> {
    let isovalues = vec![Isovalue { value: 4.0, color: None, opacity: 0.8, volume: None }];
    vec![
        Mode::Composite,
        Mode::Maximum,
        Mode::Minimum,
        Mode::Average,
        Mode::Additive,
        Mode::XRay,
        Mode::Isosurface(Isosurface::new(isovalues)),
        Mode::Slice(Slice::default()),
        Mode::Slice(Slice { thickness: 3.0, ..Slice::default() }),
    ]
}

/// A hole of NaN and one of infinity in a lit ball, beside a point light: the pictures of all
/// modes are finite, and the hole is a hole (USERS theme K).
#[test]
fn a_hole_beside_a_light_leaves_no_trace_of_nan() {
    let middle = DVec3::splat(11.5);
    let holes = [(DVec3::new(11.5, 4.0, 11.5), f64::NAN), (DVec3::new(15.0, 6.0, 15.0), f64::INFINITY)];
    let volume = unit_volume([24; 3], |p| {
        let hole = holes.iter().find(|(center, _)| (p - *center).length() < 3.0);
        hole.map_or(12.0 - (p - middle).length(), |(_, absent)| *absent)
    });
    for mode in every_mode() {
        for classification in [Classification::Post, Classification::Pre, Classification::PreIntegrated] {
            let frame = render(&stage(volume.clone(), opaque_above(2.0), |scene| {
                set_mode(scene, mode.clone());
                scene.volumes[0].shading = Some(true);
                // A point light at the rim of the hole, and one in the middle of it.
                let light = |position| Light::new(LightKind::Point { position, falloff: Falloff::default() });
                scene.lighting.lights = vec![light([11.5, 1.0, 11.5]), light([11.5, 4.0, 11.5])];
                scene.quality.classification = classification;
                scene.image.width = 48;
                scene.image.height = 48;
            }));
            assert!(finite(&frame), "{mode:?} {classification:?}");
        }
    }
    // Through the hole the first surface lies deeper than beside it.
    let frame = render(&stage(volume, opaque_above(2.0), |scene| {
        scene.image.width = 48;
        scene.image.height = 48;
    }));
    let depth = |x: usize, y: usize| frame.depth[y * 48 + x];
    assert!(depth(24, 24) > depth(17, 28) + 2.0, "{} and {}", depth(24, 24), depth(17, 28));
}

/// A surface whose level lies within a hole ends at the hole's border, lit as the field before it is
/// (5.5-8): the steps are longer than the hole is wide, so both of a segment's ends have values. In the cells that are there
/// no field passes the level.
#[test]
fn a_surface_beside_a_hole_is_lit_where_the_field_ends() {
    // The level 12 lies in the absent sheet y = 12, which is a hole from 11.5 to 12.5.
    let ramp = |hole: bool| unit_volume([24; 3], move |p| if hole && p.y == 12.0 { f64::NAN } else { p.y });
    let draw = |level, hole, search| {
        render(&stage(ramp(hole), opaque_above(2.0), |scene| {
            let isovalues = vec![Isovalue { value: level, color: None, opacity: 1.0, volume: None }];
            set_mode(scene, Mode::Isosurface(Isosurface { search, ..Isosurface::new(isovalues) }));
            scene.volumes[0].shading = Some(true);
            scene.quality.step = 3.1;
            scene.camera.projection = Projection::Orthographic { height: Some(20.0) };
            scene.camera.view =
                View::LookAt(LookAt { position: [11.5, -40.0, 11.5], target: [11.5; 3], up: [0.0, 0.0, 1.0] });
            (scene.image.width, scene.image.height) = (9, 9);
        }))
    };
    let whole = draw(12.0, false, SurfaceSearch::Exact);
    let (exact, sampled) = (SurfaceSearch::Exact, SurfaceSearch::Sampled);
    assert!(draw(12.0, true, exact).depth.iter().all(|depth| depth.is_infinite()));
    let shown = [(12.0, false, 12.0), (10.9, true, 10.9)];
    let shown = shown.into_iter().flat_map(|case| [(case, exact), (case, sampled)]);
    for ((level, hole, expected), search) in shown.chain([((12.0, true, 11.5), sampled)]) {
        let frame = draw(level, hole, search);
        for pixel in 0..81 {
            let depth = frame.depth[pixel] - 40.0;
            assert!((depth - expected as f32).abs() < 3e-3, "{level} {hole}: {depth}");
            // Towards lower values, in the same light.
            assert!((glam::Vec3::from_array(frame.normal[pixel]) + glam::Vec3::Y).length() < 1e-3, "{level} {hole}");
            for (channel, expected) in frame.color[pixel].into_iter().zip(whole.color[pixel]) {
                assert!((channel - expected).abs() < 1e-3, "{level} {hole}: {channel} instead of {expected}");
            }
        }
    }
}

#[test]
fn wholly_absent_data_draw_nothing_and_say_so() {
    let frame = render(&stage(unit_volume([8; 3], |_| f64::NAN), opaque_above(0.0), |_| ()));
    assert!(frame.color.iter().all(|color| *color == [0.0; 4]));
    assert!(matches!(frame.warnings.as_slice(), [RenderWarning::Empty { .. }]), "{:?}", frame.warnings);
}

/// One voxel, a line, a sheet, and an axis longer than common texture limits are drawn by every
/// mode; what is drawn is where the voxels are (USERS theme C).
#[test]
fn odd_shapes_are_drawn() {
    for dims in [[1, 1, 1], [1, 1, 40], [40, 1, 1], [1, 40, 1], [1, 30, 30], [2049, 16, 16], [16, 16, 4097], [2, 2, 2]]
    {
        for mode in every_mode() {
            let value = |p: DVec3| if p.element_sum() as usize & 1 == 0 { 5.0 } else { 3.5 };
            let frame = render(&stage(unit_volume(dims, value), opaque_above(2.0), |scene| {
                set_mode(scene, mode.clone());
                scene.volumes[0].shading = Some(true);
                // An odd size has a ray through the middle of what is one voxel wide.
                scene.image.width = 17;
                scene.image.height = 17;
                scene.quality.step = if dims.iter().max() > Some(&100) { 2.0 } else { 0.5 };
            }));
            assert!(finite(&frame), "{dims:?} {mode:?}");
            let surfaces = matches!(mode, Mode::Isosurface(_));
            assert!(surfaces || frame.statistics.samples_visible > 0, "{dims:?} {mode:?} is empty");
        }
    }
    let frame = render(&stage(unit_volume([2049, 16, 16], |_| 5.0), opaque_above(2.0), |scene| {
        scene.image.width = 64;
        scene.image.height = 8;
        scene.camera.projection = Projection::Orthographic { height: Some(32.0) };
    }));
    // 64 columns show 256 of the 2048 units around the middle: the block fills them all.
    assert!(frame.color[3 * 64..5 * 64].iter().all(|color| color[3] > 0.9));
}

/// Every voxel type through the whole renderer, with values over its full range.
#[test]
fn every_voxel_type_draws_the_same_ramp() {
    let grid = Grid::new([8; 3]).unwrap();
    let ramp = |low: f64, high: f64| -> Vec<f64> {
        (0..512).map(|i| (low + (high - low) * (i % 8) as f64 / 7.0).round()).collect()
    };
    let mut pictures = Vec::new();
    macro_rules! draw {
        ($($type:ty => $low:expr, $high:expr);*) => { $(
            let (low, high): (f64, f64) = ($low, $high);
            let values: Vec<$type> = ramp(low, high).into_iter().map(<$type as pellucid_field::Voxel>::from_f64).collect();
            let volume = Volume::new(grid, Voxels::from(values)).unwrap();
            let tf = transfer_function(&[(low, 0x000000), (high, 0xffffff)], &[(low, 0.0), (high, 0.5)]);
            pictures.push((stringify!($type), render(&stage(volume, tf, |_| ()))));
        )* };
    }
    draw!(u8 => 0.0, 255.0; i8 => -128.0, 127.0; u16 => 0.0, 65535.0; i16 => -32768.0, 32767.0;
        u32 => 0.0, 4294967295.0; i32 => -2147483648.0, 2147483647.0; f32 => -1e6, 1e6);
    for (name, picture) in &pictures[1..] {
        for (a, b) in picture.color.iter().flatten().zip(pictures[0].1.color.iter().flatten()) {
            // Rounding a level of u8 moves a colour by up to 2.2 / 510 and its opacity by 0.5 / 510.
            assert!((a - b).abs() < 6e-3, "{name}: {a} and {b}");
        }
    }
}

#[test]
fn a_camera_inside_sees_what_is_before_it() {
    let volume = unit_volume([32; 3], |p| p.y);
    let stage = stage(volume, transfer_function(&[(0.0, 0xffffff)], &[(0.0, 0.1)]), |scene: &mut Scene| {
        scene.camera.projection = Projection::Perspective { vertical_fov: 20.0 };
        scene.camera.view =
            View::LookAt(LookAt { position: [15.5, 21.0, 15.5], target: [15.5, 31.0, 15.5], up: [0.0, 0.0, 1.0] });
    });
    let alpha = f64::from(crate::common::center(&render(&stage))[3]);
    // Ten units of the box lie before the eye; the middle ray is tilted by a fraction of a degree.
    assert!((alpha - (1.0 - 0.9f64.powf(10.0))).abs() < 1e-3, "{alpha}");
}
