//! Harmonics turned.

use glam::{DMat3, DQuat};

use super::bands::{MOST_BANDS, MOST_COEFFICIENTS};

/// Orders of the last band.
const MOST_ORDERS: usize = 2 * MOST_BANDS - 1;

/// The matrix of a band, by order of the row and of the column, each plus the degree.
type Block = [[f64; MOST_ORDERS]; MOST_ORDERS];

/// A rotation of functions on directions: each band turns into itself, by a matrix that follows from the one before it
/// (J. Ivanic and K. Ruedenberg 1996 with their correction of 1998; Wyman et al. 2006, appendix, whose table 3 has slips
/// in u, w, V and W that are mended here: with them the matrices are not orthogonal).
#[derive(Clone, Debug, PartialEq)]
pub struct Rotation([Block; MOST_BANDS]);

impl Rotation {
    /// The rotation that takes a function f to the one that has at `rotation * direction` what f has at `direction`.
    pub fn new(rotation: DQuat) -> Self {
        let matrix = DMat3::from_quat(rotation.normalize());
        // Orders -1, 0 and 1 are y, z and x.
        let axis = |order: i32| [1, 2, 0][(order + 1) as usize];
        let first = |a: i32, b: i32| matrix.col(axis(b))[axis(a)];
        let mut blocks = [[[0.0; MOST_ORDERS]; MOST_ORDERS]; MOST_BANDS];
        blocks[0][0][0] = 1.0;
        for l in 1..MOST_BANDS as i32 {
            let last = Last { degree: l - 1, block: &blocks[l as usize - 1], first };
            let mut block = [[0.0; MOST_ORDERS]; MOST_ORDERS];
            for s in -l..=l {
                for t in -l..=l {
                    let entry = if l == 1 { first(s, t) } else { last.next(s, t) };
                    block[(s + l) as usize][(t + l) as usize] = entry;
                }
            }
            blocks[l as usize] = block;
        }
        Self(blocks)
    }

    /// Coefficients of the turned function, of several channels.
    pub fn rotate<const CHANNELS: usize>(
        &self,
        coefficients: &[[f64; CHANNELS]; MOST_COEFFICIENTS],
    ) -> [[f64; CHANNELS]; MOST_COEFFICIENTS] {
        std::array::from_fn(|i| {
            let l = i.isqrt();
            let band = &coefficients[l * l..(l + 1) * (l + 1)];
            let row = &self.0[l][i - l * l];
            std::array::from_fn(|channel| row.iter().zip(band).map(|(entry, from)| entry * from[channel]).sum())
        })
    }
}

/// A band whose matrix is known, and the matrix of band 1, by orders.
struct Last<'a, F> {
    degree: i32,
    block: &'a Block,
    first: F,
}

impl<F: Fn(i32, i32) -> f64> Last<'_, F> {
    fn entry(&self, s: i32, t: i32) -> f64 {
        self.block[(s + self.degree) as usize][(t + self.degree) as usize]
    }

    /// The entry in the matrix of the next band: u U + v V + w W.
    fn next(&self, s: i32, t: i32) -> f64 {
        let l = self.degree + 1;
        let across = s.abs();
        let divisor = f64::from(if t.abs() < l { (l + t) * (l - t) } else { 2 * l * (2 * l - 1) });
        let scale = |product: i32| (f64::from(product) / divisor).sqrt();
        let u = scale((l + s) * (l - s));
        let v = 0.5 * if s == 0 { -scale(2 * (l - 1) * l) } else { scale((l + across - 1) * (l + across)) };
        let w = if s == 0 { 0.0 } else { -0.5 * scale((l - across - 1) * (l - across)) };
        // Where a factor is 0 its term asks for entries that the smaller matrix lacks.
        let term = |factor: f64, value: &dyn Fn() -> f64| if factor == 0.0 { 0.0 } else { factor * value() };
        term(u, &|| self.product(0, s, t)) + term(v, &|| self.inner(s, t)) + term(w, &|| self.outer(s, t))
    }

    /// V, of rows nearer to the middle.
    fn inner(&self, s: i32, t: i32) -> f64 {
        let p = |a, s| self.product(a, s, t);
        let root = std::f64::consts::SQRT_2;
        match s {
            0 => p(1, 1) + p(-1, -1),
            1 => p(1, 0) * root,
            -1 => p(-1, 0) * root,
            2.. => p(1, s - 1) - p(-1, 1 - s),
            _ => p(1, s + 1) + p(-1, -s - 1),
        }
    }

    /// W, of rows farther from the middle.
    fn outer(&self, s: i32, t: i32) -> f64 {
        let p = |a, s| self.product(a, s, t);
        if s > 0 { p(1, s + 1) + p(-1, -s - 1) } else { p(1, s - 1) - p(-1, 1 - s) }
    }

    /// P: a row of band 1 by a row of this band.
    fn product(&self, a: i32, s: i32, t: i32) -> f64 {
        let l = self.degree + 1;
        let first = |t| (self.first)(a, t);
        if t == l {
            first(1) * self.entry(s, l - 1) - first(-1) * self.entry(s, 1 - l)
        } else if t == -l {
            first(1) * self.entry(s, 1 - l) + first(-1) * self.entry(s, l - 1)
        } else {
            first(0) * self.entry(s, t)
        }
    }
}
