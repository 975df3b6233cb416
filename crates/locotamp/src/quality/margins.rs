//! What the margins of a motion came to.

use super::Series;
use ocp::{Motion, Subject};
use scene::Scene;
use serde::Serialize;
use symbolic::ContactType;

/// Loads below this share of the weight that a contact bears are too light for shares of friction and extent to mean much.
const LIGHT: f64 = 0.02;

/// A margin and what it came to.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Margin {
    /// Its name among the options.
    pub name: &'static str,
    /// Unit; "1" for shares of a limit.
    pub unit: &'static str,
    /// What was demanded: the most of a share, the least of a distance.
    pub demanded: f64,
    /// The largest share used, or the smallest distance kept; `None` where nothing of the kind occurs.
    pub reached: Option<f64>,
}

fn largest(values: impl Iterator<Item = f64>) -> Option<f64> {
    values.reduce(f64::max)
}

fn smallest(values: impl Iterator<Item = f64>) -> Option<f64> {
    values.reduce(f64::min)
}

/// All margins that a motion was asked to keep.
pub(super) fn margins(scene: &Scene, motion: &Motion, series: &Series) -> Vec<Margin> {
    let program = &motion.trajectory.program;
    let wanted = &program.settings.margins;
    let joints = || program.system.actuated();
    let per_joint = |rows: &[Vec<f64>], limit: &dyn Fn(&multibody::Joint) -> f64| {
        largest(rows.iter().flat_map(|row| {
            joints()
                .filter(|j| limit(j).is_finite() && limit(j) > 0.0)
                .map(|j| row[j.idx_v].abs() / limit(j))
        }))
    };
    let range = smallest(
        motion
            .point
            .nodes
            .iter()
            .flat_map(|q| joints().map(|j| (q[j.idx_q] - j.lower).min(j.upper - q[j.idx_q]))),
    )
    .filter(|room| room.is_finite());
    let declared = |row: &[f64]| {
        let joints = joints().zip(row).filter(|(j, _)| j.torque_speed.is_some());
        largest(joints.map(|(_, share)| *share))
    };
    let at_speed = largest(series.at_speed.iter().filter_map(|row| declared(row)))
        .filter(|_| program.settings.torque_speed());
    let (friction, pressure) = contact_shares(scene, motion);
    let share = |name, demanded, reached| Margin {
        name,
        unit: "1",
        demanded,
        reached,
    };
    let distance = |name, unit, demanded, reached| Margin {
        name,
        unit,
        demanded,
        reached,
    };
    let clearance = |robot_only: bool, demanded: f64| clearance(motion, robot_only, demanded);
    let mut margins = vec![
        share("friction", wanted.friction, friction),
        share("pressure", wanted.pressure, pressure),
        share(
            "torque",
            wanted.torque,
            per_joint(&series.tau, &|j| j.torque_limit),
        ),
        share("torque_speed", wanted.torque, at_speed),
        share(
            "velocity",
            wanted.velocity,
            per_joint(&series.v, &|j| j.velocity_limit),
        ),
        distance("joint_range", "rad", wanted.joint_range, range),
        distance(
            "clearance",
            "m",
            wanted.clearance,
            clearance(false, wanted.clearance),
        ),
        distance(
            "self_clearance",
            "m",
            wanted.self_clearance,
            clearance(true, wanted.self_clearance),
        ),
        distance("swing", "m", wanted.swing, clearance(false, wanted.swing)),
    ];
    if wanted.landing.is_finite() {
        margins.push(distance("landing", "m/s", wanted.landing, landing(motion)));
    }
    if wanted.load > 0.0 {
        let demanded = wanted.load * program.system.robot_mass * scene.gravity.norm();
        let reached = foot_load(motion).map(|beyond| demanded + beyond);
        margins.push(distance("foot_load", "N", demanded, reached));
    }
    if wanted.spare > 0.0 && program.is_fine() {
        let demanded = wanted.spare * program.system.robot_mass * scene.gravity.norm();
        let reached = spare_load(motion).map(|share| demanded * share);
        margins.push(distance("spare_load", "N", demanded, reached));
    }
    margins
}

/// What moments of feet keep in reserve at the edge of the area for their centre of pressure, over what they must, where that is
/// least.
fn spare_load(motion: &Motion) -> Option<f64> {
    let program = &motion.trajectory.program;
    let lower = program.structure.elements.iter().flat_map(|e| &e.row_lower);
    let rows = program.labels.iter().zip(lower.zip(&motion.report.rows));
    let pressure =
        rows.filter(|(label, (lower, _))| label.category == "centre of pressure" && **lower > 0.0);
    smallest(pressure.map(|(_, (lower, value))| value / lower))
}

/// By how much feet in contact bear more than they must, where that is least [N].
fn foot_load(motion: &Motion) -> Option<f64> {
    let program = &motion.trajectory.program;
    let intervals = program.intervals.iter().zip(&motion.point.wrenches);
    smallest(intervals.flat_map(|(interval, wrenches)| {
        let feet = interval.forces.iter().filter_map(move |force| {
            let most_negative = program.structure.upper[interval.wrench_var + force.first + 2];
            (most_negative < 0.0)
                .then(|| (most_negative - wrenches[force.first + 2]) * force.scale[2])
        });
        feet.collect::<Vec<_>>()
    }))
}

