//! The plan's motion, evaluated once at every node: what all categories are measured on.

use nalgebra::Vector3;
use plan::{ContactType, InterfaceKind, Plan, Row6};
use spatial::Pose;

use crate::kinematics::{self, FrameMotion};
use crate::report::Location;
use crate::robot::Robot;

/// Who carries an interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Owner {
    /// A link of the robot, by index.
    Link(usize),
    /// An object, by index.
    Object(usize),
    /// A static body, by index.
    Static(usize),
}

/// An interface of the plan, resolved.
#[derive(Debug)]
pub(crate) struct Interface<'a> {
    pub name: &'a str,
    pub owner: Owner,
    pub body_from_interface: Pose,
    pub kind: InterfaceKind,
    /// Half extents along x and y [m]; infinite: unbounded.
    pub half: [f64; 2],
    /// Unit direction from the contact into the limb, own axes.
    pub limb: Vector3<f64>,
}

impl Interface<'_> {
    /// True if the extent is finite in both directions.
    pub fn is_bounded(&self) -> bool {
        self.half.iter().all(|x| x.is_finite())
    }
}

/// A contact of a phase, resolved.
#[derive(Debug)]
pub(crate) struct Contact<'a> {
    /// `a/b`
    pub name: String,
    /// Indices into the interfaces.
    pub a: usize,
    pub b: usize,
    pub kind: ContactType,
    pub mu: f64,
    pub mu_r: f64,
    pub overhang: bool,
    /// First node of the uninterrupted run of phases with this pair.
    pub since: usize,
    /// True if the phase before (if any) does not list this pair.
    pub is_new: bool,
    pub wrench: &'a [Row6],
}

/// A phase, resolved: nodes `start..=end`, intervals `start..end`.
#[derive(Debug)]
pub(crate) struct Phase<'a> {
    pub start: usize,
    pub end: usize,
    pub contacts: Vec<Contact<'a>>,
}

/// The plan's motion at every node.
#[derive(Debug)]
pub(crate) struct Motion<'a> {
    pub plan: &'a Plan,
    pub robot: Robot,
    pub interfaces: Vec<Interface<'a>>,
    pub phases: Vec<Phase<'a>>,
    /// Phase of each interval.
    pub phase_of: Vec<usize>,
    /// Length of each interval [s].
    pub dt: Vec<f64>,
    /// `[node][link]`; accelerations are zero at the last node, which has none.
    pub links: Vec<Vec<FrameMotion>>,
    /// `[node][object]`; accelerations likewise.
    pub objects: Vec<Vec<FrameMotion>>,
    /// `[node][interface]`: world pose, velocity of the origin and angular velocity.
    pub frames: Vec<Vec<FrameMotion>>,
}

impl<'a> Motion<'a> {
    /// Evaluates a plan without structural faults.
    pub fn new(plan: &'a Plan, robot: Robot, interfaces: Vec<Interface<'a>>) -> Self {
        let phases = phases(plan, &interfaces);
        let phase_of: Vec<_> = (0..phases.len())
            .flat_map(|k| vec![k; phases[k].end - phases[k].start])
            .collect();
        let dt = phase_of
            .iter()
            .map(|k| plan.phases[*k].duration / plan.phases[*k].steps as f64)
            .collect();
        let at_rest = vec![0.0; 6 + plan.n_joints()];
        let nodes = 0..plan.time.len();
        let acceleration = |t: usize| plan.a.get(t).unwrap_or(&at_rest);
        let links: Vec<_> = nodes
            .clone()
            .map(|t| kinematics::links(&robot, &plan.q[t], &plan.v[t], acceleration(t)))
            .collect();
        let objects: Vec<_> = nodes.clone().map(|t| objects_at(plan, t)).collect();
        let frames = nodes
            .map(|t| {
                interfaces
                    .iter()
                    .map(|i| frame_of(i, &links[t], &objects[t]))
                    .collect()
            })
            .collect();
        Self {
            plan,
            robot,
            interfaces,
            phases,
            phase_of,
            dt,
            links,
            objects,
            frames,
        }
    }

    /// Number of intervals.
    pub fn n_intervals(&self) -> usize {
        self.dt.len()
    }

