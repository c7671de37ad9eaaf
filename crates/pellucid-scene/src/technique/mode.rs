//! What becomes of the samples along a ray.

use pellucid_optics::Color;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::illumination::{GlobalIllumination, Illumination};
use crate::check::{Checked, direction, finite, join, require};

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
    /// How rays look for them. Default exact.
    #[serde(default)]
    pub search: SurfaceSearch,
    /// What lights them. Default lights.
    #[serde(default)]
    pub illumination: Illumination,
}

impl Isosurface {
    /// Surfaces, looked for and lit as by default.
    pub fn new(isovalues: Vec<Isovalue>) -> Self {
        Self { isovalues, search: SurfaceSearch::default(), illumination: Illumination::default() }
    }
}

/// How rays look for surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SurfaceSearch {
    /// Cell by cell, by the cubic that trilinear interpolation is along a ray: none is missed, whatever the step (5.5-8,
    /// Wyman et al. 2006). Under filters other than the linear one, and where the field is displaced, they are looked for
    /// between samples.
    #[default]
    Exact,
    /// Between samples: where two surfaces lie between the same two, both may be missed.
    Sampled,
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

impl Mode {
    /// The light of surfaces, if it is all light that arrives.
    pub fn global_illumination(&self) -> Option<&GlobalIllumination> {
        match self {
            Self::Isosurface(Isosurface { illumination: Illumination::Global(global), .. }) => Some(global),
            _ => None,
        }
    }

    /// The same, to be changed.
    pub fn global_illumination_mut(&mut self) -> Option<&mut GlobalIllumination> {
        match self {
            Self::Isosurface(Isosurface { illumination: Illumination::Global(global), .. }) => Some(global),
            _ => None,
        }
    }

    /// The mode of the same kind, with all of a slice's settings at their defaults, and all of surfaces but which they are.
    pub(super) fn plain(&self) -> Self {
        match self {
            Self::Slice(_) => Self::Slice(Slice::default()),
            Self::Isosurface(surfaces) => Self::Isosurface(Isosurface::new(surfaces.isovalues.clone())),
            other => other.clone(),
        }
    }

    pub(super) fn check(&self, path: &str) -> Checked {
        match self {
            Mode::Isosurface(Isosurface { isovalues, illumination, .. }) => {
                let path = format!("{path}.isosurface");
                require(!isovalues.is_empty(), &path, "isovalues", "none", "at least one isovalue")?;
                for (k, iso) in isovalues.iter().enumerate() {
                    let path = format!("{path}.isovalues[{k}]");
                    require(iso.value.is_finite(), &path, "value", iso.value, "a finite data value")?;
                    require((0.0..=1.0).contains(&iso.opacity), &path, "opacity", iso.opacity, "0 to 1")?;
                }
                illumination.check(&join(&path, "illumination"))
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
