//! What the camera frames: what is seen, to a part of a voxel, from any side.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec3};
use pellucid_field::{Grid, Volume};
use pellucid_optics::{Color, ColorPoint, OpacityPoint, TransferFunction};
use pellucid_scene::{
    Camera, Clip, Crop, Framing, Isosurface, Isovalue, Mode, Orbit, Projection, RayCast, Scene, Slice, Source,
    Technique, View, Viewpoint,
};

const N: usize = 40;
const MARGIN: f64 = 1.04;

/// A grid with thin, turned voxels.
fn turned() -> Grid {
    let turn = DMat3::from_quat(DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7));
    let scale = DMat3::from_diagonal(DVec3::new(1.0, -0.5, 2.0));
    Grid::with_affine([N, 2 * N, N / 2], DAffine3 { matrix3: turn * scale, translation: DVec3::new(10.0, -20.0, 5.0) })
        .unwrap()
}

/// The distance to a point near the middle of the grid, in world units, and that point.
fn distances(grid: Grid) -> (Arc<Volume>, DVec3) {
    let center = grid.center() + DVec3::new(3.3, -2.1, 1.7);
    let [nx, ny, _] = grid.dims();
    let place = |k: usize| DVec3::new((k % nx) as f64, (k / nx % ny) as f64, (k / (nx * ny)) as f64);
    let value = |k: usize| (grid.world_from_index().transform_point3(place(k)) - center).length() as f32;
    (Arc::new(Volume::new(grid, (0..grid.len()).map(value).collect::<Vec<_>>()).unwrap()), center)
}

/// Opaque up to a value.
fn up_to(value: f64) -> TransferFunction {
    let steps = [(0.0, 1.0), (value, 1.0), (value + 1e-3, 0.0)];
    let points = steps.map(|(value, opacity)| OpacityPoint::new(value, opacity)).to_vec();
    TransferFunction::new(vec![ColorPoint::new(0.0, Color::WHITE)], points).unwrap()
}

fn ball(radius: f64) -> Scene {
    let mut scene = Scene::of(Source::memory());
    scene.volumes[0].transfer_function = Some(up_to(radius));
    (scene.image.width, scene.image.height) = (300, 200);
    scene
}

fn parallel() -> Projection {
    Projection::Orthographic { height: None }
}

fn view(scene: &Scene, volume: &Arc<Volume>) -> Viewpoint {
    scene.resolve(std::slice::from_ref(volume)).unwrap().0.viewpoint
}

#[test]
fn a_ball_fills_the_picture_from_every_side() {
    for grid in [Grid::new([N; 3]).unwrap(), turned()] {
        let (volume, center) = distances(grid);
        for radius in [4.0, 7.0, 8.5, 11.0] {
            for (azimuth, elevation) in [(0.0, 0.0), (30.0, 20.0), (-77.0, 51.0), (160.0, -90.0)] {
                let mut scene = ball(radius);
                scene.camera.view = View::Orbit(Orbit { azimuth, elevation, ..Orbit::default() });
                scene.camera.projection = parallel();
                let flat = view(&scene, &volume);
                // Interpolation along the longest edges of cells bends the surface by a fraction of a voxel.
                let room = 0.35;
                let reach = flat.half_height / MARGIN;
                assert!((reach - radius).abs() < room, "{reach} for {radius}, {azimuth} {elevation}");
                assert!((flat.target - center).length() < 2.0 * room, "{} {center}", flat.target);
                // The planes through the eye along the sides of the picture, but for the margin, touch the ball.
                scene.camera.projection = Projection::default();
                let near = view(&scene, &volume);
                let slope = 15f64.to_radians().tan() / MARGIN;
                let away = radius * (1.0 + slope * slope).sqrt() / slope;
                let found = (near.eye - center).length();
                assert!((found - away).abs() < room / slope, "{found} for {away}, {azimuth} {elevation}");
            }
        }
    }
}

#[test]
fn surfaces_are_framed_where_they_are() {
    let (volume, _) = distances(turned());
    for radius in [5.0, 9.0] {
        let mut scene = ball(1.0);
        let isovalues = vec![Isovalue { value: radius, color: None, opacity: 1.0, volume: None }];
        scene.technique = Technique::RayCast(RayCast { mode: Mode::Isosurface(Isosurface::new(isovalues)) });
        scene.camera.projection = parallel();
        let reach = view(&scene, &volume).half_height / MARGIN;
        assert!((reach - radius).abs() < 0.35, "{reach} for {radius}");
    }
}

