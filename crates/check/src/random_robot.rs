//! Random robots in random motion, for tests.

use std::fmt::Write as _;

use nalgebra::Vector6;
use spatial::Random;

use crate::kinematics::{self, FrameMotion, base_pose};
use crate::robot::Robot;
use crate::urdf;

/// A tree of eight links with turning, sliding and fixed joints; the last but one joint is not listed by the plan.
pub(crate) fn robot(seed: u64) -> Robot {
    let mut random = Random::new(seed);
    let mut numbers = |n: usize, scale: f64| -> String {
        (0..n)
            .map(|_| random.uniform(-scale, scale).to_string())
            .collect::<Vec<_>>()
            .join(" ")
    };
    let mut text = "<robot name='random'>".to_owned();
    for i in 0..8 {
        let (place, mass) = (
            format!("xyz='{}' rpy='{}'", numbers(3, 0.2), numbers(3, 3.0)),
            1.0 + f64::from(i),
        );
        write!(
            text,
            "<link name='l{i}'><inertial><origin {place}/><mass value='{mass}'/>\
             <inertia ixx='0.3' ixy='0.01' ixz='-0.02' iyy='0.4' iyz='0.03' izz='0.5'/></inertial></link>"
        )
        .unwrap();
    }
    let mut parent = Random::new(seed + 1);
    for i in 1..8 {
        let kind = ["revolute", "prismatic", "revolute", "fixed"][i % 4];
        let (place, axis) = (
            format!("xyz='{}' rpy='{}'", numbers(3, 0.5), numbers(3, 3.0)),
            numbers(3, 1.0),
        );
        let above = parent.index(i);
        write!(
            text,
            "<joint name='j{i}' type='{kind}'><parent link='l{above}'/><child link='l{i}'/><origin {place}/>\
             <axis xyz='{axis}'/><limit lower='-1' upper='1' effort='9' velocity='9'/></joint>"
        )
        .unwrap();
    }
    text.push_str("</robot>");
    let joints = ["j5", "j1", "j2", "j4"].map(String::from);
    urdf::read(&text, &joints).unwrap()
}

/// A row each of `q`, `v`, `a`.
#[derive(Debug, Clone)]
pub(crate) struct State {
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    pub a: Vec<f64>,
}

impl State {
    pub fn random(robot: &Robot, seed: u64) -> Self {
        let mut random = Random::new(seed + 77);
        let n = robot.joints.len();
        let mut q: Vec<f64> = (0..7 + n).map(|_| random.uniform(-1.0, 1.0)).collect();
        q[3..7].copy_from_slice(&random.unit_quaternion());
        let mut row = || (0..6 + n).map(|_| random.uniform(-1.0, 1.0)).collect();
        Self {
            q,
            v: row(),
            a: row(),
        }
    }

    /// The state a short time later, right up to the third order for central differences.
    pub fn after(&self, dt: f64) -> Self {
        let step = |i: usize| self.v[i] * dt + 0.5 * self.a[i] * dt * dt;
        let base = base_pose(&self.q)
            .plus(&Vector6::from_fn(|i, _| step(i)))
            .to_xyzquat();
        let joints = (7..self.q.len()).map(|i| self.q[i] + step(i - 1));
        let v = self
            .v
            .iter()
            .zip(&self.a)
            .map(|(v, a)| v + a * dt)
            .collect();
        Self {
            q: base.into_iter().chain(joints).collect(),
            v,
            a: self.a.clone(),
        }
    }

    pub fn links(&self, robot: &Robot) -> Vec<FrameMotion> {
        kinematics::links(robot, &self.q, &self.v, &self.a)
    }
}
