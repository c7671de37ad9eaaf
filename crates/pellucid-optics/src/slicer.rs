//! Volume properties of 3D Slicer: `.vp.json` files, schema 1.0.0.
//!
//! Nothing is lost silently: what either side cannot express is returned as a warning. Control
//! points outside the range of the data at hand are points like all others.

mod curve;
mod file;

use std::fmt;

use crate::error::checked;
use crate::{ColorSpace, Material, OpacityPoint, OpticsError, TransferFunction};
use file::{Component, LightingCoefficients, PiecewiseFunction, SlicerDocument};

/// The look of one component of a volume, as far as both programs know it.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeProperty {
    /// Colour and opacity. Slicer's unit distance is always given.
    pub transfer_function: TransferFunction,
    /// Factor of the opacity by gradient magnitude, in Slicer's units of it; empty if there is none.
    pub gradient_opacity: Vec<OpacityPoint>,
    /// Weights of the lighting terms.
    pub material: Material,
    /// Whether samples are lit.
    pub shading: bool,
}

/// Something that one side cannot say.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SlicerWarning {
    /// A setting of the file that has no meaning here, and is not at its default.
    Ignored {
        /// Its name.
        field: String,
        /// Its value, as JSON.
        value: String,
    },
    /// A number was moved into the range that is allowed here.
    Limited {
        /// The setting.
        field: &'static str,
        /// Its value in the file.
        from: f32,
        /// Its value now.
        to: f32,
    },
    /// A curved way to the next point was replaced by straight lines, within 1/1000 of the
    /// difference between the two.
    Sampled {
        /// The list the point is in.
        list: &'static str,
        /// Its position there, from 0.
        index: usize,
    },
    /// Something that is not at its default here and cannot be written.
    NotWritten {
        /// What it is.
        what: &'static str,
    },
}

impl fmt::Display for SlicerWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ignored { field, value } => write!(f, "{field} = {value} is ignored"),
            Self::Limited { field, from, to } => write!(f, "{field} {from} is read as {to}"),
            Self::Sampled { list, index } => {
                write!(f, "{list}, point {index}: the curve to the next point is now straight lines, within 1/1000")
            }
            Self::NotWritten { what } => write!(f, "{what} cannot be written"),
        }
    }
}

impl VolumeProperty {
    /// Reads every component of every volume property in a file's text.
    ///
    /// # Errors
    /// [`OpticsError::VolumeProperty`] for text that is not of this schema; [`OpticsError::Point`]
    /// and [`OpticsError::NoPoints`] for curves that cannot be used.
    pub fn from_slicer(text: &str) -> Result<(Vec<Self>, Vec<SlicerWarning>), OpticsError> {
        let problem = |problem: String| OpticsError::VolumeProperty { problem };
        let document: SlicerDocument = serde_json::from_str(text).map_err(|error| problem(error.to_string()))?;
        if !document.schema.contains("volume-property-schema-v1.") {
            return Err(problem(format!("schema {:?}: expected volume-property-schema-v1.0.0.json", document.schema)));
        }
        let mut warnings = Vec::new();
        let mut properties = Vec::new();
        for property in document.volume_properties {
            file::report_ignored(&property.rest, &mut warnings);
            for component in property.components {
                properties.push(Self::from_component(component, &mut warnings)?);
            }
        }
        Ok((properties, warnings))
    }

    fn from_component(component: Component, warnings: &mut Vec<SlicerWarning>) -> Result<Self, OpticsError> {
        file::report_ignored(&component.rest, warnings);
        let opacities = curve::read_opacities("scalarOpacity", &component.scalar_opacity, warnings);
        let colors = match component.rgb_transfer_function {
            Some(rgb) => curve::read_colors(&rgb.points, warnings)?,
            None => curve::read_greys(&component.gray_transfer_function, warnings)?,
        };
        let gradient_opacity = curve::read_opacities("gradientOpacity", &component.gradient_opacity, warnings);
        let gradient_opacity = if component.disable_gradient_opacity { Vec::new() } else { gradient_opacity };
        if !gradient_opacity.is_empty() {
            crate::control_point::check(&gradient_opacity)?;
        }
        let unit_distance = component.scalar_opacity_unit_distance;
        let lighting = component.lighting;
        let mut limited = |field, from: f32, low: f32, high: f32| {
            let to = from.clamp(low, high);
            if to != from {
                warnings.push(SlicerWarning::Limited { field, from, to });
            }
            to
        };
        let material = Material {
            emission: 0.0,
            ambient: limited("ambient", lighting.ambient, 0.0, 1.0),
            diffuse: limited("diffuse", lighting.diffuse, 0.0, 1.0),
            specular: limited("specular", lighting.specular, 0.0, 1.0),
            shininess: limited("specularPower", lighting.specular_power, 1.0, 1000.0),
            two_sided: true,
        };
        let transfer_function = TransferFunction::new(colors, opacities)?.with_unit_distance(Some(unit_distance))?;
        Ok(Self { transfer_function, gradient_opacity, material, shading: component.shade })
    }

    /// The text of a file with these as the components of one volume property. `mean_spacing` is
    /// the unit distance, in world units, of transfer functions that leave it open.
    ///
    /// # Errors
    /// [`OpticsError::Parameter`] unless the mean spacing is positive and finite.
    pub fn to_slicer(properties: &[Self], mean_spacing: f64) -> Result<(String, Vec<SlicerWarning>), OpticsError> {
        checked("mean voxel spacing", mean_spacing, f64::MIN_POSITIVE..=f64::MAX, "a positive length")?;
        let mut warnings = Vec::new();
        let components = properties.iter().map(|property| property.to_component(mean_spacing, &mut warnings)).collect();
        let text = serde_json::to_string_pretty(&SlicerDocument::new(components));
        Ok((text.map_err(|error| OpticsError::VolumeProperty { problem: error.to_string() })?, warnings))
    }

    fn to_component(&self, mean_spacing: f64, warnings: &mut Vec<SlicerWarning>) -> Component {
        let tf = &self.transfer_function;
        let material = self.material;
        for (what, lost) in [
            ("emission of a material", material.emission != 0.0),
            ("a one-sided material", !material.two_sided),
            (
                "interpolation of colours in linear light",
                tf.color_space() == ColorSpace::Linear && tf.colors().len() > 1,
            ),
        ] {
            if lost {
                warnings.push(SlicerWarning::NotWritten { what });
            }
        }
        Component {
            shade: self.shading,
            lighting: LightingCoefficients {
                ambient: material.ambient,
                diffuse: material.diffuse,
                specular: material.specular,
                specular_power: material.shininess,
            },
            disable_gradient_opacity: self.gradient_opacity.is_empty(),
            scalar_opacity_unit_distance: tf.unit_distance().unwrap_or(mean_spacing),
            scalar_opacity: Some(PiecewiseFunction {
                points: curve::write_opacities("scalarOpacity", tf.opacities(), warnings),
            }),
            gradient_opacity: (!self.gradient_opacity.is_empty()).then(|| PiecewiseFunction {
                points: curve::write_opacities("gradientOpacity", &self.gradient_opacity, warnings),
            }),
            rgb_transfer_function: Some(PiecewiseFunction { points: curve::write_colors(tf, warnings) }),
            ..Component::default()
        }
    }
}
