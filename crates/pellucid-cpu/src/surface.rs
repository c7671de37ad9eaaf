//! Local light at a sample (5.4).

use glam::DVec3;
use pellucid_optics::{GradientWeight, Material, ResolvedLight, blinn_phong};

/// A unit normal out of the surface, towards lower values; zero where there is no gradient, so that
/// lighting vanishes there instead of turning into NaN (5.3-1).
pub fn normal(gradient: DVec3) -> DVec3 {
    -pellucid_field::normal(gradient, 0.0)
}

/// Material and lights of a volume.
pub struct Surface<'a> {
    /// How it reflects.
    pub material: &'a Material,
    /// Gradient magnitudes between which unlit turns into lit.
    pub weight: Option<GradientWeight>,
    /// World-frame lights.
    pub lights: &'a [ResolvedLight],
    /// Light from everywhere.
    pub ambient: f32,
}

impl Surface<'_> {
    /// The lit colour (not associated) of a sample at a world position.
    pub fn shade(&self, base: [f32; 3], point: DVec3, gradient: DVec3, to_eye: DVec3) -> [f32; 3] {
        let at = point.as_vec3();
        let lights = self.lights.iter().map(|light| light.incident(at));
        let lit = blinn_phong(self.material, base, normal(gradient).as_vec3(), to_eye.as_vec3(), self.ambient, lights);
        self.weight.map_or(lit, |weight| weight.mix(gradient.length() as f32, base, lit))
    }
}