/// Smallest clearance among the rows that demand the whole margin: between links of the robot, or with anything else.
fn clearance(motion: &Motion, robot_only: bool, demanded: f64) -> Option<f64> {
    let program = &motion.trajectory.program;
    let n_robot = program.system.n_robot_joints;
    let lower = program.structure.elements.iter().flat_map(|e| &e.row_lower);
    let rows = program.labels.iter().zip(lower.zip(&motion.report.rows));
    smallest(
        rows.filter(|(label, (lower, _))| {
            let Subject::Pair(_, other) = label.subject else {
                return false;
            };
            other.is_some_and(|j| j < n_robot) == robot_only && **lower >= demanded - 1e-9
        })
        .map(|(_, (_, value))| *value),
    )
}

/// Largest speed beside the contacts that begin or end, less what the time from them adds; the speed at the contact that
/// bounds it.
fn landing(motion: &Motion) -> Option<f64> {
    let program = &motion.trajectory.program;
    let upper = program.structure.elements.iter().flat_map(|e| &e.row_upper);
    let rows = program.labels.iter().zip(upper.zip(&motion.report.rows));
    let speeds = rows.filter(|(label, _)| label.category == "landing speed" && label.unit == "m/s");
    largest(
        speeds.map(|(_, (limit, value))| value.abs() - limit + program.settings.margins.landing),
    )
}

/// Largest shares of friction that unilateral contacts use, and of the extent for the centre of pressure that patches of the robot use.
fn contact_shares(scene: &Scene, motion: &Motion) -> (Option<f64>, Option<f64>) {
    let program = &motion.trajectory.program;
    let (mut friction, mut pressure) = (None, None);
    let note = |of: &mut Option<f64>, share: f64| *of = Some(of.map_or(share, |s| s.max(share)));
    for (interval, wrenches) in program.intervals.iter().zip(&motion.point.wrenches) {
        for force in &interval.forces {
            let a = &scene.interfaces[force.contact.a.0];
            let b = &scene.interfaces[force.contact.b.0];
            let mass = match a.owner {
                scene::Owner::Robot { .. } => program.system.robot_mass,
                scene::Owner::Object(o) => scene.objects[o].mass,
                scene::Owner::Static(_) => continue,
            };
            let is_patch = force.contact.kind == ContactType::UnilateralPatch;
            if !is_patch && force.contact.kind != ContactType::UnilateralPoint {
                continue;
            }
            let wrench = ocp::physical_wrench(force, wrenches);
            let normal = -wrench[2];
            if normal < LIGHT * mass * scene.gravity.norm() {
                continue;
            }
            note(
                &mut friction,
                wrench[0].hypot(wrench[1]) / (a.mu.min(b.mu) * normal),
            );
            let robot = matches!(a.owner, scene::Owner::Robot { .. });
            if let Some([x, y]) = a.half_size.filter(|_| robot && is_patch) {
                let share = (wrench[3].abs() / y).max(wrench[4].abs() / x) / normal;
                note(&mut pressure, share);
            }
        }
    }
    (friction, pressure)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Request;
    use std::path::Path;

    #[test]
    fn friction_used_is_that_of_objects_on_tables_too() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../../scenes/sequences/yardstick/red_step.toml");
        let file = scene::SequenceFile::load(&path).expect("a sequence file");
        let scene = file.load_scene().expect("its scene");
        let sequence = file.resolve(&scene).expect("a sequence of the scene");
        let request = Request {
            refinement: None,
            ..Request::default()
        };
        let solved = crate::solve(&scene, &sequence, &request, &mut |_| true).expect("a problem");
        let found = solved.best.expect("a motion");
        // soles and the bottom of the box are level: world axes are those of the surfaces
        let used = |touches: &dyn Fn(&str) -> bool, least: f64| {
            let contacts = found.plan.phases.iter().flat_map(|phase| &phase.contacts);
            let rows = contacts
                .filter(|c| touches(&c.a))
                .flat_map(|c| c.wrench.iter().map(|w| (w, c.mu)));
            let shares = rows
                .filter(|(w, _)| w[2] > least)
                .map(|(w, mu)| w[0].hypot(w[1]) / (mu * w[2]));
            shares.fold(0.0, f64::max)
        };
        let least = |mass: f64| LIGHT * mass * scene.gravity.norm();
        let feet = used(
            &|a| a.ends_with("foot"),
            least(scene.robot.model.total_mass()),
        );
        let boxes = used(&|a| a == "red_box_bottom", least(scene.objects[0].mass));
        let friction = (found.quality.margins.iter()).find(|margin| margin.name == "friction");
        let reached = friction.and_then(|margin| margin.reached).expect("a share");
        assert!(boxes > feet, "{boxes} {feet}");
        assert!((reached - boxes).abs() < 1e-3, "{reached} {boxes}");
    }
}
