//! The checks of optics and reconstruction, with the keys their settings have in a document.

use glam::DAffine3;
use pellucid_field::{Filter, Gradient};
use pellucid_optics::{
    ColorMap, Environment, GradientWeight, Light, LightKind, Material, OpticsError, Perturbation, Preset, Scattering,
    Shadows, opacity_shape,
};

use crate::Invalid;
use crate::check::{Checked, join};

fn invalid(path: &str, key: &str, error: impl std::fmt::Display) -> Invalid {
    Invalid { path: join(path, key), message: error.to_string() }
}

/// The names of presets, colour maps and opacity shapes are known.
pub(crate) fn names(path: &str, preset: Option<&str>, colormap: Option<&str>, opacity: Option<&str>) -> Checked {
    let known = |key, error: Option<OpticsError>| error.map_or(Ok(()), |error| Err(invalid(path, key, error)));
    known("preset", preset.and_then(|name| Preset::by_name(name).err()))?;
    known("colormap", colormap.and_then(|name| ColorMap::colors(name, [0.0, 1.0]).err()))?;
    known("opacity", opacity.and_then(|name| opacity_shape(name, [0.0, 1.0]).err()))
}

/// A light can be used.
pub(crate) fn light(path: &str, light: &Light) -> Checked {
    light.resolve(DAffine3::IDENTITY).map(|_| ()).map_err(|error| invalid(path, &light_key(light, &error), &error))
}

/// The key of the setting that an error about a light names; empty if it is none of them.
fn light_key(light: &Light, error: &OpticsError) -> String {
    let kind = match light.kind {
        LightKind::Directional { .. } => "directional",
        LightKind::Point { .. } => "point",
        LightKind::Spot { .. } => "spot",
        LightKind::Rectangle { .. } => "rectangle",
    };
    let key = match error {
        OpticsError::Direction { .. } => "direction",
        OpticsError::Edges { .. } => "edges",
        OpticsError::Parameter { name: "light position", .. } if kind == "rectangle" => "center",
        OpticsError::Parameter { name: "light position", .. } => "position",
        OpticsError::Parameter { name: "light reference distance", .. } => "falloff.inverse_square.reference",
        OpticsError::Parameter { name: "inner angle of a spot light", .. } => "inner_angle",
        OpticsError::Parameter { name: "outer angle of a spot light", .. } => "outer_angle",
        OpticsError::Parameter { name: "light intensity", .. } => return "intensity".to_owned(),
        OpticsError::Parameter { name: "light radius", .. } => return "radius".to_owned(),
        _ => return String::new(),
    };
    format!("kind.{kind}.{key}")
}

/// Settings of shadows are within their ranges.
pub(crate) fn shadows(path: &str, shadows: &Shadows) -> Checked {
    shadows.validate().map_err(|error| {
        let name = if let OpticsError::Parameter { name, .. } = error { name } else { "" };
        invalid(path, &join(shadows.name(), name), &error)
    })
}

/// A material is within its ranges.
pub(crate) fn material(path: &str, material: &Material) -> Checked {
    material.validate().map_err(|error| {
        let name = if let OpticsError::Parameter { name, .. } = error { name } else { "" };
        invalid(path, name.strip_prefix("material ").unwrap_or_default(), &error)
    })
}

/// A gradient weight ascends.
pub(crate) fn gradient_weight(path: &str, weight: &GradientWeight) -> Checked {
    weight.validate().map_err(|error| {
        let key = if matches!(error, OpticsError::Parameter { .. }) { "low" } else { "high" };
        invalid(path, key, &error)
    })
}

/// How a volume scatters is within its ranges.
pub(crate) fn scattering(path: &str, scattering: &Scattering) -> Checked {
    scattering.validate().map_err(|(key, error)| match (key, &error) {
        ("phase", OpticsError::Parameter { name, .. }) => {
            invalid(path, &format!("phase.{}.{name}", scattering.phase.name()), &error)
        }
        _ => invalid(path, key, &error),
    })
}

/// Noise is within its ranges.
pub(crate) fn perturbation(path: &str, perturbation: &Perturbation) -> Checked {
    perturbation.validate().map_err(|(key, error)| invalid(path, &key, error))
}

/// An environment is within its ranges.
pub(crate) fn environment(path: &str, environment: &Environment) -> Checked {
    environment.validate().map_err(|error| {
        let key = match (environment, &error) {
            (Environment::Dark, _) => "",
            (Environment::Constant { .. }, _) => "constant.intensity",
            (Environment::Gradient { .. }, _) => "gradient.intensity",
            (Environment::Image(_), OpticsError::Parameter { name: "environment rotation", .. }) => "image.rotation",
            (Environment::Image(_), _) => "image.intensity",
        };
        invalid(path, key, error)
    })
}

/// Parameters of a filter are within their ranges.
pub(crate) fn filter(path: &str, filter: &Filter) -> Checked {
    let key = match *filter {
        Filter::Bc { b, .. } if !b.is_finite() => "bc.b",
        Filter::Bc { .. } => "bc.c",
        Filter::Sinc { .. } => "sinc.half_width",
        _ => "",
    };
    filter.validate().map_err(|error| invalid(path, key, error))
}

/// Parameters of a gradient are within their ranges.
pub(crate) fn gradient(path: &str, gradient: &Gradient) -> Checked {
    gradient.validate().map_err(|error| invalid(path, "gaussian.sigma", error))
}
