//! Orbitals of the hydrogen atom.

use glam::DVec3;

use super::formula::value_and_gradient;
use super::number::Number;
use super::shape::length;
use super::{About, ScalarField};
use crate::{FieldError, VoxelType};

pub(super) const NAME: &str = "hydrogen";

/// Probability density |psi|^2 of the electron in a real orbital of hydrogen, relative to its
/// highest value, so that values lie in [0, 1]. Positions are in Bohr radii; psi is
/// `r^l exp(-r / n) L(2 r / n) S(x, y, z) / r^l` with the associated Laguerre polynomial
/// L of degree n - l - 1 and order 2 l + 1, and the real solid harmonic S: the one with `cos(m phi)` for
/// m > 0, with `sin(|m| phi)` for m < 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hydrogen {
    n: u32,
    l: u32,
    m: i32,
    /// 1 / (highest |radial part| * highest |angular part|).
    scale: f64,
}

impl Default for Hydrogen {
    /// The orbital 4d_z2: (4, 2, 0).
    fn default() -> Self {
        Self::new(4, 2, 0).expect("valid quantum numbers")
    }
}

impl Hydrogen {
    /// The orbital with principal quantum number `n` (1 to 4), angular momentum `l` (0 to n - 1)
    /// and magnetic quantum number `m` (-l to l).
    ///
    /// # Errors
    /// [`FieldError::Parameter`] for numbers outside these ranges.
    pub fn new(n: u32, l: u32, m: i32) -> Result<Self, FieldError> {
        let check = |good: bool, name, found: f64, expected| {
            if good { Ok(()) } else { Err(FieldError::Parameter { name, found, expected }) }
        };
        check((1..=4).contains(&n), "quantum number n", n.into(), "1 to 4")?;
        check(l < n, "quantum number l", l.into(), "0 to n - 1")?;
        check(m.unsigned_abs() <= l, "quantum number m", m.into(), "-l to l")?;
        let mut orbital = Self { n, l, m, scale: 1.0 };
        orbital.scale = 1.0 / (orbital.highest_radial() * harmonic([0.0; 3], l, m).1);
        Ok(orbital)
    }

    fn formula<N: Number>(&self, p: [N; 3]) -> N {
        (harmonic(p, self.l, self.m).0 * self.decay(length(p)) * self.scale).square()
    }

    /// The radial part without the factor r^l, which the solid harmonic brings.
    fn decay<N: Number>(&self, r: N) -> N {
        let x = r * (2.0 / f64::from(self.n));
        let (degree, order) = (self.n - self.l - 1, f64::from(2 * self.l + 1));
        // (k + 1) L_{k+1} = (2 k + 1 + order - x) L_k - (k + order) L_{k-1}
        let (mut before, mut laguerre) = (N::constant(0.0), N::constant(1.0));
        for k in 0..degree {
            let k = f64::from(k);
            let next = ((-x + (2.0 * k + 1.0 + order)) * laguerre - before * (k + order)) * (1.0 / (k + 1.0));
            (before, laguerre) = (laguerre, next);
        }
        laguerre * (x * -0.5).exp()
    }

    /// The highest |r^l decay(r)|: the best of many radii, refined by golden-section search.
    fn highest_radial(&self) -> f64 {
        let radial = |r: f64| (r.powi(self.l as i32) * self.decay(r)).abs();
        let step = 0.01;
        let count = (self.half_width() / step) as usize;
        let best = (0..=count).map(|i| i as f64 * step).max_by(|a, b| radial(*a).total_cmp(&radial(*b)));
        let best = best.unwrap_or(0.0);
        let (mut low, mut high) = ((best - step).max(0.0), best + step);
        while high - low > 1e-9 {
            let (a, b) = (high - 0.618 * (high - low), low + 0.618 * (high - low));
            if radial(a) > radial(b) { high = b } else { low = a }
        }
        radial(low).max(radial(best))
    }

    /// Half the side of the box: beyond it the density is below 1e-3 of its peak.
    fn half_width(&self) -> f64 {
        let n = f64::from(self.n);
        n * (2.0 * n + 2.0)
    }
}

/// The real solid harmonic of degree `l`, without normalisation, and the highest absolute value it
/// has on the unit sphere.
fn harmonic<N: Number>([x, y, z]: [N; 3], l: u32, m: i32) -> (N, f64) {
    let (xx, yy, zz) = (x.square(), y.square(), z.square());
    match (l, m) {
        (0, _) => (N::constant(1.0), 1.0),
        (1, -1) => (y, 1.0),
        (1, 0) => (z, 1.0),
        (1, _) => (x, 1.0),
        (2, -2) => (x * y, 0.5),
        (2, -1) => (y * z, 0.5),
        (2, 0) => (zz * 2.0 - xx - yy, 2.0),
        (2, 1) => (x * z, 0.5),
        (2, _) => (xx - yy, 1.0),
        (_, -3) => (y * (xx * 3.0 - yy), 1.0),
        (_, -2) => (x * y * z, 1.0 / 27f64.sqrt()),
        // Highest where the polar angle has cos^2 = 11/15: sin (5 cos^2 - 1) = (8/3) sqrt(4/15).
        (_, -1) => (y * (zz * 4.0 - xx - yy), 8.0 / 3.0 * (4.0f64 / 15.0).sqrt()),
        (_, 0) => (z * (zz * 2.0 - (xx + yy) * 3.0), 2.0),
        (_, 1) => (x * (zz * 4.0 - xx - yy), 8.0 / 3.0 * (4.0f64 / 15.0).sqrt()),
        (_, 2) => (z * (xx - yy), 2.0 / 27f64.sqrt()),
        _ => (x * (xx - yy * 3.0), 1.0),
    }
}

impl ScalarField for Hydrogen {
    value_and_gradient!();

    fn bounds(&self) -> (DVec3, DVec3) {
        (DVec3::splat(-self.half_width()), DVec3::splat(self.half_width()))
    }

    fn range(&self) -> (f64, f64) {
        (0.0, 1.0)
    }

    fn about(&self) -> About {
        About {
            name: NAME,
            description: "probability density of the electron in an orbital of hydrogen, relative to its peak",
            dims: [128; 3],
            voxel_type: VoxelType::F32,
            value_unit: None,
            length_unit: Some("a0"),
            whole_units: false,
        }
    }
}
