//! How a volume scatters light: the properties that travel with a transfer function (K-08, K-11, 6.2, 6.3-1).

use std::ops::RangeInclusive;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::control_point::{check, locate};
use crate::error::checked;
use crate::phase::MOST_ANISOTROPY;
use crate::{
    Color, ColorPoint, ColorSpace, GradientWeight, NumberPoint, OpticsError, Phase, PhaseNormalization, ResolvedLight,
};

/// How a volume scatters light. The transfer function says how much light a sample takes out of a ray
/// (its extinction); this says what becomes of it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Scattering {
    /// By which angles light is scattered. Default isotropic.
    pub phase: Phase,
    /// What the phase function's weights of direct light are relative to. Default physical.
    pub phase_normalization: PhaseNormalization,
    /// The anisotropy over the data. Default uniform.
    pub anisotropy: Anisotropy,
    /// The part of the light taken out of a ray that is scattered, not absorbed. Default color.
    pub albedo: Albedo,
    /// The colour that light becomes in one unit distance of depth, over data values: one less the
    /// indirect attenuation (K-08). Left out, indirect light is attenuated as direct light is.
    #[schemars(length(min = 1))]
    pub transport: Option<Vec<ColorPoint>>,
    /// Factors of the extinction for red, green and blue light, as the linear light of this colour, so that what is
    /// thick takes on a colour that what is thin has not (K-13). Left out, all colours are lost alike. Path tracing,
    /// ray casting and half-angle slicing heed it on all ways of light, that of a background included; a pixel's
    /// coverage, the alpha of a transparent background, is then the mean of its colours'.
    pub extinction_color: Option<Color>,
    /// How much a sample reflects as a surface instead of scattering as a cloud (K-11). Default none.
    pub surface: SurfaceShare,
}

/// The anisotropy of the phase function over the data.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum Anisotropy {
    /// That of the phase function everywhere (default).
    #[default]
    Uniform,
    /// One less the opacity per unit distance, at most 0.99: thin fringes throw light on, dense cores all
    /// around (6.2-6).
    Cloud,
    /// Through these points over data values, -0.99 to 0.99.
    Values(#[schemars(length(min = 1))] Vec<NumberPoint>),
}

/// The single-scattering albedo.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum Albedo {
    /// The colour of the transfer function (default), so that a white cloud is white.
    #[default]
    Color,
    /// One number for all colours and values, 0 to 1.
    Constant(#[schemars(range(min = 0.0, max = 1.0))] f32),
    /// Through these colours over data values, sRGB-encoded as all colours of a document.
    Colors(#[schemars(length(min = 1))] Vec<ColorPoint>),
}

/// The part S of a sample that is a surface, 0 to 1 (K-11).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum SurfaceShare {
    /// Nothing is (default).
    #[default]
    None,
    /// Through these points over data values, 0 to 1.
    Values(#[schemars(length(min = 1))] Vec<NumberPoint>),
    /// What has a gradient: from 0 at magnitude `low` to 1 at `high`.
    Gradient(GradientWeight),
}

/// How one sample scatters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatterer {
    /// Single-scattering albedo, linear RGB.
    pub albedo: [f32; 3],
    /// Anisotropy, for [`Phase::eval`].
    pub g: f32,
}

impl Scattering {
    /// The same over data values that are less by `origin`.
    pub fn counted_from(mut self, origin: f64) -> Self {
        if let Anisotropy::Values(points) = &mut self.anisotropy {
            points.iter_mut().for_each(|point| point.value -= origin);
        }
        if let Albedo::Colors(points) = &mut self.albedo {
            points.iter_mut().for_each(|point| point.value -= origin);
        }
        if let SurfaceShare::Values(points) = &mut self.surface {
            points.iter_mut().for_each(|point| point.value -= origin);
        }
        if let Some(points) = &mut self.transport {
            points.iter_mut().for_each(|point| point.value -= origin);
        }
        self
    }

