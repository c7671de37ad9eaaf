//! Cameras: what azimuth, elevation, roll, framing and rays mean.

use glam::DVec3;
use pellucid_scene::{Camera, LookAt, Orbit, Projection, Ray, View, Viewpoint};
use proptest::prelude::*;

/// The corners of a cube around the origin.
const CUBE: [DVec3; 8] = [
    DVec3::new(-1.0, -1.0, -1.0),
    DVec3::new(1.0, -1.0, -1.0),
    DVec3::new(-1.0, 1.0, -1.0),
    DVec3::new(1.0, 1.0, -1.0),
    DVec3::new(-1.0, -1.0, 1.0),
    DVec3::new(1.0, -1.0, 1.0),
    DVec3::new(-1.0, 1.0, 1.0),
    DVec3::new(1.0, 1.0, 1.0),
];

fn orbit(azimuth: f64, elevation: f64, roll: f64) -> Orbit {
    Orbit { azimuth, elevation, roll, ..Orbit::default() }
}

fn camera(projection: Projection, view: View) -> Camera {
    Camera { projection, view, ..Camera::default() }
}

fn perspective(vertical_fov: f64) -> Projection {
    Projection::Perspective { vertical_fov }
}

const PARALLEL: Projection = Projection::Orthographic { height: None };

fn looking(orbit: Orbit) -> Viewpoint {
    camera(perspective(30.0), View::Orbit(orbit)).viewpoint(100, 100, &CUBE)
}

fn close(a: DVec3, b: DVec3) -> bool {
    (a - b).length() < 1e-9
}

/// Where a world point falls in the picture, -1 to 1 across and upward, by solving for the ray
/// through it; infinite if behind the eye.
fn project(view: &Viewpoint, point: DVec3) -> (f64, f64) {
    let p = point - view.eye;
    let (x, y, depth) = (p.dot(view.right), p.dot(view.up), p.dot(view.forward));
    let scale = match (view.perspective, depth > 0.0) {
        (false, _) => view.half_height,
        (true, true) => view.half_height * depth,
        (true, false) => return (f64::INFINITY, f64::INFINITY),
    };
    (x / scale / (view.width as f64 / view.height as f64), y / scale)
}

fn assert_orthonormal(view: &Viewpoint) {
    for v in [view.right, view.up, view.forward] {
        assert!((v.length() - 1.0).abs() < 1e-9, "{view:?}");
    }
    assert!(close(view.right.cross(view.up), -view.forward), "{view:?}");
    assert!(view.eye.is_finite() && view.half_height > 0.0, "{view:?}");
}

#[test]
fn angles_mean_what_they_say() {
    // Azimuth 0: the eye on -y looks along +y, +z is up, +x is right.
    let front = looking(orbit(0.0, 0.0, 0.0));
    assert!(close(front.eye.normalize(), DVec3::NEG_Y) && close(front.forward, DVec3::Y));
    assert!(close(front.up, DVec3::Z) && close(front.right, DVec3::X));
    // A positive azimuth walks the eye to its own right.
    let right = looking(orbit(90.0, 0.0, 0.0));
    assert!(close(right.eye.normalize(), DVec3::X) && close(right.right, DVec3::Y) && close(right.up, DVec3::Z));
    // A positive elevation raises it; at the poles up is still defined.
    let raised = looking(orbit(0.0, 45.0, 0.0));
    assert!(close((raised.eye - raised.target).normalize(), DVec3::new(0.0, -1.0, 1.0).normalize()));
    let top = looking(orbit(0.0, 90.0, 0.0));
    assert!(close(top.forward, DVec3::NEG_Z) && close(top.up, DVec3::Y) && close(top.right, DVec3::X));
    let bottom = looking(orbit(0.0, -90.0, 0.0));
    assert!(close(bottom.forward, DVec3::Z) && close(bottom.up, DVec3::NEG_Y) && close(bottom.right, DVec3::X));
    // A roll of 90 degrees turns the picture clockwise: what was up points right.
    let rolled = looking(orbit(0.0, 0.0, 90.0));
    let (x, y) = project(&rolled, DVec3::Z * 0.5);
    assert!(x > 0.1 && y.abs() < 1e-9, "{x} {y}");
}

