//! Gradients of closures and of sampled fields.

use glam::DVec3;
use pellucid_field::{
    Filter, Gradient, Grid, Reconstruct, Sampler, Volume, index_gradient, normal, with_reconstruction, world_gradient,
};
use proptest::prelude::*;

use crate::{Random, assert_close, assert_near, volume};

pub const KINDS: [Gradient; 10] = [
    Gradient::Forward,
    Gradient::Backward,
    Gradient::Central,
    Gradient::Sobel,
    Gradient::SobelIsotropic,
    Gradient::Prewitt,
    Gradient::Gaussian { sigma: 0.5 },
    Gradient::Gaussian { sigma: 1.0 },
    Gradient::Gaussian { sigma: 2.0 },
    Gradient::BSpline,
];

/// The gradient of a sampler's field as generic code gets it.
pub fn gradient_of(sampler: &Sampler, kind: Gradient, p: DVec3) -> DVec3 {
    with_reconstruction!(sampler, field => field.gradient(kind, p, field.value(p)))
}

fn vector(range: f64) -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(-range..range).prop_map(DVec3::from_array)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn affine_fields_are_exact(slope in vector(3.0), offset in -5.0..5.0, p in vector(9.0)) {
        let field = |p: DVec3| slope.dot(p) + offset;
        for kind in KINDS {
            assert_near(index_gradient(kind, p, field(p), field), slope, 1e-11);
        }
    }

    /// Absence beyond any plane leaves one tap of each pair, and affine fields stay exact.
    #[test]
    fn affine_fields_are_exact_beside_a_cut(slope in vector(3.0), plane in vector(1.0), p in vector(9.0), depth in 0.0..1.5) {
        prop_assume!(plane.length() > 0.1);
        let cut = |q: DVec3| plane.normalize().dot(q - p) > depth;
        let field = |q: DVec3| if cut(q) { f64::NAN } else { slope.dot(q) };
        for kind in KINDS {
            assert_near(index_gradient(kind, p, field(p), field), slope, 1e-11);
        }
    }

    #[test]
    fn quadratics_are_exact_for_even_stencils(a in prop::array::uniform6(-1.0..1.0), b in vector(2.0), p in vector(4.0)) {
        let field = |p: DVec3| {
            a[0] * p.x * p.x + a[1] * p.y * p.y + a[2] * p.z * p.z + a[3] * p.x * p.y + a[4] * p.y * p.z + a[5] * p.z * p.x
                + b.dot(p)
        };
        let expected = b + DVec3::new(
            2.0 * a[0] * p.x + a[3] * p.y + a[5] * p.z,
            2.0 * a[1] * p.y + a[3] * p.x + a[4] * p.z,
            2.0 * a[2] * p.z + a[4] * p.y + a[5] * p.x,
        );
        for kind in &KINDS[2..] {
            assert_near(index_gradient(*kind, p, field(p), field), expected, 1e-10);
        }
        let mean = (index_gradient(Gradient::Forward, p, field(p), field) + index_gradient(Gradient::Backward, p, field(p), field)) / 2.0;
        assert_near(mean, expected, 1e-10);
    }
}

/// Error against step size on a log-log scale: slope 1 one-sided, slope 2 central (5.3-2 to 5.3-4).
#[test]
fn order_of_convergence() {
    let slope = |kind: Gradient| {
        let points: Vec<(f64, f64)> = (0..6)
            .map(|i| {
                let h = 0.1 * 0.5f64.powi(i);
                let field = |p: DVec3| (h * p.x + 0.4).sin() * (h * p.y + 0.7).sin() * (h * p.z + 1.1).sin();
                let exact = DVec3::new(
                    0.4f64.cos() * 0.7f64.sin() * 1.1f64.sin(),
                    0.4f64.sin() * 0.7f64.cos() * 1.1f64.sin(),
                    0.4f64.sin() * 0.7f64.sin() * 1.1f64.cos(),
                );
                let error = index_gradient(kind, DVec3::ZERO, field(DVec3::ZERO), field) / h - exact;
                (h.ln(), error.length().ln())
            })
            .collect();
        let mean = |f: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / points.len() as f64;
        let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
        mean(&|p| (p.0 - x) * (p.1 - y)) / mean(&|p| (p.0 - x).powi(2))
    };
    assert_close(slope(Gradient::Forward), 1.0, 0.1);
    assert_close(slope(Gradient::Backward), 1.0, 0.1);
    for kind in &KINDS[2..] {
        assert_close(slope(*kind), 2.0, 0.1);
    }
    // The gain of a central difference on a wave is sin(w) / w.
    for (w, gain) in [(0.1f64, 0.9983), (0.5, 0.9589)] {
        let found = index_gradient(Gradient::Central, DVec3::ZERO, 0.0, |p| (w * p.x).sin()).x / w;
        assert_close(found, gain, 1e-4);
    }
}

