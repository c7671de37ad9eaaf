//! Other grids.

use std::f64::consts::PI;

use glam::{DAffine3, DMat3, DVec3};
use half::f16;
use pellucid_field::{FieldError, Filter, Grid, Sampler, SincWindow, ValueMap, Volume, Voxel, resample, resample_dims};

use crate::{FILTERS, Random, assert_close, volume};

const SHARP: Filter = Filter::Sinc { window: SincWindow::Kaiser, half_width: 8 };

fn index_of(dims: [usize; 3], i: usize) -> [usize; 3] {
    [i % dims[0], i / dims[0] % dims[1], i / (dims[0] * dims[1])]
}

fn position(voxel: [usize; 3]) -> DVec3 {
    DVec3::from_array(voxel.map(|i| i as f64))
}

/// Waves along each axis, shrunk by 4 (1.5-5): kept below the new Nyquist frequency, gone above.
#[test]
fn shrinking_keeps_what_fits_and_removes_what_would_alias() {
    let (n, small) = (241, 61);
    for axis in 0..3 {
        for (part_of_nyquist, gain) in
            [(0.2, 1.0), (0.5, 1.0), (0.8, 1.0), (1.2, 0.0), (1.5, 0.0), (2.0, 0.0), (3.1, 0.0)]
        {
            let frequency = part_of_nyquist * PI / 4.0;
            let mut dims = [3, 3, 3];
            dims[axis] = n;
            let wave = volume(dims, |p| (frequency * p[axis]).sin());
            dims[axis] = small;
            let found = resample_dims(&wave, dims, SHARP).unwrap();
            for i in 10..51 {
                let mut voxel = [1, 1, 1];
                voxel[axis] = i;
                let expected = gain * (frequency * 4.0 * i as f64).sin();
                assert_close(found.value(voxel, 0), expected, if gain == 1.0 { 0.05 } else { 0.1 });
            }
        }
    }
}

/// Without widening, the same waves come out as others.
#[test]
fn nearest_aliases() {
    let wave = volume([241, 1, 1], |p| (1.5 * PI / 4.0 * p.x).sin());
    let found = resample_dims(&wave, [61, 1, 1], Filter::Nearest).unwrap();
    assert!(found.statistics().max > 0.7);
}

/// The same on a turned grid, where the low-pass runs on the old grid first.
#[test]
fn shrinking_onto_a_turned_grid() {
    for (frequency, gain) in [(0.6 * PI / 2.0, 1.0), (1.35 * PI / 2.0, 0.0)] {
        let wave = volume([80, 80, 1], |p| (frequency * p.x).sin());
        let matrix3 = DMat3::from_rotation_z(0.5) * DMat3::from_diagonal(DVec3::new(2.0, 2.0, 1.0));
        let translation = DVec3::new(40.0, 40.0, 0.0) - matrix3 * DVec3::new(8.0, 8.0, 0.0);
        let grid = Grid::with_affine([16, 16, 1], DAffine3 { matrix3, translation }).unwrap();
        let found = resample(&wave, grid, SHARP, f64::NAN).unwrap();
        for i in 0..256 {
            let p = grid.world_from_index().transform_point3(position(index_of([16, 16, 1], i)));
            assert_close(found.voxels().get(i), gain * (frequency * p.x).sin(), if gain == 1.0 { 0.05 } else { 0.1 });
        }
    }
}

fn check_identity<T: Voxel>(low: T, high: T) {
    let values = [low, high, high, low, high, low, low, high, low, high, low, high];
    let map = ValueMap { scale: 0.1, offset: -3.0 };
    let grid = Grid::with_spacing([3, 2, 2], [0.3, 0.7, 1.1], [5.0, -2.0, 0.1]).unwrap();
    let volume = Volume::new(grid, values.to_vec()).unwrap().with_value_map(map).unwrap();
    let same = [resample_dims(&volume, [3, 2, 2], Filter::Linear), resample(&volume, grid, SHARP, f64::NAN)];
    for found in same.map(Result::unwrap) {
        assert_eq!(found.voxels().voxel_type(), T::TYPE);
        assert_eq!(found.voxels().as_bytes(), volume.voxels().as_bytes());
        assert_eq!(found.value_map(), map);
    }
    // Ringing is saturated, not wrapped.
    let finer = resample_dims(&volume, [9, 7, 5], SHARP).unwrap();
    let statistics = finer.statistics();
    assert!(
        !T::TYPE.is_integer()
            || statistics.min >= map.value(low.to_f64()) && statistics.max <= map.value(high.to_f64())
    );
}