#[test]
fn rays_pass_through_corners_and_centre() {
    for (projection, perspective) in
        [(perspective(60.0), true), (Projection::Orthographic { height: Some(4.0) }, false)]
    {
        let orbit = Orbit { distance: Some(10.0), ..orbit(0.0, 0.0, 0.0) };
        let view = camera(projection, View::Orbit(orbit)).viewpoint(200, 100, &CUBE);
        let centre = view.ray(100.0, 50.0);
        assert!(close(centre.origin, DVec3::new(0.0, -10.0, 0.0)) && close(centre.direction, DVec3::Y));
        assert!(close(centre.at(10.0), DVec3::ZERO));
        // At the target the picture is 10 tan 30 high and low (or 2), and twice as wide.
        let half = if perspective { 10.0 * 30f64.to_radians().tan() } else { 2.0 };
        for (x, y, expected) in [
            (0.0, 0.0, DVec3::new(-2.0 * half, 0.0, half)),
            (200.0, 0.0, DVec3::new(2.0 * half, 0.0, half)),
            (0.0, 100.0, DVec3::new(-2.0 * half, 0.0, -half)),
            (200.0, 100.0, DVec3::new(2.0 * half, 0.0, -half)),
        ] {
            let ray = view.ray(x, y);
            assert!((ray.direction.length() - 1.0).abs() < 1e-12);
            let met = ray.at(-ray.origin.y / ray.direction.y);
            assert!(close(met, expected), "{met} {expected}");
        }
        // Pixels are square.
        let at = |x, y| view.ray(x, y).at(10.0 / view.ray(x, y).direction.y);
        let (across, down) = (at(101.0, 50.0) - at(100.0, 50.0), at(100.0, 51.0) - at(100.0, 50.0));
        assert!((across.length() - down.length()).abs() < 1e-9);
    }
}

#[test]
fn towards_the_eye() {
    let view = looking(Orbit { distance: Some(10.0), ..orbit(0.0, 0.0, 0.0) });
    assert!(close(view.to_eye(DVec3::new(0.0, -10.0, 5.0)), DVec3::NEG_Z));
    assert!(close(view.to_eye(view.eye), -view.forward));
    let parallel = camera(PARALLEL, View::Orbit(orbit(0.0, 0.0, 0.0))).viewpoint(10, 10, &CUBE);
    assert!(close(parallel.to_eye(DVec3::new(3.0, 7.0, 5.0)), DVec3::NEG_Y));
}

#[test]
fn settings_replace_framing() {
    let target = [3.0, 4.0, 5.0];
    let set = looking(Orbit { distance: Some(2.0), target: Some(target), zoom: 5.0, ..Orbit::default() });
    assert!(((set.eye - DVec3::from_array(target)).length() - 2.0).abs() < 1e-12);
    // Twice the zoom, half the picture around the same middle, and the eye stays where it is: also where distance or
    // height are set.
    let height = Projection::Orthographic { height: Some(3.0) };
    for (projection, distance) in
        [(perspective(30.0), None), (perspective(30.0), Some(7.0)), (PARALLEL, None), (height, None)]
    {
        let zoomed =
            |zoom| camera(projection, View::Orbit(Orbit { zoom, distance, ..Orbit::default() })).viewpoint(9, 9, &CUBE);
        let (near, far) = (zoomed(2.0), zoomed(1.0));
        assert!((near.half_height * 2.0 - far.half_height).abs() < 1e-12);
        assert_eq!((near.eye, near.target, near.forward), (far.eye, far.target, far.forward));
        // A point half way to the side of the picture is at its side.
        let aside = far.target
            + far.right * far.half_height * if far.perspective { (far.eye - far.target).length() } else { 1.0 } / 2.0;
        assert!((project(&far, aside).0 - 0.5).abs() < 1e-9 && (project(&near, aside).0 - 1.0).abs() < 1e-9);
    }
    // A camera inside the volume is as good as any.
    let inside = looking(Orbit { distance: Some(1e-3), ..Orbit::default() });
    assert_orthonormal(&inside);
    assert!((inside.eye - inside.target).length() < 1.1e-3 && inside.ray(0.0, 0.0).direction.is_finite());
}

