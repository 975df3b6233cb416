//! The robot and all movable objects as one multibody system: a forest whose first tree is the robot.
//!
//! Objects are single floating bodies, so one inverse dynamics gives the robot's base rows and torques and the objects'
//! Newton–Euler rows ("eq:torque_constraint", "eq:twist_wrench_dynamics"), each in its own body frame.

use crate::relative::{Body, Carrier};
use crate::turn::turn_onto;
use multibody::{Joint, JointKind, Kinematics, Model, ModelError};
use nalgebra::Vector3;
use scene::{Interface, Owner, Role, Scene};
use spatial::{Inertia, Pose};
use std::ops::Range;

/// Cosine of the angle up to which a base's z axis counts as upright.
const UPRIGHT: f64 = 0.8;

/// The system's model and where its parts are.
#[derive(Debug, Clone)]
pub struct System {
    /// Robot joints first, then one free flyer per object.
    pub model: Model,
    /// The robot alone: the first joints of `model`, with the same indices.
    pub robot: Model,
    /// Number of joints of the robot model.
    pub n_robot_joints: usize,
    /// Length of the robot's part of q.
    pub robot_nq: usize,
    /// Length of the robot's part of v.
    pub robot_nv: usize,
    /// Mass of the robot [kg].
    pub robot_mass: f64,
}

impl System {
    /// Joins the scene's robot and objects.
    ///
    /// # Errors
    /// [`ModelError`] if the parts do not make a model.
    pub fn new(scene: &Scene) -> Result<Self, ModelError> {
        let robot = &scene.robot.model;
        let mut joints = robot.joints.clone();
        for object in &scene.objects {
            joints.push(Joint {
                name: object.name.clone(),
                kind: JointKind::FreeFlyer,
                parent: None,
                parent_from_joint: Pose::identity(),
                inertia: Inertia {
                    mass: object.mass,
                    com: Vector3::zeros(),
                    inertia: object.inertia,
                },
                idx_q: 0,
                idx_v: 0,
                lower: f64::NEG_INFINITY,
                upper: f64::INFINITY,
                velocity_limit: f64::INFINITY,
                torque_limit: f64::INFINITY,
                torque_speed: None,
            });
        }
        let mut model = Model::new(&scene.name, joints, robot.frames.clone())?;
        model.gravity = scene.gravity;
        Ok(Self {
            n_robot_joints: robot.joints.len(),
            robot_nq: robot.nq,
            robot_nv: robot.nv,
            robot_mass: robot.total_mass(),
            robot: robot.clone(),
            model,
        })
    }

    /// The joint that carries an object.
    pub fn object_joint(&self, object: usize) -> usize {
        self.n_robot_joints + object
    }

    /// First index of an object in v.
    pub fn object_v(&self, object: usize) -> usize {
        self.model.joints[self.object_joint(object)].idx_v
    }

    /// First index of an object in q.
    pub fn object_q(&self, object: usize) -> usize {
        self.model.joints[self.object_joint(object)].idx_q
    }

    /// The parts of v whose equations of motion are alike in what they depend on: the robot's, then each object's.
    pub fn motion_blocks(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        let robot = 0..self.robot_nv;
        let objects = (self.robot_nv..self.model.nv).step_by(6);
        std::iter::once(robot).chain(objects.map(|first| first..first + 6))
    }

    /// Where an interface sits.
    pub fn carrier(&self, owner: Owner, body_from_interface: &Pose) -> Carrier {
        match owner {
            Owner::Robot { frame } => {
                let frame = &self.model.frames[frame];
                let body_from_frame = frame.joint_from_frame * *body_from_interface;
                Carrier {
                    body: frame.joint.map_or(Body::World, Body::Joint),
                    body_from_frame,
                }
            }
            Owner::Object(o) => Carrier {
                body: Body::Joint(self.object_joint(o)),
                body_from_frame: *body_from_interface,
            },
            Owner::Static(_) => Carrier {
                body: Body::World,
                body_from_frame: *body_from_interface,
            },
        }
    }

    /// Pose of an interface in the world.
    pub fn world_from_interface(&self, interface: &Interface, kinematics: &Kinematics) -> Pose {
        let carrier = self.carrier(interface.owner, &interface.body_from_interface);
        match carrier.body {
            Body::World => carrier.body_from_frame,
            Body::Joint(joint) => kinematics.world_from_joint[joint] * carrier.body_from_frame,
        }
    }

    /// Full start configuration: the robot's, then the objects'.
    pub fn start(&self, scene: &Scene) -> Vec<f64> {
        let mut q = scene.start.clone();
        for object in &scene.objects {
            q.extend(object.world_from_start.to_xyzquat());
        }
        q
    }

    /// Axes of the base whose z points up where the robot stands on its feet in the home posture: the base's own, unless those are far
    /// from it.
    pub fn base_from_upright(&self, scene: &Scene) -> Pose {
        let mut q = self.start(scene);
        let first = self.model.joints[0].kind.nq();
        q[..first].copy_from_slice(&Pose::identity().to_xyzquat()[..first]);
        q[first..first + scene.robot.home.len()].copy_from_slice(&scene.robot.home);
        let mut kinematics = Kinematics::new(&self.model);
        kinematics.update(&self.model, &q);
        let soles = scene.interfaces.iter().filter(|i| i.role == Role::Foot);
        let down = |sole: &Interface| {
            let base_from_sole = self.world_from_interface(sole, &kinematics);
            base_from_sole.rotate(Vector3::z())
        };
        let up: Vector3<f64> = soles.map(|sole| -down(sole)).sum();
        let Some(up) = up.try_normalize(1e-3).filter(|up| up.z < UPRIGHT) else {
            return Pose::identity();
        };
        Pose::from_parts(turn_onto(&Vector3::z(), &up), Vector3::zeros())
    }

    /// First velocity index of each floating body.
    pub fn floating(&self) -> Vec<usize> {
        self.model
            .joints
            .iter()
            .filter(|j| j.kind == JointKind::FreeFlyer)
            .map(|j| j.idx_v)
            .collect()
    }

    /// Robot joints with one degree of freedom, in the order of the model.
    pub fn actuated(&self) -> impl Iterator<Item = &Joint> {
        self.model.joints[..self.n_robot_joints]
            .iter()
            .filter(|j| j.kind != JointKind::FreeFlyer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn a_base_that_is_built_on_its_side_is_upright_where_its_feet_are_below_it() {
        let g1 = Scene::builtin("side-step").unwrap();
        let system = System::new(&g1).unwrap();
        assert_eq!(system.base_from_upright(&g1), Pose::identity());
        // The same robot with a base whose y axis points up.
        let own_from_other = Pose::exp(&nalgebra::Vector6::new(0.0, 0.0, 0.0, -PI / 2.0, 0.0, 0.0));
        let mut other = g1.clone();
        for joint in &mut other.robot.model.joints {
            if joint.parent == Some(0) {
                joint.parent_from_joint = own_from_other * joint.parent_from_joint;
            }
        }
        let system = System::new(&other).unwrap();
        let up = system.base_from_upright(&other).rotate(Vector3::z());
        assert!(
            (up - own_from_other.rotate(Vector3::z())).norm() < 0.05,
            "{up}"
        );
        assert!(up.z.abs() < 0.05 && up.y.abs() > 0.9, "{up}");
    }
}
