//! A small valid plan: a robot with one sliding leg stands on the ground, a box lies beside it, half a second, two phases.

use plan::Plan;
use serde_json::{Value, json};

const URDF: &str = r#"<robot name="hopper">
  <material name="paint"><color rgba="1 0 0.2 1"/></material>
  <link name="trunk">
    <inertial><mass value="8"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>
    <visual><origin xyz="0 0 0.1" rpy="0 0 1.5707963267948966"/><geometry><box size="0.2 0.1 0.3"/></geometry><material name="paint"/></visual>
  </link>
  <link name="leg">
    <inertial><mass value="2"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>
    <visual><geometry><cylinder radius="0.03" length="0.4"/></geometry></visual>
  </link>
  <joint name="slide" type="prismatic"><parent link="trunk"/><child link="leg"/><origin xyz="0 0 -0.3"/><axis xyz="0 0 1"/>
    <limit lower="-0.2" upper="0.2" effort="300" velocity="5"/></joint>
</robot>"#;

/// Height of the trunk at each of the five nodes [m].
const HEIGHTS: [f64; 5] = [0.5, 0.49, 0.48, 0.49, 0.5];

/// The plan as JSON.
pub(crate) fn sample_json() -> Value {
    let identity = json!([0, 0, 0, 0, 0, 0, 1]);
    let foot = |rows: usize| {
        json!({"a": "sole", "b": "ground_top", "type": "unilateral_patch", "mu": 0.5, "mu_r": 0.02,
               "wrench": vec![[10.0, 0.0, 100.0, 2.0, 1.0, 0.0]; rows]})
    };
    let resting = |rows: usize| {
        json!({"a": "crate_bottom", "b": "ground_top", "type": "unilateral_patch", "mu": 0.5, "mu_r": 0.02,
               "wrench": vec![[0.0, 0.0, 9.81, 0.0, 0.0, 0.0]; rows]})
    };
    let q: Vec<_> = HEIGHTS
        .iter()
        .map(|z| json!([0, 0, z, 0, 0, 0, 1, 0.5 - z]))
        .collect();
    let lying = json!([0.5, 0, 0.1, 0, 0, 0, 1]);
    json!({
        "format": "locotamp.plan/1", "generator": "test", "task": "sample", "status": "feasible",
        "integrator": "euler", "dynamics": "momentum",
        "robot": {"name": "hopper", "urdf": URDF, "joints": ["slide"], "torque_limits": [200.0]},
        "objects": [{"name": "green_crate", "mass": 1.0, "inertia": [0.01, 0.01, 0.01, 0, 0, 0],
                     "geometry": [{"box": [0.1, 0.1, 0.1], "pose": identity}]}],
        "environment": [{"name": "ground", "geometry": [{"plane": true, "pose": identity}]}],
        "interfaces": [
            {"name": "sole", "body": "leg", "pose": [0, 0, -0.2, 1, 0, 0, 0], "kind": "patch", "half_size": [0.08, 0.04]},
            {"name": "crate_bottom", "body": "green_crate", "pose": [0, 0, -0.1, 1, 0, 0, 0], "kind": "patch", "half_size": [0.1, 0.1]},
            {"name": "ground_top", "body": "ground", "pose": identity, "kind": "patch", "half_size": null}],
        "goal": [{"a": "sole", "b": "ground_top"}],
        "phases": [
            {"duration": 0.2, "steps": 2, "action": "start", "contacts": [foot(2), resting(2)]},
            {"duration": 0.3, "steps": 2, "action": "stay </script> & go", "contacts": [foot(2), resting(2)]}],
        "time": [0.0, 0.1, 0.2, 0.35, 0.5],
        "q": q, "v": vec![[0.0; 7]; 5], "h": vec![[0.0; 6]; 5], "a": vec![[0.0; 7]; 4], "tau": [[50.0], [60.0], [-150.0], [70.0]],
        "object_states": {"green_crate": {"pose": vec![lying; 5], "twist": vec![[0.0; 6]; 5], "accel": vec![[0.0; 6]; 4]}},
    })
}

/// The plan with `change` applied to its JSON.
pub(crate) fn changed(change: impl FnOnce(&mut Value)) -> Plan {
    let mut value = sample_json();
    change(&mut value);
    Plan::from_json(&value.to_string()).expect("the change leaves a plan")
}

/// The plan.
pub(crate) fn sample() -> Plan {
    changed(|_| ())
}
