//! Writing: exact numbers, unknown keys kept, whole files only.

use crate::sample::{sample, sample_json};
use plan::{Plan, PlanError};
use serde_json::{Value, json};

#[test]
fn a_plan_reads_back_equal_with_its_unknown_keys() {
    let mut plan = sample();
    plan.extra.insert("report".into(), json!({"iterations": 7}));
    plan.robot.extra.insert("colour".into(), json!("grey"));
    plan.phases[0].contacts[0]
        .extra
        .insert("note".into(), json!([1, 2]));
    let back = Plan::from_json(&plan.to_json().unwrap()).unwrap();
    assert_eq!(back, plan);
    assert_eq!(back.phases[0].contacts[0].extra["note"], json!([1, 2]));
}

#[test]
fn numbers_round_trip_bit_for_bit() {
    let hard = [
        0.1,
        1.0 / 3.0,
        f64::MIN_POSITIVE,
        5e-324,
        f64::MAX,
        -0.0,
        1e22,
        9_007_199_254_740_993.0,
        2.0_f64.sqrt(),
        4.35,
    ];
    let mut state = 0x9E37_79B9_7F4A_7C15_u64;
    for round in 0..200 {
        let mut plan = sample();
        for row in &mut plan.v {
            for x in row.iter_mut() {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                let candidate = f64::from_bits(state);
                *x = if candidate.is_finite() {
                    candidate
                } else {
                    hard[round % hard.len()]
                };
            }
        }
        plan.v[0][0] = hard[round % hard.len()];
        let back = Plan::from_json(&plan.to_json().unwrap()).unwrap();
        let bits = |p: &Plan| {
            p.v.iter()
                .flatten()
                .map(|x| x.to_bits())
                .collect::<Vec<_>>()
        };
        assert_eq!(bits(&back), bits(&plan));
    }
}

#[test]
fn one_row_of_numbers_stands_on_one_line() {
    let text = sample().to_json().unwrap();
    let row = "  [0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 1.0, 0.3]";
    assert_eq!(
        text.lines()
            .filter(|line| line.trim_end_matches(',') == row)
            .count(),
        4,
        "{text}"
    );
}

#[test]
fn an_absent_optional_key_is_not_written() {
    let mut plan = sample();
    plan.goal_regions.clear();
    plan.objective = None;
    let written: Value = serde_json::from_str(&plan.to_json().unwrap()).unwrap();
    assert!(written.get("goal_regions").is_none() && written.get("objective").is_none());
    assert!(sample_json().get("goal_regions").is_some());
}

#[test]
fn a_file_is_replaced_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plan.json");
    sample().write(&path).unwrap();
    let mut broken = sample();
    broken.q[1][2] = f64::NAN;
    assert!(matches!(
        broken.write(&path),
        Err(PlanError::NotFinite { .. })
    ));
    assert_eq!(Plan::read(&path).unwrap(), sample());
    let names: Vec<_> = std::fs::read_dir(folder.path())
        .unwrap()
        .map(|f| f.unwrap().file_name())
        .collect();
    assert_eq!(names, ["plan.json"], "no temporary file stays");
}

#[test]
fn a_folder_that_is_not_there_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("absent/plan.json");
    let text = sample().write(&path).unwrap_err().to_string();
    assert!(text.contains("absent/plan.json: "), "{text}");
}
