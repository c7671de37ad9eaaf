//! Sums of noises for all lanes.

use pellucid_field::Noise;
use pellucid_optics::Turbulence;

use crate::lanes::*;

/// The first channels of a sum of noises at index positions, the others 0: the vectors' form of
/// [`Turbulence::at`].
#[inline(always)]
pub fn turbulence<S: Lanes, const CHANNELS: usize>(s: S, sum: &Turbulence, index: &Vec3<S>) -> [F32<S>; 4] {
    const SIZE: i32 = Noise::SIZE as i32;
    let base = sum.noise().texels().as_ptr().cast::<u8>();
    let mut found = [splat(s, 0.0); 4];
    for term in sum.terms() {
        let place = xyz!(I => index[I].mul_add(splat(s, term.scale[I]), splat(s, term.start[I])));
        let cell = xyz!(I => place[I].floor());
        let [u, v, w] = xyz!(I => place[I] - cell[I]);
        let low = xyz!(I => cell[I].to_int::<I32<S>>() & (SIZE - 1));
        let high = xyz!(I => (low[I] + 1) & (SIZE - 1));
        let (y, z) = ([low[1] * SIZE, high[1] * SIZE], [low[2] * (SIZE * SIZE), high[2] * (SIZE * SIZE)]);
        // SAFETY: every coordinate is masked to a texel, four bytes each.
        let texel = |x: I32<S>, y: I32<S>, z: I32<S>| unsafe { s.gather::<4>(base, x + y + z) };
        let words = [
            texel(low[0], y[0], z[0]),
            texel(high[0], y[0], z[0]),
            texel(low[0], y[1], z[0]),
            texel(high[0], y[1], z[0]),
            texel(low[0], y[0], z[1]),
            texel(high[0], y[0], z[1]),
            texel(low[0], y[1], z[1]),
            texel(high[0], y[1], z[1]),
        ];
        for (channel, found) in found.iter_mut().enumerate().take(CHANNELS) {
            let near = lerp::<S>(v, row(s, &words, 0, channel, u), row(s, &words, 2, channel, u));
            let far = lerp::<S>(v, row(s, &words, 4, channel, u), row(s, &words, 6, channel, u));
            let signed = lerp::<S>(w, near, far).mul_add(splat(s, 2.0 / 255.0), splat(s, -1.0));
            *found = signed.mul_add(splat(s, term.weight), *found);
        }
    }
    found
}

/// A channel between two neighbours along a row.
#[inline(always)]
fn row<S: Lanes>(_: S, words: &[<S as Simd>::u32s; 8], first: usize, channel: usize, u: F32<S>) -> F32<S> {
    let [a, b]: [I32<S>; 2] = [
        ((words[first] >> (8 * channel as u32)) & 0xff).bitcast(),
        ((words[first + 1] >> (8 * channel as u32)) & 0xff).bitcast(),
    ];
    lerp::<S>(u, a.to_float(), b.to_float())
}
