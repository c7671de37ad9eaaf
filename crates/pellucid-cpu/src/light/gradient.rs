//! Gradients as shading sees them: where a surface faces, and how much of one there is (5.3).

use pellucid_optics::GradientWeight;

use crate::lanes::*;

/// The surface that samples are part of.
pub struct Slope<S: Lanes> {
    /// Unit normals out of it, towards lower values; zero where there is none.
    pub normal: Vec3<S>,
    /// Lengths of the gradients.
    pub magnitude: F32<S>,
}

impl<S: Lanes> Slope<S> {
    /// Of gradients.
    #[inline(always)]
    pub fn new(s: S, gradient: Vec3<S>) -> Self {
        let (normal, magnitude) = normals(s, gradient);
        Self { normal, magnitude }
    }

    /// None.
    #[inline(always)]
    pub fn none(s: S) -> Self {
        Self { normal: [splat(s, 0.0); 3], magnitude: splat(s, 0.0) }
    }
}

/// Unit normals out of the surface, towards lower values, and the lengths of the gradients. Zero
/// where there is no gradient, so that lighting vanishes there instead of turning into NaN (5.3-1).
#[inline(always)]
pub fn normals<S: Lanes>(s: S, gradient: Vec3<S>) -> (Vec3<S>, F32<S>) {
    let squared = dot::<S>(gradient, gradient);
    // Squares of very short and very long gradients leave the range of numbers.
    let plain = squared.simd_gt(splat(s, 1e-30)) & squared.simd_lt(splat(s, 1e30));
    let length = plain.select(squared, splat(s, 1.0)).sqrt();
    let inverse = splat(s, -1.0) / length;
    let normal = xyz!(I => plain.select(gradient[I] * inverse, splat(s, 0.0)));
    if plain.all_true() {
        return (normal, length);
    }
    let largest = gradient[0].abs().max(gradient[1].abs()).max(gradient[2].abs());
    let usable = !plain & largest.simd_ge(splat(s, f32::MIN_POSITIVE)) & largest.is_finite();
    let scale = usable.select(largest, splat(s, 1.0));
    let scaled = xyz!(I => gradient[I] / scale);
    let scaled_length = usable.select(dot::<S>(scaled, scaled), splat(s, 1.0)).sqrt();
    let normal = xyz!(I => usable.select(-scaled[I] / scaled_length, normal[I]));
    let zero = splat(s, 0.0);
    (normal, plain.select(length, usable.select(scaled_length * largest, zero)))
}

/// A vector of the same direction and length 1; zero if it has none.
#[inline(always)]
pub fn normalized<S: Lanes>(s: S, v: Vec3<S>) -> Vec3<S> {
    let squared = dot::<S>(v, v);
    let usable = squared.simd_gt(splat(s, 1e-24));
    let inverse = splat(s, 1.0) / usable.select(squared, splat(s, 1.0)).sqrt();
    xyz!(I => usable.select(v[I] * inverse, splat(s, 0.0)))
}

/// The weight of a gradient magnitude: the vectors' form of [`GradientWeight::weight`].
#[inline(always)]
pub fn ramp<S: Lanes>(s: S, weight: &GradientWeight, magnitude: F32<S>) -> F32<S> {
    let t = (magnitude - weight.low) * (1.0 / (weight.high - weight.low));
    let t = t.max(splat(s, 0.0)).min(splat(s, 1.0));
    t * t * (splat(s, 3.0) - t * 2.0)
}
