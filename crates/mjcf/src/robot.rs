//! Which bodies of a model are the robot, and what they are called.

use crate::error::MjcfError;
use mjcf_rs::Model;
use mjcf_rs::body::{Joint, JointType};

/// The tree of bodies that is the robot.
pub struct Robot {
    pub root: usize,
    /// Bodies of each body, by index in the model.
    pub children: Vec<Vec<usize>>,
    /// Names of all bodies, given or made up.
    pub names: Vec<String>,
}

impl Robot {
    /// The robot's bodies, parents first, in the order of the file.
    pub fn bodies(&self) -> Vec<usize> {
        self.bodies_from(self.root)
    }

    /// A body and those on it, likewise; body 0 is the world.
    pub fn bodies_from(&self, body: usize) -> Vec<usize> {
        let mut out = vec![];
        let mut next = vec![body];
        while let Some(body) = next.pop() {
            out.push(body);
            next.extend(self.children[body].iter().rev());
        }
        out
    }

    /// Name of a body's joint, given or made up.
    pub fn joint_name(&self, body: usize, index: usize, joint: &Joint) -> String {
        let made_up = || format!("{}_joint_{}", self.names[body], index + 1);
        joint.name.clone().unwrap_or_else(made_up)
    }
}

/// Does it move one body against another by one number.
pub fn is_hinge_or_slide(joint: &Joint) -> bool {
    matches!(joint.type_, JointType::Hinge | JointType::Slide)
}

/// The tree with the most joints under the world.
pub fn find(model: &Model, notes: &mut Vec<String>) -> Result<Robot, MjcfError> {
    let mut children = vec![vec![]; model.bodies.len()];
    for (body, entry) in model.bodies_iter() {
        children[entry.parent.unwrap_or(0)].push(body);
    }
    let name = |(body, entry): (usize, &mjcf_rs::BodyEntry)| {
        let made_up = || format!("body_{body}");
        entry.body.name.clone().unwrap_or_else(made_up)
    };
    let mut robot = Robot {
        root: 0,
        names: model.bodies.iter().enumerate().map(name).collect(),
        children,
    };
    let joints = |&root: &usize| {
        let bodies = robot.bodies_from(root);
        let moving = |&b: &usize| model.bodies[b].body.joints.iter().any(is_hinge_or_slide);
        bodies.iter().filter(|b| moving(b)).count()
    };
    let trees = robot.children[0].clone();
    let counts: Vec<usize> = trees.iter().map(joints).collect();
    let most = (0..trees.len()).max_by_key(|&t| (counts[t], std::cmp::Reverse(t)));
    let Some(most) = most.filter(|&t| counts[t] > 0) else {
        return Err(MjcfError::NoRobot);
    };
    robot.root = trees[most];
    let others: Vec<&str> = trees
        .iter()
        .filter(|t| **t != robot.root)
        .map(|&t| robot.names[t].as_str())
        .collect();
    if !others.is_empty() {
        notes.push(format!(
            "bodies beside the robot {:?} are left out: {}; give them as objects and static bodies of the scene",
            robot.names[robot.root],
            others.join(", ")
        ));
    }
    let root = &model.bodies[robot.root].body.joints;
    if !root.iter().any(|j| j.type_ == JointType::Free) {
        notes.push(format!(
            "body {:?} has no free joint; the robot floats all the same",
            robot.names[robot.root]
        ));
    }
    Ok(robot)
}
