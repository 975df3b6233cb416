//! How well a robot could execute a motion: smoothness, residuals between the nodes, and what the margins came to.

use multibody::Kinematics;
use ocp::{Between, Motion, Subject};
use scene::{Role, Scene};
use serde::Serialize;
use symbolic::ContactType;

/// Time between samples of the residuals [s].
const SAMPLE: f64 = 1e-3;
/// Loads below this share of the weight that a contact bears are too light for shares of friction and extent to mean much.
const LIGHT: f64 = 0.02;

/// A largest value with what it belongs to.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Peak {
    /// The value, in the field's unit.
    pub value: f64,
    /// Joint or contact.
    pub of: String,
    /// Time [s].
    pub time: f64,
}

impl Peak {
    fn see(&mut self, value: f64, time: f64, of: impl FnOnce() -> String) {
        if value > self.value {
            *self = Self {
                value,
                of: of(),
                time,
            };
        }
    }
}

/// Height of a foot between two contacts.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Swing {
    /// The foot's interface.
    pub interface: String,
    /// First phase without contact, from 0.
    pub phase: usize,
    /// Apex over the higher of the two contacts [m].
    pub height: f64,
}

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

/// Figures of one motion.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Quality {
    /// Root mean square of the joints' jerk, of differences of the accelerations [rad/s³].
    pub rms_joint_jerk: f64,
    /// Largest change of a joint torque from one interval to the next, per time [N m/s].
    pub torque_rate: Peak,
    /// Largest change of a joint torque where contacts change, over its limit.
    pub torque_jump_at_switch: Peak,
    /// Largest change of a contact force from one interval to the next, per time [N/s].
    pub force_rate: Peak,
    /// Largest force with which a contact begins or ends [N].
    pub force_at_switch: Peak,
    /// Height of every swing of a foot.
    pub swings: Vec<Swing>,
    /// Residuals between the nodes, sampled at 1 kHz.
    pub between_nodes: Residuals,
    /// Margins, demanded and reached.
    pub margins: Vec<Margin>,
}

/// Residuals between the nodes, with the acceleration and the wrenches of each interval held.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Residuals {
    /// Force that is missing at the robot's base [N].
    pub base_force: f64,
    /// Moment that is missing at the robot's base [N m].
    pub base_moment: f64,
    /// Force that is missing at an object [N].
    pub object_force: f64,
    /// Largest torque over its limit.
    pub torque_share: f64,
    /// Largest change of a torque within an interval [N m].
    pub torque_change: f64,
}

impl From<Between> for Residuals {
    fn from(found: Between) -> Self {
        Self {
            base_force: found.base_force,
            base_moment: found.base_moment,
            object_force: found.object_force,
            torque_share: found.torque_share,
            torque_change: found.torque_change,
        }
    }
}

/// A motion's numbers, interval by interval.
struct Series {
    dt: Vec<f64>,
    time: Vec<f64>,
    v: Vec<Vec<f64>>,
    a: Vec<Vec<f64>>,
    tau: Vec<Vec<f64>>,
    /// Per actuated joint, the share of the torque available at its speed.
    at_speed: Vec<Vec<f64>>,
}

impl Series {
    fn of(motion: &mut Motion) -> Self {
        let n = motion.trajectory.program.n_intervals();
        let mut series = Self {
            dt: vec![],
            time: vec![0.0],
            v: vec![],
            a: vec![],
            tau: vec![],
            at_speed: vec![],
        };
        for t in 0..n {
            let (v, a) = motion
                .trajectory
                .velocity_and_acceleration(&motion.point, t);
            series.v.push(v);
            series.a.push(a);
            series.tau.push(motion.trajectory.torques(&motion.point, t));
            let used = motion.trajectory.torque_shares(&motion.point, t, true);
            series.at_speed.push(used);
            let dt = motion.trajectory.dt(&motion.point, t);
            series.dt.push(dt);
            series.time.push(series.time[t] + dt);
        }
        series
    }

    /// Time from the middle of interval t to that of the next.
    fn apart(&self, t: usize) -> f64 {
        0.5 * (self.dt[t] + self.dt[t + 1])
    }
}

/// Measures a motion.
pub(crate) fn measure(scene: &Scene, motion: &mut Motion) -> Quality {
    let series = Series::of(motion);
    let between_nodes = motion.trajectory.between(&motion.point, SAMPLE).into();
    let (torque_rate, torque_jump_at_switch) = torques(motion, &series);
    let (force_rate, force_at_switch) = forces(scene, motion, &series);
    Quality {
        rms_joint_jerk: jerk(motion, &series),
        torque_rate,
        torque_jump_at_switch,
        force_rate,
        force_at_switch,
        swings: swings(scene, motion),
        between_nodes,
        margins: margins(scene, motion, &series),
    }
}

