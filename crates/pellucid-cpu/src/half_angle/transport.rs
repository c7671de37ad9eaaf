//! What gets through of indirect light (K-08, 6.3-1).

use crate::classify::Lookup;
use crate::lanes::*;

/// What gets through so many steps of samples of these values.
#[inline(always)]
pub fn through<S: Lanes>(s: S, transport: &Lookup, value: F32<S>, ratio: F32<S>) -> [F32<S>; 3] {
    let [r, g, b, _] = transport.lookup(s, value);
    let (one_step, is_one) = ([r, g, b], ratio.simd_eq(splat(s, 1.0)));
    if is_one.all_true() {
        return one_step;
    }
    xyz!(C => is_one.select(one_step[C], power(s, one_step[C], ratio)))
}
