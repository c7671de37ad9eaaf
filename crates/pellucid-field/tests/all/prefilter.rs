//! Interpolation with B-splines.

use glam::DVec3;
use pellucid_field::{Filter, Grid, Sampler, ValueMap, Volume, spline_coefficients};

use crate::{Random, assert_close, volume};

const INTERPOLATING: Filter = Filter::BSpline { prefilter: true };

fn noise(dims: [usize; 3], seed: u64) -> Volume {
    let mut random = Random(seed);
    let values: Vec<f32> = (0..dims.iter().product()).map(|_| random.within(-1.0, 1.0) as f32).collect();
    Volume::new(Grid::new(dims).unwrap(), values).unwrap()
}

#[test]
fn the_spline_passes_through_the_voxels() {
    for dims in [[9, 8, 7], [2, 3, 4], [1, 1, 12], [1, 5, 2], [1, 1, 1], [40, 1, 1]] {
        let volume = noise(dims, 11);
        let sampler = Sampler::new(&volume, 0, INTERPOLATING).unwrap();
        for i in 0..volume.grid().len() {
            let voxel = [i % dims[0], i / dims[0] % dims[1], i / (dims[0] * dims[1])];
            assert_close(sampler.value(DVec3::from_array(voxel.map(|i| i as f64))), volume.value(voxel, 0), 2e-6);
        }
    }
}

/// (c[i-1] + 4 c[i] + c[i+1]) / 6 = f[i] with c[-1] = c[0] and c[n] = c[n-1], by elimination.
#[test]
fn the_recursion_solves_the_tridiagonal_system() {
    for n in [2, 3, 5, 33] {
        let volume = noise([n, 1, 1], 3);
        let diagonal = |i: usize| if i == 0 || i == n - 1 { 5.0 } else { 4.0 };
        let (mut pivot, mut right) = (vec![diagonal(0)], vec![6.0 * volume.value([0, 0, 0], 0)]);
        for i in 1..n {
            pivot.push(diagonal(i) - 1.0 / pivot[i - 1]);
            right.push(6.0 * volume.value([i, 0, 0], 0) - right[i - 1] / pivot[i - 1]);
        }
        let mut c = right[n - 1] / pivot[n - 1];
        let coefficients = spline_coefficients(&volume, 0).unwrap();
        for i in (0..n).rev() {
            if i < n - 1 {
                c = (right[i] - c) / pivot[i];
            }
            assert_close(coefficients.value([i, 0, 0], 0), c, 1e-6);
        }
    }
}

/// An interpolating cubic spline is of fourth order, the smoothing one of second (9.2-6).
#[test]
fn order_of_convergence() {
    let error = |n: usize, filter: Filter| {
        // A cosine that satisfies the mirrored border.
        let wave = |x: f64| (std::f64::consts::PI * (x + 0.5) / n as f64).cos();
        let volume = volume([n, 1, 1], |p| wave(p.x));
        let sampler = Sampler::new(&volume, 0, filter).unwrap();
        let points = (0..10 * (n - 1)).map(|i| 0.1 * i as f64);
        points.fold(0.0f64, |worst, x| worst.max((sampler.value(DVec3::new(x, 0.0, 0.0)) - wave(x)).abs()))
    };
    let slope = |filter| (error(4, filter) / error(8, filter)).log2();
    assert_close(slope(INTERPOLATING), 4.0, 0.3);
    assert_close(slope(Filter::BSpline { prefilter: false }), 2.0, 0.2);
}

#[test]
fn absent_voxels_stay_absent_and_disturb_only_their_neighbours() {
    let dims = [12, 11, 10];
    let whole = noise(dims, 8);
    // A hole, a plane cut off and a line that is absent from end to end.
    let absent = |p: DVec3| p.distance(DVec3::new(6.0, 5.0, 4.0)) < 1.6 || p.z == 9.0 || p.y == 0.0 && p.z == 0.0;
    let value = |p: DVec3| whole.value(p.to_array().map(|i| i as usize), 0);
    let holed = volume(dims, |p| if absent(p) { f64::NAN } else { value(p) });
    let sampler = Sampler::new(&holed, 0, INTERPOLATING).unwrap();
    let mut untouched = 0;
    for i in 0..holed.grid().len() {
        let p = DVec3::new((i % 12) as f64, (i / 12 % 11) as f64, (i / 132) as f64);
        let neighbours = (0..27).map(|n| p + DVec3::new((n % 3) as f64, (n / 3 % 3) as f64, (n / 9) as f64) - 1.0);
        let found = sampler.value(p);
        assert_eq!(found.is_nan(), absent(p));
        if !absent(p) && !neighbours.into_iter().any(absent) {
            assert_close(found, value(p), 2e-6);
            untouched += 1;
        } else if !absent(p) {
            assert_close(found, value(p), 2.0);
        }
    }
    assert!(untouched > 300, "{untouched}");
    let nothing = volume([3, 3, 3], |_| f64::INFINITY);
    assert_eq!(spline_coefficients(&nothing, 0).unwrap().statistics().nan, 27);
}

#[test]
fn component_map_and_names_are_kept() {
    let grid = Grid::with_spacing([6, 5, 4], [1.0, 2.0, 3.0], [-1.0, 0.0, 4.0]).unwrap();
    let mut random = Random(2);
    let values: Vec<i16> = (0..240).map(|_| random.within(-2000.0, 2000.0) as i16).collect();
    let map = ValueMap { scale: 0.5, offset: -1000.0 };
    let mut volume = Volume::with_components(grid, values, 2).unwrap().with_value_map(map).unwrap().with_name("head");
    volume.value_unit = Some("HU".into());
    let coefficients = spline_coefficients(&volume, 1).unwrap();
    assert_eq!((coefficients.grid(), coefficients.name.as_str()), (&grid, "head"));
    assert_eq!((coefficients.value_unit.as_deref(), coefficients.components()), (Some("HU"), 1));
    let sampler = Sampler::new(&coefficients, 0, Filter::BSpline { prefilter: false }).unwrap();
    assert_close(sampler.value(DVec3::new(3.0, 2.0, 0.0)), volume.value([3, 2, 0], 1), 2e-3);
    assert_eq!(
        sampler.value(DVec3::new(3.4, 2.2, 0.7)),
        Sampler::new(&volume, 1, INTERPOLATING).unwrap().value(DVec3::new(3.4, 2.2, 0.7))
    );
    assert!(spline_coefficients(&volume, 2).is_err());
}
