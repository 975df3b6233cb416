//! The committed JSON Schema.

use crate::fixtures::VALID;
use scene::Scene;
use serde_json::Value;

/// Renews the committed schema when set.
const RENEW: &str = "LOCOTAMP_RENEW";

/// The schema in `docs/` is the current one.
pub fn assert_committed(name: &str, schema: &Value) {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../docs")
        .join(name);
    let current = serde_json::to_string_pretty(schema).unwrap() + "\n";
    if std::env::var_os(RENEW).is_some() {
        std::fs::write(&path, &current).unwrap();
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        committed == current,
        "docs/{name} is not current; run this test with {RENEW}=1 and read the diff"
    );
}

#[test]
fn the_committed_schema_is_that_of_the_types() {
    assert_committed("scene.schema.json", &scene::json_schema());
}

/// A TOML text as JSON; infinities, which JSON lacks, become large numbers.
fn as_json(text: &str) -> Value {
    let table: toml::Table = toml::from_str(&text.replace("inf]", "1e9]")).unwrap();
    serde_json::to_value(table).unwrap()
}

#[test]
fn the_schema_accepts_valid_scenes() {
    let validator = jsonschema::validator_for(&scene::json_schema()).unwrap();
    let texts = Scene::builtin_names()
        .filter_map(Scene::builtin_text)
        .chain([VALID, include_str!("scenes/hopper.toml")]);
    for text in texts {
        let errors: Vec<String> = validator
            .iter_errors(&as_json(text))
            .map(|error| error.to_string())
            .collect();
        assert!(errors.is_empty(), "{errors:?}\n{text}");
    }
}

#[test]
fn the_schema_rejects_spoiled_scenes() {
    let validator = jsonschema::validator_for(&scene::json_schema()).unwrap();
    let cases = [
        ("name = \"test\"\n", ""),
        ("robot = \"g1\"", "robo = \"g1\""),
        ("mass = 2.0", "mass = \"2 kg\""),
        ("size = [0.4, 0.6, 0.04]", "size = [0.4, 0.6]"),
        ("side = \"+y\"", "side = \"left\""),
        ("[\"bilateral_patch\"]", "[\"sticky\"]"),
        ("position = [0.0, 0.0]\njoints", "position = [0.0]\njoints"),
        ("max_changes = 2", "max_changes = -2"),
    ];
    for (piece, replacement) in cases {
        let text = crate::fixtures::spoiled(piece, replacement);
        assert!(
            !validator.is_valid(&as_json(&text)),
            "{replacement:?} passes the schema"
        );
    }
}

const DOCUMENT: &str = include_str!("../../../docs/scene-format.md");

/// Names of all keys of a schema.
fn keys(schema: &Value, found: &mut std::collections::BTreeSet<String>) {
    if let Some(properties) = schema.get("properties").and_then(Value::as_object) {
        found.extend(properties.keys().cloned());
    }
    let children: Vec<&Value> = match schema {
        Value::Object(map) => map.values().collect(),
        Value::Array(list) => list.iter().collect(),
        _ => Vec::new(),
    };
    for child in children {
        keys(child, found);
    }
}

/// A document names every key of a schema.
pub fn assert_keys_named(schema: &Value, document: &str) {
    let mut found = std::collections::BTreeSet::new();
    keys(schema, &mut found);
    let words: std::collections::BTreeSet<&str> = document
        .split(|c: char| !(c.is_alphanumeric() || c == '_'))
        .collect();
    let missing: Vec<&String> = found
        .iter()
        .filter(|key| !words.contains(key.as_str()))
        .collect();
    assert!(found.len() > 10 && missing.is_empty(), "{missing:?}");
}

#[test]
fn the_document_names_every_key() {
    assert_keys_named(&scene::json_schema(), DOCUMENT);
}

#[test]
fn the_example_of_the_document_is_valid() {
    let example = DOCUMENT
        .split("```toml")
        .nth(1)
        .and_then(|rest| rest.split("```").next());
    let scene =
        crate::fixtures::read(example.unwrap()).unwrap_or_else(|e| panic!("{}", e.render()));
    assert_eq!(scene.name, "pick-place");
}
