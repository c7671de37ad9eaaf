//! Voxels of every type, read for all lanes at once and turned into `f32`.

use half::f16;
use pellucid_field::Voxel;

use crate::lanes::*;

/// A voxel type that is read with vectors.
pub trait Texel: Voxel {
    /// How many voxels beyond a pair are read with it.
    const OVERREAD: usize;

    /// The voxels at `offset + d` and the one after, for every lane. If `at_end`, some of them may
    /// have fewer than [`Texel::OVERREAD`] voxels behind.
    ///
    /// # Safety
    /// Both are in the data, of which there are at least 4, and unless `at_end` so are
    /// [`Texel::OVERREAD`] voxels more.
    unsafe fn pair<S: Lanes>(s: S, data: &[Self], offset: I32<S>, d: i32, at_end: bool) -> [F32<S>; 2];

    /// The voxels from `offset + d - 1` to `offset + d + 2`, for every lane, as they are stored;
    /// anything for those before the first and after the last of the data.
    ///
    /// # Safety
    /// `offset + d` and the one after are in the data, of which there are at least 4, and unless
    /// `at_end` so are all four.
    unsafe fn quad<S: Lanes>(s: S, data: &[Self], offset: I32<S>, d: i32, at_end: bool) -> Quad<S>;

    /// The numbers of a quad.
    fn numbers<S: Lanes>(s: S, quad: &Quad<S>) -> [F32<S>; 4];
}

/// Four neighbours along x as they are stored, in as many of the words as they take.
pub type Quad<S> = [<S as Simd>::u32s; 4];

/// The four bytes from `offset + d` on. If `at_end`, those after the last byte of the data are 0,
/// as is the one before the first.
///
/// # Safety
/// `offset + d + 1` and the byte after are in the data, of which there are at least 4, and unless
/// `at_end` so are all four.
#[inline(always)]
unsafe fn bytes<S: Lanes, T>(s: S, data: &[T], offset: I32<S>, d: i32, at_end: bool) -> <S as Simd>::u32s {
    if !at_end {
        // SAFETY: as the caller's. (The base alone may lie before the data, so it must wrap.)
        return unsafe { s.gather::<1>(data.as_ptr().cast::<u8>().wrapping_offset(d as isize), offset) };
    }
    let zero = whole(s, 0);
    let wanted = offset + d;
    let there = wanted.max(zero).min(whole(s, data.len() as i32 - 4));
    // SAFETY: moved into the data.
    let words = unsafe { s.gather::<1>(data.as_ptr().cast(), there) };
    let (late, early) = ((wanted - there).max(zero) << 3, (there - wanted).max(zero) << 3);
    (words >> late.bitcast::<<S as Simd>::u32s>()) << early.bitcast::<<S as Simd>::u32s>()
}

/// Byte `n` of every word as a number.
#[inline(always)]
fn byte<S: Lanes>(words: <S as Simd>::u32s, n: u32) -> F32<S> {
    let words: I32<S> = (words >> (8 * n)).bitcast();
    (words & 0xff).to_float()
}

/// Byte `n` of every word as a signed number.
#[inline(always)]
fn signed_byte<S: Lanes>(words: <S as Simd>::u32s, n: u32) -> F32<S> {
    let words: I32<S> = (words << (24 - 8 * n)).bitcast();
    (words >> 24).to_float()
}

impl Texel for u8 {
    const OVERREAD: usize = 2;

    #[inline(always)]
    unsafe fn pair<S: Lanes>(s: S, data: &[Self], offset: I32<S>, d: i32, at_end: bool) -> [F32<S>; 2] {
        // SAFETY: as the caller's.
        let words = unsafe { bytes(s, data, offset, d, at_end) };
        [byte::<S>(words, 0), byte::<S>(words, 1)]
    }

    #[inline(always)]
    unsafe fn quad<S: Lanes>(s: S, data: &[Self], offset: I32<S>, d: i32, at_end: bool) -> Quad<S> {
        // SAFETY: as the caller's.
        [unsafe { bytes(s, data, offset, d - 1, at_end) }; 4]
    }

