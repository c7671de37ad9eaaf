//! Spherical harmonics and functions around an axis against tables, quadrature and closed forms.

use std::f64::consts::PI;

use glam::DVec3;
use pellucid_optics::{
    Bands, MOST_BANDS, MOST_COEFFICIENTS, OpticsError, Window, Zonal, spherical_harmonics, spherical_harmonics_f64,
};

use crate::nodes_on_sphere::{Numbers, gauss, nodes};

const MOST: Bands = Bands::ALL[MOST_BANDS - 1];

#[test]
fn harmonics_are_orthonormal() {
    let mut gram = [[0.0; MOST_COEFFICIENTS]; MOST_COEFFICIENTS];
    for (direction, weight) in nodes() {
        let values = spherical_harmonics_f64(MOST, direction);
        for (row, a) in gram.iter_mut().zip(values) {
            for (entry, b) in row.iter_mut().zip(values) {
                *entry += weight * a * b;
            }
        }
    }
    for (i, row) in gram.iter().enumerate() {
        for (j, entry) in row.iter().enumerate() {
            let expected = f64::from(u8::from(i == j));
            assert!((entry - expected).abs() < 1e-12, "{i} and {j}: {entry}");
        }
    }
}

#[test]
fn harmonics_are_the_polynomials_of_the_table() {
    let mut numbers = Numbers(1);
    for _ in 0..100 {
        let direction = numbers.direction();
        let [x, y, z] = direction.to_array();
        let (xx, yy, zz) = (x * x, y * y, z * z);
        let expected = [
            0.2820948,
            0.4886025 * y,
            0.4886025 * z,
            0.4886025 * x,
            1.0925484 * x * y,
            1.0925484 * y * z,
            0.3153916 * (3.0 * zz - 1.0),
            1.0925484 * x * z,
            0.5462742 * (xx - yy),
            0.5900436 * y * (3.0 * xx - yy),
            2.8906114 * x * y * z,
            0.4570458 * y * (5.0 * zz - 1.0),
            0.3731763 * z * (5.0 * zz - 3.0),
            0.4570458 * x * (5.0 * zz - 1.0),
            1.4453057 * z * (xx - yy),
            0.5900436 * x * (xx - 3.0 * yy),
            2.5033429 * x * y * (xx - yy),
            1.7701308 * y * z * (3.0 * xx - yy),
            0.9461747 * x * y * (7.0 * zz - 1.0),
            0.6690465 * y * z * (7.0 * zz - 3.0),
            0.1057855 * (35.0 * zz * zz - 30.0 * zz + 3.0),
            0.6690465 * x * z * (7.0 * zz - 3.0),
            0.4730873 * (xx - yy) * (7.0 * zz - 1.0),
            1.7701308 * x * z * (xx - 3.0 * yy),
            0.6258357 * (xx * (xx - 3.0 * yy) - yy * (3.0 * xx - yy)),
        ];
        let found = spherical_harmonics_f64(Bands::default(), direction);
        for (i, (found, expected)) in found.iter().zip(expected).enumerate() {
            assert!((found - expected).abs() < 5e-7, "{i}: {found}, not {expected}");
        }
    }
}

#[test]
fn fewer_bands_and_single_precision_give_the_same_values() {
    let mut numbers = Numbers(2);
    for _ in 0..100 {
        let direction = numbers.direction();
        let all = spherical_harmonics_f64(MOST, direction);
        for bands in Bands::ALL {
            let (fine, coarse) =
                (spherical_harmonics_f64(bands, direction), spherical_harmonics(bands, direction.as_vec3()));
            for i in 0..MOST_COEFFICIENTS {
                let expected = if i < bands.coefficients() { all[i] } else { 0.0 };
                assert_eq!(fine[i], expected);
                assert!((f64::from(coarse[i]) - expected).abs() < 2e-6, "{i}: {}, not {expected}", coarse[i]);
            }
        }
    }
    assert_eq!(Bands::default().coefficients(), 25);
    for count in [0, 7, 256 + 5] {
        assert!(matches!(Bands::new(count), Err(OpticsError::Parameter { .. })), "{count}");
    }
    assert_eq!(Bands::new(6), Ok(MOST));
}

