//! Integers of 32 bits, read like `f32`.

use pellucid_field::Volume;

use super::voxel::thirty_two_bit_quad;
use super::{Quad, Texel};
use crate::lanes::*;

/// Whether the numbers of a volume may be rounded to `f32` before they are blended: they are below
/// 2^24 and exact, or the rounding is a millionth of what they span, which is also what rounding the
/// blend costs. A narrow span far from 0 would lose its slopes.
pub fn fits(volume: &Volume) -> bool {
    let (statistics, map) = (volume.statistics(), volume.value_map());
    let (a, b) = (map.stored(statistics.min), map.stored(statistics.max));
    let largest = a.abs().max(b.abs());
    largest <= f64::from(1u32 << 24) || largest <= 16.0 * (a - b).abs()
}

impl Texel for u32 {
    const OVERREAD: usize = 0;

    #[inline(always)]
    unsafe fn pair<S: Lanes>(s: S, data: &[Self], offset: I32<S>, d: i32, _: bool) -> [F32<S>; 2] {
        // SAFETY: the caller vouches for two voxels.
        let [a, b] = unsafe { s.gather_pairs::<4>(data.as_ptr().offset(d as isize).cast(), offset) };
        [a.to_float(), b.to_float()]
    }

    #[inline(always)]
    unsafe fn quad<S: Lanes>(s: S, data: &[Self], offset: I32<S>, d: i32, at_end: bool) -> Quad<S> {
        // SAFETY: as the caller's.
        unsafe { thirty_two_bit_quad(s, data, offset, d, at_end) }
    }

    #[inline(always)]
    fn numbers<S: Lanes>(_: S, quad: &Quad<S>) -> [F32<S>; 4] {
        rgba!(N => quad[N].to_float())
    }
}

impl Texel for i32 {
    const OVERREAD: usize = 0;

    #[inline(always)]
    unsafe fn pair<S: Lanes>(s: S, data: &[Self], offset: I32<S>, d: i32, _: bool) -> [F32<S>; 2] {
        // SAFETY: the caller vouches for two voxels.
        let [a, b] = unsafe { s.gather_pairs::<4>(data.as_ptr().offset(d as isize).cast(), offset) };
        [a.bitcast::<I32<S>>().to_float(), b.bitcast::<I32<S>>().to_float()]
    }

    #[inline(always)]
    unsafe fn quad<S: Lanes>(s: S, data: &[Self], offset: I32<S>, d: i32, at_end: bool) -> Quad<S> {
        // SAFETY: as the caller's.
        unsafe { thirty_two_bit_quad(s, data, offset, d, at_end) }
    }

    #[inline(always)]
    fn numbers<S: Lanes>(_: S, quad: &Quad<S>) -> [F32<S>; 4] {
        rgba!(N => quad[N].bitcast::<I32<S>>().to_float())
    }
}