    #[inline(always)]
    fn numbers<S: Lanes>(_: S, quad: &Quad<S>) -> [F32<S>; 4] {
        rgba!(N => byte::<S>(quad[0], N as u32))
    }
}

impl Texel for i8 {
    const OVERREAD: usize = 2;

    #[inline(always)]
    unsafe fn pair<S: Lanes>(s: S, data: &[Self], offset: I32<S>, d: i32, at_end: bool) -> [F32<S>; 2] {
        // SAFETY: as the caller's.
        let words = unsafe { bytes(s, data, offset, d, at_end) };
        [signed_byte::<S>(words, 0), signed_byte::<S>(words, 1)]
    }

    #[inline(always)]
    unsafe fn quad<S: Lanes>(s: S, data: &[Self], offset: I32<S>, d: i32, at_end: bool) -> Quad<S> {
        // SAFETY: as the caller's.
        [unsafe { bytes(s, data, offset, d - 1, at_end) }; 4]
    }

    #[inline(always)]
    fn numbers<S: Lanes>(_: S, quad: &Quad<S>) -> [F32<S>; 4] {
        rgba!(N => signed_byte::<S>(quad[0], N as u32))
    }
}

/// The voxels of 16 bits from `offset + d - 1` to `offset + d + 2`, two to a word; anything for those
/// before the first and after the last of the data.
///
/// # Safety
/// As [`Texel::quad`].
#[inline(always)]
unsafe fn sixteen_bit_quad<S: Lanes, T>(
    s: S,
    data: &[T],
    offset: I32<S>,
    d: i32,
    at_end: bool,
) -> [<S as Simd>::u32s; 2] {
    if !at_end {
        // SAFETY: the caller vouches for four voxels.
        return unsafe { s.gather_pairs::<2>(data.as_ptr().wrapping_offset(d as isize - 1).cast(), offset) };
    }
    let wanted = offset + (d - 1);
    let there = wanted.max(whole(s, 0)).min(whole(s, data.len() as i32 - 4));
    // SAFETY: moved into the data.
    let [a, b] = unsafe { s.gather_pairs::<2>(data.as_ptr().cast(), there) };
    // One voxel on if the row ends before the last, one back if it starts after the first.
    let (late, early) = (wanted.simd_gt(there), wanted.simd_lt(there));
    let shifted = late.select((a >> 16) | (b << 16), early.select(a << 16, a));
    [shifted, late.select(b >> 16, early.select((a >> 16) | (b << 16), b))]
}

/// The voxels of 32 bits from `offset + d - 1` to `offset + d + 2`; anything for those before the first
/// and after the last of the data.
///
/// # Safety
/// As [`Texel::quad`].
#[inline(always)]
pub(super) unsafe fn thirty_two_bit_quad<S: Lanes, T>(
    s: S,
    data: &[T],
    offset: I32<S>,
    d: i32,
    at_end: bool,
) -> Quad<S> {
    if !at_end {
        // SAFETY: the caller vouches for four voxels, so `offset` is not negative.
        let row = unsafe { s.gather_rows::<0>(data.as_ptr().cast::<f32>().wrapping_offset(d as isize - 1), offset) };
        return rgba!(N => row[N].bitcast());
    }
    let wanted = offset + (d - 1);
    let there = wanted.max(whole(s, 0)).min(whole(s, data.len() as i32 - 4));
    // SAFETY: moved into the data.
    let row = unsafe { s.gather_rows::<0>(data.as_ptr().cast::<f32>(), there) };
    // One voxel on if the row ends before the last, one back if it starts after the first.
    let (late, early) = (wanted.simd_gt(there), wanted.simd_lt(there));
    let [a, b, c, d] = row;
    let moved = [
        early.select(a, late.select(b, a)),
        early.select(a, late.select(c, b)),
        early.select(b, late.select(d, c)),
        early.select(c, d),
    ];
    rgba!(N => moved[N].bitcast())
}

/// The low and the high half of words as numbers.
#[inline(always)]
fn unsigned_words<S: Lanes>(_: S, words: <S as Simd>::u32s) -> [F32<S>; 2] {
    // Shifted as unsigned words: a signed shift would smear large values.
    let (low, high): (I32<S>, I32<S>) = ((words & 0xffff).bitcast(), (words >> 16).bitcast());
    [low.to_float(), high.to_float()]
}

