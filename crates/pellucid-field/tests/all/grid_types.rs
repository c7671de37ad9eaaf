//! The same field on every kind of grid and in every voxel type.

use glam::{DAffine3, DMat3, DVec3};
use half::f16;
use pellucid_field::{Filter, Gradient, Grid, Sampler, Volume, Voxel, Voxels, world_gradient};

use crate::gradient::gradient_of;
use crate::{FILTERS, Random, assert_close, assert_near, voxels};

/// Grids of 24 voxels per axis around the origin: plain, anisotropic, rotated, mirrored, sheared.
fn grids() -> Vec<Grid> {
    let turn = DMat3::from_axis_angle(DVec3::new(1.0, -2.0, 0.5).normalize(), 0.9);
    let stretch = DMat3::from_diagonal(DVec3::new(0.1, 0.2, 0.15));
    let mirror = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
    let shear = DMat3::from_cols(DVec3::X, DVec3::new(0.4, 1.0, 0.0), DVec3::new(0.0, -0.3, 1.0));
    let linear = [0.1 * DMat3::IDENTITY, stretch, turn * stretch, turn * mirror * stretch, turn * shear * stretch];
    linear
        .into_iter()
        .map(|matrix3| {
            let translation = DVec3::new(0.3, -0.2, 0.1) - matrix3 * DVec3::splat(11.5);
            Grid::with_affine([24; 3], DAffine3 { matrix3, translation }).unwrap()
        })
        .collect()
}

/// Central differences of a trilinear field interpolate those at the voxels (5.3-5), which are
/// exact on a quadratic: so the sampled world gradient of a quadratic is exact everywhere.
#[test]
fn every_grid_gives_the_same_world_value_and_gradient() {
    let hessian = DMat3::from_cols(DVec3::new(1.0, 0.3, -0.2), DVec3::new(0.3, -0.7, 0.5), DVec3::new(-0.2, 0.5, 0.4));
    let slope = DVec3::new(0.5, -1.0, 2.0);
    let field = |p: DVec3| 0.5 * p.dot(hessian * p) + slope.dot(p) + 1.0;
    let mut random = Random(21);
    for grid in grids() {
        let volume =
            Volume::new(grid, voxels([24; 3], |i| field(grid.world_from_index().transform_point3(i)))).unwrap();
        let linear = Sampler::new(&volume, 0, Filter::Linear).unwrap();
        let cubic = Sampler::new(&volume, 0, Filter::CATMULL_ROM).unwrap();
        for _ in 0..300 {
            let index = random.point(5.0, 18.0);
            let p = grid.world_from_index().transform_point3(index);
            assert_close(cubic.value_world(p), field(p), 5e-6);
            for kind in
                [Gradient::Central, Gradient::SobelIsotropic, Gradient::Gaussian { sigma: 1.0 }, Gradient::BSpline]
            {
                assert_near(world_gradient(&grid, gradient_of(&linear, kind, index)), hessian * p + slope, 2e-4);
            }
        }
    }
}

/// Voxels of extreme values: interpolated in full, returned exactly, and with their true slope.
fn check_extremes<T: Voxel>(low: T, high: T) {
    let values = [low, high, high, low, high, low, low, high, low, high, low, high];
    let volume = Volume::new(Grid::new([3, 2, 2]).unwrap(), values.to_vec()).unwrap();
    let (a, b) = (low.to_f64(), high.to_f64());
    for filter in FILTERS {
        let sampler = Sampler::new(&volume, 0, filter).unwrap();
        if filter.is_interpolating() {
            for i in 0..12 {
                let voxel = [i % 3, i / 3 % 2, i / 6];
                assert_eq!(sampler.value(DVec3::from_array(voxel.map(|i| i as f64))), values[i].to_f64());
            }
        }
        if filter.is_positive() {
            assert!((a..=b).contains(&sampler.value(DVec3::new(0.3, 0.4, 0.2))));
        }
    }
    let linear = Sampler::new(&volume, 0, Filter::Linear).unwrap();
    assert_close(linear.value(DVec3::new(0.25, 0.0, 0.0)), 0.75 * a + 0.25 * b, 1e-9 * (b - a));
    assert_eq!(gradient_of(&linear, Gradient::Forward, DVec3::ZERO).x, b - a);
}