#[test]
fn a_grid_onto_itself_is_the_identity_in_every_type() {
    check_identity(u8::MIN, u8::MAX);
    check_identity(i8::MIN, i8::MAX);
    check_identity(u16::MIN, u16::MAX);
    check_identity(i16::MIN, i16::MAX);
    check_identity(u32::MIN, u32::MAX);
    check_identity(i32::MIN, i32::MAX);
    check_identity(f16::MIN, f16::MAX);
    check_identity(-1e37f32, 1e37f32);
}

/// A tiny fraction of a huge neighbour would show: coinciding voxels are taken as they are.
#[test]
fn rounding_of_affines_does_not_mix_neighbours() {
    let values: Vec<f32> = (0..1000).map(|i| if i % 2 == 0 { 1e30 } else { 1e-20 * i as f32 }).collect();
    let grid = Grid::with_spacing([10; 3], [0.3, 0.7, 1.1], [0.1, -0.7, 13.3]).unwrap();
    let volume = Volume::new(grid, values).unwrap();
    let turn = DAffine3 { matrix3: DMat3::from_rotation_z(-PI / 2.0), translation: 9.0 * DVec3::Y };
    let turned = Grid::with_affine([10; 3], grid.world_from_index() * turn).unwrap();
    for filter in FILTERS.into_iter().filter(|filter| filter.is_interpolating()) {
        let same = resample(&volume, grid, filter, f64::NAN).unwrap();
        assert_eq!(same.voxels().as_bytes(), volume.voxels().as_bytes());
        let turned = resample(&volume, turned, filter, f64::NAN).unwrap();
        assert!((0..1000).all(|i| {
            let [x, y, z] = index_of([10; 3], i);
            turned.value([x, y, z], 0) == volume.value([y, 9 - x, z], 0)
        }));
    }
}

/// Shrunk onto a grid with its axes exchanged, a volume has the same values: both ways of
/// resampling agree where the samples coincide with old voxels.
#[test]
fn parallel_and_turned_grids_agree() {
    let mut random = Random(18);
    let values: Vec<f32> = (0..17 * 17 * 5).map(|_| random.next() as f32).collect();
    let volume = Volume::new(Grid::new([17, 17, 5]).unwrap(), values).unwrap();
    for filter in FILTERS.into_iter().chain([Filter::BSpline { prefilter: true }]) {
        let parallel = resample_dims(&volume, [9, 9, 5], filter).unwrap();
        let swap = DMat3::from_cols(2.0 * DVec3::Y, 2.0 * DVec3::X, DVec3::Z);
        let grid = Grid::with_affine([9, 9, 5], DAffine3 { matrix3: swap, translation: DVec3::ZERO }).unwrap();
        let turned = resample(&volume, grid, filter, f64::NAN).unwrap();
        for i in 0..9 * 9 * 5 {
            let [x, y, z] = index_of([9, 9, 5], i);
            assert_close(turned.value([x, y, z], 0), parallel.value([y, x, z], 0), 3e-6);
        }
    }
}