/// The low and the high half of words as signed numbers.
#[inline(always)]
fn signed_words<S: Lanes>(_: S, words: <S as Simd>::u32s) -> [F32<S>; 2] {
    let words: I32<S> = words.bitcast();
    [((words << 16) >> 16).to_float(), (words >> 16).to_float()]
}

/// The low and the high half of words as half-precision numbers.
#[inline(always)]
fn half_words<S: Lanes>(s: S, words: <S as Simd>::u32s) -> [F32<S>; 2] {
    let words: I32<S> = words.bitcast();
    [half_to_single(s, words & 0xffff), half_to_single(s, (words >> 16) & 0xffff)]
}

impl Texel for u16 {
    const OVERREAD: usize = 0;

    #[inline(always)]
    unsafe fn pair<S: Lanes>(s: S, data: &[Self], offset: I32<S>, d: i32, _: bool) -> [F32<S>; 2] {
        // SAFETY: the caller vouches for two voxels.
        let words = unsafe { s.gather::<2>(data.as_ptr().offset(d as isize).cast(), offset) };
        unsigned_words(s, words)
    }

    #[inline(always)]
    unsafe fn quad<S: Lanes>(s: S, data: &[Self], offset: I32<S>, d: i32, at_end: bool) -> Quad<S> {
        // SAFETY: the caller vouches for four voxels unless at the end.
        let [a, b] = unsafe { sixteen_bit_quad(s, data, offset, d, at_end) };
        [a, b, a, b]
    }

    #[inline(always)]
    fn numbers<S: Lanes>(s: S, quad: &Quad<S>) -> [F32<S>; 4] {
        let ([a, b], [c, d]) = (unsigned_words(s, quad[0]), unsigned_words(s, quad[1]));
        [a, b, c, d]
    }
}

impl Texel for i16 {
    const OVERREAD: usize = 0;

    #[inline(always)]
    unsafe fn pair<S: Lanes>(s: S, data: &[Self], offset: I32<S>, d: i32, _: bool) -> [F32<S>; 2] {
        // SAFETY: the caller vouches for two voxels.
        let words = unsafe { s.gather::<2>(data.as_ptr().offset(d as isize).cast(), offset) };
        signed_words(s, words)
    }

    #[inline(always)]
    unsafe fn quad<S: Lanes>(s: S, data: &[Self], offset: I32<S>, d: i32, at_end: bool) -> Quad<S> {
        // SAFETY: the caller vouches for four voxels unless at the end.
        let [a, b] = unsafe { sixteen_bit_quad(s, data, offset, d, at_end) };
        [a, b, a, b]
    }

    #[inline(always)]
    fn numbers<S: Lanes>(s: S, quad: &Quad<S>) -> [F32<S>; 4] {
        let ([a, b], [c, d]) = (signed_words(s, quad[0]), signed_words(s, quad[1]));
        [a, b, c, d]
    }
}

impl Texel for f16 {
    const OVERREAD: usize = 0;

    #[inline(always)]
    unsafe fn pair<S: Lanes>(s: S, data: &[Self], offset: I32<S>, d: i32, _: bool) -> [F32<S>; 2] {
        // SAFETY: the caller vouches for two voxels.
        let words = unsafe { s.gather::<2>(data.as_ptr().offset(d as isize).cast(), offset) };
        half_words(s, words)
    }

    #[inline(always)]
    unsafe fn quad<S: Lanes>(s: S, data: &[Self], offset: I32<S>, d: i32, at_end: bool) -> Quad<S> {
        // SAFETY: the caller vouches for four voxels unless at the end.
        let [a, b] = unsafe { sixteen_bit_quad(s, data, offset, d, at_end) };
        [a, b, a, b]
    }

    #[inline(always)]
    fn numbers<S: Lanes>(s: S, quad: &Quad<S>) -> [F32<S>; 4] {
        let ([a, b], [c, d]) = (half_words(s, quad[0]), half_words(s, quad[1]));
        [a, b, c, d]
    }
}

