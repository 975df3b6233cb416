//! Reading: defaults, unknown keys, and every message about files that are not plans.

use crate::sample::{sample, sample_json, spoiled};
use plan::{ContactType, Dynamics, Integrator, InterfaceKind, Plan, PlanError, Status};
use serde_json::{Value, json};

fn message(text: &str) -> String {
    Plan::from_json(text).unwrap_err().to_string()
}

#[test]
fn every_key_of_the_format_arrives() {
    let plan = sample();
    assert_eq!(
        (plan.status, plan.integrator),
        (Status::Feasible, Integrator::SemiImplicitEuler)
    );
    assert_eq!(plan.dynamics, Dynamics::BaseRows);
    assert_eq!(plan.objective.as_ref().map(|o| o.cost), Some(Some(12.5)));
    assert_eq!(plan.robot.torque_limits, Some(vec![None]));
    assert_eq!(plan.interfaces[2].half_size, Some([None, Some(3.0)]));
    assert_eq!(plan.interfaces[1].kind, InterfaceKind::Point);
    assert_eq!(plan.interfaces[1].limb, Some([0.0, 0.0, -2.0]));
    assert_eq!(
        plan.phases[0].contacts[0].kind,
        ContactType::UnilateralPatch
    );
    assert!(plan.environment[0].geometry[0].is_plane());
    assert_eq!(plan.goal_regions[0].upper, [Some(1.0), Some(1.0), None]);
    assert_eq!(
        plan.extra.keys().collect::<Vec<_>>(),
        ["margins", "summary"]
    );
    assert_eq!(
        (plan.n_intervals(), plan.phase_starts(), plan.n_joints()),
        (3, vec![0, 2, 3], 1)
    );
    assert!((plan.duration() - 0.2).abs() < 1e-15);
}

#[test]
fn absent_optional_keys_have_the_documented_defaults() {
    let text = spoiled(|p| {
        for key in [
            "generator",
            "task",
            "gravity",
            "dynamics",
            "goal",
            "goal_regions",
            "objective",
            "violation",
        ] {
            p.as_object_mut().unwrap().remove(key);
        }
        p["phases"][0]["contacts"][0]
            .as_object_mut()
            .unwrap()
            .remove("mu");
    });
    let plan = Plan::from_json(&text).unwrap();
    assert_eq!(
        (plan.gravity, plan.dynamics),
        ([0.0, 0.0, -9.81], Dynamics::Momentum)
    );
    assert!(plan.goal.is_empty() && plan.objective.is_none());
    assert_eq!(plan.phases[0].contacts[0].mu, 0.0);
}

#[test]
fn a_missing_key_is_named() {
    let text = spoiled(|p| {
        p.as_object_mut().unwrap().remove("tau");
    });
    assert!(
        message(&text).contains("missing field `tau`"),
        "{}",
        message(&text)
    );
}

#[test]
fn a_wrong_type_is_named_with_its_place() {
    let text = spoiled(|p| p["phases"][1]["contacts"][0]["type"] = json!("sticky"));
    let text = message(&text);
    assert!(
        text.starts_with("phases[1].contacts[0].type: unknown variant `sticky`"),
        "{text}"
    );
    let text = message(&spoiled(|p| {
        p["object_states"]["box"]["pose"][2] = json!([1, 2]);
    }));
    assert!(
        text.starts_with("object_states.box.pose[2]: invalid length 2"),
        "{text}"
    );
    let text = message(&spoiled(|p| p["q"][3][1] = json!(null)));
    assert!(text.starts_with("q[3][1]: invalid type: null"), "{text}");
}

#[test]
fn other_formats_are_refused_by_name() {
    let text = message(&spoiled(|p| p["format"] = json!("locotamp.plan/0")));
    assert!(
        text.contains("\"locotamp.plan/0\", expected \"locotamp.plan/1\"; another version"),
        "{text}"
    );
    for other in [json!("urdf"), json!(7)] {
        let text = message(&spoiled(|p| p["format"] = other));
        assert!(text.contains("is it a plan file?"), "{text}");
    }
    assert!(message("{}").contains("without a format string"));
}

#[test]
fn text_that_is_not_json_gives_line_and_column() {
    let text = message("{\n \"format\": \"locotamp.plan/1\",\n oops");
    assert!(text.contains("line 3 column 2"), "{text}");
    assert!(matches!(
        Plan::from_json("[1, 2]"),
        Err(PlanError::Json { .. } | PlanError::Format { .. })
    ));
    assert!(Plan::from_json("").is_err());
}

#[test]
fn a_missing_file_is_named() {
    let text = Plan::read("no/such/plan.json").unwrap_err().to_string();
    assert!(text.starts_with("no/such/plan.json: "), "{text}");
}

#[test]
fn cutting_a_file_anywhere_gives_an_error_and_no_panic() {
    let text = sample_json().to_string();
    for end in (0..text.len()).step_by(7) {
        assert!(Plan::from_json(&text[..end]).is_err());
    }
}

#[test]
fn replacing_any_value_gives_an_error_or_a_plan_and_no_panic() {
    let replacements = [
        json!(null),
        json!(-1),
        json!(1e308),
        json!("x"),
        json!([]),
        json!({}),
        json!(u64::MAX),
        json!(true),
    ];
    for pointer in pointers(&sample_json(), String::new()) {
        for replacement in &replacements {
            let text = spoiled(|p| *p.pointer_mut(&pointer).unwrap() = replacement.clone());
            if let Ok(plan) = Plan::from_json(&text) {
                plan.faults();
            }
        }
    }
}

fn pointers(value: &Value, at: String) -> Vec<String> {
    let mut all = match value {
        Value::Object(map) => map
            .iter()
            .flat_map(|(key, x)| pointers(x, format!("{at}/{key}")))
            .collect(),
        Value::Array(items) => items
            .iter()
            .enumerate()
            .flat_map(|(i, x)| pointers(x, format!("{at}/{i}")))
            .collect(),
        _ => Vec::new(),
    };
    all.push(at);
    all
}
