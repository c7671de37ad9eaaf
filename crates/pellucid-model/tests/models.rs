//! Procedural fields against closed forms and their own gradients.

use glam::{DVec2, DVec3};
use pellucid_field::closed_form::{ScalarField, sample_field};
use pellucid_field::{Filter, Sampler, VoxelType};
use pellucid_model::{Clouds, HeightField, HeightMap, Ramp, Spectral};

/// Places all over the box of a field.
fn places(field: &dyn ScalarField, count: usize) -> impl Iterator<Item = DVec3> {
    let (low, high) = field.bounds();
    (0..count).map(move |k| {
        let share = |root: f64| (k as f64 * root.sqrt()).fract();
        low + DVec3::new(share(2.0), share(3.0), share(5.0)) * (high - low)
    })
}

#[test]
fn gradients_are_slopes() {
    let fields: [&dyn ScalarField; 2] = [&Clouds::new(3, 24), &Spectral { phases: [[0.3, 1.0, 2.0]; 5] }];
    for field in fields {
        for p in places(field, 2000) {
            const STEP: f64 = 1e-5;
            let slope = |axis: DVec3| (field.value(p + axis * STEP) - field.value(p - axis * STEP)) / (2.0 * STEP);
            let expected = DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z));
            // Where a limit or a fold lies between the taps they tell another slope.
            let (value, away) = (field.value(p), 1e-3);
            if value > away && !((1.0 - away)..1.0).contains(&value) {
                assert!((field.gradient(p) - expected).length() < 1e-4 * (1.0 + expected.length()), "{p}");
            }
        }
    }
}

/// K-25.
#[test]
fn clouds_are_seeded_bounded_and_inside_their_box() {
    for seed in 0..8 {
        let cloud = Clouds::new(seed, 32);
        assert_eq!(cloud, Clouds::new(seed, 32));
        assert_ne!(cloud, Clouds::new(seed + 1, 32));
        let (low, high) = cloud.bounds();
        let mut most = 0.0f64;
        for p in places(&cloud, 5000) {
            let value = cloud.value(p);
            assert!((0.0..=1.0).contains(&value));
            most = most.max(value);
            for axis in 0..3 {
                for side in [low[axis], high[axis]] {
                    let mut face = p;
                    face[axis] = side;
                    assert!(cloud.value(face) < 1e-12, "matter at a face");
                }
            }
        }
        assert_eq!(most, 1.0);
    }
}

/// One ellipsoid's bump by its values: 1 in the middle, 1/2 at half the radius, 0 at the radius.
#[test]
fn one_ellipsoid_is_a_bump() {
    let cloud = Clouds::new(5, 1);
    let middle = places(&cloud, 200_000).max_by(|a, b| cloud.value(*a).total_cmp(&cloud.value(*b))).unwrap();
    assert!(cloud.value(middle) > 0.95);
    let radius = |level: f64| {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..50 {
            let r = (low + high) / 2.0;
            if cloud.value(middle + DVec3::X * r) > level { low = r } else { high = r }
        }
        low
    };
    // From a middle that is known to 1/40 of the radius only.
    assert!((radius(0.5) / radius(1e-9) - 0.5).abs() < 0.05);
}

/// MOD-05: baked, errors fall with the square of the spacing.
#[test]
fn baking_converges() {
    let field = Spectral { phases: [[1.0, 2.0, 0.5]; 5] };
    let error = |n: usize| {
        let volume = sample_field(&field, [n; 3], VoxelType::F32).unwrap();
        let sampler = Sampler::new(&volume, 0, Filter::Linear).unwrap();
        let index = volume.grid().index_from_world();
        // Away from the folds of the magnitude, which have a kink.
        let smooth = places(&field, 4000).filter(|p| field.value(*p) > 0.1);
        smooth.map(|p| (sampler.value(index.transform_point3(p)) - field.value(p)).powi(2)).sum::<f64>().sqrt()
    };
    let ratio = error(65) / error(129);
    assert!((ratio - 4.0).abs() < 0.4, "{ratio}");
}

/// MOD-06's oracles.
#[test]
fn spectral_values_are_those_of_the_listing() {
    let field = Spectral::default();
    let smoothstep = |value: f64| {
        let t = ((value - 0.1) / 0.4).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    };
    for (p, value, alpha) in [([0.25, 0.5, 0.75], 0.205_989, 0.030_076), ([0.5, 0.5, 0.5], 0.461_365, 0.948_315)] {
        let found = field.value(DVec3::from_array(p));
        assert!((found - value).abs() < 1e-6, "{found}");
        assert!((smoothstep(found).powi(2) - alpha).abs() < 1e-5);
    }
    for p in places(&field, 1000) {
        assert!(field.value(p) <= 0.968_75);
        assert_eq!(field.value(DVec3::new(0.0, p.y, p.z)), 0.0);
    }
}

