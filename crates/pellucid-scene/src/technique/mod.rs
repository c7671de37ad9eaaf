//! Which technique draws, and its settings.

use pellucid_optics::{Environment, Lighting};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Look;
use crate::check::Checked;

mod half_angle;
mod illumination;
mod mode;
mod names;
mod needs;
mod path_trace;
mod ray_cast;
mod settings;
mod slicing;

pub use half_angle::{BlurJitter, BlurScaling, HalfAngle, InScatter, LightCorrection};
pub use illumination::{
    GlobalIllumination, HarmonicTransfer, HarmonicWindow, Illumination, IlluminationBasis, IlluminationInterpolation,
    IlluminationMethod, PlacesOn, SurfaceNormals,
};
pub use mode::{Combine, Isosurface, Isovalue, Mode, Slice, SurfaceSearch};
pub use names::{Likeness, TECHNIQUES};
pub use needs::{LightPath, Needs};
pub use path_trace::{Majorants, PathTrace};
pub use ray_cast::RayCast;
use settings::Settings;
pub use slicing::{BlendOrder, ColorWeight, Correction, Proxy, SliceGeometry, SliceTarget, Slicing};

/// The technique that draws the scene.
// There will be others: a backend says of one that it does not know that it lacks it.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum Technique {
    /// One ray per pixel through the volume (chapter 7).
    RayCast(RayCast),
    /// Slices through the volume, blended in their order (chapter 3). On graphics processors only.
    Slicing(Slicing),
    /// Slices halfway between light and eye, through which light travels (section 6.3).
    HalfAngle(HalfAngle),
    /// Random paths of light through the volume, with all their scatterings: what other techniques
    /// approximate.
    PathTrace(PathTrace),
}

impl Default for Technique {
    fn default() -> Self {
        Self::RayCast(RayCast::default())
    }
}

impl Technique {
    fn settings(&self) -> &dyn Settings {
        match self {
            Self::RayCast(settings) => settings,
            Self::Slicing(settings) => settings,
            Self::HalfAngle(settings) => settings,
            Self::PathTrace(settings) => settings,
        }
    }

    fn settings_mut(&mut self) -> &mut dyn Settings {
        match self {
            Self::RayCast(settings) => settings,
            Self::Slicing(settings) => settings,
            Self::HalfAngle(settings) => settings,
            Self::PathTrace(settings) => settings,
        }
    }

    /// The name of the technique, as in a document.
    pub fn name(&self) -> &'static str {
        self.settings().name()
    }

    /// What it asks of a scene.
    pub fn needs(&self) -> Needs {
        self.settings().needs()
    }

    /// What becomes of the samples.
    pub fn mode(&self) -> &Mode {
        self.settings().mode()
    }

    /// What becomes of the samples, to be changed; `None` if the technique has no choice.
    pub fn mode_mut(&mut self) -> Option<&mut Mode> {
        self.settings_mut().mode_mut()
    }

    /// What shines from around, where the technique knows of it.
    pub fn environment(&self) -> Option<&Environment> {
        self.settings().environment()
    }

    /// The same, to be changed.
    pub fn environment_mut(&mut self) -> Option<&mut Environment> {
        self.settings_mut().environment_mut()
    }

    /// The technique of the same kind, and with the same kind of mode, with all settings at their defaults.
    pub fn plain(&self) -> Self {
        self.settings().plain()
    }

    /// Settings of its own, by their names, that change nothing as the others are, with the reason.
    pub fn idle(&self) -> Vec<(&'static str, &'static str)> {
        self.settings().idle()
    }

    pub(crate) fn light_by(&mut self, look: Look, lighting: &mut Lighting) {
        self.settings_mut().light_by(look, lighting);
    }

    pub(crate) fn check(&self, path: &str) -> Checked {
        let path = format!("{path}.{}", self.name());
        self.settings().check(&path)?;
        self.mode().check(&format!("{path}.mode"))
    }

    /// The settings of slices, if those draw.
    pub fn slicing(&self) -> Option<&Slicing> {
        match self {
            Self::Slicing(settings) => Some(settings),
            _ => None,
        }
    }

    /// The settings of half-angle slicing, if that draws.
    pub fn half_angle(&self) -> Option<&HalfAngle> {
        match self {
            Self::HalfAngle(settings) => Some(settings),
            _ => None,
        }
    }

    /// The settings of the path tracer, if that draws.
    pub fn path_trace(&self) -> Option<&PathTrace> {
        match self {
            Self::PathTrace(settings) => Some(settings),
            _ => None,
        }
    }

    /// The ray caster with the same mode.
    pub fn along_rays(&self) -> Self {
        Self::RayCast(RayCast { mode: self.mode().clone() })
    }

    /// Slices of a geometry with the same mode, and the other settings of slices as they are.
    pub fn in_slices(&self, geometry: SliceGeometry) -> Self {
        let as_they_are = || Slicing { mode: self.mode().clone(), ..Slicing::default() };
        Self::Slicing(Slicing { geometry, ..self.slicing().cloned().unwrap_or_else(as_they_are) })
    }

    /// Half-angle slicing, with its settings if it is that.
    pub fn by_half_angles(&self) -> Self {
        Self::HalfAngle(self.half_angle().cloned().unwrap_or_default())
    }

    /// The path tracer, with its settings if it is one.
    pub fn by_paths(&self) -> Self {
        Self::PathTrace(self.path_trace().cloned().unwrap_or_default())
    }
}
