//! The file as it is: names and defaults of Slicer's volume-property schema 1.0.0.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use super::SlicerWarning;

const SCHEMA: &str = "https://raw.githubusercontent.com/Slicer/Slicer/main/Modules/Loadable/VolumeRendering/Resources/Schema/volume-property-schema-v1.0.0.json#";

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SlicerDocument {
    #[serde(rename = "@schema")]
    pub schema: String,
    pub volume_properties: Vec<Property>,
}

impl SlicerDocument {
    pub fn new(components: Vec<Component>) -> Self {
        let rest = [("independentComponents", json!(true)), ("interpolationType", json!("linear"))];
        let rest = rest.into_iter().map(|(field, value)| (field.to_owned(), value)).collect();
        Self { schema: SCHEMA.to_owned(), volume_properties: vec![Property { components, rest }] }
    }
}

#[derive(Serialize, Deserialize)]
pub(super) struct Property {
    #[serde(default)]
    pub components: Vec<Component>,
    #[serde(flatten)]
    pub rest: Map<String, Value>,
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Component {
    pub shade: bool,
    pub lighting: LightingCoefficients,
    pub disable_gradient_opacity: bool,
    pub scalar_opacity_unit_distance: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gray_transfer_function: Option<PiecewiseFunction<Knot<f32>>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scalar_opacity: Option<PiecewiseFunction<Knot<f32>>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gradient_opacity: Option<PiecewiseFunction<Knot<f32>>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rgb_transfer_function: Option<PiecewiseFunction<ColorKnot>>,
    #[serde(flatten)]
    pub rest: Map<String, Value>,
}

impl Default for Component {
    fn default() -> Self {
        Self {
            shade: false,
            lighting: LightingCoefficients::default(),
            disable_gradient_opacity: false,
            scalar_opacity_unit_distance: 1.0,
            gray_transfer_function: None,
            scalar_opacity: None,
            gradient_opacity: None,
            rgb_transfer_function: None,
            rest: Map::new(),
        }
    }
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct LightingCoefficients {
    pub ambient: f32,
    pub diffuse: f32,
    pub specular: f32,
    pub specular_power: f32,
}

impl Default for LightingCoefficients {
    fn default() -> Self {
        Self { ambient: 0.1, diffuse: 0.7, specular: 0.2, specular_power: 10.0 }
    }
}

#[derive(Serialize, Deserialize)]
pub(super) struct PiecewiseFunction<T> {
    pub points: Vec<T>,
}

/// A point of a curve; midpoint and sharpness are about the way to the next one.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(super) struct Knot<V> {
    pub x: f64,
    pub y: V,
    #[serde(default = "middle")]
    pub midpoint: f64,
    #[serde(default)]
    pub sharpness: f64,
}

#[derive(Clone, Copy, Serialize, Deserialize)]
pub(super) struct ColorKnot {
    pub x: f64,
    pub color: [f32; 3],
    #[serde(default = "middle")]
    pub midpoint: f64,
    #[serde(default)]
    pub sharpness: f64,
}

fn middle() -> f64 {
    0.5
}

/// Warns of settings without a meaning here, unless they say what goes without saying.
pub(super) fn report_ignored(rest: &Map<String, Value>, warnings: &mut Vec<SlicerWarning>) {
    for (field, value) in rest {
        let harmless = match field.as_str() {
            // The range follows from the points; every component has its own curves here; the
            // clipped intensity is unused unless the switch beside it is on.
            "effectiveRange" | "independentComponents" | "clippedVoxelIntensity" => true,
            "interpolationType" => value == "linear",
            "isoSurfaceValues" => value.as_array().is_some_and(Vec::is_empty),
            "useClippedVoxelIntensity" => value == false,
            "scatteringAnisotropy" => value.as_f64() == Some(0.0),
            "componentWeight" => value.as_f64() == Some(1.0),
            _ => false,
        };
        if !harmless {
            warnings.push(SlicerWarning::Ignored { field: field.clone(), value: value.to_string() });
        }
    }
}
