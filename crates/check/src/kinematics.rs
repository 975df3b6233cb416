//! Poses, velocities and accelerations of all links, each in maximal coordinates.
//!
//! Obtained by differentiating the chain directly. With r from the parent's origin to the link's, z the joint axis
//! and q the joint position, in world axes:
//!
//! - turning joint: `ω = ω_p + z q̇`, `α = α_p + z q̈ + ω_p × z q̇`, `v = v_p + ω_p × r`, `a = a_p + α_p × r + ω_p × (ω_p × r)`;
//! - sliding joint: ω, α as the parent's, `v = v_p + ω_p × r + z q̇`, `a = a_p + α_p × r + ω_p × (ω_p × r) + z q̈ + 2 ω_p × z q̇`.
//!
//! Velocities and accelerations are the classical ones of the link's origin, not spatial ones.
//! Source: Kane and Levinson, *Dynamics: Theory and Applications*, sections 2.7–2.8.

use nalgebra::Vector3;
use spatial::{Pose, exp_so3};

use crate::robot::{JointMotion, Link, Robot};

/// Motion of a frame: its pose in the world and its rates, world axes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FrameMotion {
    pub world_from_frame: Pose,
    /// Velocity of the origin [m/s].
    pub velocity: Vector3<f64>,
    /// Angular velocity [rad/s].
    pub omega: Vector3<f64>,
    /// Acceleration of the origin [m/s²].
    pub acceleration: Vector3<f64>,
    /// Angular acceleration [rad/s²].
    pub alpha: Vector3<f64>,
}

impl FrameMotion {
    /// A frame at rest.
    pub fn at_rest(world_from_frame: Pose) -> Self {
        let zero = Vector3::zeros();
        Self {
            world_from_frame,
            velocity: zero,
            omega: zero,
            acceleration: zero,
            alpha: zero,
        }
    }

    /// A body with the body-frame twist `[linear, angular]` and its time derivative.
    ///
    /// The derivative of the world-axes velocity `R v` is `R (v̇ + ω × v)`; that of `R ω` is `R ω̇`.
    pub fn of_body(world_from_body: Pose, twist: &[f64], twist_rate: &[f64]) -> Self {
        let part = |x: &[f64], from: usize| Vector3::new(x[from], x[from + 1], x[from + 2]);
        let (v, w) = (part(twist, 0), part(twist, 3));
        let (dv, dw) = (part(twist_rate, 0), part(twist_rate, 3));
        Self {
            world_from_frame: world_from_body,
            velocity: world_from_body.rotate(v),
            omega: world_from_body.rotate(w),
            acceleration: world_from_body.rotate(dv + w.cross(&v)),
            alpha: world_from_body.rotate(dw),
        }
    }

    /// Velocity of the point of the body that is now at `point_in_world` [m/s].
    pub fn velocity_at(&self, point_in_world: &Vector3<f64>) -> Vector3<f64> {
        self.velocity
            + self
                .omega
                .cross(&(point_in_world - self.world_from_frame.origin()))
    }

    /// Acceleration of the point of the body that is now at `point_in_world` [m/s²].
    pub fn acceleration_at(&self, point_in_world: &Vector3<f64>) -> Vector3<f64> {
        let r = point_in_world - self.world_from_frame.origin();
        self.acceleration + self.alpha.cross(&r) + self.omega.cross(&self.omega.cross(&r))
    }
}

/// Motion of all links for one row of `q`, `v` and `a` of the plan (`7 + n`, `6 + n`, `6 + n` numbers).
pub(crate) fn links(robot: &Robot, q: &[f64], v: &[f64], a: &[f64]) -> Vec<FrameMotion> {
    let world_from_base = robot.world_from_origin * base_pose(q);
    let mut motions: Vec<FrameMotion> = Vec::with_capacity(robot.links.len());
    for link in &robot.links {
        motions.push(match link.parent {
            None => FrameMotion::of_body(world_from_base, &v[..6], &a[..6]),
            Some(parent) => child(&motions[parent], link, &q[7..], &v[6..], &a[6..]),
        });
    }
    motions
}