/// On-the-fly differences one voxel apart are the interpolated differences of the voxels (5.3-5).
#[test]
fn central_differences_commute_with_trilinear_interpolation() {
    let mut random = Random(16);
    let values: Vec<u8> = (0..16 * 16 * 16).map(|_| (256.0 * random.next()) as u8).collect();
    let noise = Volume::new(Grid::new([16; 3]).unwrap(), values).unwrap();
    let component = |axis: usize| {
        volume([16; 3], |p| {
            let at = |step: f64| {
                let mut q = p;
                q[axis] = (q[axis] + step).clamp(0.0, 15.0);
                noise.value(q.to_array().map(|i| i as usize), 0)
            };
            0.5 * (at(1.0) - at(-1.0))
        })
    };
    let stored = [component(0), component(1), component(2)];
    let stored = stored.each_ref().map(|volume| Sampler::new(volume, 0, Filter::Linear).unwrap());
    let sampler = Sampler::new(&noise, 0, Filter::Linear).unwrap();
    for _ in 0..100_000 {
        let p = random.point(1.0, 14.0);
        let expected = DVec3::from_array(stored.each_ref().map(|s| s.value(p)));
        assert_near(gradient_of(&sampler, Gradient::Central, p), expected, 1e-10);
    }
}

/// Variance of white noise relative to central differences: the ratio of the squared weights (5.3-7).
#[test]
fn smoothing_stencils_suppress_noise() {
    let mut random = Random(77);
    let values: Vec<f32> = (0..44usize.pow(3)).map(|_| random.next() as f32).collect();
    let noise = Volume::new(Grid::new([44; 3]).unwrap(), values).unwrap();
    let sampler = Sampler::new(&noise, 0, Filter::Nearest).unwrap();
    let variance = |kind: Gradient| {
        let points = (0..32usize.pow(3)).map(|i| DVec3::new((i % 32) as f64, (i / 32 % 32) as f64, (i / 1024) as f64));
        points.map(|p| gradient_of(&sampler, kind, p + 6.0).length_squared()).sum::<f64>()
    };
    let central = variance(Gradient::Central);
    let expected = [(Gradient::Sobel, 0.141), (Gradient::SobelIsotropic, 0.2125), (Gradient::Prewitt, 0.111)];
    for (kind, ratio) in expected {
        assert_close(variance(kind) / central, ratio, 0.05 * ratio);
    }
    let gaussian = [0.5, 0.8, 1.2, 2.0].map(|sigma| variance(Gradient::Gaussian { sigma }) / central);
    assert!(gaussian.is_sorted_by(|a, b| a > b) && gaussian[0] < 1.0, "{gaussian:?}");
}

/// Largest angle between the gradient of a plane wave of 0.7 rad per voxel and its direction (5.3-8).
#[test]
fn isotropy() {
    let mut random = Random(4);
    let directions: Vec<DVec3> = (0..20_000).map(|_| random.direction()).collect();
    let worst = |kind: Gradient| {
        let angle = |d: &DVec3| index_gradient(kind, DVec3::ZERO, 0.0, |p| (0.7 * d.dot(p)).sin()).angle_between(*d);
        directions.iter().map(angle).fold(0.0, f64::max).to_degrees()
    };
    let expected = [
        (Gradient::Central, 1.35),
        (Gradient::Prewitt, 1.36),
        (Gradient::Sobel, 0.66),
        (Gradient::SobelIsotropic, 0.15),
    ];
    for (kind, degrees) in expected {
        assert_close(worst(kind), degrees, 0.1 * degrees);
    }
}

/// Normals of a radial distance, sampled, against the radius (5.3-1), and its curvature (9.2-13).
#[test]
fn normals_and_curvature_of_a_ball() {
    let center = DVec3::splat(20.0) + DVec3::new(0.13, -0.29, 0.41);
    let ball = volume([41; 3], |p| (p - center).length());
    let sampler = Sampler::new(&ball, 0, Filter::Linear).unwrap();
    let mut random = Random(12);
    for (radius, degrees) in [(8.0, 0.25), (16.0, 0.06)] {
        for _ in 0..5000 {
            let direction = random.direction();
            let p = center + radius * direction;
            let found = normal(gradient_of(&sampler, Gradient::Central, p), 1e-9);
            assert!(found.angle_between(direction).to_degrees() <= degrees);
            // The mean curvature of a sphere is 1 / r: half the divergence of its unit normals.
            let hessian = with_reconstruction!(&sampler, field => field.spline(p)).unwrap().hessian();
            assert_eq!(hessian, hessian.transpose());
            let trace = hessian.x_axis.x + hessian.y_axis.y + hessian.z_axis.z;
            assert_close(trace / 2.0, 1.0 / radius, 0.02 / radius);
        }
    }
}

