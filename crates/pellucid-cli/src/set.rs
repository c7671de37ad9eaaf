//! `--set PATH=VALUE`: any setting of the scene document by its place in it.

use std::fmt;
use std::str::FromStr;

use pellucid::scene::{Scene, json_schema, pointed};
use serde_json::{Map, Value};

use super::failure::Failure;

/// One `PATH=VALUE`.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    path: Vec<Step>,
    /// `None` removes the setting.
    value: Option<Value>,
}

/// One step of a path.
#[derive(Clone, Debug, PartialEq)]
enum Step {
    Key(String),
    Index(usize),
}

impl FromStr for Setting {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (path, value) = text.split_once('=').ok_or("expected PATH=VALUE, as in quality.step=0.25")?;
        Ok(Self { path: parse_path(path.trim())?, value: parse_value(value.trim())? })
    }
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let value = self.value.as_ref().map(|value| value.as_str().map_or_else(|| value.to_string(), str::to_owned));
        write!(f, "{}={}", self.path_text(self.path.len() - 1), value.unwrap_or_default())
    }
}

/// `volumes[0].window` as key, index, key.
fn parse_path(path: &str) -> Result<Vec<Step>, String> {
    let unclear = || format!("'{path}' is not a path like volumes[0].window");
    let mut steps = Vec::new();
    for part in path.split('.') {
        let (key, mut rest) = part.split_at(part.find('[').unwrap_or(part.len()));
        if key.is_empty() || key.contains(char::is_whitespace) {
            return Err(unclear());
        }
        steps.push(Step::Key(key.to_owned()));
        while !rest.is_empty() {
            let (index, after) = rest.strip_prefix('[').and_then(|rest| rest.split_once(']')).ok_or_else(unclear)?;
            steps.push(Step::Index(index.parse().map_err(|_| unclear())?));
            rest = after;
        }
    }
    Ok(steps)
}

/// A TOML value, a bare word, or nothing.
fn parse_value(text: &str) -> Result<Option<Value>, String> {
    if text.is_empty() {
        return Ok(None);
    }
    match toml::from_str::<Map<String, Value>>(&format!("value = {text}")) {
        // TOML has no null: it stands for a number that JSON does not have.
        Ok(table) if table.values().any(has_null) => Err(format!("{text}: numbers must be finite")),
        // More than one key: the text went on after a line break.
        Ok(mut table) if table.len() == 1 => Ok(table.remove("value")),
        _ if !text.contains(['[', ']', '{', '}', '"', '\'', '\n']) => Ok(Some(Value::String(text.to_owned()))),
        _ => Err(format!("{text} is not a TOML value")),
    }
}

fn has_null(value: &Value) -> bool {
    match value {
        Value::Null => true,
        Value::Array(items) => items.iter().any(has_null),
        Value::Object(table) => table.values().any(has_null),
        _ => false,
    }
}

/// The scene with the settings applied in order, and checked.
pub fn apply(scene: &Scene, settings: &[Setting]) -> Result<Scene, Failure> {
    let mut scene = scene.clone();
    if !settings.is_empty() {
        let schema: Value = serde_json::from_str(&json_schema()).map_err(Failure::work)?;
        let mut document = serde_json::to_value(&scene).map_err(Failure::input)?;
        for setting in settings {
            setting.write(&mut document, &schema)?;
        }
        scene = serde_path_to_error::deserialize(document).map_err(|error| {
            Failure::input(format_args!("--set {}: {}", error.path(), pointed(&error.inner().to_string())))
                .hint("'pellucid schema' prints every path and what it takes")
        })?;
    }
    scene.validate().map_err(Failure::input)?;
    Ok(scene)
}

impl Setting {
    fn write(&self, document: &mut Value, schema: &Value) -> Result<(), Failure> {
        let mut here = document;
        let mut node = Some(schema);
        for (k, step) in self.path.iter().enumerate() {
            let last = k + 1 == self.path.len();
            here = match step {
                Step::Key(key) => {
                    let known = here.as_object().is_some_and(|object| object.contains_key(key));
                    // Another variant of an enumeration replaces the one that is there.
                    let replace = !known && node.is_some_and(|node| is_choice(schema, node));
                    if replace || !here.is_object() {
                        *here = Value::Object(Map::new());
                    }
                    let Value::Object(object) = here else { return Ok(()) };
                    if last && self.value.is_none() {
                        object.remove(key);
                        return Ok(());
                    }
                    object.entry(key.clone()).or_insert(Value::Null)
                }
                Step::Index(index) => {
                    if !here.is_array() {
                        *here = Value::Array(Vec::new());
                    }
                    let Value::Array(items) = here else { return Ok(()) };
                    let length = items.len();
                    if *index > length || (last && self.value.is_none()) {
                        let problem = if *index > length {
                            format!("the list has {length} elements (numbered from 0): only the next can be added")
                        } else {
                            "elements of a list cannot be removed one by one: set the whole list".into()
                        };
                        return Err(Failure::input(format_args!("--set {}: {problem}", self.path_text(k))));
                    }
                    if *index == length {
                        items.push(Value::Null);
                    }
                    &mut items[*index]
                }
            };
            node = node.and_then(|node| child(schema, node, step));
        }
        *here = self.value.clone().unwrap_or(Value::Null);
        Ok(())
    }

    /// The path up to and with step `k`.
    fn path_text(&self, k: usize) -> String {
        let mut text = String::new();
        for step in &self.path[..=k] {
            match step {
                Step::Key(key) if text.is_empty() => text.push_str(key),
                Step::Key(key) => text.push_str(&format!(".{key}")),
                Step::Index(index) => text.push_str(&format!("[{index}]")),
            }
        }
        text
    }
}

/// The alternatives of a schema: itself, or what it refers to.
fn alternatives<'s>(root: &'s Value, node: &'s Value) -> Vec<&'s Value> {
    if let Some(reference) = node["$ref"].as_str() {
        let target = reference.strip_prefix('#').and_then(|pointer| root.pointer(pointer));
        return target.map_or_else(Vec::new, |target| alternatives(root, target));
    }
    let several = node["oneOf"].as_array().or(node["anyOf"].as_array());
    several.map_or_else(|| vec![node], |list| list.iter().flat_map(|part| alternatives(root, part)).collect())
}

/// Whether a table there has one key out of several: an enumeration that names its variant so.
fn is_choice(root: &Value, node: &Value) -> bool {
    let keys = alternatives(root, node).into_iter().filter_map(|part| part["properties"].as_object());
    let keys: Vec<usize> = keys.map(Map::len).collect();
    keys.len() > 1 && keys.iter().all(|keys| *keys == 1)
}

/// The schema of a step within a schema.
fn child<'s>(root: &'s Value, node: &'s Value, step: &Step) -> Option<&'s Value> {
    alternatives(root, node).into_iter().find_map(|part| match step {
        Step::Key(key) => part["properties"].get(key),
        Step::Index(index) => part["prefixItems"].get(index).or(part.get("items")),
    })
}
