//! How well a robot could execute a motion: smoothness, residuals between the nodes, and what the margins came to.

mod margins;

use multibody::Kinematics;
use ocp::{Between, Motion};
use scene::{Role, Scene};
use serde::Serialize;

pub use margins::Margin;
use margins::margins;

/// Time between samples of the residuals [s].
const SAMPLE: f64 = 1e-3;

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
