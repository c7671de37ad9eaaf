//! Clipping: intervals of rays against point tests.

use glam::DVec3;
use pellucid_scene::{Clip, Ray, Region};
use proptest::collection::vec;
use proptest::prelude::*;

fn region(clips: &[Clip]) -> Region {
    Region::from_clips(clips)
}

fn cube() -> Clip {
    Clip::Box { min: [-1.0, -2.0, -3.0], max: [1.0, 2.0, 3.0] }
}

#[test]
fn boundaries_belong_to_what_stays() {
    let inside = region(&[cube()]);
    for (point, stays) in [
        ([1.0, 2.0, 3.0], true),
        ([-1.0, -2.0, -3.0], true),
        ([1.0, 0.0, 0.0], true),
        ([1.0f64.next_up(), 0.0, 0.0], false),
        ([0.0, 0.0, (-3.0f64).next_down()], false),
    ] {
        assert_eq!(inside.contains(DVec3::from_array(point)), stays, "{point:?}");
    }
    let half = region(&[Clip::Plane { point: [0.5, 9.0, -9.0], normal: [100.0, 0.0, 0.0] }]);
    assert!(half.contains(DVec3::new(0.5, 3.0, 3.0)) && !half.contains(DVec3::new(0.5f64.next_down(), 0.0, 0.0)));
}

#[test]
fn no_clips_keep_everything() {
    let all = region(&[]);
    let ray = Ray { origin: DVec3::ZERO, direction: DVec3::X };
    assert!(all.is_everything() && all.contains(DVec3::splat(1e9)));
    assert_eq!(all.interval(&ray, 2.0, 5.0), Some((2.0, 5.0)));
    assert_eq!(all.interval(&ray, 5.0, 5.0), None);
    assert!(!region(&[cube()]).is_everything());
}

#[test]
fn rays_along_and_on_a_face() {
    let inside = region(&[cube()]);
    let along = |x: f64| Ray { origin: DVec3::new(x, -10.0, 0.0), direction: DVec3::Y };
    assert_eq!(inside.interval(&along(0.0), 0.0, 100.0), Some((8.0, 12.0)));
    assert_eq!(inside.interval(&along(1.0), 0.0, 100.0), Some((8.0, 12.0)));
    assert_eq!(inside.interval(&along(1.0f64.next_up()), 0.0, 100.0), None);
    assert_eq!(inside.interval(&along(0.0), 9.0, 10.0), Some((9.0, 10.0)));
    assert_eq!(inside.interval(&along(0.0), 13.0, 20.0), None);
    // What two opposite half-spaces leave is a plane or nothing.
    let plane = |x: f64, nx: f64| Clip::Plane { point: [x, 0.0, 0.0], normal: [nx, 0.0, 0.0] };
    let thin = region(&[plane(0.0, 1.0), plane(0.0, -1.0)]);
    let across = Ray { origin: DVec3::new(-5.0, 0.0, 0.0), direction: DVec3::X };
    assert!(thin.contains(DVec3::Y) && thin.interval(&across, 0.0, 10.0).is_none());
    assert_eq!(region(&[plane(1.0, 1.0), plane(0.0, -1.0)]).interval(&across, 0.0, 10.0), None);
}

/// A box as the six planes of its faces.
fn faces(min: [f64; 3], max: [f64; 3]) -> Vec<Clip> {
    let face = |axis: usize, at: [f64; 3], sign: f64| {
        let mut normal = [0.0; 3];
        normal[axis] = sign * 2.5;
        Clip::Plane { point: at, normal }
    };
    (0..3).flat_map(|axis| [face(axis, min, 1.0), face(axis, max, -1.0)]).collect()
}

fn point() -> impl Strategy<Value = [f64; 3]> {
    [-10.0f64..10.0, -10.0f64..10.0, -10.0f64..10.0]
}

fn box_clip() -> impl Strategy<Value = Clip> {
    (point(), [0.1f64..15.0, 0.1f64..15.0, 0.1f64..15.0])
        .prop_map(|(min, size)| Clip::Box { min, max: std::array::from_fn(|axis| min[axis] + size[axis]) })
}

fn clip() -> impl Strategy<Value = Clip> {
    let plane = (point(), point()).prop_filter("a normal", |(_, n)| DVec3::from_array(*n).length() > 0.1);
    prop_oneof![box_clip(), plane.prop_map(|(point, normal)| Clip::Plane { point, normal })]
}

fn ray() -> impl Strategy<Value = Ray> {
    let axes = prop::sample::select(vec![[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 1.0, 1.0]]);
    (point(), prop_oneof![3 => point(), 1 => axes])
        .prop_filter("a direction", |(_, d)| DVec3::from_array(*d).length() > 0.1)
        .prop_map(|(o, d)| Ray { origin: DVec3::from_array(o), direction: DVec3::from_array(d).normalize() })
}

proptest! {
    #[test]
    fn the_interval_is_where_points_are_inside(clips in vec(clip(), 1..4), ray in ray(), t0 in -20.0f64..5.0, length in 0.0f64..40.0) {
        let (region, t1) = (region(&clips), t0 + length);
        let found = region.interval(&ray, t0, t1);
        if let Some((from, to)) = found {
            prop_assert!(t0 <= from && from < to && to <= t1);
        }
        const SAMPLES: usize = 2000;
        for k in 0..=SAMPLES {
            let t = t0 + length * k as f64 / SAMPLES as f64;
            let (from, to) = found.unwrap_or((f64::INFINITY, f64::NEG_INFINITY));
            // At the very boundary rounding decides.
            if found.is_none() || ((t - from).abs() > 1e-9 && (t - to).abs() > 1e-9) {
                let inside = region.contains(ray.at(t));
                prop_assert!(inside == (from < t && t < to) || (found.is_none() && length < 1e-9), "{t} of {found:?}: {inside}");
            }
        }
    }

    #[test]
    fn a_box_is_its_six_planes(cube in box_clip(), ray in ray()) {
        let Clip::Box { min, max } = cube else { unreachable!() };
        let (whole, planes) = (region(&[cube]), region(&faces(min, max)));
        prop_assert_eq!(whole.interval(&ray, 0.0, 50.0), planes.interval(&ray, 0.0, 50.0));
        for k in 0..100 {
            let p = ray.at(k as f64 * 0.3);
            prop_assert_eq!(whole.contains(p), planes.contains(p));
            prop_assert_eq!(whole.contains(p), (0..3).all(|axis| min[axis] <= p[axis] && p[axis] <= max[axis]));
        }
    }
}