#[test]
fn normals_vanish_where_there_is_no_gradient() {
    assert_eq!(normal(DVec3::ZERO, 1e-9), DVec3::ZERO);
    assert_eq!(normal(DVec3::ZERO, 0.0), DVec3::ZERO);
    assert_eq!(normal(DVec3::new(1e-10, 0.0, 0.0), 1e-9), DVec3::ZERO);
    assert_eq!(normal(DVec3::new(f64::NAN, 0.0, 1.0), 1e-9), DVec3::ZERO);
    assert_eq!(normal(DVec3::new(f64::INFINITY, 0.0, 1.0), 1e-9), DVec3::ZERO);
    assert_near(normal(DVec3::new(0.0, -3.0, 4.0), 1e-9), DVec3::new(0.0, -0.6, 0.8), 1e-15);
    for kind in KINDS {
        assert_eq!(index_gradient(kind, DVec3::ZERO, f64::NAN, |_| f64::NAN), DVec3::ZERO);
        assert_eq!(index_gradient(kind, DVec3::ZERO, 4.0, |_| 4.0), DVec3::ZERO);
        // An isolated voxel has no slope.
        let alone = |p: DVec3| if p == DVec3::ZERO { 4.0 } else { f64::NAN };
        assert_eq!(index_gradient(kind, DVec3::ZERO, 4.0, alone), DVec3::ZERO);
    }
}

#[test]
fn spline_gradients_are_continuous() {
    let mut random = Random(31);
    let noise = volume([10; 3], |_| 0.0);
    let values: Vec<f32> = (0..1000).map(|_| random.next() as f32).collect();
    let noise = Volume::new(*noise.grid(), values).unwrap();
    let linear = Sampler::new(&noise, 0, Filter::Linear).unwrap();
    let jump = |sampler: &Sampler, kind: Gradient, p: DVec3| {
        let across = DVec3::new(1e-7, 0.0, 0.0);
        (gradient_of(sampler, kind, p + across) - gradient_of(sampler, kind, p - across)).length()
    };
    let slope = |p: DVec3| {
        let h = DVec3::new(1e-4, 0.0, 0.0);
        (linear.value(p + h) - linear.value(p)) - (linear.value(p) - linear.value(p - h))
    };
    let mut kink = 0.0f64;
    for _ in 0..500 {
        let mut p = random.point(2.0, 7.0);
        p.x = p.x.round();
        assert!(jump(&linear, Gradient::BSpline, p) < 1e-5);
        kink = kink.max(slope(p).abs() / 1e-4);
    }
    assert!(kink > 0.5, "trilinear fields are creased: {kink}");
}

/// The derivative of the very field that the B-spline filter reconstructs, smoothing or not.
#[test]
fn spline_gradients_are_derivatives_of_the_spline() {
    let mut random = Random(8);
    let values: Vec<f32> = (0..1000).map(|_| random.next() as f32).collect();
    let noise = Volume::new(Grid::new([10; 3]).unwrap(), values).unwrap();
    for prefilter in [false, true] {
        let spline = Sampler::new(&noise, 0, Filter::BSpline { prefilter }).unwrap();
        for _ in 0..200 {
            let p = random.point(1.0, 7.99);
            let h = 1e-5;
            let slope = DVec3::AXES.map(|axis| (spline.value(p + h * axis) - spline.value(p - h * axis)) / (2.0 * h));
            assert_near(gradient_of(&spline, Gradient::BSpline, p), DVec3::from_array(slope), 1e-6);
            let gradient = |p| gradient_of(&spline, Gradient::BSpline, p);
            let hessian = with_reconstruction!(&spline, field => field.spline(p)).unwrap().hessian();
            for (axis, column) in DVec3::AXES.into_iter().zip([hessian.x_axis, hessian.y_axis, hessian.z_axis]) {
                assert_near((gradient(p + h * axis) - gradient(p - h * axis)) / (2.0 * h), column, 1e-4);
            }
        }
    }
}