#[test]
fn every_type_over_its_full_range() {
    check_extremes(u8::MIN, u8::MAX);
    check_extremes(i8::MIN, i8::MAX);
    check_extremes(u16::MIN, u16::MAX);
    check_extremes(i16::MIN, i16::MAX);
    check_extremes(u32::MIN, u32::MAX);
    check_extremes(i32::MIN, i32::MAX);
    check_extremes(f16::MIN, f16::MAX);
    check_extremes(-1e37f32, 1e37f32);
}

/// The same small numbers in every type give the same samples.
#[test]
fn every_type_gives_the_same_samples() {
    fn of<T: Voxel>(values: &[i32]) -> Voxels {
        values.iter().map(|&v| T::from_f64(f64::from(v))).collect::<Vec<T>>().into()
    }
    let mut random = Random(6);
    let values: Vec<i32> = (0..125).map(|_| (100.0 * random.next()) as i32).collect();
    let all = [of::<u8>, of::<i8>, of::<u16>, of::<i16>, of::<u32>, of::<i32>, of::<f16>, of::<f32>];
    let volumes = all.map(|make| Volume::new(Grid::new([5; 3]).unwrap(), make(&values)).unwrap());
    for filter in FILTERS {
        let p = random.point(0.0, 4.0);
        let samples = volumes.each_ref().map(|volume| Sampler::new(volume, 0, filter).unwrap().value(p));
        assert!(samples.iter().all(|&sample| sample == samples[0]), "{filter:?} {samples:?}");
    }
}

/// Single precision ends at 1e38: what light and gradients could not be computed of is refused, with what is allowed.
#[test]
fn spacings_beyond_single_precision_are_refused() {
    use pellucid_field::{FieldError, Grid};
    for spacing in [1e-45, 1e-38, 0.9e-30, 1.1e30, 1e39, 1e60] {
        for axis in 0..3 {
            let mut all = [1.0; 3];
            all[axis] = spacing;
            let error = Grid::with_spacing([4; 3], all, [0.0; 3]).unwrap_err();
            assert!(
                matches!(error, FieldError::Extent { found, .. } if (found / spacing - 1.0).abs() < 1e-9),
                "{error}"
            );
            let text = error.to_string();
            assert!(text.contains("1e-30 to 1e30") && text.contains("spacing"), "{text}");
        }
    }
    assert!(
        Grid::with_spacing([4; 3], [1e-29; 3], [0.0; 3]).is_ok()
            && Grid::with_spacing([4; 3], [1e29; 3], [0.0; 3]).is_ok()
    );
    let far = Grid::with_spacing([4; 3], [1.0; 3], [0.0, -1e36, 0.0]).unwrap_err();
    assert!(far.to_string().contains("origin"), "{far}");
}

/// Double precision has 16 digits: places of voxels and rays have to have some of them to themselves.
#[test]
fn voxels_too_small_for_where_they_are_are_refused() {
    use pellucid_field::Grid;
    for (spacing, origin) in [(1.0, 1e15), (1.0, 1e18), (1e-14, -1.0), (1e-20, -1.0)] {
        let error = Grid::with_spacing([16; 3], [spacing; 3], [origin; 3]).unwrap_err().to_string();
        assert!(error.contains("that far from the origin"), "{error}");
    }
    for (spacing, origin) in [(1.0, 1e9), (1.0, -9e11), (1e-11, -1.0), (1e-20, 0.0), (1e-20, 1e-10)] {
        assert!(Grid::with_spacing([16; 3], [spacing; 3], [origin; 3]).is_ok(), "{spacing} at {origin}");
    }
}