#[test]
fn enlarging_samples_the_field() {
    let mut random = Random(14);
    let values: Vec<f32> = (0..6 * 5 * 4).map(|_| random.next() as f32).collect();
    let volume = Volume::new(Grid::new([6, 5, 4]).unwrap(), values).unwrap();
    for filter in FILTERS.into_iter().chain([Filter::BSpline { prefilter: true }]) {
        let sampler = Sampler::new(&volume, 0, filter).unwrap();
        let dims = [13, 5, 10];
        let finer = resample_dims(&volume, dims, filter).unwrap();
        let (low, high) = finer.grid().world_bounds();
        assert!(low.distance(DVec3::ZERO) < 1e-12 && high.distance(DVec3::new(5.0, 4.0, 3.0)) < 1e-12);
        for i in 0..dims.iter().product() {
            let voxel = index_of(dims, i);
            // The nearest voxel of a point halfway is a matter of rounding.
            let p = position(voxel) * DVec3::new(5.0 / 12.0, 1.0, 1.0 / 3.0);
            if filter != Filter::Nearest || (p - p.floor() - 0.5).abs().min_element() > 1e-9 {
                assert_close(finer.value(voxel, 0), sampler.value(p), 2e-7);
            }
        }
    }
}

#[test]
fn affine_fields_are_kept_on_any_grid() {
    let slope = DVec3::new(0.3, -0.2, 0.7);
    let field = volume([30; 3], |p| slope.dot(p));
    for (turn, step) in [(0.0, 0.4), (0.0, 2.5), (0.7, 0.4), (0.7, 2.0), (PI, 1.7), (PI / 2.0, 1.0)] {
        let matrix3 = DMat3::from_axis_angle(DVec3::Z, turn) * step;
        let n = (10.0 / step) as usize;
        let translation = DVec3::splat(15.0) - matrix3 * DVec3::splat((n - 1) as f64 / 2.0);
        let grid = Grid::with_affine([n; 3], DAffine3 { matrix3, translation }).unwrap();
        for filter in [Filter::Linear, Filter::BSpline { prefilter: true }, Filter::CATMULL_ROM, SHARP] {
            let found = resample(&field, grid, filter, f64::NAN).unwrap();
            // A kernel widened by a fraction finds the slope only nearly.
            let fractional = step > 1.0 && step != 2.0;
            let tolerance = match filter {
                Filter::Linear if fractional => 0.12,
                Filter::Sinc { .. } => 0.03,
                _ if fractional => 0.03,
                _ => 1e-5,
            };
            for i in 0..n * n * n {
                let p = grid.world_from_index().transform_point3(position(index_of([n; 3], i)));
                assert_close(found.voxels().get(i), slope.dot(p), tolerance);
            }
        }
    }
}

#[test]
fn a_mirrored_grid_reverses_the_voxels() {
    let values: Vec<i32> = (0..24).map(|i| i32::MAX - i * i).collect();
    let volume = Volume::new(Grid::new([24, 1, 1]).unwrap(), values.clone()).unwrap();
    let affine = DAffine3 { matrix3: DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)), translation: 23.0 * DVec3::X };
    let found = resample(&volume, Grid::with_affine([24, 1, 1], affine).unwrap(), Filter::Linear, f64::NAN).unwrap();
    let reversed: Vec<f64> = values.iter().rev().map(|&v| f64::from(v)).collect();
    assert_eq!((0..24).map(|i| found.voxels().get(i)).collect::<Vec<_>>(), reversed);
    // Integers that f32 cannot hold survive a turn as well.
    let turn = DAffine3 { matrix3: DMat3::from_rotation_z(-PI / 2.0), translation: DVec3::ZERO };
    let found = resample(&volume, Grid::with_affine([1, 24, 1], turn).unwrap(), Filter::Linear, 0.0).unwrap();
    assert_eq!((0..24).map(|i| found.voxels().get(i) as i32).collect::<Vec<_>>(), values);
}

/// An axis of one voxel is as thick as that voxel, whichever way the number changes.
#[test]
fn to_and_from_a_single_voxel() {
    let line = volume([5, 1, 1], |p| p.x);
    let one = resample_dims(&line, [1, 1, 1], Filter::Linear).unwrap();
    assert_eq!((one.value([0; 3], 0), one.grid().spacing()), (2.0, [4.0, 1.0, 1.0]));
    let many = resample_dims(&one, [3, 1, 4], Filter::Linear).unwrap();
    assert_eq!((many.statistics().min, many.statistics().max), (2.0, 2.0));
    for (a, b) in many.grid().world_corners().iter().zip(Grid::new([5, 1, 1]).unwrap().world_corners()) {
        // One voxel thick along y, and along z now spanned by the four samples.
        assert!(a.distance(b) < 1e-12);
    }
    assert!(matches!(resample_dims(&line, [0, 1, 1], Filter::Linear), Err(FieldError::Dims { .. })));
}