#[test]
fn a_series_compares_where_the_grid_is_framed() {
    let (volume, _) = distances(Grid::new([N; 3]).unwrap());
    let drawn = |radius: f64, frame| {
        let mut scene = ball(radius);
        scene.camera = Camera { frame, ..Camera::default() };
        view(&scene, &volume)
    };
    let whole = Camera::default().viewpoint(300, 200, &volume.grid().world_corners());
    for radius in [4.0, 7.0, 8.5, 11.0] {
        assert_same(&drawn(radius, Framing::Grid), &whole);
        assert!(drawn(radius, Framing::Visible).half_height == whole.half_height);
        assert!(drawn(radius, Framing::Visible) != whole);
    }
}

/// The view of all corners of a box in index space.
fn of_box(scene: &Scene, grid: &Grid, from: [f64; 3], to: [f64; 3]) -> Viewpoint {
    scene.camera.viewpoint(300, 200, &grid.world_corners_of((DVec3::from(from), DVec3::from(to))))
}

fn assert_same(a: &Viewpoint, b: &Viewpoint) {
    let close = (a.eye - b.eye).length() < 1e-6 && (a.target - b.target).length() < 1e-6;
    assert!(close && (a.half_height - b.half_height).abs() < 1e-6, "{a:?} {b:?}");
}

#[test]
fn a_crop_is_framed_as_a_volume_of_its_own() {
    for grid in [Grid::new([N; 3]).unwrap(), turned()] {
        let volume = Arc::new(Volume::new(grid, vec![1.0f32; grid.len()]).unwrap());
        let (from, to) = ([3.25, 10.0, 1.0], [9.5, 22.0, 6.5]);
        let modes = [Mode::Composite, Mode::Maximum, Mode::Average, Mode::XRay];
        for (mode, projection) in modes.into_iter().flat_map(|m| [(m.clone(), parallel()), (m, Projection::default())])
        {
            let mut scene = ball(2.0);
            scene.technique = Technique::RayCast(RayCast { mode });
            scene.camera.projection = projection;
            scene.volumes[0].crop = Some(Crop { from, to });
            assert_same(&view(&scene, &volume), &of_box(&scene, &grid, from, to));
        }
        // Nothing is left: the whole is as good as anything.
        let mut scene = ball(2.0);
        scene.volumes[0].crop = Some(Crop { from: [90.0; 3], to: [95.0; 3] });
        let (low, high) = grid.index_bounds();
        assert_same(&view(&scene, &volume), &of_box(&scene, &grid, low.to_array(), high.to_array()));
    }
}

#[test]
fn clips_leave_what_is_framed() {
    let grid = Grid::new([N; 3]).unwrap();
    let (volume, center) = distances(grid);
    let mut scene = ball(8.0);
    scene.camera.projection = parallel();
    scene.camera.view = View::Orbit(Orbit { azimuth: 0.0, elevation: 0.0, ..Orbit::default() });
    (scene.image.width, scene.image.height) = (200, 200);
    // Half a ball, seen from in front: 8 wide and 16 high.
    scene.clips = vec![Clip::Plane { point: center.to_array(), normal: [1.0, 0.0, 0.0] }];
    let half = view(&scene, &volume);
    assert!((half.half_height / MARGIN - 8.0).abs() < 0.35, "{}", half.half_height);
    assert!((half.target.x - center.x - 4.0).abs() < 0.5 && (half.target.z - center.z).abs() < 0.35);
    // A bevelled corner is not where it was.
    let solid = Arc::new(Volume::new(grid, vec![1.0f32; grid.len()]).unwrap());
    let edge = (N - 1) as f64;
    scene.camera.view = View::Orbit(Orbit { azimuth: 45.0, elevation: 0.0, ..Orbit::default() });
    scene.clips = vec![Clip::Plane { point: [edge / 2.0, edge / 2.0, 0.0], normal: [-1.0, -1.0, 0.0] }];
    // From azimuth 45 the picture's right is (1, 1, 0): what is left spans half the diagonal of the base.
    let bevelled = view(&scene, &solid);
    let right = (bevelled.target - DVec3::new(0.0, 0.0, edge / 2.0)).dot(bevelled.right);
    assert!((right - edge * 2f64.sqrt() / 4.0).abs() < 1e-6, "{right}");
}

/// A slice without a place lies in the middle of what is cropped, also where the crop reaches out of the grid.
#[test]
fn a_slice_cuts_the_middle_of_the_crop() {
    let grid = turned();
    let volume = Arc::new(Volume::new(grid, vec![1.0f32; grid.len()]).unwrap());
    for (from, to, middle) in [([3.0, 2.0, 1.0], [5.0, 40.0, 7.0], 4.0), ([20.0, -9.0, 0.0], [99.0; 3], 29.5)] {
        let mut scene = ball(2.0);
        let across = grid.world_from_index_gradient().col(0).to_array();
        let slice = Slice { normal: Some(across), ..Slice::default() };
        scene.technique = Technique::RayCast(RayCast { mode: Mode::Slice(slice.clone()) });
        scene.volumes[0].crop = Some(Crop { from, to });
        let stage = scene.resolve(std::slice::from_ref(&volume)).unwrap().0;
        let index = |point: DVec3| grid.world_from_index().inverse().transform_point3(point).x;
        let (point, _) = stage.slice_plane(&stage.volumes[0], &slice);
        assert!((index(point) - middle).abs() < 1e-9, "{}", index(point));
    }
}