/// K-28: the optical depth through a slab is its thickness less a ramp, or and a ramp; over any heights.
#[test]
fn slabs_have_their_optical_depth() {
    let heights = (0..64).map(|i| (i as f32 * 0.7).sin() * 0.2).collect();
    let maps = [HeightMap::new([1, 1], vec![0.25]).unwrap(), HeightMap::new([8, 8], heights).unwrap()];
    for map in maps {
        for (side, expected) in [(Ramp::Inside, 0.3 - 0.05), (Ramp::Outside, 0.3 + 0.05)] {
            let slab = HeightField::new(map.clone(), [-0.2, 0.1], 0.05, side).unwrap();
            let (low, high) = slab.bounds();
            for (x, y) in [(0.1, 0.9), (0.5, 0.5), (0.77, 0.31)] {
                const STEPS: usize = 20_000;
                let step = (high.z - low.z) / STEPS as f64;
                let at = |k: usize| slab.value(DVec3::new(x, y, low.z + (k as f64 + 0.5) * step));
                let depth = (0..STEPS).map(at).sum::<f64>() * step;
                assert!((depth - expected).abs() < 1e-6, "{depth}");
            }
        }
    }
}

/// K-29: levels keep the mean and lose what is finer than their texels.
#[test]
fn levels_of_a_map_are_means() {
    let heights = (0..256).map(|i| if (i % 16 + i / 16) % 2 == 0 { 1.0 } else { 0.0 }).collect();
    let map = HeightMap::new([16, 16], heights).unwrap();
    for (footprint, side) in [(0.5, 16), (1.0, 16), (2.0, 8), (4.0, 4), (1e9, 1)] {
        let level = map.for_footprint(footprint);
        assert_eq!(level.dims(), [side; 2]);
        let height = level.at(DVec2::new(0.4, 0.7));
        assert!(if side < 16 { height == 0.5 } else { height != 0.5 }, "{height}");
    }
    // A ramp is the same ramp on every level, but for half a texel at its ends.
    let ramp = HeightMap::new([16, 1], (0..16).map(|i| i as f32 + 0.5).collect()).unwrap();
    for footprint in [1.0, 2.0, 4.0] {
        let height = ramp.for_footprint(footprint).at(DVec2::new(0.4, 0.5));
        assert!((height - 6.4).abs() < 1e-5, "{height}");
    }
}

#[test]
fn what_is_no_slab_is_refused() {
    let map = || HeightMap::new([1, 1], vec![0.0]).unwrap();
    assert!(HeightMap::new([2, 2], vec![0.0; 3]).is_err());
    assert!(HeightMap::new([0, 2], vec![]).is_err());
    assert!(HeightMap::new([1, 1], vec![f32::NAN]).is_err());
    assert!(HeightField::new(map(), [1.0, 1.0], 0.1, Ramp::Inside).is_err());
    assert!(HeightField::new(map(), [0.0, 1.0], 0.6, Ramp::Inside).is_err());
    assert!(HeightField::new(map(), [0.0, 1.0], 0.6, Ramp::Outside).is_ok());
    assert!(HeightField::new(map(), [0.0, 1.0], 0.0, Ramp::Outside).is_err());
}

#[test]
fn land_is_that_of_its_seed_and_lies_from_low_to_high() {
    let (one, again, other) = (HeightMap::terrain(3, 64), HeightMap::terrain(3, 64), HeightMap::terrain(4, 64));
    assert_eq!(one, again);
    assert_ne!(one, other);
    let heights: Vec<f64> = (0..400).map(|k| one.at(DVec2::new(f64::from(k % 20), f64::from(k / 20)) / 20.0)).collect();
    let (low, high) = heights.iter().fold((1.0f64, 0.0f64), |(low, high), h| (low.min(*h), high.max(*h)));
    assert!((0.0..0.2).contains(&low) && (0.5..=1.0).contains(&high), "{low} to {high}");
    // Finer points are the same land.
    let fine = HeightMap::terrain(3, 512).for_footprint(8.0);
    assert_eq!(fine.dims(), [64, 64]);
    let apart = heights
        .iter()
        .enumerate()
        .map(|(k, height)| (fine.at(DVec2::new((k % 20) as f64, (k / 20) as f64) / 20.0) - height).abs());
    assert!(apart.sum::<f64>() / 400.0 < 0.05);
    assert!((one.clone().scaled(0.5).at(DVec2::splat(0.3)) - one.at(DVec2::splat(0.3)) / 2.0).abs() < 1e-6);
}
