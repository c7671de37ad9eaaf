//! What gets through of indirect light (K-08, 6.3-1).

use crate::classify::Lookup;
use crate::lanes::*;

/// What gets through so many steps of samples of these values.
#[inline(always)]
pub fn transmittance<S: Lanes>(s: S, transport: &Lookup, value: F32<S>, ratio: F32<S>) -> [F32<S>; 3] {
    let [r, g, b, _] = transport.lookup(s, value);
    let one_step = [r, g, b];
    xyz!(C => over(s, one_step[C], ratio))
}

/// What gets through `ratio` times the length that `through` is for.
#[inline(always)]
pub fn over<S: Lanes>(s: S, transmittance: F32<S>, ratio: F32<S>) -> F32<S> {
    let is_one = ratio.simd_eq(splat(s, 1.0));
    if is_one.all_true() { transmittance } else { is_one.select(transmittance, power(s, transmittance, ratio)) }
}
