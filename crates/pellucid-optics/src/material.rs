//! How a surface answers light (5.4).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::OpticsError;
use crate::error::checked;

/// Weights of the terms of local illumination (5.4-1). The classified colour is the colour of
/// the ambient and diffuse terms; highlights have the colour of the light.
///
/// To stay within what came in, keep `ambient + diffuse + specular` at or below 1 (5.4-6).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Material {
    /// Part of its own colour that the material emits, lit or not; default 0. May exceed 1.
    #[schemars(range(min = 0.0))]
    pub emission: f32,
    /// Part of the ambient light that is reflected, from 0 to 1; default 0.1. It has no physical
    /// basis and lowers contrast: fill lights serve better (5.4-2).
    #[schemars(range(min = 0.0, max = 1.0))]
    pub ambient: f32,
    /// Part of the light that is reflected evenly, from 0 to 1; default 0.6.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub diffuse: f32,
    /// Part of the light that is reflected as highlight, from 0 to 1; default 0.2.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub specular: f32,
    /// Sharpness of the highlight, the exponent of Blinn and Phong, from 1 to 1000; default 30.
    /// Its highlight is 12 degrees of tilt from centre to half brightness. The 100 of much
    /// sample code makes it 7, of the order of the noise of gradients in measured data, which
    /// then sparkle.
    #[schemars(range(min = 1.0, max = 1000.0))]
    pub shininess: f32,
    /// Whether surfaces are lit on the side that is seen, whichever way the gradient points;
    /// default true. If false, the normal is the side that light must come from.
    pub two_sided: bool,
}

impl Default for Material {
    fn default() -> Self {
        // 5.4-6, but for the shininess.
        Self { emission: 0.0, ambient: 0.1, diffuse: 0.6, specular: 0.2, shininess: 30.0, two_sided: true }
    }
}

impl Material {
    /// Checks every number.
    ///
    /// # Errors
    /// [`OpticsError::Parameter`] names the first that is outside its range or not finite.
    pub fn validate(&self) -> Result<(), OpticsError> {
        checked("material emission", self.emission as f64, 0.0..=f32::MAX as f64, "0 or more")?;
        checked("material ambient", self.ambient as f64, 0.0..=1.0, "0 to 1")?;
        checked("material diffuse", self.diffuse as f64, 0.0..=1.0, "0 to 1")?;
        checked("material specular", self.specular as f64, 0.0..=1.0, "0 to 1")?;
        checked("material shininess", self.shininess as f64, 1.0..=1000.0, "1 to 1000")
    }
}
