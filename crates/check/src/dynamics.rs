//! Dynamics of the robot: momentum, its balance, the unactuated rows and the torques.
//!
//! Every link is a free body with mass m, inertia I about its centre of mass c and the motion of [`kinematics`]. With
//! the contact wrenches (f, μ at x) on the links, the residual forces of the bodies are
//!
//! - `F_i = m_i (a_ci − g)` and `N_i = I_i α_i + ω_i × I_i ω_i`,
//!
//! and virtual power along each degree of freedom (Kane's partial velocities) gives the generalised forces: all bodies
//! together for the base, the bodies beyond a joint for the joint, `τ_j = Σ z·((c_i − o)×F_i + N_i) − Σ z·((x − o)×f + μ)`
//! for a joint turning about z through o, `Σ z·F_i − Σ z·f` for a sliding one.
//!
//! Momentum: `h = Σ (m v_c, (c − com) × m v_c + I ω)`, world axes, about the centre of mass of the robot.
//! Source: Kane and Levinson, *Dynamics: Theory and Applications*, ch. 4–6; paper, eqs. for h and τ.
//!
//! [`kinematics`]: crate::kinematics

use nalgebra::Vector3;
use plan::Integrator;

use crate::categories::Category;
use crate::integration::largest;
use crate::kinematics::FrameMotion;
use crate::measure::Measurements;
use crate::motion::{Motion, Owner};
use crate::robot::{JointMotion, Robot};

/// A force with a moment, acting at a point; world axes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Load {
    pub force: Vector3<f64>,
    /// About `point`.
    pub moment: Vector3<f64>,
    pub point: Vector3<f64>,
}

impl Load {
    /// Moment about another point.
    fn moment_about(&self, point: &Vector3<f64>) -> Vector3<f64> {
        (self.point - point).cross(&self.force) + self.moment
    }
}

/// Linear and angular momentum [kg m/s, kg m²/s], the angular part about the centre of mass, world axes.
#[derive(Debug, Clone, Copy)]
struct Momentum {
    linear: Vector3<f64>,
    angular: Vector3<f64>,
    com_in_world: Vector3<f64>,
}

/// Judges the robot's dynamics at all nodes and intervals.
pub(crate) fn judge(motion: &Motion, found: &mut Measurements) {
    let momentum: Vec<_> = motion
        .links
        .iter()
        .map(|links| momentum(&motion.robot, links))
        .collect();
    for (t, computed) in momentum.iter().enumerate() {
        let file = motion.plan.h[t];
        let gap = |i: usize| {
            if i < 3 {
                file[i] - computed.linear[i]
            } else {
                file[i] - computed.angular[i - 3]
            }
        };
        let worst = largest((0..6).map(gap)).1;
        found.add(Category::MomentumFile, worst, || motion.place(t, ""));
    }
    for t in 0..motion.n_intervals() {
        let loads = robot_loads(motion, t);
        momentum_balance(motion, t, &momentum[t], &momentum[t + 1], &loads, found);
        equations_of_motion(motion, t, &momentum[t].com_in_world, &loads, found);
    }
}

/// The contact loads on the robot's links in interval `t`: on `a` as in the file, on `b` their negatives.
fn robot_loads(motion: &Motion, t: usize) -> Vec<(usize, Load)> {
    let mut loads = Vec::new();
    for (contact, force, moment) in motion.loads(t) {
        let point = motion.frames[t][contact.a].world_from_frame.origin();
        for (interface, sign) in [(contact.a, 1.0), (contact.b, -1.0)] {
            if let Owner::Link(link) = motion.interfaces[interface].owner {
                loads.push((
                    link,
                    Load {
                        force: force * sign,
                        moment: moment * sign,
                        point,
                    },
                ));
            }
        }
    }
    loads
}

