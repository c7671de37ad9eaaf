//! Which technique draws, and its settings.

use pellucid_optics::{Color, Environment};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::{Checked, direction, finite, require};

mod half_angle;
mod needs;
mod path_trace;
mod slicing;

pub use half_angle::{BlurJitter, BlurScaling, HalfAngle, InScatter, LightCorrection};
pub use needs::{LightPath, Needs};
pub use path_trace::{Majorants, PathTrace};
pub use slicing::{BlendOrder, ColorWeight, Correction, Proxy, SliceGeometry, SliceTarget, Slicing};

/// The technique that draws the scene.
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

/// Settings of the ray caster.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RayCast {
    /// What becomes of the samples along a ray. Default composite.
    pub mode: Mode,
}

impl RayCast {
    fn needs(&self) -> Needs {
        let (composites, meets_surfaces) = (self.mode == Mode::Composite, matches!(self.mode, Mode::Isosurface(_)));
        Needs {
            light: LightPath::Arrives,
            classification: composites,
            extinction_color: composites,
            shadows: composites || meets_surfaces,
            several_volumes: true,
            overlap: !meets_surfaces,
            data_colors: composites,
        }
    }
}

/// What becomes of the samples along a ray.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum Mode {
    /// Emission and absorption, front to back (1.4-8).
    #[default]
    Composite,
    /// The largest value, then classified (1.4-10). Opacity is not corrected for the step.
    Maximum,
    /// The smallest value, then classified.
    Minimum,
    /// The mean value, then classified (1.4-11).
    Average,
    /// Emission without absorption: the sum of all light, in any order (1.2-7, model 2).
    Additive,
    /// A radiograph: absorption alone, drawn as the share of light held back (1.2-7, model 1).
    XRay,
    /// The first surface of one or several isovalues, shaded (5.5-8).
    Isosurface(Isosurface),
    /// A plane, or a slab of some thickness, at any orientation.
    Slice(Slice),
}

/// Surfaces of constant value; a ray stops at the first opaque one it meets.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Isosurface {
    /// The surfaces, at least one.
    pub isovalues: Vec<Isovalue>,
}

/// One surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Isovalue {
    /// Data value of the surface.
    pub value: f64,
    /// Its colour; left out, the transfer function's at that value.
    #[serde(default)]
    pub color: Option<Color>,
    /// Its opacity, 0 to 1; below 1 what lies behind shines through. Default 1.
    #[serde(default = "one")]
    pub opacity: f32,
    /// The volume it is a surface of, by its place in the list; left out, of all.
    #[serde(default)]
    pub volume: Option<usize>,
}

fn one() -> f32 {
    1.0
}

/// A cut through the volume, coloured by the transfer function at full opacity.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Slice {
    /// World position the plane passes through; left out, the middle of what the crop leaves of the volume.
    pub point: Option<[f64; 3]>,
    /// Direction perpendicular to the plane; left out, the direction of view.
    pub normal: Option<[f64; 3]>,
    /// Thickness of the slab in world units; 0 is a plane. Default 0.
    pub thickness: f64,
    /// What becomes of the values within the slab. Default maximum.
    pub combine: Combine,
}

/// How the values within a slab become one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Combine {
    /// The largest.
    #[default]
    Maximum,
    /// The smallest.
    Minimum,
    /// The mean.
    Average,
}

impl Technique {
    /// What becomes of the samples.
    pub fn mode(&self) -> &Mode {
        match self {
            Self::RayCast(RayCast { mode }) => mode,
            Self::Slicing(Slicing { mode, .. }) => mode,
            Self::HalfAngle(_) | Self::PathTrace(_) => &Mode::Composite,
        }
    }

    /// What becomes of the samples, to be changed; `None` if the technique has no choice.
    pub fn mode_mut(&mut self) -> Option<&mut Mode> {
        match self {
            Self::RayCast(RayCast { mode }) => Some(mode),
            Self::Slicing(Slicing { mode, .. }) => Some(mode),
            Self::HalfAngle(_) | Self::PathTrace(_) => None,
        }
    }

