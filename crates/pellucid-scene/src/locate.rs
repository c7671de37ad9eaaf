//! Finds the line on which a value of a document stands, for errors found after parsing.

use std::fmt::Write;

use toml::de::{DeTable, DeValue};

use crate::Format;

/// One step from a document to a value in it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// Into a table.
    Key(String),
    /// Into a list, from 0.
    Index(usize),
}

/// The steps of `volumes[0].source.raw`.
pub(crate) fn steps(path: &str) -> Vec<Step> {
    let parts = path.split(['.', '[']).filter(|part| !part.is_empty());
    let step = |part: &str| match part.strip_suffix(']').and_then(|index| index.parse().ok()) {
        Some(index) => Step::Index(index),
        None => Step::Key(part.to_owned()),
    };
    parts.map(step).collect()
}

/// The path as it is written in messages: `volumes[0].source.raw`.
pub(crate) fn path(steps: &[Step]) -> String {
    let mut path = String::new();
    for step in steps {
        match step {
            Step::Key(key) if path.is_empty() => path.push_str(key),
            Step::Key(key) => path.extend([".", key]),
            Step::Index(index) => write!(path, "[{index}]").expect("a string takes any text"),
        }
    }
    path
}

/// Where the deepest part of a path that is written in a text stands, from the first byte of its
/// key (or of itself, in a list), and how many steps lead to it. The text is known to be valid.
pub(crate) fn locate(text: &str, format: Format, steps: &[Step]) -> (Option<usize>, usize) {
    let starts = match format {
        Format::Toml => toml_starts(text, steps),
        Format::Json => json_starts(text, steps),
    };
    (starts.last().map(|start| line_of(text, *start)), starts.len())
}

/// The line, from 1, of a byte offset.
pub(crate) fn line_of(text: &str, offset: usize) -> usize {
    text.as_bytes()[..offset.min(text.len())].iter().filter(|byte| **byte == b'\n').count() + 1
}

/// Where each step of a path starts, as far as it is written.
fn toml_starts(text: &str, steps: &[Step]) -> Vec<usize> {
    let mut starts = Vec::new();
    let Ok(document) = DeTable::parse(text) else { return starts };
    let root = DeValue::Table(document.into_inner());
    let mut here = &root;
    for step in steps {
        let (start, next) = match (here, step) {
            (DeValue::Table(table), Step::Key(key)) => match table.get_key_value(key.as_str()) {
                Some((key, value)) => (key.span().start, value),
                None => break,
            },
            (DeValue::Array(items), Step::Index(index)) => match items.get(*index) {
                Some(value) => (value.span().start, value),
                None => break,
            },
            _ => break,
        };
        starts.push(start);
        here = next.get_ref();
    }
    starts
}

fn json_starts(text: &str, steps: &[Step]) -> Vec<usize> {
    let mut cursor = Json { text: text.as_bytes(), at: 0 };
    steps.iter().map_while(|step| cursor.enter(step)).collect()
}

/// A position in valid JSON.
struct Json<'t> {
    text: &'t [u8],
    at: usize,
}

impl Json<'_> {
    fn peek(&self) -> u8 {
        self.text.get(self.at).copied().unwrap_or(0)
    }

    /// Skips what separates keys and values.
    fn space(&mut self) {
        while matches!(self.peek(), b' ' | b'\n' | b'\r' | b'\t' | b',' | b':') {
            self.at += 1;
        }
    }

    /// Moves from a container to a value in it, and says where its key (or itself) starts.
    fn enter(&mut self, step: &Step) -> Option<usize> {
        self.space();
        if self.peek() != if matches!(step, Step::Key(_)) { b'{' } else { b'[' } {
            return None;
        }
        self.at += 1;
        for position in 0.. {
            self.space();
            let start = self.at;
            if matches!(self.peek(), b'}' | b']' | 0) {
                break;
            }
            match step {
                Step::Index(index) if *index == position => return Some(start),
                Step::Index(_) => {}
                Step::Key(wanted) => {
                    self.skip();
                    // Keys may be written with escapes.
                    let key: Option<String> = serde_json::from_slice(&self.text[start..self.at]).ok();
                    self.space();
                    if key.as_ref() == Some(wanted) {
                        return Some(start);
                    }
                }
            }
            self.skip();
        }
        None
    }

    /// Skips one value or key.
    fn skip(&mut self) {
        let mut depth = 0usize;
        loop {
            match self.peek() {
                0 => return,
                b'"' => self.skip_string(),
                b'{' | b'[' => {
                    depth += 1;
                    self.at += 1;
                }
                b'}' | b']' => {
                    depth = depth.saturating_sub(1);
                    self.at += 1;
                }
                b' ' | b'\n' | b'\r' | b'\t' | b',' | b':' => self.space(),
                _ => self.skip_word(),
            }
            if depth == 0 {
                return;
            }
        }
    }

    fn skip_string(&mut self) {
        self.at += 1;
        while !matches!(self.peek(), b'"' | 0) {
            self.at += if self.peek() == b'\\' { 2 } else { 1 };
        }
        self.at += 1;
    }

    /// Skips a number, `true`, `false` or `null`.
    fn skip_word(&mut self) {
        while matches!(self.peek(), b'+' | b'-' | b'.' | b'0'..=b'9' | b'a'..=b'z' | b'A'..=b'Z') {
            self.at += 1;
        }
    }
}
