//! Poses and velocities of all links of the robot.

use crate::ArraysError;
use crate::states::RobotState;
use multibody::{JointOrder, Kinematics, Model, Root};
use plan::Plan;
use spatial::Pose;

/// The robot of a plan, with the links that it moves.
pub(crate) struct Links {
    model: Model,
    order: JointOrder,
    /// Indices into the model's frames; the base first.
    frames: Vec<usize>,
    kinematics: Kinematics,
}

/// A link: its pose in the world, velocity of its origin [m/s] and angular velocity [rad/s], world axes.
pub(crate) struct LinkState {
    pub world_from_link: Pose,
    pub velocities_in_world: [[f64; 3]; 2],
}

impl Links {
    pub fn new(plan: &Plan) -> Result<Self, ArraysError> {
        let model = Model::from_urdf(&plan.robot.urdf, Root::Floating)?;
        let joints = &plan.robot.joints;
        let order = JointOrder::new(&model, joints);
        let order = order.map_err(|index| ArraysError::UnknownJoint {
            index,
            joint: joints[index].clone(),
        })?;
        let moves = |frame: &usize| model.frames[*frame].joint.is_some();
        Ok(Self {
            frames: (0..model.frames.len()).filter(moves).collect(),
            kinematics: Kinematics::new(&model),
            order,
            model,
        })
    }

    /// Names of the links.
    pub fn names(&self) -> Vec<String> {
        let frames = self.frames.iter();
        frames.map(|i| self.model.frames[*i].name.clone()).collect()
    }

    /// All links, in the order of their names.
    pub fn at(&mut self, robot: &RobotState) -> impl Iterator<Item = LinkState> {
        let base = robot.base.world_from_body.to_xyzquat();
        let row = [&base[..], &robot.positions].concat();
        let q = self.order.configuration(&self.model, &row);
        let twist = robot.base.twist_body_in_body.to_vector();
        let row = [twist.as_slice(), &robot.rates].concat();
        let v = self.order.velocity(&self.model, &row);
        self.kinematics.update(&self.model, &q);
        let links = &*self;
        let frames = links.frames.iter();
        frames.map(move |index| links.link(*index, &v))
    }

    fn link(&self, index: usize, v: &[f64]) -> LinkState {
        let world_from_link = self.kinematics.frame_pose(&self.model, index);
        let joint = self.model.frames[index].joint;
        let joint = joint.expect("links that nothing moves are left out");
        let twist_in_world = self.kinematics.joint_twist_in_world(&self.model, joint, v);
        let linear = twist_in_world.at(&world_from_link.origin());
        LinkState {
            world_from_link,
            velocities_in_world: [linear.into(), twist_in_world.angular.into()],
        }
    }
}
