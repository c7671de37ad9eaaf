//! Memory at an address per lane.
//!
//! The one place with `unsafe` code of the backend. Who calls a gather vouches for the offsets;
//! there are three callers, each of which limits them to what it owns in the line before.

use fearless_simd::prelude::*;
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
use fearless_simd::{Avx2, Avx512, Sse2};

use super::{F32, rgba, width};

/// An instruction set with what volumes need: vectors, and memory at an address per lane.
pub trait Lanes: Simd {
    /// Asks for the memory at an address, which need not be readable.
    #[inline(always)]
    fn prefetch<T>(self, address: *const T) {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: a hint that reads nothing; every processor of the architecture has it.
        unsafe {
            std::arch::x86_64::_mm_prefetch::<{ std::arch::x86_64::_MM_HINT_T0 }>(address.cast());
        }
        #[cfg(not(target_arch = "x86_64"))]
        let _ = address;
    }

    /// The 32 bits that start at `base + SCALE * offset`, for every lane.
    ///
    /// # Safety
    /// All four bytes are readable for every lane, and SCALE is 1, 2, 4 or 8.
    #[inline(always)]
    unsafe fn gather<const SCALE: i32>(self, base: *const u8, offsets: Self::i32s) -> Self::u32s {
        Self::u32s::from_fn(
            self,
            #[inline(always)]
            |lane| {
                let offset = SCALE as isize * offsets[lane] as isize;
                // SAFETY: the caller vouches for the four bytes of every lane.
                unsafe { base.wrapping_offset(offset).cast::<u32>().read_unaligned() }
            },
        )
    }

    /// The 64 bits that start at `base + SCALE * offset`, for every lane: the first 32 and the second.
    /// Costs little more than one [`gather`](Lanes::gather), because reading is what costs.
    ///
    /// # Safety
    /// All eight bytes are readable for every lane, and SCALE is 1, 2, 4 or 8.
    #[inline(always)]
    unsafe fn gather_pairs<const SCALE: i32>(self, base: *const u8, offsets: Self::i32s) -> [Self::u32s; 2] {
        // SAFETY: as the caller's.
        unsafe { [self.gather::<SCALE>(base, offsets), self.gather::<SCALE>(base.wrapping_add(4), offsets)] }
    }

    /// The four numbers from number `offset << SHIFT` on, for every lane: the first of all lanes, the
    /// second, ... A table of rows has a shift of 2. Reading rows whole and turning them costs a third
    /// of four gathers.
    ///
    /// # Safety
    /// All four numbers are readable for every lane, and `offset << SHIFT` is from 0 to below 2^32.
    #[inline(always)]
    unsafe fn gather_rows<const SHIFT: u32>(self, base: *const f32, offsets: Self::i32s) -> [Self::f32s; 4] {
        let numbers: Self::u32s = (offsets << SHIFT).bitcast();
        let mut found = [F32::<Self>::splat(self, 0.0); 4];
        for lane in 0..width::<Self>() {
            // SAFETY: the caller vouches for the row of every lane.
            let row = unsafe { base.wrapping_add(numbers[lane] as usize).cast::<[f32; 4]>().read() };
            for (channel, value) in found.iter_mut().zip(row) {
                channel[lane] = value;
            }
        }
        found
    }
}

#[cfg(target_arch = "aarch64")]
impl Lanes for fearless_simd::Neon {}
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
impl Lanes for fearless_simd::WasmSimd128 {}

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
mod x86 {
    #[cfg(target_arch = "x86")]
    use std::arch::x86::*;
    #[cfg(target_arch = "x86_64")]
    use std::arch::x86_64::*;

    use super::*;

    impl Lanes for Sse2 {
        #[inline(always)]
        unsafe fn gather_pairs<const SCALE: i32>(self, base: *const u8, offsets: Self::i32s) -> [Self::u32s; 2] {
            // SAFETY: the caller vouches for the addresses; the token for the instructions.
            unsafe {
                let pair = |lane: usize| {
                    let place = base.wrapping_offset(SCALE as isize * offsets[lane] as isize);
                    _mm_castsi128_ps(_mm_loadl_epi64(place.cast()))
                };
                let (ab, cd) = (_mm_movelh_ps(pair(0), pair(1)), _mm_movelh_ps(pair(2), pair(3)));
                let low = _mm_castps_si128(_mm_shuffle_ps::<0b10_00_10_00>(ab, cd));
                let high = _mm_castps_si128(_mm_shuffle_ps::<0b11_01_11_01>(ab, cd));
                [low.simd_into(self), high.simd_into(self)]
            }
        }

