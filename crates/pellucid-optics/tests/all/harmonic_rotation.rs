//! Rotations of harmonics against quadrature, rotations by angles and what rotations are.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DMat3, DQuat, DVec3};
use pellucid_optics::{Bands, MOST_BANDS, MOST_COEFFICIENTS, Rotation, spherical_harmonics_f64};

use crate::nodes_on_sphere::{Numbers, nodes};

const MOST: Bands = Bands::ALL[MOST_BANDS - 1];

type Matrix = [[f64; MOST_COEFFICIENTS]; MOST_COEFFICIENTS];

fn identity() -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))))
}

/// What becomes of every harmonic, in columns.
fn matrix(rotation: DQuat) -> Matrix {
    Rotation::new(rotation).rotate(&identity())
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..MOST_COEFFICIENTS).map(|k| a[i][k] * b[k][j]).sum()))
}

fn transposed(a: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| a[j][i]))
}

#[track_caller]
fn alike(a: &Matrix, b: &Matrix) {
    for i in 0..MOST_COEFFICIENTS {
        for j in 0..MOST_COEFFICIENTS {
            assert!((a[i][j] - b[i][j]).abs() < 1e-12, "{i}, {j}: {} and {}", a[i][j], b[i][j]);
        }
    }
}

fn rotations() -> impl Iterator<Item = DQuat> {
    let mut numbers = Numbers(3);
    (0..20).map(move |_| DQuat::from_axis_angle(numbers.direction(), TAU * numbers.next()))
}

#[test]
fn a_rotation_is_its_quadrature() {
    for rotation in rotations() {
        let mut expected = [[0.0; MOST_COEFFICIENTS]; MOST_COEFFICIENTS];
        for (direction, weight) in nodes() {
            let (turned, own) =
                (spherical_harmonics_f64(MOST, rotation * direction), spherical_harmonics_f64(MOST, direction));
            for (row, a) in expected.iter_mut().zip(turned) {
                for (entry, b) in row.iter_mut().zip(own) {
                    *entry += weight * a * b;
                }
            }
        }
        alike(&matrix(rotation), &expected);
    }
}

#[test]
fn rotations_follow_each_other_and_keep_lengths() {
    alike(&matrix(DQuat::IDENTITY), &identity());
    for (a, b) in rotations().zip(rotations().skip(1)) {
        alike(&matrix(a * b), &product(&matrix(a), &matrix(b)));
        alike(&product(&matrix(a), &transposed(&matrix(a))), &identity());
    }
}

#[test]
fn a_turned_function_has_its_values_where_they_were_turned_to() {
    let mut numbers = Numbers(4);
    for rotation in rotations() {
        let f: [[f64; 1]; MOST_COEFFICIENTS] = std::array::from_fn(|_| [numbers.next() - 0.5]);
        let turned = Rotation::new(rotation).rotate(&f);
        let value = |f: &[[f64; 1]], at: DVec3| -> f64 {
            spherical_harmonics_f64(MOST, at).iter().zip(f).map(|(value, [coefficient])| value * coefficient).sum()
        };
        for _ in 0..10 {
            let at = numbers.direction();
            assert!((value(&turned, rotation * at) - value(&f, at)).abs() < 1e-12);
        }
    }
}

/// Around z harmonics of order m turn into those of order -m, by m times the angle.
fn around_z(angle: f64) -> Matrix {
    let mut matrix = [[0.0; MOST_COEFFICIENTS]; MOST_COEFFICIENTS];
    for l in 0..MOST_BANDS as i32 {
        for m in -l..=l {
            let at = |m: i32| (l * (l + 1) + m) as usize;
            let (sine, cosine) = (f64::from(m) * angle).sin_cos();
            matrix[at(m)][at(-m)] = -sine;
            matrix[at(m)][at(m)] = cosine;
        }
    }
    matrix
}

#[test]
fn a_rotation_is_that_of_its_three_angles() {
    // About y as about z, between two quarter turns about x (Wyman et al. 2006).
    let [back, forth] = [-FRAC_PI_2, FRAC_PI_2].map(|angle| matrix(DQuat::from_rotation_x(angle)));
    let mut numbers = Numbers(5);
    for _ in 0..20 {
        let [a, b, c] = std::array::from_fn(|_| TAU * numbers.next());
        let turned = DMat3::from_rotation_z(a) * DMat3::from_rotation_y(b) * DMat3::from_rotation_z(c);
        let about_y = product(&back, &product(&around_z(b), &forth));
        let expected = product(&around_z(a), &product(&about_y, &around_z(c)));
        alike(&matrix(DQuat::from_mat3(&turned)), &expected);
    }
}
