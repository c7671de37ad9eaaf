//! An empty picture says what it is for.

use std::sync::Arc;

use pellucid_field::{Grid, Volume};
use pellucid_optics::{Color, ColorPoint, OpacityPoint, TransferFunction};
use pellucid_scene::{
    Clip, Crop, Frame, Isosurface, Isovalue, LookAt, Mode, RayCast, Scene, Slice, Source, Stage, Technique, View,
};

/// Values 0 to 511 on a grid of 8 x 8 x 8 with a spacing of 2.
fn ramp() -> Arc<Volume> {
    let grid = Grid::with_spacing([8; 3], [2.0; 3], [0.0; 3]).unwrap();
    Arc::new(Volume::new(grid, (0..512u16).collect::<Vec<_>>()).unwrap())
}

fn stage(volume: &Arc<Volume>, edit: impl FnOnce(&mut Scene)) -> Stage {
    let mut scene = Scene::of(Source::memory());
    edit(&mut scene);
    scene.resolve(std::slice::from_ref(volume)).unwrap().0
}

fn draw(scene: &mut Scene, mode: Mode) {
    scene.technique = Technique::RayCast(RayCast { mode });
}

fn tf(points: &[(f64, f32)]) -> TransferFunction {
    let points = points.iter().map(|(value, opacity)| OpacityPoint::new(*value, *opacity)).collect();
    TransferFunction::new(vec![ColorPoint::new(0.0, Color::WHITE)], points).unwrap()
}

#[test]
fn the_cause_is_named_with_what_there_is() {
    let volume = ramp();
    let nothing = Arc::new(Volume::new(*volume.grid(), vec![f32::NAN; 512]).unwrap());
    let surface =
        |value| Mode::Isosurface(Isosurface::new(vec![Isovalue { value, color: None, opacity: 1.0, volume: None }]));
    let slice = |point| Mode::Slice(Slice { normal: Some([0.0, 0.0, 1.0]), point: Some(point), ..Slice::default() });
    let away = LookAt { position: [7.0, -50.0, 7.0], target: [7.0, -99.0, 7.0], up: [0.0, 0.0, 1.0] };
    let aside = LookAt { position: [7.0, -50.0, 7.0], target: [90.0, 7.0, 7.0], up: [0.0, 0.0, 1.0] };
    let cases: [(Stage, u64, &[&str]); 11] = [
        (stage(&nothing, |_| ()), 9, &["no value", "512", "NaN"]),
        (stage(&volume, |scene| draw(scene, surface(9999.0))), 9, &["isovalue 9999", "0 to 511"]),
        (stage(&volume, |scene| draw(scene, slice([7.0, 7.0, 99.0]))), 0, &["slice", "99", "0 to 14"]),
        (
            stage(&volume, |scene| scene.volumes[0].crop = Some(Crop { from: [40.0; 3], to: [50.0; 3] })),
            0,
            &["crop", "(40, 40, 40) to (50, 50, 50)", "(7, 7, 7)"],
        ),
        (
            stage(&volume, |scene| {
                scene.clips = vec![Clip::Plane { point: [0.0, 0.0, 999.0], normal: [0.0, 0.0, 1.0] }];
            }),
            0,
            &["clips", "(0, 0, 0) to (14, 14, 14)"],
        ),
        (stage(&volume, |scene| scene.camera.view = View::LookAt(away)), 0, &["camera", "behind the eye", "(7, 7, 7)"]),
        (stage(&volume, |scene| scene.camera.view = View::LookAt(aside)), 0, &["camera", "beside the picture"]),
        (
            stage(&volume, |scene| scene.volumes[0].transfer_function = Some(tf(&[(600.0, 0.0), (700.0, 0.5)]))),
            9,
            &["transfer function", "0 to 511", "700", "volumes[0].window"],
        ),
        (
            stage(&volume, |scene| scene.volumes[0].transfer_function = Some(tf(&[(0.0, 0.0)]))),
            9,
            &["transfer function", "none anywhere"],
        ),
        (stage(&volume, |scene| scene.volumes[0].unit_distance = Some(1e6)), 9, &["unit distance", "1000000"]),
        (stage(&volume, |scene| scene.volumes[0].window = Some([1e4, 2e4])), 9, &["0 to 511", "volumes[0].window"]),
    ];
    for (k, (stage, rays_hit, parts)) in cases.into_iter().enumerate() {
        let said = stage.why_empty(rays_hit);
        for part in parts {
            assert!(said.contains(part), "{k}: '{part}' is not in: {said}");
        }
        assert!(stage.is_too_faint(&Frame::new(4, 4)));
    }
    let mut frame = Frame::new(4, 4);
    frame.color[3] = [0.0, 0.004, 0.0, 0.0];
    assert!(!stage(&volume, |_| ()).is_too_faint(&frame));
}
