//! Whether a plan can be used: sizes, finite numbers, names, unit quaternions, ranges.
//!
//! This judges the file, not the motion: whether the motion obeys its constraints is the checker's part.

mod numbers;

use std::collections::BTreeSet;

use crate::{Plan, PlanError};

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
            faults.times(self);
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
            self.count("phases", "intervals in all", 0, 1);
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
        if let Some(costs) = &plan.costs {
            let place = "costs.per_interval";
            self.rows(place, &costs.per_interval, intervals, costs.terms.len());
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
        for joint in plan.robot.torque_speed.keys() {
            self.known("robot.torque_speed".to_owned(), "joint", joint, &joints);
        }
        if let Some(costs) = &plan.costs {
            self.unique("costs.terms", costs.terms.iter(), &mut BTreeSet::new());
        }
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
