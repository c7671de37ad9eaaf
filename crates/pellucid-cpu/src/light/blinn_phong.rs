//! Local reflection (5.4).

use pellucid_optics::{GradientWeight, Material};

use super::gradient::{Slope, ramp};
use super::lights::{Arrivals, Arrived};
use super::shading::Shading;
use super::unlit::Unlit;
use crate::lanes::*;

/// The model of Blinn and Phong: the vectors' form of [`blinn_phong`](pellucid_optics::blinn_phong), which defines it.
pub struct BlinnPhong {
    /// How it reflects.
    pub material: Material,
    /// Gradient magnitudes between which unlit turns into lit.
    pub weight: Option<GradientWeight>,
    /// Radiance from all around.
    pub ambient: f32,
}

/// The light that leaves a surface: factors of its own colour, and highlights.
pub struct Reflected<S: Lanes> {
    pub diffuse: [F32<S>; 3],
    pub specular: [F32<S>; 3],
}

impl BlinnPhong {
    /// What is sent in the dark.
    pub fn unlit(&self) -> f32 {
        self.material.emission + self.material.ambient * self.ambient
    }

    /// Unit normals of what reflects.
    #[inline(always)]
    pub fn normal<S: Lanes>(&self, s: S, slope: &Slope<S>, to_eye: &Vec3<S>) -> Vec3<S> {
        let normal = slope.normal;
        if !self.material.two_sided {
            return normal;
        }
        let away = dot::<S>(normal, *to_eye).simd_lt(splat(s, 0.0));
        xyz!(I => away.select(-normal[I], normal[I]))
    }

    /// Adds the light that is reflected of one.
    #[inline(always)]
    pub fn reflect<S: Lanes>(&self, s: S, reflected: &mut Reflected<S>, light: &Arrived<S>, normal: &Vec3<S>) {
        let (material, zero) = (&self.material, splat(s, 0.0));
        // Also 0 for the normal 0: light is reflected at boundaries only.
        let facing = dot::<S>(*normal, light.to_light).max(zero);
        let diffuse = facing * material.diffuse;
        reflected.diffuse = xyz!(C => diffuse.mul_add(light.radiance[C], reflected.diffuse[C]));
        if light.specular && material.specular > 0.0 {
            let tilt = dot::<S>(*normal, light.halfway).max(zero).min(splat(s, 1.0));
            let highlight = power(s, tilt, splat(s, material.shininess)) * material.specular;
            // No highlight on the side away from the light.
            let highlight = facing.simd_gt(zero).select(highlight, zero);
            reflected.specular = xyz!(C => highlight.mul_add(light.radiance[C], reflected.specular[C]));
        }
    }
}

impl<S: Lanes> Shading<S> for BlinnPhong {
    #[inline(always)]
    fn has_surface(&self, _: S, _: &Unlit<S>) -> bool {
        true
    }

    #[inline(always)]
    fn weighs_gradients(&self) -> bool {
        self.weight.is_some()
    }

    #[inline(always)]
    fn along(&self, _: S, _: F32<S>) -> Option<[F32<S>; 3]> {
        None
    }

    #[inline(always)]
    fn shade(&self, s: S, sample: &Unlit<S>, slope: &Slope<S>, _: Option<F32<S>>, lights: &Arrivals<S>) -> [F32<S>; 4] {
        let (zero, one) = (splat(s, 0.0), splat(s, 1.0));
        let normal = self.normal(s, slope, &lights.aim.to_eye);
        let mut reflected = Reflected { diffuse: [splat(s, self.unlit()); 3], specular: [zero; 3] };
        lights.each(
            s,
            #[inline(always)]
            |light| self.reflect(s, &mut reflected, light, &normal),
        );
        let Reflected { mut diffuse, mut specular } = reflected;
        if let Some(weight) = &self.weight {
            let t = ramp(s, weight, slope.magnitude);
            diffuse = xyz!(C => lerp::<S>(t, one, diffuse[C]));
            specular = xyz!(C => specular[C] * t);
        }
        sample.lit(s, diffuse, specular)
    }
}
