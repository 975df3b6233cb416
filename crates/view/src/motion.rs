//! The plan's motion as poses: robot joints, objects and interfaces in the world at every node.

use crate::ViewError;
use multibody::{CenterOfMass, JointOrder, Kinematics, Model, Root};
use nalgebra::Vector3;
use plan::{Interface, Plan};
use spatial::Pose;
use std::collections::BTreeMap;

/// Who carries an interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Carrier {
    /// A link of the robot: index into the model's frames.
    Frame(usize),
    /// Index into the plan's objects.
    Object(usize),
    /// Index into the plan's static bodies.
    Static(usize),
}

/// A plan with the poses at all its nodes.
pub(crate) struct Motion<'a> {
    /// The plan.
    pub plan: &'a Plan,
    /// The robot.
    pub model: Model,
    /// Where the plan's rows have the joints of the model.
    pub order: JointOrder,
    /// Per interface its carrier.
    pub carriers: Vec<Carrier>,
    /// Index of an interface by name.
    pub interfaces: BTreeMap<&'a str, usize>,
    /// `[node]`
    nodes: Vec<Kinematics>,
    /// Centre of mass of the robot in the world [m], per node.
    pub com: Vec<Vector3<f64>>,
}

/// Poses at one time.
pub(crate) struct Moment {
    /// The robot.
    pub robot: Kinematics,
    /// Objects in the world.
    pub objects: Vec<Pose>,
}

impl<'a> Motion<'a> {
    /// Evaluates the plan called `name`.
    pub fn new(plan: &'a Plan, name: &str) -> Result<Self, ViewError> {
        let named = || name.to_owned();
        plan.validate().map_err(|source| ViewError::Plan {
            plan: named(),
            source,
        })?;
        let model = Model::from_urdf(&plan.robot.urdf, Root::Floating).map_err(|source| {
            ViewError::Robot {
                plan: named(),
                source,
            }
        })?;
        let order = JointOrder::new(&model, &plan.robot.joints);
        let order = order.map_err(|index| ViewError::UnknownJoint {
            plan: named(),
            index,
            joint: plan.robot.joints[index].clone(),
        })?;
        let carriers = carriers(plan, &model, name)?;
        let (nodes, com) = evaluate(plan, &model, &order);
        let interfaces = plan.interfaces.iter().enumerate();
        Ok(Self {
            plan,
            carriers,
            order,
            nodes,
            com,
            interfaces: interfaces.map(|(i, x)| (x.name.as_str(), i)).collect(),
            model,
        })
    }

    /// Robot and objects at a time [s], between nodes by interpolation.
    pub fn at(&self, time: f64) -> Moment {
        let times = &self.plan.time;
        let last = times.len() - 2;
        let t = times
            .partition_point(|x| *x <= time)
            .saturating_sub(1)
            .min(last);
        let share = ((time - times[t]) / (times[t + 1] - times[t])).clamp(0.0, 1.0);
        let [from, to] = [t, t + 1].map(|t| self.order.configuration(&self.model, &self.plan.q[t]));
        let way: Vec<_> = self
            .model
            .difference(&from, &to)
            .iter()
            .map(|x| x * share)
            .collect();
        let mut robot = Kinematics::new(&self.model);
        robot.update(&self.model, &self.model.integrate(&from, &way));
        let between = |object| {
            let [from, to] = [t, t + 1].map(|t| self.world_from_object(t, object));
            from.plus(&(to.minus(&from) * share))
        };
        Moment {
            robot,
            objects: (0..self.plan.objects.len()).map(between).collect(),
        }
    }

    /// Number of nodes.
    pub fn n_nodes(&self) -> usize {
        self.nodes.len()
    }

    /// Pose of a link in the world at a node.
    pub fn world_from_frame(&self, t: usize, frame: usize) -> Pose {
        self.nodes[t].frame_pose(&self.model, frame)
    }

    /// Pose of an object in the world at a node; objects without states stay at the origin.
    pub fn world_from_object(&self, t: usize, object: usize) -> Pose {
        let states = self.plan.object_states.get(&self.plan.objects[object].name);
        states.map_or_else(Pose::identity, |states| Pose::from_xyzquat(&states.pose[t]))
    }

    /// Pose of an interface in the world at a node.
    pub fn world_from_interface(&self, t: usize, index: usize) -> Pose {
        let world_from_body = match self.carriers[index] {
            Carrier::Frame(frame) => self.world_from_frame(t, frame),
            Carrier::Object(object) => self.world_from_object(t, object),
            Carrier::Static(_) => Pose::identity(),
        };
        world_from_body * Pose::from_xyzquat(&self.plan.interfaces[index].pose)
    }
}

fn carriers(plan: &Plan, model: &Model, name: &str) -> Result<Vec<Carrier>, ViewError> {
    let carrier = |index: usize, interface: &Interface| {
        let body = &interface.body;
        let object = plan.objects.iter().position(|x| x.name == *body);
        let fixed = || plan.environment.iter().position(|x| x.name == *body);
        object
            .map(Carrier::Object)
            .or_else(|| fixed().map(Carrier::Static))
            .or_else(|| model.frame_id(body).map(Carrier::Frame))
            .ok_or_else(|| ViewError::UnknownBody {
                plan: name.to_owned(),
                index,
                body: body.clone(),
            })
    };
    let interfaces = plan.interfaces.iter().enumerate();
    interfaces.map(|(i, x)| carrier(i, x)).collect()
}

fn evaluate(
    plan: &Plan,
    model: &Model,
    order: &JointOrder,
) -> (Vec<Kinematics>, Vec<Vector3<f64>>) {
    let mut center = CenterOfMass::new(model);
    let at = |row: &Vec<f64>| {
        let mut kinematics = Kinematics::new(model);
        kinematics.update(model, &order.configuration(model, row));
        let com = center.compute(model, &kinematics).0;
        (kinematics, com)
    };
    plan.q.iter().map(at).unzip()
}
