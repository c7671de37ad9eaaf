//! Closed-form fields whose surfaces have deep cavities, against what is known of their shapes.

use std::collections::VecDeque;

use glam::{DVec3, Vec3Swizzles};
use pellucid_field::closed_form::{Bowl, Engine, Gyroid, ScalarField, Sponge, sample_field};
use pellucid_field::{Filter, Sampler, VoxelType};

use crate::{Random, assert_close, assert_near};

#[test]
fn the_gyroid_repeats_and_is_its_own_negative() {
    let (gyroid, mut random) = (Gyroid::default(), Random(1));
    for _ in 0..100 {
        let p = random.point(-1.0, 1.0);
        assert_close(gyroid.value(-p), -gyroid.value(p), 1e-12);
        assert_close(gyroid.value(p.zxy()), gyroid.value(p), 1e-12);
        for axis in DVec3::AXES {
            assert_close(gyroid.value(p + axis * 2.0 / 3.0), gyroid.value(p), 1e-12);
        }
    }
    assert_close(gyroid.value(DVec3::splat(1.0 / 12.0)), 1.5, 1e-12);
    // Where one coordinate is 0 and the others are an eighth of a period on either side.
    assert_close(gyroid.value(DVec3::new(0.0, 1.0, -1.0) / 12.0), 0.5 - 0.5f64.sqrt(), 1e-12);
}

/// Where a field falls below or rises above 1/2 between two points.
fn crossing(value: impl Fn(DVec3) -> f64, from: DVec3, to: DVec3) -> DVec3 {
    let (mut near, mut far) = (0.0, 1.0);
    let is_inside = |t: f64| value(from.lerp(to, t)) > 0.5;
    let begins = is_inside(0.0);
    assert_ne!(begins, is_inside(1.0), "no surface between {from} and {to}");
    while far - near > 1e-9 {
        let middle = (near + far) / 2.0;
        (near, far) = if is_inside(middle) == begins { (middle, far) } else { (near, middle) };
    }
    from.lerp(to, near)
}

#[test]
fn the_surface_of_the_bowl_is_a_hemisphere_between_voxels_too() {
    let bowl = Bowl { radius: 0.5 };
    for dims in [bowl.about().dims, [41, 41, 25]] {
        let volume = sample_field(&bowl, dims, VoxelType::F32).unwrap();
        let sampler = Sampler::new(&volume, 0, Filter::Linear).unwrap();
        let between = |p: DVec3| sampler.value_world(p);
        let voxel = volume.grid().spacing()[0];
        let mut random = Random(2);
        for _ in 0..2000 {
            let out = random.direction();
            // At the rim it is sharp.
            let out = out.with_z(-out.z.abs());
            if bowl.radius * -out.z < 2.0 * voxel {
                continue;
            }
            let found = crossing(between, out * 0.2, out * 0.6);
            // A line across a voxel leaves a sphere by an eighth of its square over the radius, in each of two axes.
            assert_close(found.length(), bowl.radius, 0.26 * voxel * voxel / bowl.radius);
            let slope = |axis: DVec3| between(found + axis * voxel) - between(found - axis * voxel);
            let normal = DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z)).normalize();
            assert!(normal.dot(out) > 1f64.to_radians().cos(), "{normal} at {out}");
        }
    }
}

#[test]
fn the_bowl_is_open_above_and_flat_outside() {
    let bowl = Bowl::default();
    let value = |p: DVec3| bowl.value(p);
    let mut random = Random(3);
    for _ in 0..100 {
        let out = random.direction();
        let out = out.with_z(-out.z.abs());
        if out.z < -0.1 {
            assert_close(bowl.value(out * 0.6), 0.5, 1e-12);
            assert_near(bowl.gradient(out * 0.6).normalize(), out, 1e-12);
        }
        assert!(bowl.value(-out * 0.9) < 0.5, "nothing shades the hollow");
        assert!(bowl.value(out * 0.59) < 0.5);
    }
    for (from, to, expected) in [
        (DVec3::new(0.725, 0.725, 0.2), DVec3::new(0.725, 0.725, -0.3), DVec3::new(0.725, 0.725, 0.0)),
        (DVec3::new(-1.0, 0.3, -0.4), DVec3::new(-0.7, 0.3, -0.4), DVec3::new(-0.85, 0.3, -0.4)),
        (DVec3::new(0.1, 0.3, -1.0), DVec3::new(0.1, 0.3, -0.75), DVec3::new(0.1, 0.3, -0.85)),
    ] {
        assert_near(crossing(value, from, to), expected, 1e-6);
    }
}

