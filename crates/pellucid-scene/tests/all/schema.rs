//! The schema of scene documents, and what its texts say about defaults.

use std::path::{Path, PathBuf};

use pellucid_scene::{Format, Scene, json_schema};
use serde_json::Value;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

#[test]
fn the_published_schema_is_that_of_the_code() {
    let published = std::fs::read_to_string(root().join("docs/scene.schema.json")).unwrap_or_default();
    assert!(
        published == json_schema(),
        "docs/scene.schema.json is not the schema of this code; write it again: pellucid schema > docs/scene.schema.json"
    );
}

/// Every property of every object of the schema, as (name, its schema).
fn properties(schema: &Value) -> Vec<(String, Value)> {
    let mut found = Vec::new();
    match schema {
        Value::Object(object) => {
            for (key, value) in object {
                if key == "properties" {
                    found.extend(value.as_object().unwrap().clone());
                }
                found.extend(properties(value));
            }
        }
        Value::Array(items) => found.extend(items.iter().flat_map(properties)),
        _ => {}
    }
    found
}

/// What the word after "default" in a text promises.
fn promised(text: &str) -> Option<Value> {
    let (_, rest) = text.split_once("Default ").or_else(|| text.split_once("default "))?;
    // Up to the end of the clause; a point within a number is not one.
    let end = rest.find(['\n', ',', ';', '(']).unwrap_or(rest.len());
    let clause = rest[..end].split(". ").next().unwrap().trim().trim_end_matches('.');
    Some(match clause {
        "black" => serde_json::json!({ "color": "#000000" }),
        "white" => Value::from("#ffffff"),
        "+z" => serde_json::json!([0.0, 0.0, 1.0]),
        "the world" => Value::from("world"),
        "the mean voxel spacing" => return None,
        word => serde_json::from_str(word).unwrap_or_else(|_| Value::from(word)),
    })
}

fn equal(a: &Value, b: &Value) -> bool {
    match (a.as_f64(), b.as_f64()) {
        // Single precision settings have their default's nearest neighbour in the schema.
        (Some(a), Some(b)) => a as f32 == b as f32,
        _ => a == b,
    }
}

#[test]
fn documented_defaults_are_those_of_the_code() {
    let schema: Value = serde_json::from_str(&json_schema()).unwrap();
    let (mut checked, mut silent) = (0, Vec::new());
    for (name, property) in properties(&schema) {
        let text = property["description"].as_str().unwrap_or_default();
        let default = property.get("default");
        match (promised(text), default) {
            (Some(promised), Some(default)) => {
                assert!(equal(&promised, default), "{name}: {text:?} says {promised}, the code has {default}");
                checked += 1;
            }
            (Some(promised), None) => panic!("{name} says its default is {promised}, but the code has none"),
            // Structures say theirs field by field; null is "left out"; empty is nothing.
            (None, Some(Value::Number(_) | Value::Bool(_))) => silent.push(name),
            (None, Some(Value::String(default))) if !default.is_empty() => silent.push(name),
            (None, _) => {}
        }
    }
    assert!(checked > 35, "only {checked} documented defaults were found");
    assert!(silent.is_empty(), "defaults without a word: {silent:?}");
}

#[test]
fn every_property_is_described_and_every_reference_leads_somewhere() {
    let text = json_schema();
    let schema: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(schema["type"], "object");
    assert_eq!(schema["additionalProperties"], false);
    let fields = serde_json::to_value(Scene::default()).unwrap();
    assert!(fields.as_object().unwrap().keys().eq(schema["properties"].as_object().unwrap().keys()));
    let references = text.split("\"$ref\": \"#/$defs/").skip(1).map(|rest| rest.split('"').next().unwrap());
    let mut count = 0;
    for reference in references {
        assert!(schema["$defs"][reference].is_object(), "{reference}");
        count += 1;
    }
    assert!(count > 20);
    // A variant is described beside its property.
    let variants = [
        "perspective",
        "orthographic",
        "orbit",
        "look_at",
        "plane",
        "box",
        "file",
        "raw",
        "sample",
        "model",
        "clouds",
        "spectral",
        "height_field",
        "terrain",
        "constant",
        "colors",
        "values",
    ];
    for (name, property) in properties(&schema) {
        let variant = variants.contains(&name.as_str()) || property.get("$ref").is_some();
        assert!(variant || property["description"].is_string() || property["properties"].is_object(), "{name}");
    }
}

#[test]
fn example_scenes_are_scenes() {
    let Ok(folder) = std::fs::read_dir(root().join("scenes")) else { return };
    for path in folder.map(|entry| entry.unwrap().path()) {
        if let Some(format) = Format::of(&path) {
            let scene = Scene::parse(&std::fs::read_to_string(&path).unwrap(), format);
            assert!(scene.is_ok(), "{}: {}", path.display(), scene.unwrap_err());
        }
    }
}
