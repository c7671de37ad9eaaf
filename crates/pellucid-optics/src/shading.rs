//! Local illumination: from a colour, a normal and the lights to what the eye sees (5.4).

use glam::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::checked;
use crate::{Incident, Material, OpticsError};

/// The colour of a lit sample after Blinn and Phong (5.4-6), linear RGB, **not** associated: the
/// caller multiplies by the opacity, or transparent samples would glow (5.4-1).
///
/// `base` is the classified colour. `normal` is a unit vector, or zero where the gradient is:
/// light is reflected at boundaries, so there only emission and ambient light remain (5.3-1).
/// `to_eye` is a unit vector. `ambient` is the ambient light. Lights add up; none is negative.
#[inline]
pub fn blinn_phong(
    material: &Material,
    base: [f32; 3],
    normal: Vec3,
    to_eye: Vec3,
    ambient: f32,
    lights: impl IntoIterator<Item = Incident>,
) -> [f32; 3] {
    let unlit = material.emission + material.ambient * ambient;
    let mut color = base.map(|v| v * unlit);
    if normal == Vec3::ZERO || normal.is_nan() {
        return color;
    }
    let normal = if material.two_sided && normal.dot(to_eye) < 0.0 { -normal } else { normal };
    for light in lights {
        let facing = normal.dot(light.to_light);
        // No highlight either on the side away from the light.
        if facing <= 0.0 {
            continue;
        }
        let diffuse = material.diffuse * facing;
        // Halfway between light and eye; where they are opposite there is no highlight.
        let halfway = (light.to_light + to_eye).normalize_or_zero();
        let highlight = if light.specular { normal.dot(halfway).max(0.0).powf(material.shininess) } else { 0.0 };
        for channel in 0..3 {
            color[channel] += (base[channel] * diffuse + material.specular * highlight) * light.radiance[channel];
        }
    }
    color
}

/// Shading only where the gradient can be trusted: the weight of the lit colour against the
/// unlit one rises smoothly from 0 at gradient magnitude `low` to 1 at `high` (5.3-12).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GradientWeight {
    /// Up to this magnitude samples are unlit; data units per world unit, not negative.
    #[schemars(range(min = 0.0))]
    pub low: f32,
    /// From this magnitude on they are lit; above `low`.
    #[schemars(range(min = 0.0))]
    pub high: f32,
}

impl GradientWeight {
    /// Checks both numbers.
    ///
    /// # Errors
    /// [`OpticsError::Parameter`] or [`OpticsError::Interval`] unless 0 <= low < high.
    pub fn validate(&self) -> Result<(), OpticsError> {
        checked("gradient weight low", self.low as f64, 0.0..=f32::MAX as f64, "0 or more")?;
        crate::transfer_function::ascending("gradient weight", [self.low as f64, self.high as f64])
    }

    /// The weight of the lit colour, from 0 to 1; 0 where the magnitude is absent.
    #[inline]
    pub fn weight(&self, magnitude: f32) -> f32 {
        if magnitude.is_nan() {
            return 0.0;
        }
        let t = ((magnitude - self.low) / (self.high - self.low)).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    }

    /// The lit and the unlit colour mixed by the weight.
    #[inline]
    pub fn mix(&self, magnitude: f32, unlit: [f32; 3], lit: [f32; 3]) -> [f32; 3] {
        let weight = self.weight(magnitude);
        std::array::from_fn(|channel| unlit[channel] + (lit[channel] - unlit[channel]) * weight)
    }
}
