//! A small valid plan: a box on a foot, one phase of two intervals, one of one.

use plan::Plan;
use serde_json::{Value, json};

/// The plan as JSON, with keys of the writer's own.
pub(crate) fn sample_json() -> Value {
    let identity = json!([0, 0, 0, 0, 0, 0, 1]);
    let contact = |rows: usize| {
        json!({"a": "sole", "b": "ground_top", "type": "unilateral_patch", "mu": 0.7, "mu_r": 0.02,
               "wrench": vec![[0.0, 0.0, 9.81, 0.0, 0.0, 0.0]; rows]})
    };
    let q = vec![vec![0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 1.0, 0.3]; 4];
    json!({
        "format": "locotamp.plan/1", "generator": "test", "task": "sample", "status": "feasible",
        "objective": {"name": "time", "value": 0.1, "cost": 12.5}, "violation": 3.1e-6,
        "gravity": [0, 0, -9.81], "integrator": "semi_implicit_euler", "dynamics": "base_rows",
        "robot": {"name": "r", "urdf": "<robot name=\"r\"><link name=\"foot\"/></robot>", "joints": ["knee"],
                  "torque_limits": [null]},
        "objects": [{"name": "box", "mass": 1.0, "inertia": [0.1, 0.1, 0.1, 0, 0, 0],
                     "geometry": [{"box": [0.1, 0.1, 0.1], "pose": identity}]}],
        "environment": [{"name": "ground", "geometry": [{"plane": true, "pose": identity}]}],
        "interfaces": [
            {"name": "sole", "body": "foot", "pose": [0, 0, -0.1, 1, 0, 0, 0], "kind": "patch", "half_size": [0.1, 0.05]},
            {"name": "tip", "body": "box", "pose": identity, "kind": "point", "half_size": null, "limb": [0, 0, -2]},
            {"name": "ground_top", "body": "ground", "pose": identity, "kind": "patch", "half_size": [null, 3.0]}],
        "goal": [{"a": "sole", "b": "ground_top"}],
        "goal_regions": [{"body": "box", "lower": [null, -1, 0], "upper": [1, 1, null]}],
        "phases": [
            {"duration": 0.1, "steps": 2, "action": "start", "contacts": [contact(2)]},
            {"duration": 0.1, "steps": 1, "action": "stay", "contacts": [contact(1)]}],
        "time": [0.0, 0.05, 0.1, 0.2],
        "q": q, "v": vec![[0.0; 7]; 4], "h": vec![[0.0; 6]; 4], "a": vec![[0.0; 7]; 3], "tau": [[0.5], [0.5], [0.5]],
        "object_states": {"box": {"pose": vec![identity; 4], "twist": vec![[0.0; 6]; 4], "accel": vec![[0.0; 6]; 3]}},
        "costs": {"terms": ["time", "force"], "per_interval": [[0.05, 2.0], [0.05, 2.0], [0.1, 8.0]], "end": {"goal": -0.5}},
        "margins": {"friction": [0.4, 0.0]}, "summary": "two phases"
    })
}

/// The plan, read.
pub(crate) fn sample() -> Plan {
    Plan::from_json(&sample_json().to_string()).expect("the sample is a plan")
}

/// The sample with `corrupt` applied to its JSON, as text.
pub(crate) fn spoiled(corrupt: impl FnOnce(&mut Value)) -> String {
    let mut value = sample_json();
    corrupt(&mut value);
    value.to_string()
}
