//! Cubics: what trilinear interpolation is along a piece of a ray between two planes of voxels (5.5-8, G-03).

use crate::lanes::*;

/// What is known of a field on pieces of rays.
pub struct Course<S: Lanes> {
    /// Where it passes a range of values, or may: nothing else is known of other pieces.
    pub passes: Mask<S>,
    /// How it does.
    pub cubic: Cubic<S>,
    /// Any of its values, on whichever side of the range the others are; no number where it is absent.
    pub value: F32<S>,
}

/// Coefficients of cubics in the part of the way on a piece of a ray; lowest first.
pub struct Cubic<S: Lanes>(pub [F32<S>; 4]);

impl<S: Lanes> Cubic<S> {
    /// Through four values, at 0, 1, 2 and 3: Newton's differences, and from them the powers.
    #[inline(always)]
    pub fn through(values: [F32<S>; 4]) -> Self {
        let differences = xyz!(I => values[I + 1] - values[I]);
        let seconds = [differences[1] - differences[0], differences[2] - differences[1]];
        let cubed = (seconds[1] - seconds[0]) * (1.0 / 6.0);
        let squared = seconds[0] * 0.5 - cubed * 3.0;
        Self([values[0], differences[0] - squared - cubed, squared, cubed])
    }

    /// The values at a place.
    #[inline(always)]
    pub fn at(&self, t: F32<S>) -> F32<S> {
        let [c0, c1, c2, c3] = self.0;
        c3.mul_add(t, c2).mul_add(t, c1).mul_add(t, c0)
    }

    /// Where the slopes `c1 + 2 c2 t + 3 c3 t^2` are 0, in no order; no number or an infinite one where there is no such
    /// place.
    #[inline(always)]
    pub fn turns(&self, s: S) -> [F32<S>; 2] {
        let [_, c1, c2, c3] = self.0;
        let root = c2.mul_add(c2, c3 * c1 * -3.0).sqrt();
        let sum = c2.simd_lt(splat(s, 0.0)).select(root - c2, -root - c2);
        [sum / (c3 * 3.0), c1 / sum]
    }

    /// The same in another measure of the way: of `u`, where places are `slope u + shift`.
    #[inline(always)]
    pub fn measured(&self, s: S, slope: f32, shift: f32) -> Self {
        let [_, c1, c2, c3] = self.0;
        let bent = c2 + c3 * (3.0 * shift);
        let slant = c1 + (c2 * 2.0 + c3 * (3.0 * shift)) * shift;
        Self([self.at(splat(s, shift)), slant * slope, bent * slope.powi(2), c3 * slope.powi(3)])
    }
}