#[test]
fn absence_follows_the_nearest_voxel() {
    let hole = DVec3::new(12.0, 9.0, 7.0);
    let absent = |p: DVec3| p.distance(hole) < 3.3;
    let holed = volume([24, 20, 16], |p| {
        if !absent(p) {
            1.0 + p.x
        } else if p.x > 12.0 {
            f64::INFINITY
        } else {
            f64::NAN
        }
    });
    for filter in FILTERS {
        for dims in [[11, 9, 9], [30, 41, 16], [9, 40, 5]] {
            let found = resample_dims(&holed, dims, filter).unwrap();
            let scale = holed.grid().index_bounds().1 / found.grid().index_bounds().1;
            for i in 0..found.grid().len() {
                let p = scale * position(index_of(dims, i));
                if (p - p.floor() - 0.5).abs().min_element() > 1e-9 {
                    let value = found.value(index_of(dims, i), 0);
                    assert_eq!(value.is_nan(), absent((p + 0.5).floor()), "{filter:?} {p}");
                    assert!(!filter.is_positive() || value.is_nan() || (1.0..=24.0).contains(&value));
                }
            }
        }
    }
}

#[test]
fn outside_is_what_was_asked_for() {
    let grid = Grid::with_spacing([4, 4, 4], [1.0; 3], [-2.0, 0.0, 0.0]).unwrap();
    let inside = |i: usize| i % 4 >= 2;
    let floats = resample(&volume([8; 3], |_| 3.0), grid, Filter::Linear, f64::NAN).unwrap();
    assert!((0..64).all(|i| floats.voxels().get(i).is_nan() != inside(i)));
    let map = ValueMap { scale: 2.0, offset: -10.0 };
    let ints = Volume::new(Grid::new([8; 3]).unwrap(), vec![9u8; 512]).unwrap().with_value_map(map).unwrap();
    let filled = resample(&ints, grid, Filter::Linear, -4.0).unwrap();
    assert!((0..64).all(|i| filled.voxels().get(i) == if inside(i) { 9.0 } else { 3.0 }));
    let error = resample(&ints, grid, Filter::Linear, f64::NAN).unwrap_err();
    assert!(error.to_string().contains("integer voxels cannot be absent"), "{error}");
    let turned = DAffine3 { matrix3: DMat3::from_rotation_z(0.4), translation: DVec3::new(-1.0, 0.0, 0.0) };
    let turned = resample(&ints, Grid::with_affine([4; 3], turned).unwrap(), Filter::Linear, -4.0).unwrap();
    assert_eq!((turned.voxels().get(0), turned.voxels().get(3)), (3.0, 9.0));
}

#[test]
fn components_names_and_labels_are_kept() {
    let mut random = Random(15);
    let values: Vec<u16> = (0..10 * 10 * 10).flat_map(|_| [7 * (random.next() * 5.0) as u16, 40_000]).collect();
    let mut volume = Volume::with_components(Grid::new([10; 3]).unwrap(), values, 2).unwrap().with_name("labels");
    (volume.value_unit, volume.length_unit) = (Some("label".into()), Some("mm".into()));
    let found = resample_dims(&volume, [4, 17, 10], Filter::Nearest).unwrap();
    assert_eq!((found.components(), found.name.as_str()), (2, "labels"));
    assert_eq!((found.value_unit.as_deref(), found.length_unit.as_deref()), (Some("label"), Some("mm")));
    for i in 0..found.grid().len() {
        let label = found.voxels().get(2 * i) as u16;
        assert!(label.is_multiple_of(7) && label <= 28 && found.voxels().get(2 * i + 1) == 40_000.0);
    }
    let bad = Filter::Bc { b: f64::NAN, c: 0.0 };
    assert!(resample_dims(&volume, [4; 3], bad).is_err());
}
