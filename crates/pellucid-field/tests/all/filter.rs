//! Kernels and one-dimensional weights.

use pellucid_field::{
    FieldError, Filter, SincWindow, bspline_derivative_weights, bspline_second_derivative_weights, bspline_weights,
};
use proptest::prelude::*;

use crate::{FILTERS, assert_close};

const AFFINE_EXACT: [Filter; 4] =
    [Filter::Linear, Filter::BSpline { prefilter: false }, Filter::CATMULL_ROM, Filter::MITCHELL];

/// Offset of the first tap: 1 - m.
fn first(filter: Filter) -> f64 {
    1.0 - filter.half_width() as f64
}

proptest! {
    #[test]
    fn weights_sum_to_one(u in 0.0..1.0) {
        for filter in FILTERS {
            assert_eq!(filter.weights(u).len(), 2 * filter.half_width());
            assert_close(filter.weights(u).iter().sum(), 1.0, 1e-14);
        }
    }

    #[test]
    fn a_ramp_is_reproduced(u in 0.0..1.0) {
        for filter in AFFINE_EXACT {
            let moment: f64 = filter.weights(u).iter().enumerate().map(|(i, w)| w * (first(filter) + i as f64)).sum();
            assert_close(moment, u, 1e-14);
        }
    }

    /// The largest sample of voxels from 0 to 1 has 1 wherever the weight is positive.
    #[test]
    fn no_sample_overshoots_further(p in [0.0..1.0f64, 0.0..1.0f64, 0.0..1.0f64]) {
        for filter in FILTERS {
            let weights = p.map(|u| filter.weights(u).to_vec());
            let products = weights[0].iter().flat_map(|x| weights[1].iter().map(move |y| x * y));
            let products: Vec<f64> = products.flat_map(|xy| weights[2].iter().map(move |z| xy * z)).collect();
            let largest: f64 = products.iter().filter(|w| **w > 0.0).sum();
            prop_assert!(largest <= 1.0 + filter.overshoot() + 1e-12, "{filter:?}: {largest}");
        }
    }

    #[test]
    fn weights_are_the_kernel_at_the_taps(u in 0.0..1.0) {
        for filter in FILTERS {
            let kernel: Vec<f64> = (0..2 * filter.half_width()).map(|i| filter.kernel(u - first(filter) - i as f64)).collect();
            let sum: f64 = kernel.iter().sum();
            for (found, expected) in filter.weights(u).iter().zip(kernel) {
                assert_close(*found, expected / sum, 1e-14);
            }
        }
    }

    #[test]
    fn kernels_are_even_and_end_at_their_half_width(t in 0.0..10.0) {
        for filter in FILTERS {
            if filter != Filter::Nearest {
                prop_assert_eq!(filter.kernel(t), filter.kernel(-t));
            }
            prop_assert!(t < filter.half_width() as f64 || filter.kernel(t) == 0.0);
        }
    }

    #[test]
    fn positive_filters_have_no_negative_weight(u in 0.0..1.0, b in -0.5..4.0, c in -0.5..0.5) {
        for filter in [Filter::Bc { b, c: 0.0 }, Filter::Bc { b, c }].into_iter().chain(FILTERS) {
            prop_assert!(!filter.is_positive() || filter.weights(u).iter().all(|&w| w >= -1e-16));
        }
    }

    #[test]
    fn bspline_equals_de_boor(u in 0.0..1.0, f in prop::array::uniform4(-1.0..1.0)) {
        let sum: f64 = bspline_weights(u).iter().zip(f).map(|(w, f)| w * f).sum();
        assert_close(sum, de_boor(u, f), 1e-14);
    }

    #[test]
    fn derivative_weights_are_exact_on_quadratics(u in 0.0..1.0, x0 in -5.0..5.0) {
        let squares = [-1.0, 0.0, 1.0, 2.0].map(|i| (x0 + i) * (x0 + i));
        let dot = |w: [f64; 4]| -> f64 { w.iter().zip(squares).map(|(w, f)| w * f).sum() };
        assert_close(dot(bspline_derivative_weights(u)), 2.0 * (x0 + u), 1e-12);
        assert_close(dot(bspline_second_derivative_weights(u)), 2.0, 1e-12);
        assert_close(bspline_derivative_weights(u).iter().sum(), 0.0, 1e-15);
    }

    #[test]
    fn derivative_weights_are_differences_of_weights(u in 0.01..0.99) {
        let h = 1e-5;
        for i in 0..4 {
            let slope = (bspline_weights(u + h)[i] - bspline_weights(u - h)[i]) / (2.0 * h);
            assert_close(bspline_derivative_weights(u)[i], slope, 1e-9);
            let slope = (bspline_derivative_weights(u + h)[i] - bspline_derivative_weights(u - h)[i]) / (2.0 * h);
            assert_close(bspline_second_derivative_weights(u)[i], slope, 1e-9);
        }
    }
}

