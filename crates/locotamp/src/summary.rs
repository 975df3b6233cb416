//! The short summary of a plan that people read first.

/// One phase.
#[derive(Debug, Clone, PartialEq)]
pub struct PhaseSummary {
    /// What changes on entering it.
    pub action: String,
    /// Its duration [s].
    pub duration: f64,
    /// Its contacts, "a on b".
    pub contacts: Vec<String>,
}

/// A plan in a few lines.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// Phases in order.
    pub phases: Vec<PhaseSummary>,
    /// Sum of the durations [s].
    pub duration: f64,
    /// Number of intervals.
    pub intervals: usize,
    /// Cost of the optimiser.
    pub cost: f64,
    /// Iterations of the optimiser.
    pub iterations: usize,
    /// Time of the optimiser [s].
    pub seconds: f64,
    /// Largest violation in words and SI units, e.g. "contact slip of left_foot on ground_top, 3e-9 m in phase 2".
    pub violation: String,
    /// Largest torque over its limit (ratio), its joint, and the time [s].
    pub torque: (f64, String, f64),
}

use ocp::{Motion, Subject, System, Worst};
use scene::Scene;

/// Name of a body: a robot link, an object (both by joint) or a static body.
pub(crate) fn body_name(scene: &Scene, system: &System, body: Result<usize, usize>) -> String {
    match body {
        Ok(joint) if joint >= system.n_robot_joints => {
            scene.objects[joint - system.n_robot_joints].name.clone()
        }
        Ok(joint) => {
            let link = system.model.frames.iter().find(|f| f.joint == Some(joint));
            link.map_or_else(
                || system.model.joints[joint].name.clone(),
                |f| f.name.clone(),
            )
        }
        Err(fixed) => scene.statics[fixed].name.clone(),
    }
}

/// The link that a joint of the robot moves.
fn link(scene: &Scene, joint: usize) -> String {
    let model = &scene.robot.model;
    let moved = model.frames.iter().find(|f| f.joint == Some(joint));
    moved.map_or_else(|| model.joints[joint].name.clone(), |f| f.name.clone())
}

/// What a row speaks of: joint, contact, pair of bodies or goal.
pub(crate) fn subject(scene: &Scene, subject: Subject) -> String {
    let name = |i: symbolic::InterfaceId| scene.interfaces[i.0].name.as_str();
    let joint = |v: usize| {
        let robot = scene
            .robot
            .model
            .joints
            .iter()
            .find(|j| (j.idx_v..j.idx_v + j.kind.nv()).contains(&v));
        let object = || {
            scene
                .objects
                .get((v.saturating_sub(scene.robot.model.nv)) / 6)
        };
        match robot {
            Some(j) if j.kind.nv() == 1 => j.name.clone(),
            Some(_) => "base".into(),
            None => object().map_or_else(String::new, |o| o.name.clone()),
        }
    };
    match subject {
        Subject::Coordinate(v) => joint(v),
        Subject::Contact(c) => format!("{} on {}", name(c.a), name(c.b)),
        Subject::Pair(a, b) => {
            let body = |j: usize| match j.checked_sub(scene.robot.model.joints.len()) {
                Some(o) => scene.objects[o].name.clone(),
                None => link(scene, j),
            };
            format!(
                "{} and {}",
                body(a),
                b.map_or_else(|| "the environment".into(), body)
            )
        }
        Subject::Goal(r) => scene.goal_regions[r].body.clone(),
        Subject::Duration => "the phase".into(),
    }
}

/// A violated row in plain words.
pub(crate) fn words(scene: &Scene, worst: &Worst) -> String {
    format!("{}, in phase {}", amount(scene, worst), worst.phase + 1)
}

/// The same whatever the phase.
pub(crate) fn amount(scene: &Scene, worst: &Worst) -> String {
    let Worst { label, amount, .. } = worst;
    format!(
        "{} of {}: {amount:.2e} {} off",
        label.category,
        subject(scene, label.subject),
        label.unit
    )
}

/// Why a motion was not found: what is violated most, and which limit pulls hardest against it.
pub(crate) fn resistance(scene: &Scene, motion: &Motion) -> Option<String> {
    let worst = motion.worst.as_ref()?;
    let text = words(scene, worst);
    Some(match &motion.hardest {
        Some(h) if h.label != worst.label => format!(
            "{text}; what limits it most is the {} of {}, in phase {}",
            h.label.category,
            subject(scene, h.label.subject),
            h.phase + 1
        ),
        _ => text,
    })
}

/// Summarises a motion.
pub(crate) fn summarise(scene: &Scene, labels: &[String], motion: &mut Motion) -> Summary {
    let point = motion.point.clone();
    let n = motion.trajectory.program.n_intervals();
    let mut torque = (0.0, String::new(), 0.0);
    let mut time = 0.0;
    for t in 0..n {
        let tau = motion.trajectory.torques(&point, t);
        for joint in motion.trajectory.program.system.actuated() {
            let ratio = tau[joint.idx_v].abs() / joint.torque_limit;
            if ratio > torque.0 {
                torque = (ratio, joint.name.clone(), time);
            }
        }
        time += motion.trajectory.dt(&point, t);
    }
    let program = &motion.trajectory.program;
    let mut first = 0;
    let mut phases = Vec::new();
    for (k, &steps) in program.steps.iter().enumerate() {
        let contacts = program.intervals[first].forces.iter().map(|f| {
            let name = |i: symbolic::InterfaceId| scene.interfaces[i.0].name.as_str();
            format!("{} on {}", name(f.contact.a), name(f.contact.b))
        });
        phases.push(PhaseSummary {
            action: labels.get(k).cloned().unwrap_or_default(),
            duration: point.durations[k],
            contacts: contacts.collect(),
        });
        first += steps;
    }
    let worst = ocp::worst_row(program, &motion.report, 0.0);
    Summary {
        phases,
        duration: point.durations.iter().sum(),
        intervals: n,
        cost: motion.report.objective,
        iterations: motion.iterations,
        seconds: motion.seconds,
        violation: worst.map_or_else(|| "none".into(), |w| words(scene, &w)),
        torque,
    }
}
