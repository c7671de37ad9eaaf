//! Where samples are in the light's picture (6.1-5).

use pellucid_plan::half_angle::LightFrame;

use crate::lanes::*;

/// The vectors' half of a [`LightFrame`].
pub trait Project<S: Lanes> {
    /// Where index positions are in the picture, in texels, and texels per world unit across the light there.
    fn texels(&self, s: S, index: &Vec3<S>) -> [[F32<S>; 2]; 2];

    /// World distances from a light that is somewhere, at index positions.
    fn distance(&self, s: S, index: &Vec3<S>) -> F32<S>;
}

impl<S: Lanes> Project<S> for LightFrame {
    #[inline(always)]
    fn texels(&self, s: S, index: &Vec3<S>) -> [[F32<S>; 2]; 2] {
        let [x, y, depth] = xyz!(I => {
            let [a, b, c, d] = self.rows[I];
            index[0].mul_add(splat(s, a), index[1].mul_add(splat(s, b), index[2].mul_add(splat(s, c), splat(s, d))))
        });
        let density = [splat(s, self.texel.x.recip() as f32), splat(s, self.texel.y.recip() as f32)];
        if self.is_directional {
            return [[x, y], density];
        }
        let inverse = splat(s, 1.0) / depth;
        [[x * inverse, y * inverse], [density[0] * inverse, density[1] * inverse]]
    }

    #[inline(always)]
    fn distance(&self, s: S, index: &Vec3<S>) -> F32<S> {
        let [place, _] = self.texels(s, index);
        let [a, b, c, d] = self.rows[2];
        let depth =
            index[0].mul_add(splat(s, a), index[1].mul_add(splat(s, b), index[2].mul_add(splat(s, c), splat(s, d))));
        let (low, texel) = (self.low.as_vec2(), self.texel.as_vec2());
        let u = place[0].mul_add(splat(s, texel.x), splat(s, low.x));
        let v = place[1].mul_add(splat(s, texel.y), splat(s, low.y));
        depth * u.mul_add(u, v.mul_add(v, splat(s, 1.0))).sqrt()
    }
}