/// The recursion of 9.2-9, which never sees a kernel; `f` are voxels -1 to 2.
fn de_boor(u: f64, mut f: [f64; 4]) -> f64 {
    for level in 0..3 {
        for i in 0..3 - level {
            let alpha = (u - (i as f64 - 1.0) - level as f64 + 1.0) / (3.0 - level as f64);
            f[i] = (1.0 - alpha) * f[i] + alpha * f[i + 1];
        }
    }
    f[0]
}

#[test]
fn golden_weights() {
    let check = |filter: Filter, u: f64, expected: [f64; 4]| {
        filter.weights(u).iter().zip(expected).for_each(|(&found, expected)| assert_close(found, expected, 5e-8));
    };
    let bspline = Filter::BSpline { prefilter: false };
    check(bspline, 0.25, [0.0703125, 0.6119792, 0.3151042, 0.0026042]);
    check(bspline, 0.5, [0.0208333, 0.4791667, 0.4791667, 0.0208333]);
    check(Filter::CATMULL_ROM, 0.5, [-0.0625, 0.5625, 0.5625, -0.0625]);
    // Mitchell and Netravali 1988, B = C = 1/3: k(0) = 16/18, k(1) = 1/18, k(1/2) = 77/144, k(3/2) = -5/144.
    check(Filter::MITCHELL, 0.0, [1.0 / 18.0, 16.0 / 18.0, 1.0 / 18.0, 0.0]);
    check(Filter::MITCHELL, 0.5, [-5.0 / 144.0, 77.0 / 144.0, 77.0 / 144.0, -5.0 / 144.0]);
    assert_close(bspline.kernel(0.0), 2.0 / 3.0, 1e-15);
    assert_close(bspline.kernel(-1.0), 1.0 / 6.0, 1e-15);
}

/// The polynomial coefficients of 9.2-6, in powers 3, 2, 1, 0 of u.
#[test]
fn published_polynomials() {
    const BSPLINE: [[f64; 4]; 4] = [
        [-1.0 / 6.0, 0.5, -0.5, 1.0 / 6.0],
        [0.5, -1.0, 0.0, 2.0 / 3.0],
        [-0.5, 0.5, 0.5, 1.0 / 6.0],
        [1.0 / 6.0, 0.0, 0.0, 0.0],
    ];
    const CATMULL_ROM: [[f64; 4]; 4] =
        [[-0.5, 1.0, -0.5, 0.0], [1.5, -2.5, 0.0, 1.0], [-1.5, 2.0, 0.5, 0.0], [0.5, -0.5, 0.0, 0.0]];
    for (filter, taps) in [(Filter::BSpline { prefilter: false }, BSPLINE), (Filter::CATMULL_ROM, CATMULL_ROM)] {
        for u in (0..100).map(|i| f64::from(i) / 100.0) {
            for (weight, c) in filter.weights(u).iter().zip(taps) {
                assert_close(*weight, ((c[0] * u + c[1]) * u + c[2]) * u + c[3], 1e-15);
            }
        }
    }
}