/// The largest number of voxels on one side of the level 1/2 that hang together, by faces, and which they are.
fn largest_piece(values: &[f64], n: usize, is_inside: bool) -> (usize, Vec<bool>) {
    let belongs = |i: usize| (values[i] > 0.5) == is_inside;
    let mut seen = vec![false; values.len()];
    let mut largest = (0, vec![]);
    for start in 0..values.len() {
        if seen[start] || !belongs(start) {
            continue;
        }
        let (mut piece, mut count, mut queue) = (vec![false; values.len()], 0, VecDeque::from([start]));
        seen[start] = true;
        while let Some(i) = queue.pop_front() {
            (piece[i], count) = (true, count + 1);
            for (place, step) in [(i % n, 1), (i / n % n, n), (i / n / n, n * n)] {
                let sides = [(place > 0).then(|| i - step), (place + 1 < n).then(|| i + step)];
                for next in sides.into_iter().flatten() {
                    if !seen[next] && belongs(next) {
                        seen[next] = true;
                        queue.push_back(next);
                    }
                }
            }
        }
        if count > largest.0 {
            largest = (count, piece);
        }
    }
    largest
}

#[test]
fn the_cells_of_the_sponge_open_into_each_other_and_it_holds_together() {
    const N: usize = 80;
    let volume = sample_field(&Sponge::default(), [N; 3], VoxelType::F32).unwrap();
    let values: Vec<f64> = (0..N * N * N).map(|i| volume.value([i % N, i / N % N, i / N / N], 0)).collect();
    let depth = |i: usize| {
        let at = DVec3::new((i % N) as f64, (i / N % N) as f64, (i / N / N) as f64);
        (at * 2.0 / (N - 1) as f64 - 1.0).length()
    };
    let solid = values.iter().filter(|value| **value > 0.5).count();
    let (whole, _) = largest_piece(&values, N, true);
    assert!(whole as f64 > 0.99 * solid as f64, "{whole} of {solid} voxels hang together");
    // What is reached from outside, of all that is empty within.
    let (_, open) = largest_piece(&values, N, false);
    let empty: Vec<usize> = (0..values.len()).filter(|i| values[*i] <= 0.5 && depth(*i) < 0.8).collect();
    let reached = empty.iter().filter(|i| open[**i]).count();
    assert!(reached as f64 > 0.95 * empty.len() as f64, "{reached} of {} voxels are open", empty.len());
    assert!(empty.iter().any(|i| open[*i] && depth(*i) < 0.2), "cavities are not deep");
    let within = (0..values.len()).filter(|i| depth(*i) < 0.8).count();
    let share = empty.len() as f64 / within as f64;
    assert!((0.4..0.8).contains(&share), "{share} of it is empty");
}

#[test]
fn the_engine_has_its_parts_where_they_belong() {
    let at = |x: f64, y: f64, z: f64| Engine.value(DVec3::new(x, y, z));
    let (air, wall, sleeve) = (0.0, 0.45, 0.9);
    for (side, end) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
        assert_eq!(at(45.0 * side, 88.0 * end, -56.0), air, "bolt hole of the flange");
        assert_eq!(at(49.5 * side, 60.0 * end, -56.0), wall, "flange");
        assert_eq!(at(32.0 * side, 78.0 * end, 40.0), air, "bolt hole of the deck");
        assert_eq!(at(32.0 * side, 78.0 * end, 20.0), wall, "below the bolt hole");
        assert_eq!(at(25.0 * side, 42.0 * end, 0.0), sleeve, "sleeve");
        assert_eq!(at(29.0 * side, 42.0 * end, 0.0), wall, "around the sleeve");
        assert_eq!(at(25.0 * side, 42.0 * end, -30.0), wall, "below the sleeve");
        assert_eq!(at(15.0 * side, 42.0 * end, 60.0), air, "bore");
        assert_eq!(at(25.0 * side, 42.0 * end, 66.0), sleeve, "collar above the deck");
        assert_eq!(at(25.0 * side, 42.0 * end, 70.0), air, "above the collar");
        assert_eq!(at(20.0 * side, 70.0 * end, -50.0), air, "hollow");
    }
    // Oil along the block, across it and up.
    assert_eq!([at(-32.0, 50.0, 14.0), at(32.0, 50.0, -14.0), at(5.0, 0.0, 14.0), at(0.0, 0.0, 50.0)], [air; 4]);
    assert_eq!([at(-47.0, 0.0, 24.0), at(47.0, 0.0, 24.0)], [wall, air], "a boss on one side only");
    assert_eq!([at(-47.0, 58.0, 30.0), at(47.0, 58.0, 30.0)], [air, wall], "and a stud on the other");
    let volume = sample_field(&Engine, Engine.about().dims, Engine.about().voxel_type).unwrap();
    assert!(volume.grid().spacing().iter().all(|spacing| (spacing - 1.0).abs() < 1e-12), "a voxel is a unit");
}
