//! Values between voxels.

use glam::DVec3;
use pellucid_field::{FieldError, Filter, Grid, Reconstruct, Sampler, ValueMap, Volume, with_reconstruction};
use proptest::prelude::*;

use crate::{FILTERS, Random, assert_close, volume};

const DIMS: [usize; 3] = [7, 6, 5];

fn random_volume(seed: u64) -> Volume {
    let mut random = Random(seed);
    let values: Vec<f32> = (0..DIMS.iter().product()).map(|_| random.within(-3.0, 5.0) as f32).collect();
    Volume::new(Grid::new(DIMS).unwrap(), values).unwrap()
}

fn point() -> impl Strategy<Value = DVec3> {
    (0.0..6.0, 0.0..5.0, 0.0..4.0).prop_map(|(x, y, z)| DVec3::new(x, y, z))
}

/// All voxels of the support, each with the product of its kernel values, clamped to the border.
fn direct_sum(volume: &Volume, filter: Filter, p: DVec3, voxel: impl Fn([usize; 3]) -> f64) -> f64 {
    let m = filter.half_width() as i64;
    let (mut sum, mut weights) = (0.0, 0.0);
    for k in 1 - m..=m {
        for j in 1 - m..=m {
            for i in 1 - m..=m {
                let at = p.floor() + DVec3::new(i as f64, j as f64, k as f64);
                let t = p - at;
                let weight = filter.kernel(t.x) * filter.kernel(t.y) * filter.kernel(t.z);
                let last = |axis: usize| (volume.grid().dims()[axis] - 1) as f64;
                sum += weight * voxel(std::array::from_fn(|axis| at[axis].clamp(0.0, last(axis)) as usize));
                weights += weight;
            }
        }
    }
    sum / weights
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn separable_evaluation_equals_the_direct_sum(seed: u64, p in point()) {
        let volume = random_volume(seed);
        for filter in FILTERS {
            let found = Sampler::new(&volume, 0, filter).unwrap().value(p);
            assert_close(found, direct_sum(&volume, filter, p, |voxel| volume.value(voxel, 0)), 1e-12);
        }
    }

    #[test]
    fn trilinear_is_exact_on_multilinear_fields(c in prop::array::uniform8(-2.0..2.0), p in point()) {
        let field = |p: DVec3| {
            let [x, y, z] = p.to_array();
            c[0] + c[1] * x + c[2] * y + c[3] * z + c[4] * x * y + c[5] * y * z + c[6] * z * x + c[7] * x * y * z
        };
        assert_close(Sampler::new(&volume(DIMS, field), 0, Filter::Linear).unwrap().value(p), field(p), 5e-5);
    }

    #[test]
    fn positive_filters_stay_within_their_support(seed: u64, p in point()) {
        let volume = random_volume(seed);
        for filter in FILTERS.into_iter().filter(|filter| filter.is_positive()) {
            let value = Sampler::new(&volume, 0, filter).unwrap().value(p);
            let range = support(&volume, filter, p).map(|voxel| volume.value(voxel, 0));
            let (low, high) = range.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
            prop_assert!(value >= low - 1e-12 && value <= high + 1e-12, "{filter:?}");
        }
    }

    /// The rule for holes, spelt out: a sample is absent if its nearest voxel is; if not, absent
    /// taps have the value of the nearest voxel.
    #[test]
    fn holes_neither_grow_nor_leak(seed: u64, p in point(), share in 0.0..0.9) {
        let mut random = Random(seed);
        let holes: Vec<f32> = (0..DIMS.iter().product()).map(|i| match random.next() {
            r if r < share => [f32::NAN, f32::INFINITY, f32::NEG_INFINITY][i % 3],
            r => r as f32 * 4.0 - 2.0,
        }).collect();
        let volume = Volume::new(Grid::new(DIMS).unwrap(), holes).unwrap();
        let nearest = volume.value((p + 0.5).floor().to_array().map(|i| i as usize), 0);
        for filter in FILTERS {
            let found = Sampler::new(&volume, 0, filter).unwrap().value(p);
            let present = |voxel| Some(volume.value(voxel, 0)).filter(|v| v.is_finite()).unwrap_or(nearest);
            if nearest.is_finite() {
                assert_close(found, direct_sum(&volume, filter, p, present), 1e-12);
            } else {
                prop_assert!(found.is_nan(), "{filter:?}");
            }
        }
    }
}