/// On a turntable what is upright stays upright, and the eye at its height; 30 degrees are 30 degrees of azimuth.
#[test]
fn a_turntable_turns_about_the_patients_axis() {
    for elevation in [-60.0, 0.0, 20.0, 75.0] {
        let at = |azimuth| {
            looking(Orbit { target: Some([3.0, 4.0, 5.0]), distance: Some(9.0), ..orbit(azimuth, elevation, 0.0) })
        };
        for degrees in [30.0, -111.0, 180.0] {
            let (turned, expected) = (at(10.0).turntable(degrees), at(10.0 + degrees));
            for (a, b) in [(turned.eye, expected.eye), (turned.right, expected.right), (turned.up, expected.up)] {
                assert!(close(a, b), "{turned:?} {expected:?}");
            }
            assert!((turned.eye.z - at(10.0).eye.z).abs() < 1e-12 && turned.right.z.abs() < 1e-12);
        }
    }
}

#[test]
fn look_at_looks_at() {
    let look = LookAt { position: [10.0, 0.0, 0.0], target: [0.0; 3], up: [0.0, 0.0, 7.0] };
    let view = camera(perspective(30.0), View::LookAt(look)).viewpoint(10, 10, &CUBE);
    assert!(close(view.eye, DVec3::X * 10.0) && close(view.forward, DVec3::NEG_X));
    assert!(close(view.up, DVec3::Z) && close(view.right, DVec3::Y));
}

#[test]
fn an_up_along_the_view_still_makes_a_camera() {
    let directions = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.3, -0.7, 0.2], [0.1, 0.1, 0.1]];
    for up in directions {
        for (sign, tilt) in [1.0, -1.0].into_iter().flat_map(|s| [0.0, 1e-17, 1e-12, 1e-7, 1e-5].map(|t| (s, t))) {
            for scale in [1e-30, 1.0, 1e30] {
                let position = std::array::from_fn(|axis| sign * up[axis] * 3.0 + if axis == 1 { tilt } else { 0.0 });
                let look = LookAt { position, target: [0.0; 3], up: up.map(|v| v * scale) };
                for projection in [perspective(30.0), PARALLEL] {
                    let view = camera(projection, View::LookAt(look)).viewpoint(10, 10, &CUBE);
                    assert_orthonormal(&view);
                    // Not rounding noise: +y is up instead, unless that is the view as well.
                    let across = DVec3::Y.cross(-view.forward);
                    if tilt < 1e-6 && across.length() > 1e-3 {
                        assert!((view.right - across.normalize()).length() < 1e-9, "{look:?} {view:?}");
                    }
                }
            }
        }
    }
    // Looking straight down is the view of an orbit at its pole.
    let look = LookAt { position: [0.0, 0.0, 5.0], target: [0.0; 3], up: [0.0, 0.0, 1.0] };
    let down = camera(perspective(30.0), View::LookAt(look)).viewpoint(10, 10, &CUBE);
    assert!(close(down.up, DVec3::Y) && close(down.right, DVec3::X));
}

#[test]
fn nothing_to_frame_is_no_trouble() {
    for corners in [&[][..], &[DVec3::ONE; 3]] {
        for projection in [perspective(30.0), PARALLEL] {
            let view = camera(projection, View::default()).viewpoint(10, 10, corners);
            assert_orthonormal(&view);
            assert!(view.ray(3.0, 4.0).direction.is_finite());
        }
    }
}

proptest! {
    #[test]
    fn framing_fills_the_picture_and_loses_nothing(
        low in [-1e3f64..1e3, -1e3f64..1e3, -1e3f64..1e3],
        size in [0.1f64..300.0, 0.1f64..300.0, 0.1f64..300.0],
        angles in [-720.0f64..720.0, -90.0f64..90.0, -720.0f64..720.0],
        width in 1usize..2000,
        height in 1usize..2000,
        fov in proptest::option::of(1.0f64..170.0),
    ) {
        let corners: Vec<DVec3> = (0..8)
            .map(|k| DVec3::from_array(std::array::from_fn(|axis| low[axis] + if k >> axis & 1 == 1 { size[axis] } else { 0.0 })))
            .collect();
        let projection = fov.map_or(PARALLEL, perspective);
        let view = camera(projection, View::Orbit(orbit(angles[0], angles[1], angles[2]))).viewpoint(width, height, &corners);
        assert_orthonormal(&view);
        let mut reach = 0.0f64;
        for corner in &corners {
            let (x, y) = project(&view, *corner);
            prop_assert!(x.abs() < 1.0 && y.abs() < 1.0, "{x} {y}");
            reach = reach.max(x.abs()).max(y.abs());
            // The ray through that place of the picture passes through the corner.
            let ray = view.ray((x + 1.0) / 2.0 * width as f64, (1.0 - y) / 2.0 * height as f64);
            let away = (*corner - ray.origin).reject_from_normalized(ray.direction).length();
            prop_assert!(away < 1e-7 * (1.0 + (*corner - ray.origin).length()), "{away}");
            // All of it is in front of the eye.
            prop_assert!((*corner - view.eye).dot(view.forward) > 0.0);
        }
        // Seen at an angle wider than its corner, a box is framed by an eye right before the corner.
        let depths = corners.iter().map(|corner| (*corner - view.eye).dot(view.forward));
        let (near, far) = depths.fold((f64::INFINITY, 0.0f64), |(a, b), d| (a.min(d), b.max(d)));
        prop_assert!(reach > 0.95 || near < 2e-3 * (far - near), "{reach}");
    }
}

