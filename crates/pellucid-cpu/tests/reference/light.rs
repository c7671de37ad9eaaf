//! Blinn and Phong's answer to all lights (5.4-6).

use glam::DVec3;

use super::Reference;

impl Reference<'_> {
    /// [`lit`](Self::lit), and how much of it rounding of the gradient decides.
    pub fn lit_and_doubt(
        &self,
        base: [f64; 3],
        world: DVec3,
        value: f64,
        gradient: DVec3,
        to_eye: DVec3,
    ) -> [[f64; 3]; 2] {
        let lit = self.lit(base, world, gradient, to_eye);
        let mut doubt = [0.0f64; 3];
        if self.staged.material.is_some() {
            for other in self.field.doubtful_gradients(self.field.index(world), value, gradient) {
                let other = self.lit(base, world, other, to_eye);
                (0..3).for_each(|channel| doubt[channel] = doubt[channel].max((other[channel] - lit[channel]).abs()));
            }
        }
        [lit, doubt]
    }

    /// A colour as it is lit at a point of the world where the field has this gradient; what it is
    /// without a material.
    pub fn lit(&self, base: [f64; 3], world: DVec3, gradient: DVec3, to_eye: DVec3) -> [f64; 3] {
        let Some(material) = &self.staged.material else { return base };
        let [diffuse, specular, shininess] = [material.diffuse, material.specular, material.shininess].map(f64::from);
        let normal = -gradient.try_normalize().unwrap_or(DVec3::ZERO);
        let normal = if material.two_sided && normal.dot(to_eye) < 0.0 { -normal } else { normal };
        let unlit = f64::from(material.emission) + f64::from(material.ambient) * f64::from(self.stage.ambient);
        let mut lit = base.map(|c| c * unlit);
        for light in &self.stage.lights {
            let light = light.incident(world.as_vec3());
            let to_light = light.to_light.as_dvec3();
            let facing = normal.dot(to_light);
            // Nothing is reflected on the side away from the light, nor where there is no boundary.
            if facing <= 0.0 {
                continue;
            }
            let halfway = (to_light + to_eye).normalize_or_zero();
            let tilt = if light.specular { normal.dot(halfway).max(0.0) } else { 0.0 };
            for channel in 0..3 {
                let reflected = base[channel] * diffuse * facing + specular * tilt.powf(shininess);
                lit[channel] += reflected * f64::from(light.radiance[channel]);
            }
        }
        let Some(weight) = self.staged.gradient_weight else { return lit };
        let [low, high] = [weight.low, weight.high].map(f64::from);
        let t = ((gradient.length() - low) / (high - low)).clamp(0.0, 1.0);
        let t = t * t * (3.0 - 2.0 * t);
        [0, 1, 2].map(|channel| base[channel] * (1.0 - t) + lit[channel] * t)
    }
}