    /// The ray caster with the same mode.
    pub fn along_rays(&self) -> Self {
        Self::RayCast(RayCast { mode: self.mode().clone() })
    }

    /// Slices of a geometry with the same mode, and the other settings of slices as they are.
    pub fn in_slices(&self, geometry: SliceGeometry) -> Self {
        match self {
            Self::Slicing(slicing) => Self::Slicing(Slicing { geometry, ..slicing.clone() }),
            other => Self::Slicing(Slicing { mode: other.mode().clone(), geometry, ..Slicing::default() }),
        }
    }

    /// Half-angle slicing, with its settings if it is that.
    pub fn by_half_angles(&self) -> Self {
        match self {
            Self::HalfAngle(settings) => Self::HalfAngle(settings.clone()),
            _ => Self::HalfAngle(HalfAngle::default()),
        }
    }

    /// The path tracer, with its settings if it is one.
    pub fn by_paths(&self) -> Self {
        match self {
            Self::PathTrace(settings) => Self::PathTrace(settings.clone()),
            _ => Self::PathTrace(PathTrace::default()),
        }
    }

    /// The name of the technique, as in a document.
    pub fn name(&self) -> &'static str {
        match self {
            Self::RayCast(_) => "ray_cast",
            Self::Slicing(_) => "slicing",
            Self::HalfAngle(_) => "half_angle",
            Self::PathTrace(_) => "path_trace",
        }
    }

    /// What shines from around, where the technique knows of it.
    pub fn environment(&self) -> Option<&Environment> {
        match self {
            Self::PathTrace(PathTrace { environment, .. }) => Some(environment),
            Self::RayCast(_) | Self::Slicing(_) | Self::HalfAngle(_) => None,
        }
    }

    /// The same, to be changed.
    pub fn environment_mut(&mut self) -> Option<&mut Environment> {
        match self {
            Self::PathTrace(PathTrace { environment, .. }) => Some(environment),
            Self::RayCast(_) | Self::Slicing(_) | Self::HalfAngle(_) => None,
        }
    }

    /// What it asks of a scene.
    pub fn needs(&self) -> Needs {
        match self {
            Self::RayCast(ray_cast) => ray_cast.needs(),
            Self::Slicing(slicing) => slicing.needs(),
            Self::HalfAngle(half_angle) => half_angle.needs(),
            Self::PathTrace(path_trace) => path_trace.needs(),
        }
    }

    pub(crate) fn check(&self, path: &str) -> Checked {
        let path = format!("{path}.{}", self.name());
        match self {
            Self::RayCast(_) => {}
            Self::Slicing(slicing) => slicing.check(&path)?,
            Self::HalfAngle(half_angle) => half_angle.check(&path)?,
            Self::PathTrace(path_trace) => path_trace.check(&path)?,
        }
        self.mode().check(&format!("{path}.mode"))
    }
}

impl Mode {
    fn check(&self, path: &str) -> Checked {
        match self {
            Mode::Isosurface(Isosurface { isovalues }) => {
                let path = format!("{path}.isosurface");
                require(!isovalues.is_empty(), &path, "isovalues", "none", "at least one isovalue")?;
                for (k, iso) in isovalues.iter().enumerate() {
                    let path = format!("{path}.isovalues[{k}]");
                    require(iso.value.is_finite(), &path, "value", iso.value, "a finite data value")?;
                    require((0.0..=1.0).contains(&iso.opacity), &path, "opacity", iso.opacity, "0 to 1")?;
                }
                Ok(())
            }
            Mode::Slice(slice) => {
                let path = format!("{path}.slice");
                slice.point.map_or(Ok(()), |point| finite(&path, "point", point))?;
                slice.normal.map_or(Ok(()), |normal| direction(&path, "normal", normal))?;
                let thickness = slice.thickness;
                require(thickness >= 0.0 && thickness.is_finite(), &path, "thickness", thickness, "0 or a length")
            }
            _ => Ok(()),
        }
    }
}