proptest! {
    /// Turning a view about its up hint is looking from the turned position, Rodrigues' formula
    /// written out, with the same hint.
    #[test]
    fn a_turned_view_looks_at_its_target_from_the_turned_position(
        position in [1.0f64..9.0, -9.0..9.0, -9.0..9.0], target in [-9.0f64..0.9, -9.0..9.0, -9.0..9.0],
        up in [-0.2f64..0.2, -0.2..0.2, 0.5..1.0], degrees in -400.0f64..400.0,
    ) {
        let look = LookAt { position, target, up };
        let [from, to, hint] = [position, target, up].map(DVec3::from_array);
        prop_assume!((from - to).cross(hint).length() > 0.1);
        let axis = hint.normalize();
        let (sin, cos) = degrees.to_radians().sin_cos();
        let offset = from - to;
        let turned = offset * cos + axis.cross(offset) * sin + axis * axis.dot(offset) * (1.0 - cos);
        let expected = LookAt { position: (to + turned).to_array(), ..look };
        let [view, expected] = [look, expected].map(|look| camera(perspective(30.0), View::LookAt(look)).viewpoint(7, 5, &CUBE));
        let view = view.turned(hint, degrees);
        prop_assert!(view.target == to && view.half_height == expected.half_height);
        for (a, b) in [(view.eye, expected.eye), (view.right, expected.right), (view.up, expected.up), (view.forward, expected.forward)] {
            prop_assert!(close(a, b), "{view:?} {expected:?}");
        }
        prop_assert_eq!((view.turned(DVec3::ZERO, 90.0), view.turned(hint, 0.0)), (view, view));
    }
}

proptest! {
    /// A shift moves rays by pixels; fewer rows move them by nothing: the ray through the same place,
    /// measured from the middle of the picture in picture heights, is the same.
    #[test]
    fn shifts_and_other_resolutions_keep_the_rays(
        width in 1usize..500, height in 1usize..500, rows in 0usize..600, parallel: bool,
        (x, y) in (-10.0f64..500.0, -10.0f64..500.0), (dx, dy) in (-3.0f64..3.0, -3.0f64..3.0),
    ) {
        let projection = if parallel { PARALLEL } else { perspective(30.0) };
        let view = camera(projection, View::default()).viewpoint(width, height, &CUBE);
        let near = |a: Ray, b: Ray| close(a.origin, b.origin) && close(a.direction, b.direction);
        let shifted = view.shifted(dx, dy);
        prop_assert!(near(shifted.ray(x, y), view.ray(x + dx, y + dy)));
        prop_assert!(near(shifted.shifted(dx, -dy).ray(x, y), view.ray(x + 2.0 * dx, y)));
        prop_assert_eq!(view.shifted(0.0, 0.0).ray(x, y), view.ray(x, y));

        let other = shifted.with_rows(rows);
        let scale = rows.max(1) as f64 / height as f64;
        prop_assert_eq!(other.height, rows.max(1));
        // Its columns cover the picture and no more than that.
        let covered = width as f64 * scale;
        prop_assert!(other.width as f64 > covered - 1e-9 && other.width as f64 - 1.0 < covered, "{}", other.width);
        let place = |v: f64, from: usize, to: usize| (v - from as f64 / 2.0) * scale + to as f64 / 2.0;
        let ray = other.ray(place(x, width, other.width), place(y, height, other.height));
        prop_assert!(near(ray, shifted.ray(x, y)));
    }
}