#[test]
fn the_spline_gradient_falls_back_beside_absence() {
    let hole = DVec3::new(5.0, 5.0, 5.0);
    let slope = DVec3::new(0.25, -2.0, 0.5);
    let field = volume([11; 3], |p| if p == hole { f64::NAN } else { slope.dot(p) + 0.01 * p.x * p.x * p.x });
    let sampler = Sampler::new(&field, 0, Filter::Linear).unwrap();
    for p in [hole + DVec3::X, hole + 1.3, DVec3::splat(0.5), DVec3::ZERO, DVec3::splat(10.0), DVec3::splat(9.5)] {
        assert!(with_reconstruction!(&sampler, field => field.spline(p)).is_none());
        assert_eq!(gradient_of(&sampler, Gradient::BSpline, p), gradient_of(&sampler, Gradient::Central, p));
    }
    // By way of samples (as under a clip) it is the same as by way of voxels.
    let mut random = Random(3);
    for _ in 0..100 {
        let p = random.point(0.0, 10.0);
        let center = sampler.value(p);
        if center.is_finite() {
            let sampled = index_gradient(Gradient::BSpline, p, center, |q| sampler.value(q));
            assert_near(sampled, gradient_of(&sampler, Gradient::BSpline, p), 1e-6);
        }
    }
}

/// Gradients of an affine field up to the border, beside holes and on thin grids.
#[test]
fn sampled_affine_fields_are_exact_up_to_the_border() {
    let slope = DVec3::new(0.25, -2.0, 0.5);
    for dims in [[8, 8, 8], [2, 2, 2], [1, 1, 9], [5, 1, 1], [1, 1, 1]] {
        let field = volume(dims, |p| slope.dot(p));
        let sampler = Sampler::new(&field, 0, Filter::Linear).unwrap();
        for i in 0..field.grid().len() {
            let p = DVec3::new((i % dims[0]) as f64, (i / dims[0] % dims[1]) as f64, (i / (dims[0] * dims[1])) as f64);
            let expected =
                DVec3::from_array(std::array::from_fn(|axis| if dims[axis] > 1 { slope[axis] } else { 0.0 }));
            for kind in [Gradient::Forward, Gradient::Backward, Gradient::Central, Gradient::BSpline] {
                assert_near(gradient_of(&sampler, kind, p), expected, 1e-6);
            }
        }
    }
}

#[test]
fn sigma_is_checked_and_limited() {
    for sigma in [0.0, -1.0, 3.1, f64::NAN, f64::INFINITY] {
        let kind = Gradient::Gaussian { sigma };
        assert!(kind.validate().is_err());
        assert_near(index_gradient(kind, DVec3::ZERO, 0.0, |p| p.x), DVec3::X, 1e-12);
    }
    assert!(KINDS.iter().all(|kind| kind.validate().is_ok()));
    assert_eq!(Gradient::default(), Gradient::Central);
}

#[test]
fn world_gradients_have_world_units() {
    let grid = Grid::with_spacing([4, 4, 4], [0.5, 2.0, 4.0], [0.0; 3]).unwrap();
    assert_near(world_gradient(&grid, DVec3::splat(1.0)), DVec3::new(2.0, 0.5, 0.25), 1e-15);
}

/// The stencils as weights are the estimators, wherever every tap is there.
#[test]
fn stencils_are_the_estimators() {
    let field = |p: DVec3| (0.7 * p.x - 0.4 * p.y).sin() + 0.3 * p.z * p.x + (0.9 * p.z).cos();
    let p = DVec3::new(0.3, -0.8, 0.5);
    let gaussian = Gradient::Gaussian { sigma: 1.3 };
    let kinds = [Gradient::Forward, Gradient::Backward, Gradient::Central, Gradient::Sobel];
    for kind in kinds.into_iter().chain([Gradient::SobelIsotropic, Gradient::Prewitt, gaussian]) {
        let [smoothing, derivative] = kind.stencil().unwrap();
        let (taps, radius) = (smoothing.len(), (smoothing.len() / 2) as f64);
        let mut sum = DVec3::ZERO;
        for i in 0..taps * taps * taps {
            let [x, y, z] = [i % taps, i / taps % taps, i / (taps * taps)];
            let value = field(p + DVec3::new(x as f64, y as f64, z as f64) - radius);
            let weight = |along: usize| {
                let weight = |axis: usize, tap: usize| if axis == along { derivative[tap] } else { smoothing[tap] };
                weight(0, x) * weight(1, y) * weight(2, z)
            };
            sum += value * DVec3::new(weight(0), weight(1), weight(2));
        }
        assert_near(sum, index_gradient(kind, p, field(p), field), 1e-12);
    }
    assert_eq!(Gradient::BSpline.stencil(), None);
}