    /// Checks every number.
    ///
    /// # Errors
    /// The key of the first setting that cannot be used, and why.
    pub fn validate(&self) -> Result<(), (&'static str, OpticsError)> {
        let at = |key, checked: Result<(), OpticsError>| checked.map_err(|error| (key, error));
        at("phase", self.phase.validate())?;
        if self.anisotropy != Anisotropy::Uniform && self.phase.anisotropy().is_none() {
            return Err(("anisotropy", OpticsError::NoAnisotropy { phase: self.phase.name() }));
        }
        if let Anisotropy::Values(points) = &self.anisotropy {
            at("anisotropy.values", limited(points, -MOST_ANISOTROPY..=MOST_ANISOTROPY, "-0.99 to 0.99"))?;
        }
        match &self.albedo {
            Albedo::Color => {}
            Albedo::Constant(albedo) => {
                at("albedo.constant", checked("albedo", f64::from(*albedo), 0.0..=1.0, "0 to 1"))?;
            }
            Albedo::Colors(points) => at("albedo.colors", check(points))?,
        }
        if let Some(points) = &self.transport {
            at("transport", check(points))?;
        }
        match &self.surface {
            SurfaceShare::None => Ok(()),
            SurfaceShare::Values(points) => at("surface.values", limited(points, 0.0..=1.0, "0 to 1")),
            SurfaceShare::Gradient(weight) => at("surface.gradient", weight.validate()),
        }
    }

    /// The factors of the extinction for each colour, linear and 0 to 1, where not all of them are 1 (K-13).
    pub fn extinction_factors(&self) -> Option<[f32; 3]> {
        self.extinction_color.map(|color| color.to_linear(ColorSpace::Srgb)).filter(|factors| *factors != [1.0; 3])
    }

    /// Whether paths that were scattered find a light by chance as well as by choice. They carry what all lights
    /// bring: highlights, which a light may not make, and the share of light that is physical.
    pub fn meets(&self, light: &ResolvedLight) -> bool {
        let physical = self.phase_normalization == PhaseNormalization::Physical;
        light.has_extent() && light.is_specular() && physical
    }

    /// How a sample of this data value scatters that the transfer function gives this colour (linear RGB)
    /// and opacity per unit distance.
    #[inline]
    pub fn at(&self, value: f64, [r, g, b, opacity]: [f32; 4]) -> Scatterer {
        let albedo = match &self.albedo {
            Albedo::Color => [r, g, b],
            Albedo::Constant(albedo) => [*albedo; 3],
            Albedo::Colors(points) => color(points, value),
        };
        let g = match &self.anisotropy {
            Anisotropy::Uniform => self.phase.anisotropy().unwrap_or(0.0),
            Anisotropy::Cloud => (1.0 - opacity).clamp(0.0, MOST_ANISOTROPY),
            Anisotropy::Values(points) => number(points, value),
        };
        Scatterer { albedo, g }
    }

    /// The part of indirect light that gets through one unit distance at a data value, if that is not
    /// what gets through of direct light (K-08). Over a length, `t^(length / unit)`.
    #[inline]
    pub fn transport_at(&self, value: f64) -> Option<[f32; 3]> {
        self.transport.as_ref().map(|points| color(points, value))
    }

    /// Whether any sample may be a surface.
    pub fn has_surfaces(&self) -> bool {
        self.surface != SurfaceShare::None
    }

    /// The part of a sample that is a surface, at a data value and gradient magnitude (data units per
    /// world unit).
    #[inline]
    pub fn surface_at(&self, value: f64, gradient: f32) -> f32 {
        match &self.surface {
            SurfaceShare::None => 0.0,
            SurfaceShare::Values(points) => number(points, value),
            SurfaceShare::Gradient(weight) => weight.weight(gradient),
        }
    }
}

/// Points that ascend, with numbers within `range`.
fn limited(points: &[NumberPoint], range: RangeInclusive<f32>, expected: &str) -> Result<(), OpticsError> {
    check(points)?;
    let outside = points.iter().position(|point| !range.contains(&point.number));
    outside.map_or(Ok(()), |index| {
        let NumberPoint { value, number, .. } = points[index];
        let problem = format!("number is {number}: expected {expected}");
        Err(OpticsError::Point { list: "values", index, value, problem })
    })
}

fn color(points: &[ColorPoint], value: f64) -> [f32; 3] {
    if !value.is_finite() {
        return Color::BLACK.rgb();
    }
    let (from, to, t) = locate(points, value);
    from.color.lerp(to.color, t as f32).to_linear(ColorSpace::Srgb)
}

fn number(points: &[NumberPoint], value: f64) -> f32 {
    if !value.is_finite() {
        return 0.0;
    }
    let (from, to, t) = locate(points, value);
    from.number + (to.number - from.number) * t as f32
}