fn momentum(robot: &Robot, links: &[FrameMotion]) -> Momentum {
    let bodies = || {
        robot
            .links
            .iter()
            .zip(links)
            .filter(|(link, _)| link.mass > 0.0 || link.inertia_in_link.norm() > 0.0)
    };
    let centre =
        |(link, at): (&crate::robot::Link, &FrameMotion)| at.world_from_frame.act(link.com_in_link);
    let mass_moment: Vector3<f64> = bodies().map(|body| centre(body) * body.0.mass).sum();
    let com_in_world = mass_moment / robot.mass();
    let mut total = Momentum {
        linear: Vector3::zeros(),
        angular: Vector3::zeros(),
        com_in_world,
    };
    for (link, at) in bodies() {
        let c = centre((link, at));
        let linear = at.velocity_at(&c) * link.mass;
        let omega_in_link = at.world_from_frame.rotate_inverse(at.omega);
        total.linear += linear;
        total.angular += (c - com_in_world).cross(&linear);
        total.angular += at
            .world_from_frame
            .rotate(link.inertia_in_link * omega_in_link);
    }
    total
}

/// `(h[t+1] − h[t]) / dt = (m g + Σ f, Σ (x − com) × f + μ)`, at node t.
fn momentum_balance(
    motion: &Motion,
    t: usize,
    now: &Momentum,
    next: &Momentum,
    loads: &[(usize, Load)],
    found: &mut Measurements,
) {
    let dt = motion.dt[t];
    let force: Vector3<f64> = loads.iter().map(|(_, load)| load.force).sum();
    let moment: Vector3<f64> = loads
        .iter()
        .map(|(_, load)| load.moment_about(&now.com_in_world))
        .sum();
    let weight = motion.gravity() * motion.robot.mass();
    let force_gap = (next.linear - now.linear) / dt - weight - force;
    let moment_gap = (next.angular - now.angular) / dt - moment;
    found.add(Category::CentroidalForce, force_gap.norm(), || {
        motion.place(t, "")
    });
    found.add(Category::CentroidalMoment, moment_gap.norm(), || {
        motion.place(t, "")
    });
}

fn equations_of_motion(
    motion: &Motion,
    t: usize,
    com_in_world: &Vector3<f64>,
    loads: &[(usize, Load)],
    found: &mut Measurements,
) {
    let forces = inverse_dynamics(
        &motion.robot,
        &motion.links[t],
        &motion.gravity(),
        com_in_world,
        loads,
    );
    found.add(Category::UnactuatedForce, forces.base_force.norm(), || {
        motion.place(t, "")
    });
    found.add(
        Category::UnactuatedMoment,
        forces.base_moment.norm(),
        || motion.place(t, ""),
    );
    for (j, torque) in forces.torques.iter().enumerate() {
        let name = &motion.robot.joints[j];
        let error = (motion.plan.tau[t][j] - torque).abs();
        found.add(Category::TorqueFile, error, || motion.place(t, name));
        let excess = (torque.abs() - effort_limit(motion, j)).max(0.0);
        // f64::max drops a NaN; keep it.
        let excess = if torque.is_finite() {
            excess
        } else {
            f64::INFINITY
        };
        found.add(Category::TorqueLimit, excess, || {
            motion.place(t, format!("{name} {torque:.1} N m"))
        });
        torque_at_speed(motion, t, j, *torque, found);
    }
}

/// Torque `tau` of joint `j` in interval `t` against what is left of its limit at speed, at the nodes whose velocity the
/// integrator uses.
fn torque_at_speed(motion: &Motion, t: usize, j: usize, tau: f64, found: &mut Measurements) {
    let name = &motion.robot.joints[j];
    for (node, left) in left_at_speed(motion, t, j, tau) {
        let excess = tau.abs() - effort_limit(motion, j) * left;
        let excess = if excess.is_finite() {
            excess.max(0.0)
        } else {
            f64::INFINITY
        };
        let speed = motion.plan.v[node][6 + j];
        found.add(Category::TorqueSpeed, excess, || {
            motion.place(t, format!("{name} {tau:.1} N m at {speed:.1} rad/s"))
        });
    }
}

