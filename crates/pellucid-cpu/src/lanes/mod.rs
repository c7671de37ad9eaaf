//! Rays side by side: native vectors of `f32`, one lane a ray.
//!
//! Everything that runs per sample is written once, generic over [`Lanes`], and compiled for every
//! instruction set (`level`). The vectors and their arithmetic are `fearless_simd`'s; what volumes
//! need besides, reading memory at an address per lane, is `gather`.

mod gather;
mod level;
mod math;

pub use fearless_simd::prelude::*;
pub use gather::Lanes;
pub use level::InstructionSet;
pub(crate) use level::{baseline, dispatch};
pub use math::{Vec3, dot, extinction, lerp, opacity_of, opacity_over, power, within};

/// An array of three, from an expression of the index. Not a closure: what runs on lanes has to be
/// compiled into the function whose instruction set is switched on, and closures of library
/// functions are not.
macro_rules! xyz {
    ($i:ident => $value:expr) => {
        [
            {
                const $i: usize = 0;
                $value
            },
            {
                const $i: usize = 1;
                $value
            },
            {
                const $i: usize = 2;
                $value
            },
        ]
    };
}
pub(crate) use xyz;

/// An array of four, from an expression of the index; see [`xyz`].
macro_rules! rgba {
    ($i:ident => $value:expr) => {
        [
            {
                const $i: usize = 0;
                $value
            },
            {
                const $i: usize = 1;
                $value
            },
            {
                const $i: usize = 2;
                $value
            },
            {
                const $i: usize = 3;
                $value
            },
        ]
    };
}
pub(crate) use rgba;

/// Lanes of numbers.
pub type F32<S> = <S as Simd>::f32s;
/// Lanes of whole numbers.
pub type I32<S> = <S as Simd>::i32s;
/// Lanes of yes and no.
pub type Mask<S> = <S as Simd>::mask32s;

/// The most lanes there are.
pub const MOST_LANES: usize = 16;

/// How many lanes an instruction set has: the number of rays that are followed at once.
pub const fn width<S: Simd>() -> usize {
    <S::f32s as SimdBase<S>>::LEN
}

/// The first lanes of an array.
#[inline(always)]
pub fn load<S: Simd>(s: S, values: &[f32; MOST_LANES]) -> F32<S> {
    F32::<S>::from_slice(s, &values[..width::<S>()])
}

/// Writes lanes to the front of an array.
#[inline(always)]
pub fn store<S: Simd>(lanes: F32<S>, values: &mut [f32; MOST_LANES]) {
    lanes.store_slice(&mut values[..width::<S>()]);
}

/// Writes four numbers of every lane side by side, lane after lane.
#[inline(always)]
pub fn store_rows<S: Lanes>(s: S, numbers: [F32<S>; 4], to: &mut [f32]) {
    let mut columns = [[0.0; MOST_LANES]; 4];
    for (lanes, column) in numbers.into_iter().zip(&mut columns) {
        store::<S>(lanes, column);
    }
    for (block, rows) in to.chunks_exact_mut(16).enumerate() {
        let four = rgba!(C => fearless_simd::f32x4::from_slice(s, &columns[C][4 * block..][..4]));
        SimdInterleaved::store_four_interleaved(four, rows);
    }
}

/// The same number in all lanes.
#[inline(always)]
pub fn splat<S: Simd>(s: S, value: f32) -> F32<S> {
    F32::<S>::splat(s, value)
}

/// The same whole number in all lanes.
#[inline(always)]
pub fn whole<S: Simd>(s: S, value: i32) -> I32<S> {
    I32::<S>::splat(s, value)
}

/// The same answer in all lanes.
#[inline(always)]
pub fn all<S: Simd>(s: S, value: bool) -> Mask<S> {
    <Mask<S> as SimdMask<S>>::splat(s, value)
}

/// The number of lanes that say yes.
#[inline(always)]
pub fn count<S: Simd>(mask: Mask<S>) -> u64 {
    u64::from(mask.to_bitmask().count_ones())
}