fn jerk(motion: &Motion, series: &Series) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    for t in 0..series.a.len().saturating_sub(1) {
        for joint in motion.trajectory.program.system.actuated() {
            let i = joint.idx_v;
            let jerk = (series.a[t + 1][i] - series.a[t][i]) / series.apart(t);
            sum += jerk * jerk;
            count += 1;
        }
    }
    (sum / f64::from(count.max(1))).sqrt()
}

fn torques(motion: &Motion, series: &Series) -> (Peak, Peak) {
    let program = &motion.trajectory.program;
    let (mut rate, mut jump) = (Peak::default(), Peak::default());
    for t in 0..series.tau.len().saturating_sub(1) {
        let switch = program.phase_of(t) != program.phase_of(t + 1);
        for joint in program.system.actuated() {
            let i = joint.idx_v;
            let change = (series.tau[t + 1][i] - series.tau[t][i]).abs();
            let time = series.time[t + 1];
            rate.see(change / series.apart(t), time, || joint.name.clone());
            if switch && joint.torque_limit.is_finite() {
                jump.see(change / joint.torque_limit, time, || joint.name.clone());
            }
        }
    }
    (rate, jump)
}

fn forces(scene: &Scene, motion: &Motion, series: &Series) -> (Peak, Peak) {
    let program = &motion.trajectory.program;
    let (mut rate, mut at_switch) = (Peak::default(), Peak::default());
    let name = |force: &ocp::Force| {
        let name = |i: symbolic::InterfaceId| scene.interfaces[i.0].name.as_str();
        format!("{} on {}", name(force.contact.a), name(force.contact.b))
    };
    let linear = |t: usize, force: &ocp::Force| {
        let wrench = ocp::physical_wrench(force, &motion.point.wrenches[t]);
        wrench.fixed_rows::<3>(0).into_owned()
    };
    for t in 0..series.dt.len().saturating_sub(1) {
        let (before, after) = (
            &program.intervals[t].forces,
            &program.intervals[t + 1].forces,
        );
        let time = series.time[t + 1];
        let same = |force: &ocp::Force, others: &[ocp::Force]| {
            others.iter().position(|o| o.contact == force.contact)
        };
        for force in before {
            match same(force, after) {
                Some(i) => {
                    let change = (linear(t + 1, &after[i]) - linear(t, force)).norm();
                    rate.see(change / series.apart(t), time, || name(force));
                }
                None => at_switch.see(linear(t, force).norm(), time, || name(force)),
            }
        }
        for force in after.iter().filter(|force| same(force, before).is_none()) {
            at_switch.see(linear(t + 1, force).norm(), time, || name(force));
        }
    }
    (rate, at_switch)
}

fn swings(scene: &Scene, motion: &Motion) -> Vec<Swing> {
    let program = &motion.trajectory.program;
    let model = &program.system.model;
    let heights = |interface: &scene::Interface| -> Vec<f64> {
        let carrier = (program.system).carrier(interface.owner, &interface.body_from_interface);
        let mut kinematics = Kinematics::new(model);
        let nodes = motion.point.nodes.iter();
        nodes
            .map(|q| {
                kinematics.update(model, q);
                carrier.world_from_frame(&kinematics).origin().z
            })
            .collect()
    };
    let mut found = Vec::new();
    for (i, interface) in scene.interfaces.iter().enumerate() {
        if interface.role != Role::Foot {
            continue;
        }
        let held = |t: usize| {
            let forces = &program.intervals[t].forces;
            forces.iter().any(|force| force.contact.a.0 == i)
        };
        let n = program.n_intervals();
        let z = heights(interface);
        let mut start = None;
        for t in 1..n {
            if !held(t) && held(t - 1) {
                start = Some(t);
            } else if let (true, Some(from)) = (held(t), start) {
                let apex = z[from..=t]
                    .iter()
                    .copied()
                    .fold(f64::NEG_INFINITY, f64::max);
                found.push(Swing {
                    interface: interface.name.clone(),
                    phase: program.phase_of(from),
                    height: apex - z[from].max(z[t]),
                });
                start = None;
            }
        }
    }
    found
}

fn largest(values: impl Iterator<Item = f64>) -> Option<f64> {
    values.reduce(f64::max)
}

fn smallest(values: impl Iterator<Item = f64>) -> Option<f64> {
    values.reduce(f64::min)
}

fn margins(scene: &Scene, motion: &Motion, series: &Series) -> Vec<Margin> {
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
