//! Whether a plan can be used: sizes, finite numbers, names, unit quaternions, ranges.
//!
//! This judges the file, not the motion: whether the motion obeys its constraints is the checker's part.

use std::collections::BTreeSet;

use crate::{Geometry, Plan, PlanError, Pose7};

/// Largest deviation of a quaternion's norm from one.
const QUATERNION_TOLERANCE: f64 = 1e-5;

/// Largest gap between a node's time and the sum of the durations before it [s].
const TIME_TOLERANCE: f64 = 1e-6;

impl Plan {
    /// Checks sizes, numbers, names and ranges.
    ///
    /// # Errors
    /// The first fault found: see [`Plan::faults`].
    pub fn validate(&self) -> Result<(), PlanError> {
        self.faults().into_iter().next().map_or(Ok(()), Err)
    }

    /// All faults of sizes, numbers, names and ranges; structural ones first
    /// (see [`PlanError::is_structural`]).
    pub fn faults(&self) -> Vec<PlanError> {
        let mut faults = Faults::default();
        faults.sizes(self);
        faults.names(self);
        faults.finite_numbers(self);
        if faults.0.is_empty() {
            faults.ranges(self);
            faults.quaternions(self);
        }
        faults.0
    }
}

#[derive(Default)]
struct Faults(Vec<PlanError>);

impl Faults {
    fn count(
        &mut self,
        place: impl Into<String>,
        what: &'static str,
        found: usize,
        expected: usize,
    ) {
        if found != expected {
            self.0.push(PlanError::Size {
                place: place.into(),
                what,
                found,
                expected,
            });
        }
    }

    fn rows(&mut self, place: &str, rows: &[Vec<f64>], n_rows: usize, width: usize) {
        self.count(place, "rows", rows.len(), n_rows);
        if let Some((t, row)) = rows.iter().enumerate().find(|(_, row)| row.len() != width) {
            self.count(format!("{place}[{t}]"), "numbers", row.len(), width);
        }
    }

    fn sizes(&mut self, plan: &Plan) {
        let (intervals, n) = (plan.n_intervals(), plan.n_joints());
        let nodes = intervals.saturating_add(1);
        if intervals == 0 {
            self.value("phases", 0.0, "at least one phase of at least one step");
        }
        self.count("time", "values", plan.time.len(), nodes);
        self.rows("q", &plan.q, nodes, 7 + n);
        self.rows("v", &plan.v, nodes, 6 + n);
        self.count("h", "rows", plan.h.len(), nodes);
        self.rows("a", &plan.a, intervals, 6 + n);
        self.rows("tau", &plan.tau, intervals, n);
        if let Some(limits) = &plan.robot.torque_limits {
            self.count("robot.torque_limits", "values", limits.len(), n);
        }
        for (name, states) in &plan.object_states {
            let place = |key: &str| format!("object_states.{name}.{key}");
            self.count(place("pose"), "rows", states.pose.len(), nodes);
            self.count(place("twist"), "rows", states.twist.len(), nodes);
            self.count(place("accel"), "rows", states.accel.len(), intervals);
        }
        for (k, phase) in plan.phases.iter().enumerate() {
            for (i, contact) in phase.contacts.iter().enumerate() {
                let place = format!(
                    "phases[{k}].contacts[{i}].wrench ({}/{})",
                    contact.a, contact.b
                );
                self.count(place, "rows", contact.wrench.len(), phase.steps);
            }
        }
    }