fn support(volume: &Volume, filter: Filter, p: DVec3) -> impl Iterator<Item = [usize; 3]> {
    let m = filter.half_width() as i64;
    let dims = volume.grid().dims();
    let taps = move |axis: usize| {
        (1 - m..=m).map(move |i| (p[axis].floor() as i64 + i).clamp(0, dims[axis] as i64 - 1) as usize)
    };
    taps(0).flat_map(move |x| taps(1).flat_map(move |y| taps(2).map(move |z| [x, y, z])))
}

#[test]
fn interpolating_filters_return_voxels_bit_for_bit() {
    let mut random = Random(5);
    let values = (0..DIMS.iter().product()).map(|_| match random.next() {
        r if r < 0.3 => f32::NAN,
        r => (r as f32 - 0.6) * 10f32.powf(random.within(-30.0, 30.0) as f32),
    });
    let volume = Volume::new(Grid::new(DIMS).unwrap(), values.collect::<Vec<f32>>()).unwrap();
    for filter in FILTERS.into_iter().filter(|filter| filter.is_interpolating()) {
        let sampler = Sampler::new(&volume, 0, filter).unwrap();
        for i in 0..volume.grid().len() {
            let voxel = [i % 7, i / 7 % 6, i / 42];
            let (found, stored) = (sampler.value(DVec3::from_array(voxel.map(|i| i as f64))), volume.value(voxel, 0));
            assert!(found == stored || found.is_nan() && stored.is_nan(), "{filter:?} {voxel:?}: {found} {stored}");
        }
    }
}

#[test]
fn bspline_at_voxels_smooths() {
    let line = [4.0f32, -1.0, 7.0, 2.5, 0.0];
    let volume = Volume::new(Grid::new([5, 1, 1]).unwrap(), line.to_vec()).unwrap();
    let sampler = Sampler::new(&volume, 0, Filter::BSpline { prefilter: false }).unwrap();
    for i in 1..4 {
        let expected = f64::from(line[i - 1] + 4.0 * line[i] + line[i + 1]) / 6.0;
        assert_close(sampler.value(DVec3::new(i as f64, 0.0, 0.0)), expected, 1e-12);
    }
    assert_close(sampler.value(DVec3::ZERO), (5.0 * 4.0 - 1.0) / 6.0, 1e-12);
}

#[test]
fn the_field_ends_at_the_box() {
    let volume = volume(DIMS, |p| p.x + 10.0 * p.y + 100.0 * p.z);
    for filter in FILTERS {
        let sampler = Sampler::new(&volume, 0, filter).unwrap();
        for axis in 0..3 {
            let last = (DIMS[axis] - 1) as f64;
            let at = |x: f64| DVec3::from_array(std::array::from_fn(|a| if a == axis { x } else { 2.0 }));
            for (inside, border) in [(-5e-7, 0.0), (last + 5e-7, last)] {
                assert_eq!(sampler.value(at(inside)), sampler.value(at(border)));
                assert!(sampler.value(at(border)).is_finite());
            }
            for outside in [-2e-6, last + 2e-6, -1e300, f64::INFINITY, f64::NAN] {
                assert!(sampler.value(at(outside)).is_nan(), "{filter:?} {outside}");
            }
        }
    }
}

