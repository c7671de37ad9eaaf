//! 8-bit sRGB codes of linear light without a power per channel.

use std::sync::LazyLock;

use pellucid_optics::srgb_encode;

/// Bins around equidistant numbers of 0..=1. The curve is steepest at 0, 12.92 * 255 codes per unit: a bin of this
/// width meets at most one change of code.
const BINS: u16 = 4096;

/// The code that begins each bin, and the smallest light of every code: together they decide as
/// the formula, rounded, does.
pub struct Srgb8 {
    starts: [u8; BINS as usize + 1],
    /// `[c]` is the smallest light with a code above `c`.
    ends: [f32; 256],
}

/// Made at its first use.
pub static SRGB8: LazyLock<Srgb8> = LazyLock::new(Srgb8::new);

/// The code by its definition, for light of 0 to 1.
fn by_formula(light: f32) -> u8 {
    (srgb_encode(light) * 255.0).round() as u8
}

impl Srgb8 {
    fn new() -> Self {
        let begin = |bin: usize| (bin as f32 - 0.5) / f32::from(BINS);
        let starts = std::array::from_fn(|bin| by_formula(begin(bin).max(0.0)));
        let ends = std::array::from_fn(|code| first_above(code as u8));
        Self { starts, ends }
    }

    /// The code of linear light, clamped to 0..=1; NaN is black.
    #[inline(always)]
    pub fn code(&self, light: f32) -> u8 {
        let light = part(light);
        let start = self.starts[nearest(light * f32::from(BINS)) as usize];
        start + u8::from(light >= self.ends[usize::from(start)])
    }
}

/// The smallest light whose code is above `code`: bits of positive floats are ordered as they are.
fn first_above(code: u8) -> f32 {
    if code == u8::MAX {
        return f32::INFINITY;
    }
    let (mut below, mut above) = (0, 1f32.to_bits());
    while above - below > 1 {
        let middle = below + (above - below) / 2;
        if by_formula(f32::from_bits(middle)) > code { above = middle } else { below = middle }
    }
    f32::from_bits(above)
}

/// The number as a part of 0 to 1; NaN is 0.
#[inline(always)]
pub fn part(v: f32) -> f32 {
    if v > 0.0 { v.min(1.0) } else { 0.0 }
}

/// The nearest whole number of a number of 0 to 65535, halves up. `f32::round` and casts are calls
/// and branches on the oldest processors; this becomes a few instructions for several numbers.
#[inline(always)]
pub fn nearest(v: f32) -> u32 {
    /// From here on floats have no fractions: a sum is rounded, halves to even.
    const WHOLE: f32 = (1 << 23) as f32;
    let sum = v + WHOLE;
    let low_bits = sum.to_bits() - WHOLE.to_bits();
    low_bits + u32::from(v - (sum - WHOLE) >= 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_decides_as_the_formula_does() {
        // A dense sweep, every bin's border, and the numbers next to every change of code.
        let sweep = (0..=2_000_000).map(|k| k as f32 / 2e6);
        let borders = (0..BINS).flat_map(|bin| {
            let border = (f32::from(bin) + 0.5) / f32::from(BINS);
            [border.next_down(), border, border.next_up()]
        });
        let changes = SRGB8.ends[..255].iter().flat_map(|end| {
            let bits = end.to_bits();
            (bits - 64..bits + 64).map(f32::from_bits)
        });
        for light in sweep.chain(borders).chain(changes) {
            assert_eq!(SRGB8.code(light), by_formula(light), "{light:e}");
        }
    }

    #[test]
    fn light_out_of_range_is_clamped() {
        for (light, code) in [(-1.0, 0), (-0.0, 0), (f32::NAN, 0), (1.5, 255), (f32::INFINITY, 255)] {
            assert_eq!(SRGB8.code(light), code, "{light}");
        }
    }

    #[test]
    fn nearest_rounds_as_the_standard_library_does() {
        let halves = (0..65535u16).flat_map(|k| {
            let half = f32::from(k) + 0.5;
            [half.next_down(), half, half.next_up()]
        });
        for v in halves.chain((0..1_000_000).map(|k| k as f32 * 0.06553)) {
            assert_eq!(nearest(v), v.round() as u32, "{v}");
        }
        assert_eq!([f32::NAN, -1.0, -0.0, 2.0, 0.25].map(part), [0.0, 0.0, 0.0, 1.0, 0.25]);
    }
}
