//! Scenes as text: TOML and JSON, one schema, errors that point at the line.

use std::fmt;

use serde_json::{Number, Value};
use serde_path_to_error::Segment;

use crate::citations;
use crate::locate::{Step, line_of, locate, path, steps};
use crate::meant::pointed;
use crate::{Format, Invalid, Scene};

/// Why a text is not a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub struct DocumentError {
    /// Line of the text, from 1, where known.
    pub line: Option<usize>,
    /// What is wrong and what is expected there.
    pub message: String,
}

impl fmt::Display for DocumentError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "line {line}: {}", self.message),
            None => f.write_str(&self.message),
        }
    }
}

impl Scene {
    /// Reads a scene and checks every value.
    ///
    /// # Errors
    /// Unknown keys, wrong types and values out of range, with the line they stand on.
    pub fn parse(text: &str, format: Format) -> Result<Self, DocumentError> {
        let value = match format {
            Format::Toml => value_from_toml(text)?,
            Format::Json => serde_json::from_str(text).map_err(json_error)?,
        };
        let scene: Self = serde_path_to_error::deserialize(value).map_err(|error| {
            let message = error.inner().to_string();
            let mut steps: Vec<Step> = error.path().iter().map_while(step).collect();
            // The path ends before a variant that does not exist; it stands there as key or as text.
            let variant = message.strip_prefix("unknown variant `").and_then(|rest| rest.split('`').next());
            steps.extend(variant.map(|variant| Step::Key(variant.to_owned())));
            let (line, depth) = locate(text, format, &steps);
            DocumentError::at(line, &path(&steps[..depth]), &pointed(&message))
        })?;
        scene.validate().map_err(|Invalid { path, message }| {
            let (line, _) = locate(text, format, &steps(&path));
            DocumentError::at(line, &path, &message)
        })?;
        match format {
            Format::Toml => Ok(scene),
            // A value has kept the last of several equal keys: only reading the text finds them.
            Format::Json => serde_json::from_str(text).map_err(json_error),
        }
    }

    /// The scene as text; [`Scene::parse`] gives the same scene back.
    ///
    /// # Errors
    /// A value out of range, and a path that is not Unicode: neither format can hold it.
    pub fn to_text(&self, format: Format) -> Result<String, DocumentError> {
        self.validate().map_err(|Invalid { path, message }| DocumentError::at(None, &path, &message))?;
        match format {
            Format::Toml => toml::to_string_pretty(self).map_err(|error| error.to_string()),
            Format::Json => serde_json::to_string_pretty(self).map_err(|error| error.to_string()),
        }
        .map_err(|message| DocumentError { line: None, message })
    }
}

impl DocumentError {
    fn at(line: Option<usize>, path: &str, message: &str) -> Self {
        let message = if path.is_empty() { message.to_owned() } else { format!("{path}: {message}") };
        Self { line, message }
    }
}

/// What went wrong while reading JSON text itself.
fn json_error(error: serde_json::Error) -> DocumentError {
    let message = error.to_string();
    // serde_json appends " at line L column C"; the line is reported apart.
    let message = message.rsplit_once(" at line ").map_or(message.as_str(), |(head, _)| head);
    DocumentError { line: Some(error.line()).filter(|line| *line > 0), message: message.to_owned() }
}

/// TOML as a JSON value, so that both formats are read, and answered, alike. (Read directly, TOML
/// also drops what a list has too much.)
fn value_from_toml(text: &str) -> Result<Value, DocumentError> {
    let table: toml::Table = toml::from_str(text).map_err(|error| DocumentError {
        line: error.span().map(|span| line_of(text, span.start)),
        message: error.message().trim_end().replace('\n', ", "),
    })?;
    let mut steps = Vec::new();
    json_from_toml(toml::Value::Table(table), &mut steps)
        .map_err(|message| DocumentError::at(locate(text, Format::Toml, &steps).0, &path(&steps), message))
}

/// The JSON value of a TOML value, or what is wrong with the value that `steps` then lead to.
fn json_from_toml(value: toml::Value, steps: &mut Vec<Step>) -> Result<Value, &'static str> {
    let mut inner = |step, value| {
        steps.push(step);
        let value = json_from_toml(value, steps)?;
        steps.pop();
        Ok::<_, &'static str>(value)
    };
    Ok(match value {
        toml::Value::String(text) => Value::String(text),
        toml::Value::Integer(number) => number.into(),
        toml::Value::Float(number) => {
            Value::Number(Number::from_f64(number).ok_or("found a number that is not finite, expected a finite one")?)
        }
        toml::Value::Boolean(switch) => Value::Bool(switch),
        toml::Value::Datetime(_) => return Err("found a date, expected text in quotes or a number"),
        toml::Value::Array(items) => {
            let items = items.into_iter().enumerate().map(|(k, item)| inner(Step::Index(k), item));
            Value::Array(items.collect::<Result<_, &'static str>>()?)
        }
        toml::Value::Table(table) => {
            let entries = table.into_iter().map(|(key, value)| Ok((key.clone(), inner(Step::Key(key), value)?)));
            Value::Object(entries.collect::<Result<_, &'static str>>()?)
        }
    })
}

fn step(segment: &Segment) -> Option<Step> {
    match segment {
        Segment::Seq { index } => Some(Step::Index(*index)),
        Segment::Map { key } | Segment::Enum { variant: key } => Some(Step::Key(key.clone())),
        Segment::Unknown => None,
    }
}

/// The JSON Schema of scene documents (for both formats).
pub fn json_schema() -> String {
    let mut schema = schemars::schema_for!(Scene);
    schema.ensure_object().values_mut().for_each(citations::leave_out);
    serde_json::to_string_pretty(&schema).expect("a schema is JSON") + "\n"
}
