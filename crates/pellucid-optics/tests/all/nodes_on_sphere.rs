//! A quadrature over directions that is exact for products of harmonics.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

/// Directions and their solid angles: Gauss's points in the height by even ones around.
pub fn nodes() -> Vec<(DVec3, f64)> {
    const AROUND: usize = 48;
    let at = |(z, weight): (f64, f64)| {
        (0..AROUND).map(move |k| {
            let (sine, cosine) = (TAU * k as f64 / AROUND as f64).sin_cos();
            let across = (1.0 - z * z).sqrt();
            (DVec3::new(across * cosine, across * sine, z), weight * TAU / AROUND as f64)
        })
    };
    gauss(24).into_iter().flat_map(at).collect()
}

/// Gauss's points in -1..1 and their weights: roots of Legendre's polynomial, by Newton's method.
pub fn gauss(count: usize) -> Vec<(f64, f64)> {
    let point = |k: usize| {
        let mut z = (PI * (k as f64 + 0.75) / (count as f64 + 0.5)).cos();
        let mut slope = 0.0;
        for _ in 0..20 {
            let (mut before, mut value) = (1.0, z);
            for l in 2..=count {
                let l = l as f64;
                (before, value) = (value, ((2.0 * l - 1.0) * z * value - (l - 1.0) * before) / l);
            }
            slope = count as f64 * (z * value - before) / (z * z - 1.0);
            z -= value / slope;
        }
        (z, 2.0 / ((1.0 - z * z) * slope * slope))
    };
    (0..count).map(point).collect()
}

/// Reproducible numbers in 0..1: a linear congruential generator (Knuth's MMIX constants).
pub struct Numbers(pub u64);

impl Numbers {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A direction, evenly.
    pub fn direction(&mut self) -> DVec3 {
        let (z, turn) = (2.0 * self.next() - 1.0, TAU * self.next());
        let across = (1.0 - z * z).sqrt();
        DVec3::new(across * turn.cos(), across * turn.sin(), z)
    }
}