/// The share of the limit of joint `j` that is left for a torque `tau` in interval `t`, and the node: one entry per velocity
/// that the integrator uses, none where nothing is declared or enforced. Full when the joint brakes, at most 1, at least 0.
pub(crate) fn left_at_speed(
    motion: &Motion,
    t: usize,
    j: usize,
    tau: f64,
) -> impl Iterator<Item = (usize, f64)> {
    let curve = motion.plan.robot.torque_speed.get(&motion.robot.joints[j]);
    let curve = curve.filter(|_| effort_limit(motion, j).is_finite());
    let nodes = match motion.plan.integrator {
        Integrator::Euler => t..=t,
        Integrator::SemiImplicitEuler => t + 1..=t + 1,
        Integrator::ConstantAcceleration => t..=t + 1,
    };
    curve.into_iter().flat_map(move |curve| {
        nodes.clone().map(move |node| {
            let driving = motion.plan.v[node][6 + j] * tau.signum();
            let left = 1.0 - (driving - curve.corner) / (curve.max - curve.corner);
            (node, left.clamp(0.0, 1.0))
        })
    })
}

/// Effort limit of joint `j` [N m]; infinite if the plan declares it as not enforced.
pub(crate) fn effort_limit(motion: &Motion, j: usize) -> f64 {
    match &motion.plan.robot.torque_limits {
        Some(limits) if limits[j].is_none() => f64::INFINITY,
        _ => motion.robot.limits[j].effort,
    }
}

/// Recomputed joint torques of interval `t` [N m].
pub(crate) fn torques(motion: &Motion, t: usize) -> Vec<f64> {
    let loads = robot_loads(motion, t);
    let com_in_world = momentum(&motion.robot, &motion.links[t]).com_in_world;
    inverse_dynamics(
        &motion.robot,
        &motion.links[t],
        &motion.gravity(),
        &com_in_world,
        &loads,
    )
    .torques
}

/// Generalised forces that the motion needs beyond the contact loads.
struct GeneralisedForces {
    /// World axes [N].
    base_force: Vector3<f64>,
    /// About the centre of mass of the robot, world axes [N m].
    base_moment: Vector3<f64>,
    /// By joint [N m or N].
    torques: Vec<f64>,
}

fn inverse_dynamics(
    robot: &Robot,
    links: &[FrameMotion],
    gravity: &Vector3<f64>,
    com_in_world: &Vector3<f64>,
    contact_loads: &[(usize, Load)],
) -> GeneralisedForces {
    let inertial = robot
        .links
        .iter()
        .zip(links)
        .enumerate()
        .map(|(i, (link, at))| (i, needed_by_body(link, at, gravity)));
    let contacts = contact_loads.iter().map(|(i, load)| {
        let opposite = Load {
            force: -load.force,
            moment: -load.moment,
            ..*load
        };
        (*i, opposite)
    });
    let zero = Vector3::zeros();
    let mut forces = GeneralisedForces {
        base_force: zero,
        base_moment: zero,
        torques: vec![0.0; robot.joints.len()],
    };
    for (i, load) in inertial.chain(contacts) {
        forces.base_force += load.force;
        forces.base_moment += load.moment_about(com_in_world);
        add_virtual_power(robot, links, i, &load, &mut forces.torques);
    }
    forces
}

/// Newton's and Euler's equations of one free body: the force at its centre of mass, and the moment, that move it so.
fn needed_by_body(link: &crate::robot::Link, at: &FrameMotion, gravity: &Vector3<f64>) -> Load {
    let point = at.world_from_frame.act(link.com_in_link);
    let rotation = at.world_from_frame.rotation();
    let inertia = rotation * link.inertia_in_link * rotation.transpose();
    Load {
        force: (at.acceleration_at(&point) - gravity) * link.mass,
        moment: inertia * at.alpha + at.omega.cross(&(inertia * at.omega)),
        point,
    }
}

