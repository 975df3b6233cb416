//! A plan that moves: a trunk that turns more than once, an arm that turns, a foot that slides, a tumbling crate; two phases.

use nalgebra::Vector6;
use plan::{Integrator, Plan};
use serde_json::{Value, json};
use spatial::Pose;

const URDF: &str = r#"<robot name="mover">
  <link name="trunk"><inertial><mass value="8"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
  <link name="arm"><inertial><mass value="1"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
  <link name="foot"><inertial><mass value="2"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
  <link name="palm"/>
  <joint name="shoulder" type="revolute"><parent link="trunk"/><child link="arm"/><origin xyz="0.1 0.2 0.3" rpy="0.3 0 0"/>
    <axis xyz="0 0.6 0.8"/><limit lower="-9" upper="9" effort="300" velocity="9"/></joint>
  <joint name="wrist" type="fixed"><parent link="arm"/><child link="palm"/><origin xyz="0 0 -0.3" rpy="0 0.5 0"/></joint>
  <joint name="slide" type="prismatic"><parent link="trunk"/><child link="foot"/><origin xyz="0 0 -0.3"/><axis xyz="0 0 1"/>
    <limit lower="-9" upper="9" effort="300" velocity="9"/></joint>
</robot>"#;

/// Length of each of the ten intervals [s].
pub(crate) const DT: f64 = 0.05;

/// Joints in another order than in the URDF.
const JOINTS: [&str; 2] = ["slide", "shoulder"];

/// A state with the rule that leads to the next: a pose, then coordinates that add.
struct Walk {
    integrator: Integrator,
    pose: Pose,
    rest: Vec<f64>,
    v: Vec<f64>,
}

impl Walk {
    fn step(&mut self, a: &[f64]) {
        let before = self.v.clone();
        let v: Vec<_> = before.iter().zip(a).map(|(v, a)| v + a * DT).collect();
        let moved = |i: usize| match self.integrator {
            Integrator::Euler => before[i] * DT,
            Integrator::SemiImplicitEuler => v[i] * DT,
            Integrator::ConstantAcceleration => before[i] * DT + 0.5 * a[i] * DT * DT,
        };
        self.pose = self.pose.plus(&Vector6::from_fn(|i, _| moved(i)));
        let rest = self.rest.iter().enumerate();
        self.rest = rest.map(|(i, x)| x + moved(6 + i)).collect();
        self.v = v;
    }

    fn row(&self) -> Vec<f64> {
        [&self.pose.to_xyzquat()[..], &self.rest].concat()
    }
}

/// Acceleration of coordinate `i` in interval `t`.
fn acceleration(t: usize, i: usize) -> f64 {
    5.0 * ((3 * t + 7 * i) as f64).sin()
}

/// States, velocities and accelerations of a walk.
fn walked(mut walk: Walk) -> [Vec<Vec<f64>>; 3] {
    let (mut q, mut v, mut a) = (vec![walk.row()], vec![walk.v.clone()], Vec::new());
    for t in 0..10 {
        let now: Vec<_> = (0..walk.v.len()).map(|i| acceleration(t, i)).collect();
        walk.step(&now);
        a.push(now);
        q.push(walk.row());
        v.push(walk.v.clone());
    }
    [q, v, a]
}

/// The plan as JSON.
pub(crate) fn moving_json(integrator: Integrator) -> Value {
    let [q, v, a] = walked(Walk {
        integrator,
        pose: Pose::from_translation(0.0, 0.0, 0.6),
        rest: vec![0.1, -0.2],
        v: vec![0.5, -0.3, 0.2, 2.0, 1.0, 14.0, 0.4, -1.0],
    });
    let [pose, twist, accel] = walked(Walk {
        integrator,
        pose: Pose::from_xyzquat(&[0.5, 0.1, 0.1, 0.0, 0.6, 0.0, 0.8]),
        rest: Vec::new(),
        v: vec![0.0, 0.1, 0.0, 1.0, -2.0, 0.5],
    });
    let identity = json!([0, 0, 0, 0, 0, 0, 1]);
    let contact = |a: &str, from: usize, steps: usize| {
        let row = |t: usize| json!([1, 2, 100 + t, 0.1, 0.2, 0.3]);
        json!({"a": a, "b": "ground_top", "type": "unilateral_patch", "mu": 0.5, "mu_r": 0.02,
               "wrench": (from..from + steps).map(row).collect::<Vec<_>>()})
    };
    json!({
        "format": "locotamp.plan/1", "status": "feasible", "integrator": integrator,
        "robot": {"name": "mover", "urdf": URDF, "joints": JOINTS},
        "objects": [{"name": "crate", "mass": 1.0, "inertia": [0.01, 0.01, 0.01, 0, 0, 0]}],
        "environment": [{"name": "ground", "geometry": [{"plane": true, "pose": identity}]}],
        "interfaces": [
            {"name": "sole", "body": "foot", "pose": identity, "kind": "patch", "half_size": [0.08, 0.04]},
            {"name": "crate_bottom", "body": "crate", "pose": identity, "kind": "patch", "half_size": [0.1, 0.1]},
            {"name": "ground_top", "body": "ground", "pose": identity, "kind": "patch", "half_size": null}],
        "phases": [
            {"duration": 0.2, "steps": 4, "contacts": [contact("sole", 0, 4)]},
            {"duration": 0.3, "steps": 6, "contacts": [contact("crate_bottom", 4, 6)]}],
        "time": (0..=10).map(|t| f64::from(t) * DT).collect::<Vec<_>>(),
        "q": q, "v": v, "h": vec![[0.0; 6]; 11], "a": a,
        "tau": (0..10).map(|t| [10 + t, -t]).collect::<Vec<_>>(),
        "object_states": {"crate": {"pose": pose, "twist": twist, "accel": accel}},
    })
}

/// The plan with `change` applied to its JSON.
pub(crate) fn changed(change: impl FnOnce(&mut Value)) -> Plan {
    let mut value = moving_json(Integrator::ConstantAcceleration);
    change(&mut value);
    Plan::from_json(&value.to_string()).expect("the change leaves a plan")
}

/// The plan.
pub(crate) fn moving(integrator: Integrator) -> Plan {
    Plan::from_json(&moving_json(integrator).to_string()).expect("it is a plan")
}

pub(crate) const INTEGRATORS: [Integrator; 3] = [
    Integrator::Euler,
    Integrator::SemiImplicitEuler,
    Integrator::ConstantAcceleration,
];