#[test]
fn the_clamped_cosine_has_the_coefficients_and_the_energy_of_its_closed_form() {
    let up = Zonal::CLAMPED_COSINE.around(DVec3::Z, MOST);
    let zonal = [0.886_227, 1.023_327, 0.495_416, 0.0, -0.110_778, 0.0];
    for (i, found) in up.iter().enumerate() {
        let l = i.isqrt();
        let expected = if i == l * (l + 1) { zonal[l] } else { 0.0 };
        assert!((found - expected).abs() < 1e-6, "{i}: {found}, not {expected}");
    }
    // The square of the cosine integrates to 2 pi / 3.
    for (bands, share) in Bands::ALL.into_iter().zip([37.5, 87.5, 99.22, 99.22, 99.80]) {
        let energy: f64 = up[..bands.coefficients()].iter().map(|v| v * v).sum();
        let found = 100.0 * energy / (2.0 * PI / 3.0);
        assert!((found - share).abs() < 5e-3, "{} bands: {found} %, not {share} %", bands.count());
    }
}

#[test]
fn few_bands_of_the_clamped_cosine_ring_as_known() {
    for (count, error, least, peak) in [(5, 0.0586, -0.03125, 0.96875), (3, 0.09375, -0.0396, 1.0625)] {
        let bands = Bands::new(count).unwrap();
        let up = Zonal::CLAMPED_COSINE.around(DVec3::Z, bands);
        let (mut worst, mut low) = (0.0f64, f64::INFINITY);
        for k in 0..=20_000 {
            let z = f64::from(k) / 10_000.0 - 1.0;
            let values = spherical_harmonics_f64(bands, DVec3::new((1.0 - z * z).max(0.0).sqrt(), 0.0, z));
            let found: f64 = values.iter().zip(up).map(|(value, coefficient)| value * coefficient).sum();
            worst = worst.max((found - z.max(0.0)).abs());
            low = low.min(found);
            if k == 20_000 {
                assert!((found - peak).abs() < 1e-12, "{count} bands: a peak of {found}");
            }
        }
        assert!((worst - error).abs() < 5e-5, "{count} bands: an error of {worst}");
        assert!((low - least).abs() < 5e-5, "{count} bands: a least value of {low}");
    }
}

#[test]
fn a_disc_is_its_quadrature_and_the_smallest_a_direction() {
    let axis = DVec3::new(0.48, -0.6, 0.64);
    let (side, up) = axis.any_orthonormal_pair();
    for degrees in [0.1f64, 5.0, 40.0, 90.0] {
        let sine_squared = degrees.to_radians().sin().powi(2);
        let lowest = degrees.to_radians().cos();
        let mut expected = [0.0; MOST_COEFFICIENTS];
        for (place, weight) in gauss(12) {
            let z = 0.5 * (1.0 + lowest) + 0.5 * (1.0 - lowest) * place;
            for k in 0..16 {
                let (sin, cos) = (2.0 * PI * f64::from(k) / 16.0).sin_cos();
                let direction = axis * z + (side * cos + up * sin) * (1.0 - z * z).sqrt();
                let solid_angle = weight * 0.5 * (1.0 - lowest) * 2.0 * PI / 16.0;
                for (sum, value) in expected.iter_mut().zip(spherical_harmonics_f64(MOST, direction)) {
                    *sum += value * solid_angle / (PI * sine_squared);
                }
            }
        }
        let found = Zonal::cap(sine_squared).around(axis, MOST);
        for i in 0..MOST_COEFFICIENTS {
            // Of the smallest disc the quadrature has lost digits.
            assert!((found[i] - expected[i]).abs() < 1e-9, "{degrees} degrees, {i}: {} for {}", found[i], expected[i]);
        }
    }
    assert_eq!(Zonal::cap(0.0).factors(), [1.0; MOST_BANDS]);
}

#[test]
fn windows_fall_from_band_to_band() {
    for window in [Window::Hanning, Window::Lanczos] {
        for bands in Bands::ALL {
            let factors = Zonal::window(window, bands).factors();
            assert_eq!(factors[0], 1.0);
            assert!(factors.windows(2).all(|pair| pair[1] < pair[0] || pair == [0.0, 0.0]), "{factors:?}");
            assert!(factors[bands.count()..].iter().all(|factor| *factor == 0.0), "{factors:?}");
        }
    }
    let four = Bands::new(4).unwrap();
    let (hanning, lanczos) = (Zonal::window(Window::Hanning, four), Zonal::window(Window::Lanczos, four));
    assert!((hanning.factors()[2] - 0.5).abs() < 1e-15 && (lanczos.factors()[2] - 2.0 / PI).abs() < 1e-15);
}
