//! Quaternions, the time grid, and how each state follows from the one before.
//!
//! `q[t+1] = q[t] ⊕ (v[s]·dt + c·a[t]·dt²)`, `v[t+1] = v[t] + a[t]·dt` with s = t, c = 0 for Euler, s = t + 1 for
//! semi-implicit Euler, c = ½ for constant acceleration; ⊕ is the exponential of the body-frame twist for the base and
//! the objects, addition for joints.

use nalgebra::Vector6;
use plan::{Integrator, Plan};
use spatial::Pose;

use crate::categories::Category;
use crate::kinematics::base_pose;
use crate::measure::Measurements;
use crate::motion::Motion;
use crate::report::Location;

/// Judges the states of the robot and the objects.
pub(crate) fn judge(motion: &Motion, found: &mut Measurements) {
    quaternions(motion, found);
    time_grid(motion, found);
    let rule = Rule::of(motion.plan.integrator);
    for t in 0..motion.n_intervals() {
        robot_step(motion, rule, t, found);
        object_steps(motion, rule, t, found);
    }
}

/// The integrator: which node's velocity moves the configuration, and the factor of `a·dt²`.
#[derive(Debug, Clone, Copy)]
struct Rule {
    ahead: usize,
    curvature: f64,
}

impl Rule {
    fn of(integrator: Integrator) -> Self {
        match integrator {
            Integrator::Euler => Self {
                ahead: 0,
                curvature: 0.0,
            },
            Integrator::SemiImplicitEuler => Self {
                ahead: 1,
                curvature: 0.0,
            },
            Integrator::ConstantAcceleration => Self {
                ahead: 0,
                curvature: 0.5,
            },
        }
    }

    /// The increment of one coordinate over an interval.
    fn increment(self, velocity: f64, acceleration: f64, dt: f64) -> f64 {
        velocity * dt + self.curvature * acceleration * dt * dt
    }

    /// How far `next` is from where the body-frame twist and acceleration lead from `from` [m; rad].
    fn gap(self, from: &Pose, next: &Pose, twist: &[f64], accel: &[f64], dt: f64) -> Vector6<f64> {
        let xi = Vector6::from_fn(|i, _| self.increment(twist[i], accel[i], dt));
        next.minus(&from.plus(&xi))
    }
}

fn quaternions(motion: &Motion, found: &mut Measurements) {
    let plan = motion.plan;
    let error = |xyzw: &[f64]| (xyzw.iter().map(|x| x * x).sum::<f64>().sqrt() - 1.0).abs();
    for (t, row) in plan.q.iter().enumerate() {
        found.add(Category::Quaternion, error(&row[3..7]), || {
            motion.place(t, "robot")
        });
    }
    for (name, states) in &plan.object_states {
        for (t, pose) in states.pose.iter().enumerate() {
            found.add(Category::Quaternion, error(&pose[3..7]), || {
                motion.place(t, name)
            });
        }
    }
    for (name, pose) in fixed_poses(plan) {
        found.add(Category::Quaternion, error(&pose[3..7]), || {
            Location::of(name)
        });
    }
}

/// Poses of interfaces and shapes.
fn fixed_poses(plan: &Plan) -> impl Iterator<Item = (&str, &plan::Pose7)> {
    let interfaces = plan.interfaces.iter().map(|x| (x.name.as_str(), &x.pose));
    let objects = plan.objects.iter().map(|x| (x.name.as_str(), &x.geometry));
    let statics = plan
        .environment
        .iter()
        .map(|x| (x.name.as_str(), &x.geometry));
    let shapes = objects
        .chain(statics)
        .flat_map(|(name, list)| list.iter().map(move |g| (name, &g.pose)));
    interfaces.chain(shapes)
}

fn time_grid(motion: &Motion, found: &mut Measurements) {
    let time = &motion.plan.time;
    found.add(Category::TimeGrid, time[0].abs(), || {
        Location::of("time[0]")
    });
    for (t, dt) in motion.dt.iter().enumerate() {
        let error = if *dt > 0.0 {
            (time[t + 1] - time[t] - dt).abs()
        } else {
            f64::INFINITY
        };
        found.add(Category::TimeGrid, error, || motion.place(t, ""));
    }
}

/// The entry of largest absolute value, and that value (not finite if any entry is not).
pub(crate) fn largest(entries: impl Iterator<Item = f64>) -> (usize, f64) {
    let mut worst = (0, 0.0);
    for (i, x) in entries.enumerate() {
        if !x.is_finite() {
            return (i, f64::INFINITY);
        }
        if x.abs() > worst.1 {
            worst = (i, x.abs());
        }
    }
    worst
}

fn robot_step(motion: &Motion, rule: Rule, t: usize, found: &mut Measurements) {
    let (plan, dt) = (motion.plan, motion.dt[t]);
    let (q, next, v, a) = (
        &plan.q[t],
        &plan.q[t + 1],
        &plan.v[t + rule.ahead],
        &plan.a[t],
    );
    let base = rule.gap(&base_pose(q), &base_pose(next), &v[..6], &a[..6], dt);
    let joints = (7..q.len()).map(|i| next[i] - q[i] - rule.increment(v[i - 1], a[i - 1], dt));
    let (entry, error) = largest(base.iter().copied().chain(joints));
    found.add(Category::IntegrationQ, error, || {
        motion.place(t, coordinate(motion, entry))
    });
    let rates = (0..a.len()).map(|i| plan.v[t][i] + a[i] * dt - plan.v[t + 1][i]);
    let (entry, error) = largest(rates);
    found.add(Category::IntegrationV, error, || {
        motion.place(t, coordinate(motion, entry))
    });
}

fn object_steps(motion: &Motion, rule: Rule, t: usize, found: &mut Measurements) {
    let dt = motion.dt[t];
    for (name, states) in &motion.plan.object_states {
        let (twist, accel) = (&states.twist[t + rule.ahead], &states.accel[t]);
        let pose = |t: usize| Pose::from_xyzquat(&states.pose[t]);
        let (_, error) = largest(
            rule.gap(&pose(t), &pose(t + 1), twist, accel, dt)
                .iter()
                .copied(),
        );
        found.add(Category::IntegrationObjQ, error, || motion.place(t, name));
        let rates = (0..6).map(|i| states.twist[t][i] + accel[i] * dt - states.twist[t + 1][i]);
        found.add(Category::IntegrationObjV, largest(rates).1, || {
            motion.place(t, name)
        });
    }
}

/// Name of entry `i` of a tangent vector.
fn coordinate(motion: &Motion, i: usize) -> String {
    const BASE: [&str; 6] = [
        "base x",
        "base y",
        "base z",
        "base roll",
        "base pitch",
        "base yaw",
    ];
    match BASE.get(i) {
        Some(name) => (*name).to_owned(),
        None => motion.robot.joints[i - 6].clone(),
    }
}
