//! The committed JSON Schema.

use crate::sample::{sample, sample_json, spoiled};
use serde_json::{Value, json};

/// Renews the committed schema when set.
const RENEW: &str = "LOCOTAMP_RENEW";

fn committed_schema() -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/plan.schema.json")
}

#[test]
fn the_committed_schema_is_that_of_the_types() {
    let current = serde_json::to_string_pretty(&plan::json_schema()).unwrap() + "\n";
    if std::env::var_os(RENEW).is_some() {
        std::fs::write(committed_schema(), &current).unwrap();
    }
    let committed = std::fs::read_to_string(committed_schema()).unwrap_or_default();
    assert!(
        committed == current,
        "docs/plan.schema.json is not current; run this test with {RENEW}=1 and read the diff"
    );
}

#[test]
fn the_schema_accepts_what_is_written_and_what_is_read() {
    let validator = jsonschema::validator_for(&plan::json_schema()).unwrap();
    let written: Value = serde_json::from_str(&sample().to_json().unwrap()).unwrap();
    for value in [sample_json(), written] {
        let errors: Vec<_> = validator
            .iter_errors(&value)
            .map(|e| e.to_string())
            .collect();
        assert!(errors.is_empty(), "{errors:?}");
    }
}

#[test]
fn the_schema_rejects_spoiled_files() {
    let validator = jsonschema::validator_for(&plan::json_schema()).unwrap();
    let cases: [fn(&mut Value); 7] = [
        |p| p["format"] = json!("locotamp.plan/2"),
        |p| p["phases"][0]["steps"] = json!(0),
        |p| p["phases"][0]["contacts"][0]["type"] = json!("sticky"),
        |p| p["h"][0] = json!([1, 2, 3]),
        |p| p["q"][0][0] = json!("0.1"),
        |p| p["integrator"] = json!("rk4"),
        |p| {
            p.as_object_mut().unwrap().remove("tau");
        },
    ];
    for (i, corrupt) in cases.into_iter().enumerate() {
        let value: Value = serde_json::from_str(&spoiled(corrupt)).unwrap();
        assert!(!validator.is_valid(&value), "case {i} passes the schema");
    }
}
