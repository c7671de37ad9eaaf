//! Control points of curves over the data values, and their two forms in documents.

use std::fmt;
use std::marker::PhantomData;

use schemars::JsonSchema;
use serde::de::value::MapAccessDeserializer;
use serde::de::{DeserializeOwned, DeserializeSeed, Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::sequence::exactly;
use crate::{Color, OpticsError};

/// How a curve runs from one control point to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Interpolation {
    /// Straight (default).
    #[default]
    Linear,
    /// Constant up to the next point, where it jumps.
    Step,
    /// Straight with rounded ends: `t^2 (3 - 2t)`.
    Smooth,
}

/// A colour at a data value. In documents `[value, color]`, or with names,
/// `{ value, color, interpolation }`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColorPoint {
    /// Data value.
    pub value: f64,
    /// Colour there.
    pub color: Color,
    /// The way to the next point.
    pub interpolation: Interpolation,
}

/// An opacity at a data value. In documents `[value, opacity]`, or with names,
/// `{ value, opacity, interpolation }`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpacityPoint {
    /// Data value.
    pub value: f64,
    /// Opacity there over one unit distance, in 0..=1.
    pub opacity: f32,
    /// The way to the next point.
    pub interpolation: Interpolation,
}

/// A number at a data value. In documents `[value, number]`, or with names,
/// `{ value, number, interpolation }`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NumberPoint {
    /// Data value.
    pub value: f64,
    /// Number there.
    pub number: f32,
    /// The way to the next point.
    pub interpolation: Interpolation,
}

impl ColorPoint {
    /// A point with [`Interpolation::Linear`].
    pub const fn new(value: f64, color: Color) -> Self {
        Self { value, color, interpolation: Interpolation::Linear }
    }
}

impl OpacityPoint {
    /// A point with [`Interpolation::Linear`].
    pub const fn new(value: f64, opacity: f32) -> Self {
        Self { value, opacity, interpolation: Interpolation::Linear }
    }
}

impl NumberPoint {
    /// A point with [`Interpolation::Linear`].
    pub const fn new(value: f64, number: f32) -> Self {
        Self { value, number, interpolation: Interpolation::Linear }
    }
}

/// What curves need of their points.
pub(crate) trait ControlPoint: Copy {
    /// The name of such lists in messages.
    const LIST: &'static str;
    fn value(&self) -> f64;
    fn interpolation(&self) -> Interpolation;
    /// What is wrong with the point, apart from its place in the list.
    fn problem(&self) -> Option<String>;
}

impl ControlPoint for ColorPoint {
    const LIST: &'static str = "colors";

    fn value(&self) -> f64 {
        self.value
    }

    fn interpolation(&self) -> Interpolation {
        self.interpolation
    }

    fn problem(&self) -> Option<String> {
        None
    }
}

impl ControlPoint for OpacityPoint {
    const LIST: &'static str = "opacities";

    fn value(&self) -> f64 {
        self.value
    }

    fn interpolation(&self) -> Interpolation {
        self.interpolation
    }

    fn problem(&self) -> Option<String> {
        let fits = (0.0..=1.0).contains(&self.opacity);
        (!fits).then(|| format!("opacity is {}: expected 0 to 1 (not 0 to 255)", self.opacity))
    }
}

impl ControlPoint for NumberPoint {
    const LIST: &'static str = "values";

    fn value(&self) -> f64 {
        self.value
    }

    fn interpolation(&self) -> Interpolation {
        self.interpolation
    }

    fn problem(&self) -> Option<String> {
        (!self.number.is_finite()).then(|| format!("number is {}: expected a finite one", self.number))
    }
}

/// Checks a list: not empty, finite values that ascend, two points at most at one value.
pub(crate) fn check<P: ControlPoint>(points: &[P]) -> Result<(), OpticsError> {
    if points.is_empty() {
        return Err(OpticsError::NoPoints { list: P::LIST });
    }
    (1..=points.len()).try_for_each(|count| check_last(&points[..count]))
}

/// Checks the last point of a list against those before it.
fn check_last<P: ControlPoint>(points: &[P]) -> Result<(), OpticsError> {
    let index = points.len() - 1;
    let (point, value) = (&points[index], points[index].value());
    let before = |back: usize| index.checked_sub(back).map(|earlier| points[earlier].value());
    let problem = if value.is_nan() || value.abs() > f32::MAX as f64 {
        Some("the value must be finite and fit a 32-bit float".to_owned())
    } else if let Some(previous) = before(1).filter(|&previous| previous > value) {
        Some(format!("points must ascend, the one before is at {previous}"))
    } else if before(2) == Some(value) {
        Some("a third point at the same value: two make a jump".to_owned())
    } else {
        point.problem()
    };
    problem.map_or(Ok(()), |problem| Err(OpticsError::Point { list: P::LIST, index, value, problem }))
}

/// Reads a list of points and checks each as it comes, so that an error is that of the point.
pub(crate) fn read_points<'de, P, D>(deserializer: D) -> Result<Vec<P>, D::Error>
where
    P: ControlPoint + Deserialize<'de>,
    D: Deserializer<'de>,
{
    deserializer.deserialize_seq(Points(Vec::new()))
}

struct Points<P>(Vec<P>);

