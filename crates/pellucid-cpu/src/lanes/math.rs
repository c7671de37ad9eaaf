//! The few functions of lanes that processors do not have.

use super::{F32, Lanes, splat};
use fearless_simd::prelude::*;

/// Three coordinates of every lane.
pub type Vec3<S> = [F32<S>; 3];

/// `a + u (b - a)`: exactly `a` at `u = 0`, and exactly `a` where both are equal.
#[inline(always)]
pub fn lerp<S: Lanes>(u: F32<S>, a: F32<S>, b: F32<S>) -> F32<S> {
    u.mul_add(b - a, a)
}

/// Limited to 0 to `last`, and 0 where there is no number: what addresses are made of. (The plain maximum leaves it to the
/// processor what becomes of NaN; against a constant this one costs nothing more.)
#[inline(always)]
pub fn within<S: Lanes>(s: S, x: F32<S>, last: f32) -> F32<S> {
    x.max_precise(splat(s, 0.0)).min(splat(s, last))
}

/// The scalar product.
#[inline(always)]
pub fn dot<S: Lanes>(a: Vec3<S>, b: Vec3<S>) -> F32<S> {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

/// `x^n` for x from 0 to 1 and n above 0; 0 at 0.
///
/// The relative error is below `2e-7 (1 + n)`.
#[inline(always)]
pub fn power<S: Lanes>(s: S, x: F32<S>, n: F32<S>) -> F32<S> {
    let tiny = splat(s, f32::MIN_POSITIVE);
    let result = exp2(s, n * log2(s, x.max(tiny)));
    x.simd_lt(tiny).select(splat(s, 0.0), result)
}

/// `1 - (1 - alpha)^ratio`, the opacity over `ratio` times the length, for alpha from 0 to 1 and any
/// ratio from 0 on; thin media keep their precision, as in
/// [`correct_opacity`](pellucid_optics::correct_opacity), the definition of this.
#[inline(always)]
pub fn opacity_over<S: Lanes>(s: S, alpha: F32<S>, ratio: F32<S>) -> F32<S> {
    let one = splat(s, 1.0);
    // What is opaque has no depth that a number could tell.
    alpha.simd_lt(one).select(opacity_of(s, extinction(s, alpha) * ratio), one)
}

/// `-ln(1 - alpha)`, the extinction per length that has the opacity alpha, from 0 to below 1; thin
/// media keep their precision, as in [`extinction`](pellucid_optics::extinction), the definition.
#[inline(always)]
pub fn extinction<S: Lanes>(s: S, alpha: F32<S>) -> F32<S> {
    let one = splat(s, 1.0);
    let thin = alpha.simd_lt(splat(s, 0.02));
    let series = alpha * (one + alpha * (splat(s, 0.5) + alpha * (splat(s, 1.0 / 3.0) + alpha * 0.25)));
    thin.select(series, log2(s, one - alpha) * -std::f32::consts::LN_2)
}

/// `1 - e^-depth`, the opacity of an optical depth from 0 on; thin media keep their precision.
#[inline(always)]
pub fn opacity_of<S: Lanes>(s: S, depth: F32<S>) -> F32<S> {
    let one = splat(s, 1.0);
    let thin = depth.simd_lt(splat(s, 0.1));
    let fourth = splat(s, 1.0 / 24.0) - depth * (1.0 / 120.0);
    let series = depth * (one - depth * (splat(s, 0.5) - depth * (splat(s, 1.0 / 6.0) - depth * fourth)));
    thin.select(series, one - exp2(s, depth * -std::f32::consts::LOG2_E))
}

/// Binary logarithm of positive normal numbers.
#[inline(always)]
fn log2<S: Lanes>(s: S, x: F32<S>) -> F32<S> {
    // x = 2^e m with m from sqrt(1/2) to sqrt(2).
    let bits: <S as Simd>::i32s = x.bitcast();
    let shifted = bits - 0x3f35_04f3;
    let exponent = (shifted >> 23).to_float::<F32<S>>();
    let mantissa: F32<S> = ((shifted & 0x007f_ffff) + 0x3f35_04f3).bitcast();
    // log2 m = 2 / ln 2 * artanh z, z = (m - 1) / (m + 1), an odd series in |z| < 0.172.
    let z = (mantissa - 1.0) / (mantissa + 1.0);
    let z2 = z * z;
    let p = z2.mul_add(splat(s, 0.320_598_9), splat(s, 0.412_198_57));
    let p = z2.mul_add(p, splat(s, 0.577_078_04));
    let p = z2.mul_add(p, splat(s, 0.961_796_7));
    let p = z2.mul_add(p, splat(s, 2.885_39));
    z.mul_add(p, exponent)
}

/// `2^x` for x up to 0 (a power of a number from 0 to 1); 0 below -126.
#[inline(always)]
fn exp2<S: Lanes>(s: S, x: F32<S>) -> F32<S> {
    let x = x.max(splat(s, -126.0));
    let whole = x.floor();
    let u = x - whole;
    // Taylor series of 2^u about 1/2, up to u^6: the remainder is below 1e-8.
    let v = (u - 0.5) * std::f32::consts::LN_2;
    let p = v.mul_add(splat(s, 1.0 / 720.0), splat(s, 1.0 / 120.0));
    let p = v.mul_add(p, splat(s, 1.0 / 24.0));
    let p = v.mul_add(p, splat(s, 1.0 / 6.0));
    let p = v.mul_add(p, splat(s, 0.5));
    let p = v.mul_add(p, splat(s, 1.0));
    let p = v.mul_add(p, splat(s, 1.0)) * std::f32::consts::SQRT_2;
    let scale: F32<S> = ((whole.to_int::<<S as Simd>::i32s>() + 127) << 23).bitcast();
    p * scale
}

#[cfg(test)]
mod tests {
    use pellucid_optics::correct_opacity;

    use super::*;
    use crate::lanes::{InstructionSet, dispatch};

    fn evaluate<S: Lanes>(s: S, x: f32, n: f32, opacity: bool) -> f32 {
        let (x, n) = (splat(s, x), splat(s, n));
        if opacity { opacity_over(s, x, n)[0] } else { power(s, x, n)[0] }
    }

    fn each_set(check: impl Fn(&dyn Fn(f32, f32, bool) -> f32, InstructionSet)) {
        for set in InstructionSet::ALL.into_iter().filter_map(InstructionSet::resolve) {
            check(&|x, n, opacity| dispatch!(set, s => evaluate(s, x, n, opacity)), set);
        }
    }

    #[test]
    fn addresses_are_within_limits_whatever_they_are_made_of() {
        fn limits<S: Lanes>(s: S, x: f32) -> f32 {
            within(s, splat(s, x), 7.5)[0]
        }
        let signs = [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 3.25, 8.0, -0.0];
        for set in InstructionSet::ALL.into_iter().filter_map(InstructionSet::resolve) {
            let found = signs.map(|x| dispatch!(set, s => limits(s, x)));
            assert_eq!(found, [0.0, 0.0, 7.5, 0.0, 0.0, 3.25, 7.5, 0.0], "{set}");
        }
    }

    #[test]
    fn powers_are_precise() {
        each_set(|function, set| {
            assert_eq!(function(0.0, 20.0, false), 0.0);
            for i in 1..=400 {
                let x = i as f32 / 400.0;
                for n in [0.01f32, 0.5, 1.0, 2.0, 20.0, 100.0, 1000.0] {
                    let exact = f64::from(x).powf(f64::from(n));
                    let error = (f64::from(function(x, n, false)) - exact).abs();
                    let bound = 2e-7 * (1.0 + f64::from(n)) * exact + 1e-37;
                    assert!(error <= bound, "{set}: {x}^{n} is off by {error}");
                }
            }
        });
    }

    #[test]
    fn opacities_have_their_depths() {
        fn there_and_back<S: Lanes>(s: S, alpha: f32) -> f32 {
            opacity_of(s, extinction(s, splat(s, alpha)))[0]
        }
        for set in InstructionSet::ALL.into_iter().filter_map(InstructionSet::resolve) {
            for i in 0..=400 {
                let alpha = (i as f32 / 400.0).powi(3);
                let found = dispatch!(set, s => there_and_back(s, alpha));
                assert!((found - alpha).abs() <= 2e-7 + 1e-6 * alpha, "{set}: {found}, exact {alpha}");
            }
        }
    }

    #[test]
    fn opacity_correction_is_the_definition() {
        each_set(|function, set| {
            for i in 0..=400 {
                let alpha = (i as f32 / 400.0).powi(3);
                for ratio in [0.001f32, 0.1, 0.3, 0.5, 0.9, 0.999, 1.4, 4.0, 50.0, 1e4] {
                    let (found, exact) = (function(alpha, ratio, true), correct_opacity(alpha, ratio));
                    assert!(
                        (found - exact).abs() <= 1e-6 * exact.max(0.3),
                        "{set}: {alpha} over {ratio}: {found} {exact}"
                    );
                    assert!(alpha > 0.01 || (found - exact).abs() <= 1e-6 * exact, "{set}: {alpha} over {ratio}");
                }
            }
        });
    }
}