    fn unique<'a>(
        &mut self,
        kind: &str,
        names: impl Iterator<Item = &'a String>,
        taken: &mut BTreeSet<&'a str>,
    ) {
        for (i, name) in names.enumerate() {
            if !taken.insert(name) {
                self.0.push(PlanError::DuplicateName {
                    place: format!("{kind}[{i}]"),
                    name: name.clone(),
                });
            }
        }
    }

    fn known(&mut self, place: String, kind: &'static str, name: &str, known: &BTreeSet<&str>) {
        if !known.contains(name) {
            let known = known.iter().copied().collect::<Vec<_>>().join(", ");
            self.0.push(PlanError::UnknownName {
                place,
                kind,
                name: name.to_owned(),
                known,
            });
        }
    }

    fn names(&mut self, plan: &Plan) {
        let mut joints = BTreeSet::new();
        self.unique("robot.joints", plan.robot.joints.iter(), &mut joints);
        let mut bodies = BTreeSet::new();
        self.unique("objects", plan.objects.iter().map(|x| &x.name), &mut bodies);
        let objects = bodies.clone();
        self.unique(
            "environment",
            plan.environment.iter().map(|x| &x.name),
            &mut bodies,
        );
        let mut interfaces = BTreeSet::new();
        self.unique(
            "interfaces",
            plan.interfaces.iter().map(|x| &x.name),
            &mut interfaces,
        );

        for name in plan.object_states.keys() {
            self.known("object_states".to_owned(), "object", name, &objects);
        }
        let with_states: BTreeSet<_> = plan.object_states.keys().map(String::as_str).collect();
        for (i, object) in plan.objects.iter().enumerate() {
            self.known(
                format!("objects[{i}]"),
                "entry of object_states",
                &object.name,
                &with_states,
            );
        }
        bodies.extend(link_names(&plan.robot.urdf));
        for (i, interface) in plan.interfaces.iter().enumerate() {
            self.known(
                format!("interfaces[{i}].body"),
                "link, object or static body",
                &interface.body,
                &bodies,
            );
        }
        for (k, phase) in plan.phases.iter().enumerate() {
            for (i, contact) in phase.contacts.iter().enumerate() {
                self.known(
                    format!("phases[{k}].contacts[{i}].a"),
                    "interface",
                    &contact.a,
                    &interfaces,
                );
                self.known(
                    format!("phases[{k}].contacts[{i}].b"),
                    "interface",
                    &contact.b,
                    &interfaces,
                );
            }
        }
        for (i, goal) in plan.goal.iter().enumerate() {
            self.known(format!("goal[{i}].a"), "interface", &goal.a, &interfaces);
            self.known(format!("goal[{i}].b"), "interface", &goal.b, &interfaces);
        }
        bodies.extend(&interfaces);
        for (i, region) in plan.goal_regions.iter().enumerate() {
            self.known(
                format!("goal_regions[{i}].body"),
                "link, object or interface",
                &region.body,
                &bodies,
            );
        }
    }

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

    fn finite_numbers(&mut self, plan: &Plan) {
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
        self.finite("time", &plan.time);
        self.finite_rows("q", &plan.q);
        self.finite_rows("v", &plan.v);
        self.finite_rows("h", &plan.h);
        self.finite_rows("a", &plan.a);
        self.finite_rows("tau", &plan.tau);
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
                region.lower.iter().chain(&region.upper).flatten(),
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

    fn ranges(&mut self, plan: &Plan) {
        let mut end = 0.0;
        for (k, (phase, node)) in plan
            .phases
            .iter()
            .zip(plan.phase_starts().into_iter().skip(1))
            .enumerate()
        {
            end += phase.duration;
            if phase.duration <= 0.0 {
                self.value(
                    format!("phases[{k}].duration"),
                    phase.duration,
                    "a positive number of seconds",
                );
            } else if (plan.time[node] - end).abs() > TIME_TOLERANCE {
                self.value(
                    format!("time[{node}]"),
                    plan.time[node],
                    "the sum of the phases' durations up to there",
                );
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

    fn quaternions(&mut self, plan: &Plan) {
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

/// Names of the `<link>` elements, by a scan of the text: enough to tell a wrong name, without an XML parser.
fn link_names(urdf: &str) -> impl Iterator<Item = &str> {
    urdf.split("<link").skip(1).filter_map(|rest| {
        let head = &rest[..rest.find('>')?];
        let value = head[head.find("name")? + 4..]
            .trim_start()
            .strip_prefix('=')?
            .trim_start();
        let quote = value.chars().next().filter(|c| *c == '"' || *c == '\'')?;
        value[1..].split(quote).next()
    })
}

#[cfg(test)]
mod tests {
    use super::link_names;

    #[test]
    fn link_names_are_found_whatever_the_quotes_and_spaces() {
        let urdf = "<robot name='r'><link name=\"pelvis\"><visual/></link><link  name = 'foot' />\n<link\n name=\"toe\"/><linkage/></robot><link";
        assert_eq!(
            link_names(urdf).collect::<Vec<_>>(),
            ["pelvis", "foot", "toe"]
        );
    }
}