/// Adds the power of `load` on link `i` per unit rate of each joint between the link and the base.
fn add_virtual_power(
    robot: &Robot,
    links: &[FrameMotion],
    i: usize,
    load: &Load,
    torques: &mut [f64],
) {
    let mut at = Some(i);
    while let Some(link) = at {
        let frame = &links[link].world_from_frame;
        match robot.links[link].motion {
            JointMotion::Fixed => {}
            JointMotion::Turns { axis, column } => {
                torques[column] += frame.rotate(axis).dot(&load.moment_about(&frame.origin()));
            }
            JointMotion::Slides { axis, column } => {
                torques[column] += frame.rotate(axis).dot(&load.force);
            }
        }
        at = robot.links[link].parent;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random_robot::{State, robot};

    const H: f64 = 1e-5;

    fn gravity() -> Vector3<f64> {
        Vector3::new(0.5, -0.3, -9.81)
    }

    fn forces(robot: &Robot, state: &State, loads: &[(usize, Load)]) -> GeneralisedForces {
        let links = state.links(robot);
        inverse_dynamics(
            robot,
            &links,
            &gravity(),
            &momentum(robot, &links).com_in_world,
            loads,
        )
    }

    fn random_load(seed: u64) -> Load {
        let mut random = spatial::Random::new(seed);
        let mut vector = |scale: f64| Vector3::from_fn(|_, _| random.uniform(-scale, scale));
        Load {
            force: vector(10.0),
            moment: vector(5.0),
            point: vector(1.0),
        }
    }

    #[test]
    fn without_contacts_the_base_forces_are_the_rate_of_momentum_less_the_weight() {
        for seed in 0..20 {
            let robot = robot(seed);
            let state = State::random(&robot, seed);
            let at = |h: f64| momentum(&robot, &state.after(h).links(&robot));
            let (before, after) = (at(-H), at(H));
            let found = forces(&robot, &state, &[]);
            let weight = gravity() * robot.mass();
            let force = (after.linear - before.linear) / (2.0 * H) - weight;
            let moment = (after.angular - before.angular) / (2.0 * H);
            assert!(
                (found.base_force - force).norm() < 1e-7 * (1.0 + force.norm()),
                "seed {seed}"
            );
            assert!(
                (found.base_moment - moment).norm() < 1e-7 * (1.0 + moment.norm()),
                "seed {seed}"
            );
        }
    }

    /// Kinetic energy less the work of gravity.
    fn energy(robot: &Robot, state: &State) -> f64 {
        let body = |(link, at): (&crate::robot::Link, &FrameMotion)| {
            let c = at.world_from_frame.act(link.com_in_link);
            let omega = at.world_from_frame.rotate_inverse(at.omega);
            let turning = omega.dot(&(link.inertia_in_link * omega));
            0.5 * (link.mass * at.velocity_at(&c).norm_squared() + turning)
                - link.mass * gravity().dot(&c)
        };
        robot.links.iter().zip(&state.links(robot)).map(body).sum()
    }

    fn power(robot: &Robot, state: &State, forces: &GeneralisedForces) -> f64 {
        let links = state.links(robot);
        let com = momentum(robot, &links).com_in_world;
        let base = forces.base_force.dot(&links[0].velocity_at(&com))
            + forces.base_moment.dot(&links[0].omega);
        let joints: f64 = forces
            .torques
            .iter()
            .zip(&state.v[6..])
            .map(|(tau, rate)| tau * rate)
            .sum();
        base + joints
    }

    #[test]
    fn the_power_of_all_forces_is_the_rate_of_energy() {
        for seed in 0..50 {
            let robot = robot(seed);
            let state = State::random(&robot, seed);
            let rate =
                (energy(&robot, &state.after(H)) - energy(&robot, &state.after(-H))) / (2.0 * H);
            let found = power(&robot, &state, &forces(&robot, &state, &[]));
            assert!(
                (found - rate).abs() < 1e-6 * (1.0 + rate.abs()),
                "seed {seed}: {found} {rate}"
            );
        }
    }

    #[test]
    fn a_contact_takes_its_power_from_the_actuators() {
        for seed in 0..20 {
            let robot = robot(seed);
            let state = State::random(&robot, seed);
            let link = seed as usize % robot.links.len();
            let load = random_load(seed);
            let without = power(&robot, &state, &forces(&robot, &state, &[]));
            let with = power(&robot, &state, &forces(&robot, &state, &[(link, load)]));
            let at = state.links(&robot)[link];
            let given = load.force.dot(&at.velocity_at(&load.point)) + load.moment.dot(&at.omega);
            assert!(
                (without - with - given).abs() < 1e-9 * (1.0 + given.abs()),
                "seed {seed}"
            );
        }
    }
}
