//! Limits of joints: range, torque, and a speed that is assumed.

use crate::force_ranges::ForceRanges;
use mjcf_rs::Model;
use mjcf_rs::body::{Joint, JointType};
use mjcf_rs::extras::{Actuator, ActuatorKind};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Speed limit of hinges [rad/s] and slides [m/s]: MJCF knows none.
const SPEED: (f64, f64) = (10.0, 1.0);
/// Torque [N·m] or force [N] of an actuator without a limit, and of every joint of a model that has no actuators.
const UNLIMITED: f64 = 1000.0;
/// Range of a hinge without one [rad], and of a slide [m].
const FREE: (f64, f64) = (TAU, 10.0);

/// Limits of one joint.
pub struct Limit {
    pub range: [f64; 2],
    pub effort: f64,
    pub velocity: f64,
}

/// Limits of a model's joints.
pub struct Limits {
    autolimits: bool,
    /// By name of the joint [N·m or N].
    efforts: BTreeMap<String, f64>,
    unlimited: Vec<String>,
    without_actuator: Vec<String>,
    /// Where joints are that nothing drives, if it is not zero [rad or m].
    home: BTreeMap<String, f64>,
    without_range: Vec<String>,
}

impl Limits {
    /// From the model's actuators, the force ranges of its joints, and the posture of its keyframe.
    pub fn new(
        model: &Model,
        ranges: ForceRanges,
        home: &[(String, f64)],
        notes: &mut Vec<String>,
    ) -> Self {
        let autolimits = model.compiler.autolimits;
        let mut efforts: BTreeMap<String, f64> = BTreeMap::new();
        let mut unlimited = vec![];
        for actuator in &model.actuators {
            let Some(joint) = &actuator.joint else {
                continue;
            };
            let effort = effort(actuator, autolimits).unwrap_or(f64::INFINITY);
            *efforts.entry(joint.clone()).or_default() += effort;
        }
        for (joint, range) in ranges {
            let most = least_side(range);
            let effort = efforts.entry(joint).or_insert(most);
            *effort = effort.min(most);
        }
        for (joint, effort) in efforts.iter_mut().filter(|(_, e)| e.is_infinite()) {
            *effort = UNLIMITED;
            unlimited.push(joint.clone());
        }
        if efforts.is_empty() {
            notes.push(format!(
                "the model has no actuators: {UNLIMITED} N·m, or N, are assumed for every joint"
            ));
        }
        notes.push(format!(
            "MJCF gives no limits of speed: {} rad/s for hinges and {} m/s for slides are assumed",
            SPEED.0, SPEED.1
        ));
        Self {
            autolimits,
            efforts,
            unlimited,
            without_actuator: vec![],
            home: home.iter().cloned().collect(),
            without_range: vec![],
        }
    }

    /// Limits of a hinge or slide.
    pub fn of(&mut self, name: &str, joint: &Joint) -> Limit {
        let hinge = joint.type_ == JointType::Hinge;
        let (free, velocity) = if hinge {
            (FREE.0, SPEED.0)
        } else {
            (FREE.1, SPEED.1)
        };
        let limited = joint
            .limited
            .resolve(self.autolimits, joint.range.is_some());
        let effort = if self.efforts.is_empty() {
            Some(UNLIMITED)
        } else {
            self.efforts.get(name).copied()
        };
        let Some(effort) = effort else {
            self.without_actuator.push(name.to_owned());
            let at = self.home.get(name).copied().unwrap_or(joint.ref_);
            return Limit {
                range: [at, at],
                effort: UNLIMITED,
                velocity,
            };
        };
        let range = joint.range.filter(|_| limited).unwrap_or_else(|| {
            self.without_range.push(name.to_owned());
            [-free, free]
        });
        Limit {
            range,
            effort,
            velocity,
        }
    }

    /// What was assumed of the joints asked for.
    pub fn notes(self) -> impl Iterator<Item = String> {
        let say = |joints: Vec<String>, what: &str| {
            (!joints.is_empty()).then(|| format!("{what}: {}", joints.join(", ")))
        };
        let all = [
            say(
                self.without_actuator,
                "joints without actuator, which nothing moves here",
            ),
            say(
                self.unlimited,
                &format!("joints whose actuators have no limit, {UNLIMITED} N·m are assumed"),
            ),
            say(
                self.without_range,
                &format!("joints without range, ±{:.2} rad are assumed", FREE.0),
            ),
        ];
        all.into_iter().flatten()
    }
}

/// What a range allows in both directions.
fn least_side([low, high]: [f64; 2]) -> f64 {
    high.min(-low).max(0.0)
}

/// Largest torque [N·m] or force [N] of an actuator at its joint; `None` if it has no limit.
fn effort(actuator: &Actuator, autolimits: bool) -> Option<f64> {
    let gear = actuator.gear[0].abs();
    let forces = actuator.force_range;
    let limited = actuator.force_limited.resolve(autolimits, forces.is_some());
    let by_force = forces.filter(|_| limited).map(|f| gear * least_side(f));
    let servo = actuator.bias_type.as_deref().is_some_and(|b| b != "none");
    let gain = match actuator.kind {
        ActuatorKind::Motor => Some(1.0),
        ActuatorKind::General if !servo => Some(actuator.gainprm.first().map_or(1.0, |g| g.abs())),
        _ => None,
    };
    let controls = actuator.ctrl_range;
    let limited = actuator
        .ctrl_limited
        .resolve(autolimits, controls.is_some());
    let controls = controls.filter(|_| limited).map(least_side);
    let by_control = gain.zip(controls).map(|(gain, most)| gear * gain * most);
    match (by_force, by_control) {
        (Some(a), Some(b)) => Some(a.min(b)),
        (a, b) => a.or(b),
    }
}