impl<'de, P: ControlPoint + Deserialize<'de>> Visitor<'de> for Points<P> {
    type Value = Vec<P>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a list of points")
    }

    fn visit_seq<A: SeqAccess<'de>>(mut self, mut seq: A) -> Result<Vec<P>, A::Error> {
        while seq.next_element_seed(&mut self)?.is_some() {}
        check(&self.0).map_err(A::Error::custom)?;
        Ok(self.0)
    }
}

/// Reads the next point.
impl<'de, P: ControlPoint + Deserialize<'de>> DeserializeSeed<'de> for &mut Points<P> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        self.0.push(P::deserialize(deserializer)?);
        check_last(&self.0).map_err(D::Error::custom)
    }
}

/// The two points that make the curve at `value` and how far it is from the first to the second.
/// At a jump the upper side holds; beyond the ends the end points do.
pub(crate) fn locate<P: ControlPoint>(points: &[P], value: f64) -> (&P, &P, f64) {
    let above = points.partition_point(|point| point.value() <= value);
    if above == 0 || above == points.len() {
        let end = &points[above.saturating_sub(1)];
        return (end, end, 0.0);
    }
    let (from, to) = (&points[above - 1], &points[above]);
    let t = (value - from.value()) / (to.value() - from.value());
    let t = match from.interpolation() {
        Interpolation::Linear => t,
        Interpolation::Step => 0.0,
        Interpolation::Smooth => t * t * (3.0 - 2.0 * t),
    };
    (from, to, t)
}

fn is_linear(interpolation: &Interpolation) -> bool {
    *interpolation == Interpolation::Linear
}

// The document forms. They are written by serde's untagged enums, but read by a visitor: an
// untagged enum answers every mistake with "did not match any variant".

#[derive(Serialize, Deserialize, JsonSchema)]
struct ColorPair(f64, Color);

#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct ColorTable {
    /// Data value.
    value: f64,
    /// Colour there.
    color: Color,
    /// The way to the next point.
    #[serde(default, skip_serializing_if = "is_linear")]
    interpolation: Interpolation,
}

#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
enum ColorForm {
    Pair(ColorPair),
    Table(ColorTable),
}

#[derive(Serialize, Deserialize, JsonSchema)]
struct OpacityPair(f64, #[schemars(range(min = 0.0, max = 1.0))] f32);

#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct OpacityTable {
    /// Data value.
    value: f64,
    /// Opacity there over one unit distance.
    #[schemars(range(min = 0.0, max = 1.0))]
    opacity: f32,
    /// The way to the next point.
    #[serde(default, skip_serializing_if = "is_linear")]
    interpolation: Interpolation,
}

#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
enum OpacityForm {
    Pair(OpacityPair),
    Table(OpacityTable),
}

#[derive(Serialize, Deserialize, JsonSchema)]
struct NumberPair(f64, f32);

#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct NumberTable {
    /// Data value.
    value: f64,
    /// Number there.
    number: f32,
    /// The way to the next point.
    #[serde(default, skip_serializing_if = "is_linear")]
    interpolation: Interpolation,
}

#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
enum NumberForm {
    Pair(NumberPair),
    Table(NumberTable),
}

/// Implements the document forms of a point; `$field` is what it has at its value.
macro_rules! document_forms {
    ($point:ident, $form:ident, $pair:ident, $table:ident, $field:ident) => {
        impl From<$pair> for $point {
            fn from($pair(value, $field): $pair) -> Self {
                Self::new(value, $field)
            }
        }

        impl From<$table> for $point {
            fn from($table { value, $field, interpolation }: $table) -> Self {
                Self { value, $field, interpolation }
            }
        }

        impl Serialize for $point {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                let Self { value, $field, interpolation } = *self;
                let form = match interpolation {
                    Interpolation::Linear => $form::Pair($pair(value, $field)),
                    _ => $form::Table($table { value, $field, interpolation }),
                };
                form.serialize(serializer)
            }
        }

        impl<'de> Deserialize<'de> for $point {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let expected =
                    concat!("[value, ", stringify!($field), "] or { value, ", stringify!($field), ", interpolation }");
                deserializer.deserialize_any(PairOrTable::<$pair, $table, $point> { expected, form: PhantomData })
            }
        }

        impl JsonSchema for $point {
            fn schema_name() -> std::borrow::Cow<'static, str> {
                stringify!($point).into()
            }

            fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
                $form::json_schema(generator)
            }
        }
    };
}

document_forms!(ColorPoint, ColorForm, ColorPair, ColorTable, color);
document_forms!(OpacityPoint, OpacityForm, OpacityPair, OpacityTable, opacity);
document_forms!(NumberPoint, NumberForm, NumberPair, NumberTable, number);

/// Reads a point from its short or its long form.
struct PairOrTable<Pair, Table, Point> {
    expected: &'static str,
    form: PhantomData<(Pair, Table, Point)>,
}

impl<'de, Pair, Table, Point> Visitor<'de> for PairOrTable<Pair, Table, Point>
where
    Pair: DeserializeOwned + Into<Point>,
    Table: DeserializeOwned + Into<Point>,
{
    type Value = Point;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.expected)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<Point, A::Error> {
        exactly::<Pair, A>(seq, 2, &self).map(Into::into)
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Point, A::Error> {
        Table::deserialize(MapAccessDeserializer::new(map)).map(Into::into)
    }
}
