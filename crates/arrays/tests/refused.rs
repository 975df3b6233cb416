//! What is said of plans that have no arrays.

use crate::plans::changed;
use arrays::sample;
use plan::Plan;
use serde_json::json;

fn message(plan: &Plan, rate: f64) -> String {
    let error = sample(plan, rate).expect_err("there are no arrays");
    error.to_string()
}

#[test]
fn rates_out_of_range_are_refused_with_their_value() {
    let plan = changed(|_| ());
    for (rate, said) in [
        (0.0, "0"),
        (-50.0, "-50"),
        (f64::NAN, "NaN"),
        (f64::INFINITY, "inf"),
        (1e9, "1000000000"),
    ] {
        let expected = format!("the rate is {said} Hz, expected a number from 1 to 1000");
        assert_eq!(message(&plan, rate), expected);
    }
}

#[test]
fn a_plan_too_long_for_its_rate_is_refused() {
    let plan = changed(|plan| {
        plan["phases"][1]["duration"] = 1e6.into();
        for t in 5..=10 {
            plan["time"][t] = (0.2 + 1e6 * (t - 4) as f64 / 6.0).into();
        }
    });
    assert_eq!(
        message(&plan, 50.0),
        "1000000.2 s at 50 Hz are more than 200000 samples; a lower rate gives fewer"
    );
}

#[test]
fn faults_of_the_plan_are_named_with_their_place() {
    let joint = changed(|plan| plan["robot"]["joints"][1] = json!("knee"));
    assert_eq!(
        message(&joint, 50.0),
        "robot.joints[1]: the URDF has no moving joint \"knee\""
    );
    let fixed = changed(|plan| plan["robot"]["joints"][1] = json!("wrist"));
    assert!(message(&fixed, 50.0).contains("\"wrist\""));
    let short = changed(|plan| {
        plan["tau"].as_array_mut().unwrap().pop();
    });
    let text = message(&short, 50.0);
    assert!(
        text.contains("tau") && text.ends_with("`locotamp check` lists all faults"),
        "{text}"
    );
    let urdf = changed(|plan| {
        let text = plan["robot"]["urdf"].as_str().unwrap();
        plan["robot"]["urdf"] = text.replace("value=\"8\"", "value=\"heavy\"").into();
    });
    assert!(
        message(&urdf, 50.0).starts_with("robot.urdf: "),
        "{}",
        message(&urdf, 50.0)
    );
}