        #[inline(always)]
        unsafe fn gather_rows<const SHIFT: u32>(self, base: *const f32, offsets: Self::i32s) -> [Self::f32s; 4] {
            // SAFETY: the caller vouches for the rows; the token for the instructions.
            unsafe {
                // Unsigned: nothing is left to do to a lane's offset but to add it.
                let numbers: Self::u32s = (offsets << SHIFT).bitcast();
                let row = |lane: usize| _mm_loadu_ps(base.wrapping_add(numbers[lane] as usize));
                let (mut a, mut b, mut c, mut d) = (row(0), row(1), row(2), row(3));
                _MM_TRANSPOSE4_PS(&mut a, &mut b, &mut c, &mut d);
                [a.simd_into(self), b.simd_into(self), c.simd_into(self), d.simd_into(self)]
            }
        }
    }

    impl Lanes for Avx2 {
        #[inline(always)]
        unsafe fn gather<const SCALE: i32>(self, base: *const u8, offsets: Self::i32s) -> Self::u32s {
            // SAFETY: the caller vouches for the addresses; the token for the instructions.
            unsafe { _mm256_i32gather_epi32::<SCALE>(base.cast(), offsets.into()).simd_into(self) }
        }

        #[inline(always)]
        unsafe fn gather_pairs<const SCALE: i32>(self, base: *const u8, offsets: Self::i32s) -> [Self::u32s; 2] {
            // SAFETY: the caller vouches for the addresses; the token for the instructions.
            unsafe {
                let offsets: __m256i = offsets.into();
                let (front, back) = (_mm256_castsi256_si128(offsets), _mm256_extracti128_si256::<1>(offsets));
                let ab = _mm256_castsi256_ps(_mm256_i32gather_epi64::<SCALE>(base.cast(), front));
                let cd = _mm256_castsi256_ps(_mm256_i32gather_epi64::<SCALE>(base.cast(), back));
                // Shuffles stay within halves: lanes 0 1 4 5 2 3 6 7, which the permutation sorts.
                let low = _mm256_castps_pd(_mm256_shuffle_ps::<0b10_00_10_00>(ab, cd));
                let high = _mm256_castps_pd(_mm256_shuffle_ps::<0b11_01_11_01>(ab, cd));
                let low = _mm256_castpd_si256(_mm256_permute4x64_pd::<0b11_01_10_00>(low));
                let high = _mm256_castpd_si256(_mm256_permute4x64_pd::<0b11_01_10_00>(high));
                [low.simd_into(self), high.simd_into(self)]
            }
        }

