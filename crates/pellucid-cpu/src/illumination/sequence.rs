//! Numbers for paths of light, that fill the square more evenly than random ones would: Sobol' points, scrambled after Owen by
//! hashes (Burley 2020). They belong to a place and a number of a path, whoever asks for them and when.

use glam::Vec2;

/// The numbers of all paths from a place.
#[derive(Clone, Copy, Debug)]
pub struct Sequence(u32);

impl Sequence {
    /// Those of a place, by a number of its own.
    pub fn new(place: u64) -> Self {
        Self(hashed(place as u32 ^ hashed((place >> 32) as u32)))
    }

    /// Two numbers in 0..1 for a choice that a path makes: the first 2^n paths have them in any 2^n equal parts of the
    /// square, once each.
    #[inline]
    pub fn pair(self, path: u32, choice: u32) -> Vec2 {
        let seed = hashed(self.0.wrapping_add(choice.wrapping_mul(0x9e37_79b9)));
        let number = scrambled(path, seed);
        let [x, y] = sobol(number);
        let unit = |bits: u32| (bits >> 8) as f32 * (1.0 / (1 << 24) as f32);
        Vec2::new(unit(scrambled(x, hashed(seed ^ 1))), unit(scrambled(y, hashed(seed ^ 2))))
    }
}

/// The first two dimensions of a Sobol' point: binary digits backwards, of the number and of its product with Pascal's
/// triangle modulo 2.
fn sobol(number: u32) -> [u32; 2] {
    let mut product = number;
    for (shift, mask) in [(1, 0xaaaa_aaaa), (2, 0xcccc_cccc), (4, 0xf0f0_f0f0), (8, 0xff00_ff00), (16, 0xffff_0000_u32)]
    {
        product ^= (product & mask) >> shift;
    }
    [number.reverse_bits(), product.reverse_bits()]
}

/// Owen's scrambling: digits are changed by what stands before them alone (Laine and Karras 2011, with Burley's constants).
fn scrambled(digits: u32, seed: u32) -> u32 {
    let mut x = digits.reverse_bits().wrapping_add(seed);
    for factor in [0x6c50_b47c, 0xb82f_1e52, 0xc7af_e638, 0x8d22_f6e6_u32] {
        x ^= x.wrapping_mul(factor);
    }
    x.reverse_bits()
}

/// A number that looks like chance (Wellons' "lowbias32").
fn hashed(x: u32) -> u32 {
    let x = (x ^ x >> 16).wrapping_mul(0x21f0_aaad);
    let x = (x ^ x >> 15).wrapping_mul(0x735a_2d97);
    x ^ x >> 15
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_of_the_square_has_its_path() {
        for place in [0, 1, 1 << 40] {
            let sequence = Sequence::new(place);
            for choice in 0..3 {
                for columns in [1, 4, 16, 64] {
                    let rows = 64 / columns;
                    let mut met = [0; 64];
                    for path in 0..64 {
                        let u = sequence.pair(path, choice);
                        met[(u.y * rows as f32) as usize * columns + (u.x * columns as f32) as usize] += 1;
                    }
                    assert_eq!(met, [1; 64], "{columns} columns");
                }
            }
        }
    }

    #[test]
    fn choices_of_a_path_are_independent() {
        const PATHS: u32 = 4096;
        let sequence = Sequence::new(7);
        let product = |path| {
            let [a, b] = [0, 1].map(|choice| sequence.pair(path, choice) - 0.5);
            f64::from(a.x * b.x + a.y * b.y)
        };
        let covariance = (0..PATHS).map(product).sum::<f64>() / f64::from(PATHS);
        assert!(covariance.abs() < 4.0 / 12.0 * (2.0 / f64::from(PATHS)).sqrt(), "{covariance}");
    }
}