    /// Number of nodes.
    pub fn n_nodes(&self) -> usize {
        self.dt.len() + 1
    }

    /// A place in the plan: node `t` (or the interval it begins) and what is there.
    pub fn place(&self, t: usize, what: impl Into<String>) -> Location {
        let phase = self.phase_of.get(t).or(self.phase_of.last()).copied();
        Location {
            what: what.into(),
            phase,
            node: Some(t),
            share: None,
            time: self.plan.time.get(t).copied(),
        }
    }

    /// All contacts with the phase they belong to.
    pub fn contacts(&self) -> impl Iterator<Item = (&Phase<'a>, &Contact<'a>)> {
        self.phases
            .iter()
            .flat_map(|phase| phase.contacts.iter().map(move |contact| (phase, contact)))
    }

    /// Contacts of interval `t` with their wrenches on `a`: force and moment about the origin of `a`, world axes.
    pub fn loads(
        &self,
        t: usize,
    ) -> impl Iterator<Item = (&Contact<'a>, Vector3<f64>, Vector3<f64>)> {
        let phase = &self.phases[self.phase_of[t]];
        phase.contacts.iter().map(move |contact| {
            let [fx, fy, fz, mx, my, mz] = contact.wrench[t - phase.start];
            (contact, Vector3::new(fx, fy, fz), Vector3::new(mx, my, mz))
        })
    }

    /// Pose of `a` relative to `b` at node `t`.
    pub fn b_from_a(&self, contact: &Contact, t: usize) -> Pose {
        let [world_from_a, world_from_b] =
            [contact.a, contact.b].map(|i| self.frames[t][i].world_from_frame);
        world_from_b.inverse() * world_from_a
    }

    /// Gravity [m/s²].
    pub fn gravity(&self) -> Vector3<f64> {
        Vector3::from(self.plan.gravity)
    }
}

fn phases<'a>(plan: &'a Plan, interfaces: &[Interface<'a>]) -> Vec<Phase<'a>> {
    let index = |name: &str| interfaces.iter().position(|i| i.name == name);
    let starts = plan.phase_starts();
    let mut phases: Vec<Phase> = Vec::new();
    for (k, phase) in plan.phases.iter().enumerate() {
        let before = phases.last();
        // Names are resolved: the plan has no structural fault.
        let resolved = phase
            .contacts
            .iter()
            .filter_map(|c| Some((c, index(&c.a)?, index(&c.b)?)));
        let contacts = resolved
            .map(|(c, a, b)| {
                let earlier = before.and_then(|p| p.contacts.iter().find(|x| (x.a, x.b) == (a, b)));
                Contact {
                    name: format!("{}/{}", c.a, c.b),
                    a,
                    b,
                    kind: c.kind,
                    mu: c.mu,
                    mu_r: c.mu_r,
                    overhang: c.overhang,
                    since: earlier.map_or(starts[k], |x| x.since),
                    is_new: k > 0 && earlier.is_none(),
                    wrench: &c.wrench,
                }
            })
            .collect();
        phases.push(Phase {
            start: starts[k],
            end: starts[k + 1],
            contacts,
        });
    }
    phases
}

fn objects_at(plan: &Plan, t: usize) -> Vec<FrameMotion> {
    let motion = |object: &plan::Object| {
        let states = &plan.object_states[&object.name];
        let accel = states.accel.get(t).copied().unwrap_or_default();
        FrameMotion::of_body(
            Pose::from_xyzquat(&states.pose[t]),
            &states.twist[t],
            &accel,
        )
    };
    plan.objects.iter().map(motion).collect()
}

fn frame_of(interface: &Interface, links: &[FrameMotion], objects: &[FrameMotion]) -> FrameMotion {
    let body = match interface.owner {
        Owner::Link(i) => links[i],
        Owner::Object(i) => objects[i],
        Owner::Static(_) => return FrameMotion::at_rest(interface.body_from_interface),
    };
    let world_from_frame = body.world_from_frame * interface.body_from_interface;
    let origin = world_from_frame.origin();
    FrameMotion {
        world_from_frame,
        velocity: body.velocity_at(&origin),
        acceleration: body.acceleration_at(&origin),
        ..body
    }
}
