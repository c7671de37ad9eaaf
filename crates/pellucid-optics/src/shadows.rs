//! What a ray caster asks of lights: how their light gets to a sample, and how the sample answers.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::OpticsError;
use crate::error::checked;

/// Whether what lies between a light and a sample holds light back. Modes that light samples
/// (composite and isosurface) see it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum Shadows {
    /// It does not (default).
    #[default]
    None,
    /// A ray from every sample to every light (6.1-1): exact, and slow, as the work grows with the square of
    /// the number of steps.
    Rays(ShadowRays),
    /// The light at the points of a grid, computed once for all samples and views (6.1-2). Between the points
    /// it is interpolated, so light leaks into dark places and shadows out of them, over up to two of its
    /// cells (K-04). Isosurfaces use rays: their shadows have edges.
    Volume(ShadowVolume),
}

/// Settings of shadow rays.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ShadowRays {
    /// Distance between samples on the way to the light, in units of the smallest voxel spacing, 0.01 to 100.
    /// Default 1.
    #[schemars(range(min = 0.01, max = 100.0))]
    pub step: f64,
}

impl Default for ShadowRays {
    fn default() -> Self {
        Self { step: 1.0 }
    }
}

/// Settings of the shadow volume.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ShadowVolume {
    /// Points of the grid for each voxel and axis, 0.05 to 4: a light takes 4 bytes for each point. Default 0.5.
    #[schemars(range(min = 0.05, max = 4.0))]
    pub resolution: f64,
}

impl Default for ShadowVolume {
    fn default() -> Self {
        Self { resolution: 0.5 }
    }
}

impl Shadows {
    /// Checks every number.
    ///
    /// # Errors
    /// [`OpticsError::Parameter`] names the first that is outside its range or not finite.
    pub fn validate(&self) -> Result<(), OpticsError> {
        match self {
            Self::None => Ok(()),
            Self::Rays(ShadowRays { step }) => checked("step", *step, 0.01..=100.0, "0.01 to 100 voxel spacings"),
            Self::Volume(ShadowVolume { resolution }) => {
                checked("resolution", *resolution, 0.05..=4.0, "0.05 to 4 points for each voxel")
            }
        }
    }

    /// The name, as in a document.
    pub fn name(&self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Rays(_) => "rays",
            Self::Volume(_) => "volume",
        }
    }
}

/// How samples answer light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LightModel {
    /// As surfaces, where the volume is shaded; else they shine by themselves (default).
    #[default]
    Surface,
    /// As a cloud that scatters light once, by the volume's `scattering`: without gradients, but for the part
    /// of it that is a surface (6.0-1, K-11). What half-angle slicing does, without its indirect light.
    Scattering,
}
