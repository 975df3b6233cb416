//! The motion between the nodes of a plan, as its integrator means it.
//!
//! With s the time since node t, within interval t: `q(s) = q[t] ⊕ (u·s + c·a[t]·s²)` and u = v[t], c = 0 for Euler, u = v[t+1],
//! c = 0 for semi-implicit Euler, u = v[t], c = ½ for constant acceleration; ⊕ is the exponential of the body-frame twist for
//! the base and the objects, addition for joints. Source: `docs/plan-format.md`, "Integrator".
//!
//! Velocities are the derivatives of that: of a body with ξ(s) = u·s + c·a·s² the twist Jr(ξ)·(u + 2c·a·s), in its own frame,
//! with Jr the right Jacobian of exp. At the nodes they are the plan's own.

use crate::grid::Moment;
use nalgebra::Vector6;
use plan::{Integrator, Plan};
use spatial::{Pose, Twist, right_jacobian};

/// Which velocity and acceleration move a state within an interval.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rule {
    /// 1 where the velocity is that of the node ahead.
    ahead: usize,
    accelerates: bool,
}

/// A body in the world.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BodyState {
    pub world_from_body: Pose,
    pub twist_body_in_body: Twist,
}

/// The base and the joints in the order of the plan.
#[derive(Debug, Clone)]
pub(crate) struct RobotState {
    pub base: BodyState,
    /// [rad or m]
    pub positions: Vec<f64>,
    /// [rad/s or m/s]
    pub rates: Vec<f64>,
}

impl Rule {
    pub fn of(integrator: Integrator) -> Self {
        Self {
            ahead: usize::from(integrator == Integrator::SemiImplicitEuler),
            accelerates: integrator == Integrator::ConstantAcceleration,
        }
    }

    /// Robot at a moment.
    pub fn robot(self, plan: &Plan, moment: Moment) -> RobotState {
        let q = &plan.q[moment.node];
        let (v, a) = (
            &plan.v[self.velocity_node(moment)],
            &plan.a[moment.interval],
        );
        let pose = [q[0], q[1], q[2], q[3], q[4], q[5], q[6]];
        let joints = (7..q.len()).map(|i| self.moved(v[i - 1], a[i - 1], moment.since));
        let (steps, rates): (Vec<_>, _) = joints.unzip();
        RobotState {
            base: self.body(&pose, &v[..6], &a[..6], moment.since),
            positions: q[7..].iter().zip(steps).map(|(q, step)| q + step).collect(),
            rates,
        }
    }

    /// Object at a moment.
    pub fn object(self, states: &plan::ObjectStates, moment: Moment) -> BodyState {
        let twist = &states.twist[self.velocity_node(moment)];
        let accel = &states.accel[moment.interval];
        self.body(&states.pose[moment.node], twist, accel, moment.since)
    }

    /// The node whose velocity counts: at a node its own.
    fn velocity_node(self, moment: Moment) -> usize {
        if moment.since > 0.0 {
            moment.node + self.ahead
        } else {
            moment.node
        }
    }

    fn body(self, pose: &plan::Pose7, twist: &[f64], accel: &[f64], since: f64) -> BodyState {
        let moved = |i: usize| self.moved(twist[i], accel[i], since);
        let xi = Vector6::from_fn(|i, _| moved(i).0);
        let rate = Vector6::from_fn(|i, _| moved(i).1);
        BodyState {
            world_from_body: Pose::from_xyzquat(pose).plus(&xi),
            twist_body_in_body: Twist::from_vector(&(right_jacobian(&xi) * rate)),
        }
    }

    /// Increment of one coordinate after a time, and its rate.
    fn moved(self, velocity: f64, acceleration: f64, since: f64) -> (f64, f64) {
        let a = if self.accelerates { acceleration } else { 0.0 };
        ((velocity + 0.5 * a * since) * since, velocity + a * since)
    }
}

impl BodyState {
    /// Velocity of the origin [m/s] and angular velocity [rad/s], world axes.
    pub fn velocities_in_world(&self) -> [[f64; 3]; 2] {
        let Twist { linear, angular } = self.twist_body_in_body;
        [linear, angular].map(|x| self.world_from_body.rotate(x).into())
    }
}
