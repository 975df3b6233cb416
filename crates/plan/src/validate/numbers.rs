//! Numbers of a plan: finite, in their ranges, quaternions of unit norm, times that follow from the durations.

use super::Faults;
use crate::{Geometry, Plan, PlanError, Pose7};

/// Largest deviation of a quaternion's norm from one.
const QUATERNION_TOLERANCE: f64 = 1e-5;

/// Largest gap between a node's time and the sum of the durations before it [s].
const TIME_TOLERANCE: f64 = 1e-6;

impl Faults {
    fn finite<'a>(&mut self, place: &str, values: impl IntoIterator<Item = &'a f64>) {
        if let Some((i, value)) = values.into_iter().enumerate().find(|(_, x)| !x.is_finite()) {
            self.0.push(PlanError::NotFinite {
                place: format!("{place}[{i}]"),
                value: *value,
            });
        }
    }

    /// At most one fault per array: a broken solver fills them with thousands.
    fn finite_rows<Row: AsRef<[f64]>>(&mut self, place: &str, rows: &[Row]) {
        if let Some((t, row)) = rows
            .iter()
            .enumerate()
            .find(|(_, row)| row.as_ref().iter().any(|x| !x.is_finite()))
        {
            self.finite(&format!("{place}[{t}]"), row.as_ref());
        }
    }

    pub(super) fn finite_numbers(&mut self, plan: &Plan) {
        self.finite("gravity", &plan.gravity);
        self.finite("violation", &plan.violation);
        if let Some(objective) = &plan.objective {
            self.finite(
                "objective",
                std::iter::once(&objective.value).chain(&objective.cost),
            );
        }
        self.finite(
            "robot.torque_limits",
            plan.robot.torque_limits.iter().flatten().flatten(),
        );
        for (joint, at) in &plan.robot.torque_speed {
            self.finite(
                &format!("robot.torque_speed.{joint}"),
                [&at.corner, &at.max],
            );
        }
        self.finite("time", &plan.time);
        self.finite_rows("q", &plan.q);
        self.finite_rows("v", &plan.v);
        self.finite_rows("h", &plan.h);
        self.finite_rows("a", &plan.a);
        self.finite_rows("tau", &plan.tau);
        if let Some(costs) = &plan.costs {
            self.finite_rows("costs.per_interval", &costs.per_interval);
            self.finite("costs.end", costs.end.values());
        }
        for (name, states) in &plan.object_states {
            self.finite_rows(&format!("object_states.{name}.pose"), &states.pose);
            self.finite_rows(&format!("object_states.{name}.twist"), &states.twist);
            self.finite_rows(&format!("object_states.{name}.accel"), &states.accel);
        }
        for (place, geometry) in geometries(plan) {
            self.finite(
                &place,
                geometry
                    .pose
                    .iter()
                    .chain(geometry.half_size.iter().flatten()),
            );
        }
        for (i, object) in plan.objects.iter().enumerate() {
            self.finite(&format!("objects[{i}].inertia"), &object.inertia);
            self.finite(&format!("objects[{i}].mass"), [&object.mass]);
        }
        for (i, x) in plan.interfaces.iter().enumerate() {
            let optional = x
                .half_size
                .iter()
                .flatten()
                .flatten()
                .chain(x.limb.iter().flatten());
            self.finite(&format!("interfaces[{i}]"), x.pose.iter().chain(optional));
        }
        for (i, region) in plan.goal_regions.iter().enumerate() {
            self.finite(
                &format!("goal_regions[{i}]"),
                (region.lower.iter().chain(&region.upper).flatten())
                    .chain(region.yaw.iter().flatten())
                    .chain(&region.tilt),
            );
        }
        for (k, phase) in plan.phases.iter().enumerate() {
            self.finite(&format!("phases[{k}].duration"), [&phase.duration]);
            for (i, contact) in phase.contacts.iter().enumerate() {
                let place = format!("phases[{k}].contacts[{i}]");
                self.finite(&place, [&contact.mu, &contact.mu_r]);
                self.finite_rows(&format!("{place}.wrench"), &contact.wrench);
            }
        }
    }

    fn value(&mut self, place: impl Into<String>, value: f64, expected: &'static str) {
        self.0.push(PlanError::Value {
            place: place.into(),
            value,
            expected,
        });
    }

    pub(super) fn times(&mut self, plan: &Plan) {
        let mut end = 0.0;
        let ends = plan.phase_starts().into_iter().skip(1);
        for (k, (phase, node)) in plan.phases.iter().zip(ends).enumerate() {
            end += phase.duration;
            let (place, value, expected) = if phase.duration <= 0.0 {
                let place = format!("phases[{k}].duration");
                (place, phase.duration, "a positive number of seconds")
            } else if (plan.time[node] - end).abs() > TIME_TOLERANCE {
                let place = format!("time[{node}]");
                (
                    place,
                    plan.time[node],
                    "the sum of the phases' durations up to there",
                )
            } else {
                continue;
            };
            self.0.push(PlanError::Time {
                place,
                value,
                expected,
            });
        }
    }

    pub(super) fn ranges(&mut self, plan: &Plan) {
        for (k, phase) in plan.phases.iter().enumerate() {
            if phase.steps == 0 {
                self.value(format!("phases[{k}].steps"), 0.0, "at least one");
            }
            for (i, contact) in phase.contacts.iter().enumerate() {
                if contact.mu < 0.0 || contact.mu_r < 0.0 {
                    let place = format!("phases[{k}].contacts[{i}]: mu or mu_r");
                    self.value(
                        place,
                        contact.mu.min(contact.mu_r),
                        "a friction coefficient of at least zero",
                    );
                }
            }
        }
        for (joint, at) in &plan.robot.torque_speed {
            let place = |key: &str| format!("robot.torque_speed.{joint}.{key}");
            if at.corner <= 0.0 {
                self.value(place("corner"), at.corner, "a speed above zero");
            }
            if at.max <= at.corner {
                self.value(place("max"), at.max, "a speed above the corner");
            }
        }
        for (i, object) in plan.objects.iter().enumerate() {
            if object.mass <= 0.0 {
                self.value(
                    format!("objects[{i}].mass"),
                    object.mass,
                    "a positive number of kilograms",
                );
            }
        }
        for (place, geometry) in geometries(plan) {
            if let Some(worst) = geometry
                .half_size
                .iter()
                .flatten()
                .copied()
                .find(|x| *x <= 0.0)
            {
                self.value(format!("{place}.box"), worst, "positive half sizes");
            }
        }
        for (i, interface) in plan.interfaces.iter().enumerate() {
            let sizes = interface.half_size.iter().flatten().flatten();
            if let Some(worst) = sizes.copied().find(|x| *x < 0.0) {
                self.value(
                    format!("interfaces[{i}].half_size"),
                    worst,
                    "half sizes of at least zero",
                );
            }
            if interface.limb == Some([0.0; 3]) {
                self.value(format!("interfaces[{i}].limb"), 0.0, "a direction");
            }
        }
    }

    fn quaternion(&mut self, place: impl FnOnce() -> String, xyzw: &[f64]) {
        let norm = xyzw.iter().map(|x| x * x).sum::<f64>().sqrt();
        let error = (norm - 1.0).abs();
        if error.is_nan() || error > QUATERNION_TOLERANCE {
            self.0.push(PlanError::Quaternion {
                place: place(),
                norm,
            });
        }
    }

    pub(super) fn quaternions(&mut self, plan: &Plan) {
        for (t, row) in plan.q.iter().enumerate() {
            self.quaternion(|| format!("q[{t}]"), &row[3..7]);
        }
        for (name, states) in &plan.object_states {
            for (t, pose) in states.pose.iter().enumerate() {
                self.quaternion(
                    || format!("object_states.{name}.pose[{t}]"),
                    rotation_part(pose),
                );
            }
        }
        for (i, interface) in plan.interfaces.iter().enumerate() {
            self.quaternion(
                || format!("interfaces[{i}].pose ({})", interface.name),
                rotation_part(&interface.pose),
            );
        }
        for (place, geometry) in geometries(plan) {
            self.quaternion(|| format!("{place}.pose"), rotation_part(&geometry.pose));
        }
    }
}

fn rotation_part(pose: &Pose7) -> &[f64] {
    &pose[3..7]
}

/// All shapes with their places in the file.
fn geometries(plan: &Plan) -> impl Iterator<Item = (String, &Geometry)> {
    let objects = plan
        .objects
        .iter()
        .enumerate()
        .map(|(i, x)| (format!("objects[{i}]"), &x.geometry));
    let statics = plan
        .environment
        .iter()
        .enumerate()
        .map(|(i, x)| (format!("environment[{i}]"), &x.geometry));
    objects.chain(statics).flat_map(|(body, list)| {
        list.iter()
            .enumerate()
            .map(move |(j, g)| (format!("{body}.geometry[{j}]"), g))
    })
}