#[test]
fn windows_have_their_published_form() {
    use std::f64::consts::PI;
    // I0(x) = 1/pi times the integral of exp(x cos t) over [0, pi].
    let bessel =
        |x: f64| (0..1000).map(|i| (x * (PI * (f64::from(i) + 0.5) / 1000.0).cos()).exp()).sum::<f64>() / 1000.0;
    for t in [0.3, 1.0, 1.7, 3.9] {
        let (x, sinc) = (t / 4.0, (PI * t).sin() / (PI * t));
        let expected = [
            (SincWindow::Lanczos, (PI * x).sin() / (PI * x)),
            (SincWindow::Hann, (0.5 * PI * x).cos().powi(2)),
            (SincWindow::Blackman, 0.42 + 0.5 * (PI * x).cos() + 0.08 * (2.0 * PI * x).cos()),
            (SincWindow::Kaiser, bessel(6.0 * (1.0 - x * x).sqrt()) / bessel(6.0)),
        ];
        for (window, expected) in expected {
            assert_close(Filter::Sinc { window, half_width: 4 }.kernel(t), sinc * expected, 1e-12);
        }
    }
}

/// A wider window brings the windowed sinc nearer to the ideal filter (1.5-6).
#[test]
fn wider_sincs_reconstruct_a_band_limited_signal_better() {
    let signal = |x: f64| (1.4 * x).sin();
    let error = |half_width: u8| {
        let filter = Filter::Sinc { window: SincWindow::Kaiser, half_width };
        (0..50).fold(0.0f64, |worst, i| {
            let x = 0.37 * f64::from(i);
            let left = x.floor() + first(filter);
            let sum: f64 = filter.weights(x.fract()).iter().enumerate().map(|(i, w)| w * signal(left + i as f64)).sum();
            worst.max((sum - signal(x)).abs())
        })
    };
    let errors = [2, 4, 6, 8].map(error);
    assert!(errors.is_sorted_by(|a, b| a > b) && errors[3] < 2e-3, "{errors:?}");
}

#[test]
fn an_interpolating_filter_has_one_weight_at_a_voxel() {
    for filter in FILTERS {
        let weights = filter.weights(0.0);
        let one = (0..weights.len()).all(|i| weights[i] == f64::from(i + 1 == filter.half_width()));
        assert_eq!(filter.is_interpolating(), one, "{filter:?}");
    }
    assert!(Filter::BSpline { prefilter: true }.is_interpolating());
    assert!(!Filter::BSpline { prefilter: true }.is_positive());
    assert!(Filter::BSpline { prefilter: false }.is_positive());
}

#[test]
fn parameters_out_of_range_are_named() {
    for half_width in [0, 1, 9, 255] {
        let filter = Filter::Sinc { window: SincWindow::Hann, half_width };
        assert!(matches!(filter.validate(), Err(FieldError::Parameter { name: "sinc half width", .. })));
        assert_close(filter.weights(0.3).iter().sum(), 1.0, 1e-14);
    }
    assert!(Filter::Bc { b: f64::NAN, c: 0.0 }.validate().is_err());
    assert!(Filter::Bc { b: 0.0, c: f64::INFINITY }.validate().is_err());
    assert!(FILTERS.iter().all(|filter| filter.validate().is_ok()));
    assert_eq!(Filter::default(), Filter::Linear);
}

/// At the middle of a cell Catmull-Rom's weights are -1/16, 9/16, 9/16, -1/16, and furthest apart.
#[test]
fn the_overshoot_of_catmull_rom_is_reached() {
    assert_close(Filter::CATMULL_ROM.overshoot(), (1.25f64.powi(3) - 1.0) / 2.0, 1e-3);
    assert_eq!(Filter::Linear.overshoot(), 0.0);
    assert_eq!(Filter::BSpline { prefilter: true }.overshoot(), 0.0);
}