        #[inline(always)]
        unsafe fn gather_rows<const SHIFT: u32>(self, base: *const f32, offsets: Self::i32s) -> [Self::f32s; 4] {
            // SAFETY: the caller vouches for the rows; the token for the instructions.
            unsafe {
                // Unsigned: nothing is left to do to a lane's offset but to add it.
                let numbers: Self::u32s = (offsets << SHIFT).bitcast();
                let row = |lane: usize| _mm_loadu_ps(base.wrapping_add(numbers[lane] as usize));
                // Lane i of a quarter beside lane i + 4.
                let pair = |lane: usize| _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(row(lane)), row(lane + 4));
                let (a, b, c, d) = (pair(0), pair(1), pair(2), pair(3));
                let (ab, cd) = (_mm256_unpacklo_ps(a, b), _mm256_unpacklo_ps(c, d));
                let (ab2, cd2) = (_mm256_unpackhi_ps(a, b), _mm256_unpackhi_ps(c, d));
                let (ab, cd) = (_mm256_castps_pd(ab), _mm256_castps_pd(cd));
                let (ab2, cd2) = (_mm256_castps_pd(ab2), _mm256_castps_pd(cd2));
                let found = [
                    _mm256_unpacklo_pd(ab, cd),
                    _mm256_unpackhi_pd(ab, cd),
                    _mm256_unpacklo_pd(ab2, cd2),
                    _mm256_unpackhi_pd(ab2, cd2),
                ];
                rgba!(C => _mm256_castpd_ps(found[C]).simd_into(self))
            }
        }
    }

    impl Lanes for Avx512 {
        #[inline(always)]
        unsafe fn gather<const SCALE: i32>(self, base: *const u8, offsets: Self::i32s) -> Self::u32s {
            // SAFETY: the caller vouches for the addresses; the token for the instructions.
            unsafe { _mm512_i32gather_epi32::<SCALE>(offsets.into(), base.cast()).simd_into(self) }
        }

        #[inline(always)]
        unsafe fn gather_pairs<const SCALE: i32>(self, base: *const u8, offsets: Self::i32s) -> [Self::u32s; 2] {
            // SAFETY: the caller vouches for the addresses; the token for the instructions.
            unsafe {
                let offsets: __m512i = offsets.into();
                let (front, back) = (_mm512_castsi512_si256(offsets), _mm512_extracti64x4_epi64::<1>(offsets));
                let ab = _mm512_i32gather_epi64::<SCALE>(front, base.cast());
                let cd = _mm512_i32gather_epi64::<SCALE>(back, base.cast());
                let even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
                let odd = _mm512_setr_epi32(1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31);
                let low = _mm512_permutex2var_epi32(ab, even, cd);
                let high = _mm512_permutex2var_epi32(ab, odd, cd);
                [low.simd_into(self), high.simd_into(self)]
            }
        }

        #[inline(always)]
        unsafe fn gather_rows<const SHIFT: u32>(self, base: *const f32, offsets: Self::i32s) -> [Self::f32s; 4] {
            // SAFETY: the caller vouches for the rows; the token for the instructions.
            unsafe {
                // Unsigned: nothing is left to do to a lane's offset but to add it.
                let numbers: Self::u32s = (offsets << SHIFT).bitcast();
                // Macros, as closures are compiled without the instructions where they are not inlined.
                macro_rules! row {
                    ($lane:expr) => {
                        _mm_loadu_ps(base.wrapping_add(numbers[$lane] as usize))
                    };
                }
                // Lane i of a quarter beside lanes i + 4, i + 8 and i + 12.
                macro_rules! four {
                    ($lane:expr) => {{
                        let v = _mm512_castps128_ps512(row!($lane));
                        let v = _mm512_insertf32x4::<1>(v, row!($lane + 4));
                        let v = _mm512_insertf32x4::<2>(v, row!($lane + 8));
                        _mm512_insertf32x4::<3>(v, row!($lane + 12))
                    }};
                }
                let (a, b, c, d) = (four!(0), four!(1), four!(2), four!(3));
                let (ab, cd) = (_mm512_unpacklo_ps(a, b), _mm512_unpacklo_ps(c, d));
                let (ab2, cd2) = (_mm512_unpackhi_ps(a, b), _mm512_unpackhi_ps(c, d));
                let (ab, cd) = (_mm512_castps_pd(ab), _mm512_castps_pd(cd));
                let (ab2, cd2) = (_mm512_castps_pd(ab2), _mm512_castps_pd(cd2));
                let found = [
                    _mm512_unpacklo_pd(ab, cd),
                    _mm512_unpackhi_pd(ab, cd),
                    _mm512_unpacklo_pd(ab2, cd2),
                    _mm512_unpackhi_pd(ab2, cd2),
                ];
                rgba!(C => _mm512_castpd_ps(found[C]).simd_into(self))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{InstructionSet, dispatch, width};

    #[test]
    fn every_set_reads_what_is_there() {
        let bytes: Vec<u8> = (0..1024u32).map(|i| (i * 37 % 251) as u8).collect();
        let rows: Vec<[f32; 4]> = (0..100).map(|i| [0, 1, 2, 3].map(|c| (i * 4 + c) as f32)).collect();
        fn check<S: Lanes>(s: S, bytes: &[u8], rows: &[[f32; 4]]) {
            s.vectorize(
                #[inline(always)]
                || {
                    let offsets = S::i32s::from_fn(s, |lane| (lane as i32 * 29 + 3) % 90);
                    // SAFETY: the offsets are below 90, and 2 * 90 + 4 bytes and 90 rows are there.
                    let words = unsafe { s.gather::<2>(bytes.as_ptr(), offsets) };
                    // SAFETY: as above, with eight bytes.
                    let pairs = unsafe { s.gather_pairs::<2>(bytes.as_ptr(), offsets) };
                    // SAFETY: as above.
                    let found = unsafe { s.gather_rows::<2>(rows.as_ptr().cast(), offsets) };
                    // SAFETY: as above; rows that start anywhere.
                    let shifted = unsafe { s.gather_rows::<0>(rows.as_ptr().cast(), offsets) };
                    for lane in 0..width::<S>() {
                        let at = offsets[lane] as usize;
                        let word: [u8; 4] = bytes[2 * at..2 * at + 4].try_into().unwrap();
                        let next: [u8; 4] = bytes[2 * at + 4..2 * at + 8].try_into().unwrap();
                        assert_eq!(words[lane], u32::from_ne_bytes(word));
                        assert_eq!(pairs.map(|lanes| lanes[lane]), [word, next].map(u32::from_ne_bytes));
                        assert_eq!([0, 1, 2, 3].map(|c| found[c][lane]), rows[at]);
                        let numbers = rows.as_flattened();
                        assert_eq!([0, 1, 2, 3].map(|c| shifted[c][lane]), numbers[at..at + 4]);
                    }
                },
            );
        }
        for set in InstructionSet::ALL.into_iter().filter_map(InstructionSet::resolve) {
            dispatch!(set, s => check(s, &bytes, &rows));
        }
    }
}