#[test]
fn an_oblique_slice_is_framed_and_not_its_volume() {
    let grid = Grid::new([N; 3]).unwrap();
    let volume = Arc::new(Volume::new(grid, vec![1.0f32; grid.len()]).unwrap());
    let mut scene = ball(2.0);
    let slice = Slice { normal: Some([1.0, 1.0, 1.0]), ..Slice::default() };
    scene.technique = Technique::RayCast(RayCast { mode: Mode::Slice(slice) });
    scene.camera.projection = parallel();
    let elevation = (1.0 / 3f64.sqrt()).asin().to_degrees();
    scene.camera.view = View::Orbit(Orbit { azimuth: 135.0, elevation, ..Orbit::default() });
    // A cube cut through its middle across its diagonal is a regular hexagon with sides of edge / sqrt 2.
    let reach = view(&scene, &volume).half_height / MARGIN;
    let side = (N - 1) as f64 / 2f64.sqrt();
    let flats = side * 3f64.sqrt() / 2.0;
    assert!(reach > flats - 1e-3 && reach < side + 1e-3, "{reach} of {flats} to {side}");
}

/// One voxel among nothing, in the corner of a grid whose blocks are not full.
#[test]
fn a_single_voxel_and_flat_grids_are_framed() {
    for dims in [[13, 1, 1], [13, 9, 1], [3, 17, 33], [1, 1, 1]] {
        let grid = Grid::new(dims).unwrap();
        let mut values = vec![5.0f32; grid.len()];
        *values.last_mut().unwrap() = 0.0;
        let volume = Arc::new(Volume::new(grid, values).unwrap());
        let mut scene = ball(1.0);
        scene.camera.projection = parallel();
        let found = view(&scene, &volume);
        let (low, high) = grid.index_bounds();
        // Seen is what is at most 1: within a fifth of a voxel of the last one, across the thickness of flat axes.
        let corner =
            DVec3::from_array([0, 1, 2].map(|axis| if dims[axis] == 1 { low[axis] } else { high[axis] - 0.25 }));
        let expected = scene.camera.viewpoint(300, 200, &grid.world_corners_of((corner, high)));
        assert!((found.half_height - expected.half_height).abs() < 0.15, "{dims:?} {found:?} {expected:?}");
        assert!((found.target - expected.target).length() < 0.25, "{dims:?} {found:?} {expected:?}");
    }
}

/// A voxel that is far from all others and stands alone draws the camera nowhere; a lamp of some voxels does.
#[test]
fn a_hot_voxel_is_not_framed() {
    let (distances, _) = distances(Grid::new([N; 3]).unwrap());
    let solid = |hot: &[usize]| {
        let value = |k: usize| {
            let near = distances.value([k % N, k / N % N, k / (N * N)], 0) < 6.0;
            if hot.contains(&k) {
                1e6
            } else if near {
                100.0
            } else {
                0.0f32
            }
        };
        let volume = Volume::new(*distances.grid(), (0..N * N * N).map(value).collect::<Vec<_>>()).unwrap();
        let mut scene = Scene::of(Source::memory());
        scene.camera.projection = parallel();
        view(&scene, &Arc::new(volume)).half_height
    };
    let last = N * N * N - 1;
    let clean = solid(&[]);
    for hot in [&[last][..], &[last, 0, 77 * N], &[N * N + N + 1, 5]] {
        assert_eq!(solid(hot), clean);
    }
    assert!(solid(&[last, last - 1, last - N, last - N * N]) > 1.5 * clean);
}

/// What is hidden from the transfer function, or absent, is not framed.
#[test]
fn holes_are_not_framed() {
    let grid = Grid::new([N; 3]).unwrap();
    let (distances, center) = distances(grid);
    let value = |k: usize| {
        let p = DVec3::new((k % N) as f64, (k / N % N) as f64, (k / (N * N)) as f64);
        let d = distances.value([k % N, k / N % N, k / (N * N)], 0) as f32;
        if p.x > center.x + 20.0 { f32::NAN } else { d }
    };
    let volume = Arc::new(Volume::new(grid, (0..N * N * N).map(value).collect::<Vec<_>>()).unwrap());
    let mut scene = ball(6.0);
    scene.camera.projection = parallel();
    assert!((view(&scene, &volume).half_height / MARGIN - 6.0).abs() < 0.35);
}
