//! All arrays of a plan.

use crate::grid::{Moment, moments, node_times};
use crate::links::Links;
use crate::phases::Phases;
use crate::states::Rule;
use crate::{Array, ArraysError, Values};
use plan::Plan;
use spatial::Pose;

/// The arrays of a plan at k / rate, k = 0, 1, …, up to the end of the plan; `rate` in [`crate::RATES`] [Hz].
///
/// SI units, world axes, quaternions (w, x, y, z) without jumps of sign; `docs/npz-format.md` lists names and shapes.
///
/// # Errors
/// The plan has a fault, its URDF cannot be read or lacks a joint, the rate is out of range or gives too many samples.
pub fn sample(plan: &Plan, rate: f64) -> Result<Vec<Array>, ArraysError> {
    plan.validate()?;
    let mut links = Links::new(plan)?;
    let phases = Phases::new(plan);
    let moments = moments(&node_times(plan), rate)?;
    let mut tables = Tables::default();
    for moment in &moments {
        tables.add(plan, *moment, &mut links, &phases);
    }
    let names = Names {
        joints: plan.robot.joints.clone(),
        bodies: links.names(),
        objects: plan.objects.iter().map(|x| x.name.clone()).collect(),
        contacts: phases.names(),
    };
    Ok(tables.named(rate, names))
}

/// What the columns are called.
struct Names {
    joints: Vec<String>,
    bodies: Vec<String>,
    objects: Vec<String>,
    contacts: Vec<String>,
}

/// The values of all samples, one after the other.
#[derive(Default)]
struct Tables {
    samples: usize,
    joint_pos: Vec<f64>,
    joint_vel: Vec<f64>,
    joint_acc: Vec<f64>,
    joint_torque: Vec<f64>,
    bodies: Bodies,
    objects: Bodies,
    contact_active: Vec<bool>,
    contact_wrench: Vec<f64>,
    phase: Vec<i64>,
}

/// Poses and velocities of bodies.
#[derive(Default)]
struct Bodies {
    positions: Vec<f64>,
    quaternions: Vec<f64>,
    linear: Vec<f64>,
    angular: Vec<f64>,
}

impl Tables {
    fn add(&mut self, plan: &Plan, moment: Moment, links: &mut Links, phases: &Phases) {
        let rule = Rule::of(plan.integrator);
        let robot = rule.robot(plan, moment);
        self.joint_pos.extend(&robot.positions);
        self.joint_vel.extend(&robot.rates);
        self.joint_acc.extend(&plan.a[moment.interval][6..]);
        self.joint_torque.extend(&plan.tau[moment.interval]);
        let before = self.bodies.last(self.samples);
        for (i, link) in links.at(&robot).enumerate() {
            let before = before.get(i);
            self.bodies
                .add(&link.world_from_link, link.velocities_in_world, before);
        }
        let before = self.objects.last(self.samples);
        for (i, object) in plan.objects.iter().enumerate() {
            let state = rule.object(&plan.object_states[&object.name], moment);
            let velocities = state.velocities_in_world();
            self.objects
                .add(&state.world_from_body, velocities, before.get(i));
        }
        for wrench in phases.wrenches(moment.interval) {
            self.contact_active.push(wrench.is_some());
            self.contact_wrench.extend(wrench.unwrap_or_default());
        }
        let phase = i64::try_from(phases.of(moment.interval));
        self.phase.push(phase.expect("a list is shorter than that"));
        self.samples += 1;
    }

    fn named(self, rate: f64, names: Names) -> Vec<Array> {
        let t = self.samples;
        let [j, b, o, c] = [
            &names.joints,
            &names.bodies,
            &names.objects,
            &names.contacts,
        ]
        .map(Vec::len);
        let array = |name, shape: &[usize], values| Array {
            name,
            shape: shape.to_vec(),
            values,
        };
        let real = |name, shape: &[usize], values| array(name, shape, Values::Real(values));
        let text = |name, values: Vec<_>| array(name, &[values.len()], Values::Text(values));
        let time = (0..t).map(|k| k as f64 / rate).collect();
        vec![
            real("fps", &[1], vec![rate]),
            real("time", &[t], time),
            text("joint_names", names.joints),
            real("joint_pos", &[t, j], self.joint_pos),
            real("joint_vel", &[t, j], self.joint_vel),
            real("joint_acc", &[t, j], self.joint_acc),
            real("joint_torque", &[t, j], self.joint_torque),
            text("body_names", names.bodies),
            real("body_pos_w", &[t, b, 3], self.bodies.positions),
            real("body_quat_w", &[t, b, 4], self.bodies.quaternions),
            real("body_lin_vel_w", &[t, b, 3], self.bodies.linear),
            real("body_ang_vel_w", &[t, b, 3], self.bodies.angular),
            text("object_names", names.objects),
            real("object_pos_w", &[t, o, 3], self.objects.positions),
            real("object_quat_w", &[t, o, 4], self.objects.quaternions),
            real("object_lin_vel_w", &[t, o, 3], self.objects.linear),
            real("object_ang_vel_w", &[t, o, 3], self.objects.angular),
            text("contact_names", names.contacts),
            array(
                "contact_active",
                &[t, c],
                Values::Truth(self.contact_active),
            ),
            real("contact_wrench", &[t, c, 6], self.contact_wrench),
            array("phase", &[t], Values::Whole(self.phase)),
        ]
    }
}

impl Bodies {
    /// Quaternions of the last of some samples, (w, x, y, z); none if there is none.
    fn last(&self, samples: usize) -> Vec<[f64; 4]> {
        let all = self.quaternions.len();
        let row = all.checked_div(samples).unwrap_or(0);
        let quaternions = self.quaternions[all - row..].chunks_exact(4);
        quaternions.map(|x| [x[0], x[1], x[2], x[3]]).collect()
    }

    /// Of the two quaternions of a rotation the one that is nearer the one before is taken.
    fn add(&mut self, pose: &Pose, [linear, angular]: [[f64; 3]; 2], before: Option<&[f64; 4]>) {
        let [x, y, z, qx, qy, qz, qw] = pose.to_xyzquat();
        let quaternion = [qw, qx, qy, qz];
        let along =
            |before: &[f64; 4]| -> f64 { before.iter().zip(quaternion).map(|(a, b)| a * b).sum() };
        let sign = if before.is_some_and(|before| along(before) < 0.0) {
            -1.0
        } else {
            1.0
        };
        self.positions.extend([x, y, z]);
        self.quaternions.extend(quaternion.map(|x| sign * x));
        self.linear.extend(linear);
        self.angular.extend(angular);
    }
}