#[test]
fn an_axis_of_one_voxel_has_its_thickness() {
    let volume = volume([1, 1, 9], |p| p.z * p.z);
    for filter in FILTERS {
        let sampler = Sampler::new(&volume, 0, filter).unwrap();
        let middle = sampler.value(DVec3::new(0.0, 0.0, 3.25));
        assert!(middle.is_finite());
        assert_eq!(sampler.value(DVec3::new(-0.5, 0.5, 3.25)), middle);
        assert!(sampler.value(DVec3::new(-0.6, 0.0, 3.25)).is_nan());
        assert!(sampler.value(DVec3::new(0.0, 0.0, 8.1)).is_nan());
    }
    let voxel = crate::volume([1, 1, 1], |_| 3.0);
    assert!(FILTERS.iter().all(|&f| Sampler::new(&voxel, 0, f).unwrap().value(DVec3::splat(0.4)) == 3.0));
}

#[test]
fn halfway_the_nearest_voxel_is_the_next() {
    let sampler = volume([3, 1, 1], |p| p.x);
    let sampler = Sampler::new(&sampler, 0, Filter::Nearest).unwrap();
    for (x, expected) in [(0.49, 0.0), (0.5, 1.0), (1.49, 1.0), (1.5, 2.0), (2.0, 2.0)] {
        assert_eq!(sampler.value(DVec3::new(x, 0.0, 0.0)), expected);
    }
}

#[test]
fn components_and_value_map() {
    let grid = Grid::new([4, 3, 2]).unwrap();
    let interleaved: Vec<u16> = (0..24u16).flat_map(|i| [i, 1000 + 2 * i, 60000 - 3 * i]).collect();
    let map = ValueMap { scale: -0.5, offset: 7.0 };
    let volume = Volume::with_components(grid, interleaved, 3).unwrap().with_value_map(map).unwrap();
    let p = DVec3::new(1.25, 0.5, 0.75);
    let i = p.x + 4.0 * (p.y + 3.0 * p.z);
    for (component, stored) in [i, 1000.0 + 2.0 * i, 60000.0 - 3.0 * i].into_iter().enumerate() {
        let found = Sampler::new(&volume, component, Filter::Linear).unwrap().value(p);
        assert_close(found, 7.0 - 0.5 * stored, 1e-9);
    }
    let error = Sampler::new(&volume, 3, Filter::Linear).unwrap_err();
    assert!(matches!(error, FieldError::Parameter { name: "component", found: 3.0, .. }));
}

/// A tensor product does not care for the order of the axes (9.2-5).
#[test]
fn turning_the_axes_turns_the_field() {
    let volume = random_volume(9);
    let turned = crate::volume([5, 7, 6], |p| volume.value([p.y as usize, p.z as usize, p.x as usize], 0));
    let mut random = Random(1);
    for filter in FILTERS {
        let (a, b) = (Sampler::new(&volume, 0, filter).unwrap(), Sampler::new(&turned, 0, filter).unwrap());
        let p = random.point(0.0, 4.0);
        assert_close(a.value(p), b.value(DVec3::new(p.z, p.x, p.y)), 1e-12);
    }
}

/// 16-bit values a step of 8-bit data apart give many levels between them (9.2-2).
#[test]
fn levels_between_voxels_are_not_quantised() {
    let volume = Volume::new(Grid::new([2, 1, 1]).unwrap(), vec![0u16, 257]).unwrap();
    let sampler = Sampler::new(&volume, 0, Filter::Linear).unwrap();
    let mut levels: Vec<f64> = (0..1000).map(|i| sampler.value(DVec3::new(f64::from(i) / 1000.0, 0.0, 0.0))).collect();
    levels.dedup();
    assert_eq!(levels.len(), 1000);
}

#[test]
fn generic_code_gets_the_concrete_field() {
    fn twice(field: &impl Reconstruct, p: DVec3) -> f64 {
        2.0 * field.value(p)
    }
    let volume = random_volume(3);
    let p = DVec3::new(2.3, 1.1, 3.7);
    for filter in FILTERS {
        let sampler = Sampler::new(&volume, 0, filter).unwrap();
        assert_eq!(with_reconstruction!(&sampler, field => twice(&field, p)), 2.0 * sampler.value(p));
    }
}
