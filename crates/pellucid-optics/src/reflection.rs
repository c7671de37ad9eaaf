//! A lit surface as paths of light meet it: [`blinn_phong`] as a distribution of directions.

use std::f32::consts::PI;

use glam::Vec3;

use crate::{Incident, Material, blinn_phong, turned};

/// A point of a surface and who looks at it. The light it reflects is that of [`blinn_phong`], without
/// emission and ambient light, which are not reflected from anywhere.
#[derive(Clone, Copy, Debug)]
pub struct Reflection {
    material: Material,
    base: [f32; 3],
    normal: Vec3,
    to_eye: Vec3,
    /// The chance that a direction is chosen for the diffuse part.
    diffuse_share: f32,
}

impl Reflection {
    /// A surface of a classified colour, seen from `to_eye`; both vectors are unit vectors. `None` where
    /// nothing is reflected: without a normal, and behind surfaces of one side.
    pub fn new(material: &Material, base: [f32; 3], normal: Vec3, to_eye: Vec3) -> Option<Self> {
        let facing = normal.dot(to_eye);
        if normal == Vec3::ZERO || !facing.is_finite() || (facing < 0.0 && !material.two_sided) {
            return None;
        }
        // The whole of the highlight if the surface is seen head-on: 8 / (s + 2).
        let specular = material.specular * (8.0 / (material.shininess + 2.0)).min(1.0);
        let whole = material.diffuse + specular;
        (whole > 0.0).then(|| Self {
            material: Material { emission: 0.0, ambient: 0.0, ..*material },
            base,
            normal: if facing < 0.0 { -normal } else { normal },
            to_eye,
            diffuse_share: material.diffuse / whole,
        })
    }

    /// The side of the surface that is seen: a unit vector.
    pub fn normal(&self) -> Vec3 {
        self.normal
    }

    /// What is seen of a light.
    #[inline]
    pub fn light(&self, light: Incident) -> [f32; 3] {
        blinn_phong(&self.material, self.base, self.normal, self.to_eye, 0.0, [light])
    }

    /// The share of the light from a direction that is seen, per steradian, with the cosine at the
    /// surface. A light of radiance 1 brings pi units of light, hence the factor.
    #[inline]
    pub fn eval(&self, direction: Vec3) -> [f32; 3] {
        self.light(Incident { to_light: direction, radiance: [1.0 / PI; 3], specular: true })
    }

    /// The density per steradian of [`sample`](Self::sample), of those directions where
    /// [`eval`](Self::eval) may be something: its integral is 1, or less if highlights are broad.
    #[inline]
    pub fn pdf(&self, direction: Vec3) -> f32 {
        let diffuse = self.normal.dot(direction).max(0.0) / PI;
        let halfway = (direction + self.to_eye).normalize_or_zero();
        let (tilt, seen) = (self.normal.dot(halfway).max(0.0), self.to_eye.dot(halfway));
        let exponent = self.material.shininess;
        // Directions lie four times as densely around their own middle as halves around theirs.
        let specular =
            if seen > 0.0 { (exponent + 1.0) / (2.0 * PI) * tilt.powf(exponent) / (4.0 * seen) } else { 0.0 };
        self.diffuse_share * diffuse + (1.0 - self.diffuse_share) * specular
    }

    /// A direction that light is likely to come from, from three numbers in 0..1. It may lead into the
    /// surface, where [`eval`](Self::eval) is nothing.
    #[inline]
    pub fn sample(&self, choice: f32, u: [f32; 2]) -> Vec3 {
        if choice < self.diffuse_share {
            return turned(self.normal, (1.0 - u[0]).sqrt(), u[1]);
        }
        let halfway = turned(self.normal, (1.0 - u[0]).powf(1.0 / (self.material.shininess + 1.0)), u[1]);
        let seen = self.to_eye.dot(halfway);
        // What is turned away from the eye reflects nothing.
        if seen > 0.0 { (halfway * (2.0 * seen) - self.to_eye).normalize() } else { -self.normal }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mean over evenly spread numbers.
    fn mean(f: impl Fn(f32, [f32; 2]) -> f64) -> f64 {
        const SIDE: usize = 120;
        let at = |k: usize| (k as f32 + 0.5) / SIDE as f32;
        let all = (0..SIDE.pow(3)).map(|k| f(at(k % SIDE), [at(k / SIDE % SIDE), at(k / SIDE / SIDE)]));
        all.sum::<f64>() / SIDE.pow(3) as f64
    }

    #[test]
    fn directions_are_as_frequent_as_they_claim() {
        for (diffuse, specular, shininess) in [(0.6, 0.2, 30.0), (0.0, 1.0, 4.0), (1.0, 0.0, 30.0)] {
            let material = Material { diffuse, specular, shininess, ..Material::default() };
            let to_eye = Vec3::new(0.3, -0.2, 0.8).normalize();
            let surface = Reflection::new(&material, [0.5; 3], Vec3::Z, to_eye).unwrap();
            let sphere = |f: &dyn Fn(Vec3) -> f32| {
                4.0 * std::f64::consts::PI * mean(|a, [b, c]| f64::from(f(turned(Vec3::X, 2.0 * b - 1.0, c + a))))
            };
            let density = sphere(&|direction| surface.pdf(direction));
            assert!(density < 1.002 && (density > 0.998 || shininess < 30.0), "{shininess}: {density}");
            // What is reflected of an even light, both ways.
            let whole = sphere(&|direction| surface.eval(direction)[1]);
            let sampled = mean(|choice, u| {
                let direction = surface.sample(choice, u);
                let density = surface.pdf(direction);
                if density > 0.0 { f64::from(surface.eval(direction)[1] / density) } else { 0.0 }
            });
            assert!((whole - sampled).abs() < 5e-3, "{whole} and {sampled}");
        }
    }

    #[test]
    fn nothing_is_reflected_without_a_normal_or_behind_a_surface_of_one_side() {
        let material = Material::default();
        let one_sided = Material { two_sided: false, ..material };
        assert!(Reflection::new(&material, [1.0; 3], Vec3::ZERO, Vec3::Z).is_none());
        assert!(Reflection::new(&material, [1.0; 3], -Vec3::Z, Vec3::Z).is_some());
        assert!(Reflection::new(&one_sided, [1.0; 3], -Vec3::Z, Vec3::Z).is_none());
        let dark = Material { diffuse: 0.0, specular: 0.0, ..material };
        assert!(Reflection::new(&dark, [1.0; 3], Vec3::Z, Vec3::Z).is_none());
    }
}
