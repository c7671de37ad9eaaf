//! The transfer function: data values to colour and opacity (4.1-1).

use schemars::JsonSchema;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize};

use crate::control_point::{check, locate, read_points};
use crate::error::checked;
use crate::{Color, ColorPoint, ColorSpace, OpacityPoint, OpticsError};

/// A map from data values to colour and opacity, as two curves through control points.
///
/// Points ascend in value. Two points at one value are a jump, whose upper side holds at the
/// value itself. Values beyond the first and the last point have the properties of that point.
/// The opacity is that of [`unit_distance`](Self::unit_distance) world units of the material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "Document", into = "Document")]
pub struct TransferFunction {
    colors: Vec<ColorPoint>,
    opacities: Vec<OpacityPoint>,
    color_space: ColorSpace,
    unit_distance: Option<f64>,
}

/// The transfer function as it stands in a document, before it is checked.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "TransferFunction")]
struct Document {
    /// Colours at ascending data values; at least one. Two at one value are a jump.
    #[serde(deserialize_with = "read_points")]
    #[schemars(length(min = 1))]
    colors: Vec<ColorPoint>,
    /// Opacities at ascending data values; at least one. Two at one value are a jump.
    #[serde(deserialize_with = "read_points")]
    #[schemars(length(min = 1))]
    opacities: Vec<OpacityPoint>,
    /// The space the colours are given and interpolated in. Default srgb.
    #[serde(default)]
    color_space: ColorSpace,
    /// World units of material that have the given opacities; by default the mean voxel spacing.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "read_unit_distance")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    unit_distance: Option<f64>,
}

/// Checks the length where it is read, so that an error is that of its key.
fn read_unit_distance<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    let found = Option::deserialize(deserializer)?;
    check_unit_distance(found).map_err(D::Error::custom)?;
    Ok(found)
}

fn check_unit_distance(found: Option<f64>) -> Result<(), OpticsError> {
    let expected = "a positive length in world units";
    found.map_or(Ok(()), |found| checked("unit_distance", found, f64::MIN_POSITIVE..=f64::MAX, expected))
}

impl TryFrom<Document> for TransferFunction {
    type Error = OpticsError;

    fn try_from(document: Document) -> Result<Self, OpticsError> {
        Self::new(document.colors, document.opacities)?
            .with_color_space(document.color_space)
            .with_unit_distance(document.unit_distance)
    }
}

impl From<TransferFunction> for Document {
    fn from(tf: TransferFunction) -> Self {
        let TransferFunction { colors, opacities, color_space, unit_distance } = tf;
        Self { colors, opacities, color_space, unit_distance }
    }
}

impl TransferFunction {
    /// A transfer function through these points, with sRGB colours and the default unit distance.
    ///
    /// # Errors
    /// [`OpticsError::NoPoints`] for an empty list; [`OpticsError::Point`] names the first point
    /// that is not finite, not in order, a third at its value, or has an opacity outside 0..=1.
    pub fn new(colors: Vec<ColorPoint>, opacities: Vec<OpacityPoint>) -> Result<Self, OpticsError> {
        check(&colors)?;
        check(&opacities)?;
        Ok(Self { colors, opacities, color_space: ColorSpace::default(), unit_distance: None })
    }

    /// The same points, their colours given and interpolated in another space.
    pub fn with_color_space(mut self, color_space: ColorSpace) -> Self {
        self.color_space = color_space;
        self
    }

    /// The same opacities over another length in world units; `None` for the mean voxel spacing
    /// of the volume it is used on.
    ///
    /// # Errors
    /// [`OpticsError::Parameter`] unless the length is positive and finite.
    pub fn with_unit_distance(mut self, unit_distance: Option<f64>) -> Result<Self, OpticsError> {
        check_unit_distance(unit_distance)?;
        self.unit_distance = unit_distance;
        Ok(self)
    }

    /// The colour points, ascending.
    pub fn colors(&self) -> &[ColorPoint] {
        &self.colors
    }

    /// The opacity points, ascending.
    pub fn opacities(&self) -> &[OpacityPoint] {
        &self.opacities
    }

    /// The space of the colour points.
    pub fn color_space(&self) -> ColorSpace {
        self.color_space
    }

    /// World units of material that have the opacities; `None` means the mean voxel spacing.
    pub fn unit_distance(&self) -> Option<f64> {
        self.unit_distance
    }

    /// The colour at a data value, linear RGB, not associated with the opacity. Black where the
    /// value is absent.
    pub fn color(&self, value: f64) -> [f32; 3] {
        if !value.is_finite() {
            return Color::BLACK.rgb();
        }
        let (from, to, t) = locate(&self.colors, value);
        from.color.lerp(to.color, t as f32).to_linear(self.color_space)
    }

    /// The opacity of one unit distance of material at a data value. Zero where the value is absent.
    pub fn opacity(&self, value: f64) -> f32 {
        if !value.is_finite() {
            return 0.0;
        }
        let (from, to, t) = locate(&self.opacities, value);
        from.opacity + (to.opacity - from.opacity) * t as f32
    }

    /// The interval of values from the first to the last control point; outside it the function
    /// is constant on either side.
    pub fn hull(&self) -> [f64; 2] {
        let (c, o) = (&self.colors, &self.opacities);
        [c[0].value.min(o[0].value), c[c.len() - 1].value.max(o[o.len() - 1].value)]
    }

    /// The first two neighbouring opacity points at different values that are the same in single precision, as look-ups
    /// see them.
    pub fn merged_points(&self) -> Option<[f64; 2]> {
        let pairs = self.opacities.windows(2).map(|pair| [pair[0].value, pair[1].value]);
        pairs.into_iter().find(|[a, b]| a < b && *a as f32 == *b as f32)
    }

    /// The values of all control points, ascending.
    pub(crate) fn values(&self) -> Vec<f64> {
        let colors = self.colors.iter().map(|point| point.value);
        let mut values: Vec<f64> = colors.chain(self.opacities.iter().map(|point| point.value)).collect();
        values.sort_by(f64::total_cmp);
        values
    }

    /// The same curves over values that are less by `origin`.
    pub fn counted_from(mut self, origin: f64) -> Self {
        self.colors.iter_mut().for_each(|point| point.value -= origin);
        self.opacities.iter_mut().for_each(|point| point.value -= origin);
        self
    }

    /// The same curves with every value shifted and scaled so that the interval `from` becomes
    /// the interval `to`: how a relative preset is fitted to a window.
    ///
    /// # Errors
    /// [`OpticsError::Interval`] unless both ascend and are finite; [`OpticsError::Point`] if a
    /// point leaves the range of finite values.
    pub fn remap(mut self, from: [f64; 2], to: [f64; 2]) -> Result<Self, OpticsError> {
        for (name, found) in [("interval to map from", from), ("interval to map to", to)] {
            ascending(name, found)?;
        }
        let scale = (to[1] - to[0]) / (from[1] - from[0]);
        let map = |value: &mut f64| *value = to[0] + (*value - from[0]) * scale;
        self.colors.iter_mut().for_each(|point| map(&mut point.value));
        self.opacities.iter_mut().for_each(|point| map(&mut point.value));
        // Distinct values may have become one: the checks of a new function apply.
        check(&self.colors)?;
        check(&self.opacities)?;
        Ok(self)
    }
}

/// Checks that an interval is finite and ascends.
pub(crate) fn ascending(name: &'static str, found: [f64; 2]) -> Result<(), OpticsError> {
    if found[0] < found[1] && (found[1] - found[0]).is_finite() {
        return Ok(());
    }
    Err(OpticsError::Interval { name, found, expected: "above" })
}
