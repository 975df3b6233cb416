//! Random robots for tests and benchmarks.

use crate::{Frame, Joint, JointKind, Model, Root};
use nalgebra::{Matrix3, Vector3};
use spatial::{Inertia, Pose, Random};

impl Model {
    /// A random tree with `joints` single-degree joints (revolute and prismatic, axes aligned or not) and one frame per
    /// joint; the same for the same seed. For tests of algorithms.
    ///
    /// # Panics
    /// If there is nothing that moves: no joints on a fixed root, or more than the model allows.
    pub fn random(seed: u64, root: Root, joints: usize) -> Self {
        let mut random = Random::new(seed);
        let mut list = Vec::new();
        if root == Root::Floating {
            list.push(random_joint(
                &mut random,
                "base".to_owned(),
                JointKind::FreeFlyer,
                None,
            ));
        }
        for number in 0..joints {
            let kind = random_kind(&mut random);
            let parent = random_parent(&mut random, &list);
            list.push(random_joint(
                &mut random,
                format!("joint_{number}"),
                kind,
                parent,
            ));
        }
        let frame = |(index, joint): (usize, &Joint)| Frame {
            name: format!("link_of_{}", joint.name),
            joint: Some(index),
            joint_from_frame: Pose::random(seed * 1000 + index as u64),
            shapes: Vec::new(),
        };
        let frames = list.iter().enumerate().map(frame).collect();
        Self::new("random", list, frames)
            .expect("random joints are in depth-first order and have mass")
    }
}

fn random_kind(random: &mut Random) -> JointKind {
    let units = [Vector3::x(), Vector3::y(), Vector3::z()];
    match random.index(8) {
        choice @ 0..3 => JointKind::Revolute {
            axis: units[choice],
        },
        3 => JointKind::Prismatic {
            axis: units[random.index(3)],
        },
        4 => JointKind::Prismatic {
            axis: random_direction(random),
        },
        _ => JointKind::Revolute {
            axis: random_direction(random),
        },
    }
}

fn random_direction(random: &mut Random) -> Vector3<f64> {
    let [x, y, z, w] = random.unit_quaternion();
    Vector3::new(x, y, z + 0.01 * w).normalize()
}

/// The last joint or one of its ancestors, so that the order stays depth-first; mostly the last.
fn random_parent(random: &mut Random, list: &[Joint]) -> Option<usize> {
    let mut parent = list.len().checked_sub(1);
    while random.index(3) == 0 {
        match parent.map(|index| list[index].parent) {
            // a floating base stays the only root
            Some(None) if list[0].kind == JointKind::FreeFlyer => break,
            Some(above) => parent = above,
            None => break,
        }
    }
    parent
}

fn random_joint(
    random: &mut Random,
    name: String,
    kind: JointKind,
    parent: Option<usize>,
) -> Joint {
    let free = kind == JointKind::FreeFlyer;
    let placement = if free {
        Pose::identity()
    } else {
        Pose::random(random.next_u64())
    };
    let root = Matrix3::from_fn(|_, _| random.uniform(-0.3, 0.3));
    let inertia = Inertia {
        mass: random.uniform(0.5, 3.0),
        com: Vector3::from_fn(|_, _| random.uniform(-0.3, 0.3)),
        inertia: root * root.transpose() + Matrix3::identity() * 0.01,
    };
    let range = if free { f64::INFINITY } else { 2.0 };
    let (lower, upper) = (-range, range);
    let (velocity_limit, torque_limit) = (f64::INFINITY, f64::INFINITY);
    Joint {
        name,
        kind,
        parent,
        parent_from_joint: placement,
        inertia,
        idx_q: 0,
        idx_v: 0,
        lower,
        upper,
        velocity_limit,
        torque_limit,
        torque_speed: None,
    }
}
