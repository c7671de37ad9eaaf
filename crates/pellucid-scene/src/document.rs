//! Scenes as text: TOML and JSON, one schema, errors that point at the line.

use std::fmt;

use crate::locate::{json_line, toml_line};
use crate::{Invalid, Scene};

/// The text formats of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// `.toml`
    Toml,
    /// `.json`
    Json,
}

impl Format {
    /// The format of a file name, if its extension is one of ours.
    pub fn of(path: &std::path::Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "toml" => Some(Self::Toml),
            "json" => Some(Self::Json),
            _ => None,
        }
    }
}

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
        let scene: Self = match format {
            Format::Toml => toml::from_str(text).map_err(|error| DocumentError {
                line: error.span().map(|span| line_of(text, span.start)),
                message: error.message().trim_end().replace('\n', ", "),
            })?,
            Format::Json => serde_json::from_str(text).map_err(|error| DocumentError {
                line: Some(error.line()).filter(|line| *line > 0),
                message: without_position(&error.to_string()),
            })?,
        };
        scene.validate().map_err(|Invalid { path, message }| DocumentError {
            line: match format {
                Format::Toml => toml_line(text, &path),
                Format::Json => json_line(text, &path),
            },
            message: format!("{path}: {message}"),
        })?;
        Ok(scene)
    }

    /// The scene as text; [`Scene::parse`] gives the same scene back.
    ///
    /// # Panics
    /// Never: every scene can be written in both formats.
    pub fn to_text(&self, format: Format) -> String {
        match format {
            Format::Toml => toml::to_string_pretty(self).expect("scene types have TOML forms"),
            Format::Json => serde_json::to_string_pretty(self).expect("scene types have JSON forms"),
        }
    }
}

/// The JSON Schema of scene documents (for both formats).
pub fn json_schema() -> String {
    let schema = schemars::schema_for!(Scene);
    serde_json::to_string_pretty(&schema).expect("a schema is JSON") + "\n"
}

/// The line, from 1, of a byte offset.
pub(crate) fn line_of(text: &str, offset: usize) -> usize {
    text.as_bytes()[..offset.min(text.len())].iter().filter(|byte| **byte == b'\n').count() + 1
}

/// serde_json appends " at line L column C"; the line is reported apart.
fn without_position(message: &str) -> String {
    message.rsplit_once(" at line ").map_or(message, |(head, _)| head).to_owned()
}