/// Half precision from the low 16 bits of every lane; what is not finite stays so.
#[inline(always)]
fn half_to_single<S: Lanes>(s: S, bits: I32<S>) -> F32<S> {
    // Exponent and mantissa move to their place; the product sets the exponent right, also for
    // numbers too small to be normal.
    let magnitude: F32<S> = ((bits & 0x7fff) << 13).bitcast();
    let magnitude = magnitude * f32::from_bits(0x7780_0000);
    let magnitude = magnitude.simd_ge(splat(s, 65536.0)).select(splat(s, f32::INFINITY), magnitude);
    let sign: I32<S> = (bits & 0x8000) << 16;
    let with_sign: I32<S> = magnitude.bitcast::<I32<S>>() | sign;
    with_sign.bitcast()
}

impl Texel for f32 {
    const OVERREAD: usize = 0;

    #[inline(always)]
    unsafe fn pair<S: Lanes>(s: S, data: &[Self], offset: I32<S>, d: i32, _: bool) -> [F32<S>; 2] {
        // SAFETY: the caller vouches for two voxels.
        let [a, b] = unsafe { s.gather_pairs::<4>(data.as_ptr().offset(d as isize).cast(), offset) };
        [a.bitcast(), b.bitcast()]
    }

    #[inline(always)]
    unsafe fn quad<S: Lanes>(s: S, data: &[Self], offset: I32<S>, d: i32, at_end: bool) -> Quad<S> {
        // SAFETY: as the caller's.
        unsafe { thirty_two_bit_quad(s, data, offset, d, at_end) }
    }

    #[inline(always)]
    fn numbers<S: Lanes>(_: S, quad: &Quad<S>) -> [F32<S>; 4] {
        rgba!(N => quad[N].bitcast())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{InstructionSet, dispatch};

    /// Every quad of the data, those at its ends too, whose voxels outside may be anything.
    fn check<S: Lanes, T: Texel>(s: S, data: &[T]) {
        s.vectorize(
            #[inline(always)]
            || {
                for first in 0..data.len() as i32 - 1 {
                    let last = data.len() as i32 - 2;
                    let offset = I32::<S>::from_fn(s, |lane| (first + lane as i32).min(last));
                    let inside = first > 0 && (first + width::<S>() as i32) < last;
                    // SAFETY: a voxel and the next are there; and four, unless said to be at the end.
                    let quad = unsafe { T::quad(s, data, offset - 1, 1, !inside) };
                    let found = T::numbers(s, &quad);
                    for lane in 0..width::<S>() {
                        for (n, numbers) in found.iter().enumerate() {
                            let at = offset[lane] + n as i32 - 1;
                            if let Some(voxel) = usize::try_from(at).ok().and_then(|at| data.get(at)) {
                                assert_eq!(numbers[lane], voxel.to_f32(), "voxel {at} of {}", data.len());
                            }
                        }
                    }
                }
            },
        );
    }

    /// Numbers over the whole range of every type: what is read with the wrong sign is seen.
    #[test]
    fn quads_are_the_voxels_around() {
        let shares = |n: usize| (0..n).map(|i| (i * 37 % 101) as f64 / 100.0);
        fn spread<T: Voxel>(shares: impl Iterator<Item = f64>, low: f64, high: f64) -> Vec<T> {
            shares.map(|share| T::from_f64((low + share * (high - low)).round())).collect()
        }
        for set in InstructionSet::ALL.into_iter().filter_map(InstructionSet::resolve) {
            for n in [4, 5, 40] {
                dispatch!(set, s => {
                    check(s, &spread::<u8>(shares(n), 0.0, 255.0));
                    check(s, &spread::<i8>(shares(n), -128.0, 127.0));
                    check(s, &spread::<u16>(shares(n), 0.0, 65535.0));
                    check(s, &spread::<i16>(shares(n), -32768.0, 32767.0));
                    check(s, &spread::<u32>(shares(n), 0.0, f64::from(u32::MAX)));
                    check(s, &spread::<i32>(shares(n), f64::from(i32::MIN), f64::from(i32::MAX)));
                    check(s, &spread::<f16>(shares(n), -30000.0, 30000.0));
                    check(s, &spread::<f32>(shares(n), -1e6, 1e6));
                });
            }
        }
    }
}
