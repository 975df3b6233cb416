//! How the torques of joints fall with speed, as a robot file says: `[[torque_speed]]`.

use crate::SceneError;
use crate::robot::unknown_name;
use crate::source::{At, Source};
use multibody::{JointKind, Model, TorqueSpeed};
use serde::Deserialize;

/// One torque–speed line for one or more joints.
#[derive(Debug, Deserialize)]
#[serde(
    deny_unknown_fields,
    expecting = "a table with joints, corner, no_load"
)]
pub(crate) struct TorqueSpeedEntry {
    /// Names of joints; `*` stands for any text.
    pub joints: Vec<At<String>>,
    /// Speed up to which the whole torque is available [rad/s or m/s].
    pub corner: At<f64>,
    /// Speed at which none is left; default: the velocity limit of the URDF.
    pub no_load: Option<At<f64>>,
}

/// Writes the lines of the entries into the joints of the model.
pub(crate) fn set_torque_speed(
    source: &Source,
    model: &mut Model,
    entries: &[TorqueSpeedEntry],
) -> Result<(), SceneError> {
    for entry in entries {
        let corner = source.positive("corner of torque_speed", "rad/s", &entry.corner)?;
        for pattern in &entry.joints {
            let moving = |j: &usize| model.joints[*j].kind != JointKind::FreeFlyer;
            let fits = |j: &usize| matches(pattern, &model.joints[*j].name);
            let found: Vec<usize> = (0..model.joints.len())
                .filter(moving)
                .filter(fits)
                .collect();
            if found.is_empty() {
                let known = model.joints.iter().skip(1).map(|joint| joint.name.as_str());
                return Err(unknown_name(
                    source,
                    pattern,
                    "torque_speed",
                    "moving joint",
                    known,
                ));
            }
            for j in found {
                let curve = curve(source, entry, corner, model, j, pattern)?;
                model.joints[j].torque_speed = Some(curve);
            }
        }
    }
    Ok(())
}

/// The line of one joint.
fn curve(
    source: &Source,
    entry: &TorqueSpeedEntry,
    corner: f64,
    model: &Model,
    joint: usize,
    pattern: &At<String>,
) -> Result<TorqueSpeed, SceneError> {
    let joint = &model.joints[joint];
    let what = format!("torque_speed of joint {:?}", joint.name);
    let fault = |span, problem: &str| Err(source.bad_keys(span, &what, problem));
    if joint.torque_speed.is_some() {
        return fault(pattern.span(), "given twice; leave one out");
    }
    if !joint.torque_limit.is_finite() {
        return fault(pattern.span(), "its URDF has no effort limit; give it one");
    }
    let no_load = match &entry.no_load {
        Some(value) => source.positive("no_load of torque_speed", "rad/s", value)?,
        None if joint.velocity_limit.is_finite() => joint.velocity_limit,
        None => {
            return fault(
                pattern.span(),
                "its URDF has no velocity limit; give no_load, the speed at which no torque is left",
            );
        }
    };
    if no_load <= corner {
        let problem = format!(
            "corner is {corner} rad/s, expected less than {no_load} rad/s, where no torque is left"
        );
        return fault(entry.corner.span(), &problem);
    }
    Ok(TorqueSpeed { corner, no_load })
}

/// Does a name fit a pattern in which `*` stands for any text.
fn matches(pattern: &str, name: &str) -> bool {
    match pattern.split_once('*') {
        None => pattern == name,
        Some((head, rest)) => name.strip_prefix(head).is_some_and(|tail| {
            let ends = tail.char_indices().map(|(at, _)| at).chain([tail.len()]);
            ends.map(|at| &tail[at..]).any(|tail| matches(rest, tail))
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_star_stands_for_any_text() {
        for pattern in ["left_knee", "*", "*_knee", "left_*", "l*_k*e", "left_knee*"] {
            assert!(matches(pattern, "left_knee"), "{pattern}");
        }
        for pattern in ["left", "knee", "*_hip", "right_*", "", "*k"] {
            assert!(!matches(pattern, "left_knee"), "{pattern}");
        }
    }
}