/// Pose of the base of a row of `q`.
pub(crate) fn base_pose(q: &[f64]) -> Pose {
    Pose::from_xyzquat(&[q[0], q[1], q[2], q[3], q[4], q[5], q[6]])
}

fn child(parent: &FrameMotion, link: &Link, q: &[f64], dq: &[f64], ddq: &[f64]) -> FrameMotion {
    let world_from_joint = parent.world_from_frame * link.parent_from_link;
    let mut motion = FrameMotion {
        world_from_frame: world_from_joint,
        ..*parent
    };
    if let JointMotion::Slides { axis, column } = link.motion {
        let origin = world_from_joint.act(axis * q[column]);
        motion.world_from_frame = Pose::from_parts(*world_from_joint.rotation(), origin);
    }
    let origin = motion.world_from_frame.origin();
    motion.velocity = parent.velocity_at(&origin);
    motion.acceleration = parent.acceleration_at(&origin);
    match link.motion {
        JointMotion::Fixed => {}
        JointMotion::Turns { axis, column } => {
            let z = world_from_joint.rotate(axis);
            let turned = world_from_joint.rotation() * exp_so3(&(axis * q[column]));
            motion.world_from_frame = Pose::from_parts(turned, origin);
            motion.omega += z * dq[column];
            motion.alpha += z * ddq[column] + parent.omega.cross(&z) * dq[column];
        }
        JointMotion::Slides { axis, column } => {
            let z = world_from_joint.rotate(axis);
            motion.velocity += z * dq[column];
            motion.acceleration += z * ddq[column] + parent.omega.cross(&z) * (2.0 * dq[column]);
        }
    }
    motion
}

/// The configuration a `share` of the way from `q` to `next`, along the screw of the base and straight for the joints.
pub(crate) fn between(q: &[f64], next: &[f64], share: f64) -> Vec<f64> {
    let (from, to) = (base_pose(q), base_pose(next));
    let base = from.plus(&(to.minus(&from) * share)).to_xyzquat();
    let joints = q[7..]
        .iter()
        .zip(&next[7..])
        .map(|(x, y)| x + share * (y - x));
    base.into_iter().chain(joints).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random_robot::{State, robot};

    #[test]
    fn rates_are_the_derivatives_of_poses_and_of_rates() {
        const H: f64 = 1e-5;
        for seed in 0..20 {
            let robot = robot(seed);
            let state = State::random(&robot, seed);
            let at = |h: f64| state.after(h).links(&robot);
            for ((before, now), after) in at(-H).iter().zip(&at(0.0)).zip(&at(H)) {
                let twist = (after.world_from_frame.minus(&before.world_from_frame)) / (2.0 * H);
                let turning = now
                    .world_from_frame
                    .rotate(twist.fixed_rows::<3>(3).into_owned());
                let moving = (after.world_from_frame.origin() - before.world_from_frame.origin())
                    / (2.0 * H);
                assert!((turning - now.omega).norm() < 1e-8);
                assert!((moving - now.velocity).norm() < 1e-8);
                assert!(
                    ((after.velocity - before.velocity) / (2.0 * H) - now.acceleration).norm()
                        < 1e-7
                );
                assert!(((after.omega - before.omega) / (2.0 * H) - now.alpha).norm() < 1e-7);
            }
        }
    }

    #[test]
    fn halfway_between_two_configurations_is_as_far_from_both() {
        let robot = robot(0);
        let (from, to) = (State::random(&robot, 1).q, State::random(&robot, 2).q);
        let middle = between(&from, &to, 0.5);
        let gap =
            base_pose(&middle).minus(&base_pose(&from)) - base_pose(&to).minus(&base_pose(&middle));
        assert!(gap.norm() < 1e-12);
        assert!((middle[8] - 0.5 * (from[8] + to[8])).abs() < 1e-15);
    }
}
