//! The nonlinear program of one contact sequence: which variables, terms and rows exist, and where.
//!
//! Nodes t = 0 … N carry configurations of the whole system (robot and objects), intervals t the wrenches of active
//! contacts, phases their durations. With explicit Euler and rest at both ends q₁ = q₀ and q_N = q_{N−1}
//! (formulation 2.16), so nodes 0 and 1 are fixed and the last two share their variables.
//!
//! One element of the solver per interval: wrenches λ_t, nodes A = t, B = t+1, C = t+2, durations of the phases of this
//! and the next interval. Terms of node t belong to element t.

use std::sync::Arc;

use crate::collision::{CollisionModel, ExtraClearance};
use crate::relative::{Body, Carrier, RelativeFrame};
use crate::settings::{Preset, Settings};
use crate::system::System;
use crate::terms::{
    ForceTerm, PoseTerm, alignment::Alignment, bounds::Bounds, friction::Friction, grasp::Grasp,
    half_space::HalfSpace, height::Height, place::Place, point_friction::PointFriction,
    pressure::Pressure, region::Region, slip_velocity, support_pressure::SupportPressure,
    tilt::Tilt, torsion::Torsion,
};
use multibody::JointKind;
use scene::{Owner, Role, Scene};
use solver::{BlockStructure, ElementStructure, Structure};
use spatial::Pose;
use symbolic::{Contact, ContactState, ContactType};

/// One phase of a contact sequence.
#[derive(Debug, Clone, PartialEq)]
pub struct Phase {
    /// Its contacts.
    pub state: ContactState,
    /// Its number of intervals N_k.
    pub steps: usize,
}

/// What the nodes stand for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Grid {
    /// A trajectory with dynamics: N_k intervals per phase.
    Motion,
    /// One configuration per phase boundary, geometry only.
    Keyframes,
    /// The same without the goal regions, for the beginning of a sequence.
    OpenKeyframes,
}

impl Grid {
    /// True for one configuration per phase boundary.
    pub fn is_keyframes(self) -> bool {
        self != Self::Motion
    }
}

/// Where a row comes from, for reports.
#[derive(Debug, Clone, PartialEq)]
pub struct RowLabel {
    /// Category, as the checker names it.
    pub category: &'static str,
    /// Contact, joint or pair, by index into what the category speaks of.
    pub subject: Subject,
    /// SI value = row value · scale.
    pub scale: f64,
    /// Unit of the SI value.
    pub unit: &'static str,
}

/// What a row speaks of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Subject {
    /// Velocity index of the system.
    Coordinate(usize),
    /// A contact.
    Contact(Contact),
    /// Two bodies, as indices of joints; the second one is the world if `None`.
    Pair(usize, Option<usize>),
    /// The goal.
    Goal,
}

/// Rows of a pose term at a node.
#[derive(Debug, Clone)]
pub struct NodeTerm {
    /// Position in [`Node::frames`].
    pub slot: usize,
    /// The term.
    pub term: Arc<dyn PoseTerm>,
    /// First row within the element.
    pub first_row: usize,
    /// Number of rows.
    pub n_rows: usize,
    /// Block within the element.
    pub block: usize,
}

/// A cost that is a pose term (summed over its rows).
#[derive(Debug, Clone)]
pub struct NodeCost {
    /// Position in [`Node::frames`].
    pub slot: usize,
    /// The term.
    pub term: Arc<dyn PoseTerm>,
    /// Weight per row.
    pub weights: Vec<f64>,
}

/// One node.
#[derive(Debug, Clone, Default)]
pub struct Node {
    /// First variable of its increments; `None` for a fixed node.
    pub var: Option<usize>,
    /// Relative frames evaluated here, indices into [`Program::frames`].
    pub frames: Vec<usize>,
    /// Rows.
    pub terms: Vec<NodeTerm>,
    /// Costs.
    pub costs: Vec<NodeCost>,
    /// Weight of the posture cost.
    pub posture: f64,
}

impl Node {
    fn slot(&mut self, frame: usize) -> usize {
        self.frames
            .iter()
            .position(|&f| f == frame)
            .unwrap_or_else(|| {
                self.frames.push(frame);
                self.frames.len() - 1
            })
    }
}

/// Sticking of one contact over one interval.
#[derive(Debug, Clone)]
pub struct Stick {
    /// Position in the frames of node t.
    pub slot_a: usize,
    /// Position in the frames of node t+1.
    pub slot_b: usize,
    /// What stays.
    pub place: Arc<Place>,
    /// First row within the element.
    pub first_row: usize,
    /// Block within the element.
    pub block: usize,
}

/// Sticking of one contact at velocity level, at the node whose velocity an interval uses.
#[derive(Debug, Clone)]
pub struct Slip {
    /// Position in the frames of node t.
    pub slot: usize,
    /// True for patches, whose yaw rate is zero too.
    pub yaw: bool,
    /// First row within the element.
    pub first_row: usize,
    /// Block within the element: increments of nodes t and t+1, then the duration.
    pub block: usize,
}

/// How a contact acts on the robot's momentum.
#[derive(Debug, Clone, Copy)]
pub struct OnRobot {
    /// Relative frame of interface a in the world.
    pub frame: usize,
    /// Its position in the frames of node t.
    pub slot: usize,
    /// 1 where the robot carries a, −1 where it carries b.
    pub sign: f64,
}

/// Rows of a contact's wrench.
#[derive(Debug, Clone)]
pub struct ForceRows {
    /// The term.
    pub term: Arc<dyn ForceTerm>,
    /// First row within the element.
    pub first_row: usize,
    /// Number of rows.
    pub n_rows: usize,
    /// Block within the element.
    pub block: usize,
}

/// The wrench of one contact in one interval.
#[derive(Debug, Clone)]
pub struct Force {
    /// The contact.
    pub contact: Contact,
    /// Position in the frames of node t.
    pub slot: usize,
    /// Relative frame.
    pub frame: usize,
    /// First local variable within the element (= offset within the interval's wrenches).
    pub first: usize,
    /// 6 for patches, 3 for points.
    pub n: usize,
    /// Force and moment that count as one.
    pub scale: [f64; 6],
    /// Scaled wrench that costs nothing.
    pub reference: [f64; 6],
    /// Its part in the robot's momentum rows.
    pub on_robot: Option<OnRobot>,
    /// Rows.
    pub rows: Vec<ForceRows>,
}

/// One interval and the layout of its element.
#[derive(Debug, Clone, Default)]
pub struct Interval {
    /// Its phase.
    pub phase: usize,
    /// Number of wrench variables.
    pub n_wrench: usize,
    /// First wrench variable, global.
    pub wrench_var: usize,
    /// Local offset of node t.
    pub a: Option<usize>,
    /// Local offset of node t+1, where it counts.
    pub b: Option<usize>,
    /// Local offset of node t+2, where it counts.
    pub c: Option<usize>,
    /// Is v_t free (not rest).
    pub v: bool,
    /// Is v_{t+1} free.
    pub v_next: bool,
    /// Local offset of the duration of this phase.
    pub time: Option<usize>,
    /// Local offset of the duration of the next interval's phase.
    pub time_next: Option<usize>,
    /// Does the element carry the equations of motion (first rows, first block).
    pub dynamics: bool,
    /// First row of the velocity limits; one row and block per actuated joint.
    pub velocity_rows: Option<usize>,
    /// First block of the velocity limits.
    pub velocity_block: usize,
    /// Contacts that stick by displacement.
    pub sticks: Vec<Stick>,
    /// Contacts that stick by velocity.
    pub slips: Vec<Slip>,
    /// Wrenches.
    pub forces: Vec<Force>,
}

/// The whole program.
#[derive(Debug, Clone)]
pub struct Program {
    /// The multibody system.
    pub system: System,
    /// Options.
    pub settings: Settings,
    /// Motion or keyframes.
    pub grid: Grid,
    /// Steps per phase (1 for keyframes).
    pub steps: Vec<usize>,
    /// All relative frames.
    pub frames: Vec<RelativeFrame>,
    /// Nodes 0 … N.
    pub nodes: Vec<Node>,
    /// Intervals 0 … N−1.
    pub intervals: Vec<Interval>,
    /// First duration variable.
    pub duration_var: usize,
    /// Posture that costs nothing, per velocity index (0 for floating bodies).
    pub home: Vec<f64>,
    /// Velocity and acceleration weights per velocity index.
    pub motion_weights: Vec<(f64, f64)>,
    /// Scale of each row of the equations of motion.
    pub dynamics_scale: Vec<f64>,
    /// True if the first six rows of the equations of motion are the robot's momentum ([`crate::momentum`]).
    pub momentum: bool,
    /// For the solver.
    pub structure: Structure,
    /// One label per row of all elements.
    pub labels: Vec<RowLabel>,
}

/// Time for which a force that counts as one makes a momentum that counts as one [s]: a typical interval.
const MOMENTUM_STEP: f64 = 0.1;

/// Builds the program step by step.
struct Builder<'a> {
    scene: &'a Scene,
    program: Program,
    keys: Vec<(usize, usize)>,
    labels: Vec<Vec<RowLabel>>,
}

impl Program {
    /// The program of a contact sequence; node configurations `near` (one per node) choose which collision pairs are
    /// worth a row; `extra` raises clearances.
    #[allow(clippy::too_many_arguments)] // the parts of a problem; one caller in this crate
    pub fn new(
        scene: &Scene,
        system: &System,
        collisions: &CollisionModel,
        phases: &[Phase],
        settings: &Settings,
        grid: Grid,
        near: &[Vec<f64>],
        extra: &ExtraClearance,
    ) -> Self {
        let steps: Vec<usize> = phases
            .iter()
            .map(|p| if grid == Grid::Motion { p.steps } else { 1 })
            .collect();
        let n = steps.iter().sum::<usize>();
        let nv = system.model.nv;
        let mut builder = Builder {
            scene,
            program: Program {
                system: system.clone(),
                settings: settings.clone(),
                grid,
                frames: vec![],
                nodes: vec![Node::default(); n + 1],
                intervals: vec![Interval::default(); n],
                duration_var: 0,
                home: vec![0.0; nv],
                motion_weights: vec![(0.0, 0.0); nv],
                dynamics_scale: vec![1.0; nv],
                momentum: settings.preset == Preset::Paper
                    && system
                        .robot
                        .joints
                        .first()
                        .is_some_and(|j| j.kind == JointKind::FreeFlyer),
                structure: Structure::default(),
                labels: vec![],
                steps,
            },
            keys: vec![],
            labels: vec![vec![]; n],
        };
        builder.scales();
        builder.variables();
        builder.costs();
        for t in 0..n {
            builder.equations_of_motion(t);
            builder.velocity_limits(t);
            builder.contact_geometry(t, phases);
            builder.forces(t, phases);
        }
        builder.goal();
        builder.collisions(collisions, phases, near, extra);
        builder.program.labels = builder.labels.into_iter().flatten().collect();
        builder.program
    }

    /// Phase of an interval.
    pub fn phase_of(&self, t: usize) -> usize {
        self.intervals[t].phase
    }

    /// Number of intervals.
    pub fn n_intervals(&self) -> usize {
        self.intervals.len()
    }

    /// Node whose configuration node `t` has (the last node rests where its predecessor is).
    pub fn master_node(&self, t: usize) -> usize {
        if self.grid == Grid::Motion && t == self.n_intervals() {
            t - 1
        } else {
            t
        }
    }
}

/// True if `contact` binds the geometry of interval `t`: it is active there, or was released at node t
/// (formulation 2.19: at rest at the release too).
fn binds(phases: &[Phase], program: &Program, contact: Contact, t: usize) -> bool {
    let active = |t: usize| {
        phases[program.phase_of(t)]
            .state
            .contacts
            .contains(&contact)
    };
    active(t) || (program.grid == Grid::Motion && t > 0 && active(t - 1))
}

impl Builder<'_> {
    fn scales(&mut self) {
        let p = &mut self.program;
        let (system, weights) = (&p.system, &p.settings.weights);
        let g = self.scene.gravity.norm();
        let weight = system.robot_mass * g.max(1.0);
        let impulse = if p.momentum { MOMENTUM_STEP } else { 1.0 };
        for (j, joint) in system.model.joints.iter().enumerate() {
            let object = j >= system.n_robot_joints;
            let i = joint.idx_v;
            if joint.kind == JointKind::FreeFlyer {
                let (force, arm) = if object {
                    ((joint.inertia.mass * g).max(1.0), 0.1)
                } else {
                    (weight / 3.0 * impulse, 0.3)
                };
                for k in 0..6 {
                    p.dynamics_scale[i + k] = if k < 3 { force } else { force * arm };
                    p.motion_weights[i + k] = if object {
                        (weights.object_velocity, weights.object_acceleration)
                    } else {
                        (weights.velocity, weights.acceleration)
                    };
                }
            } else {
                p.dynamics_scale[i] = if joint.torque_limit.is_finite() {
                    joint.torque_limit.max(1e-3)
                } else {
                    50.0
                };
                p.motion_weights[i] = (weights.velocity, weights.acceleration);
                p.home[i] = self.scene.robot.home[i - system.model.joints[0].kind.nv()];
            }
        }
    }

    /// Variables: node increments, wrenches, durations; and the layout of every element.
    fn variables(&mut self) {
        let p = &mut self.program;
        let (n, nv) = (p.intervals.len(), p.system.model.nv);
        let motion = p.grid == Grid::Motion;
        let mut phase_of = Vec::new();
        for (k, &steps) in p.steps.iter().enumerate() {
            phase_of.extend(std::iter::repeat_n(k, steps));
        }
        let s = &mut p.structure;
        let first_free = if motion { 2 } else { 1 };
        let last_free = if motion { n - 1 } else { n };
        for t in first_free..=last_free {
            p.nodes[t].var = Some(s.n_vars);
            for joint in &p.system.model.joints {
                let margin = p
                    .settings
                    .margins
                    .joint_range
                    .min(0.1 * (joint.upper - joint.lower));
                let bounded = joint.kind != JointKind::FreeFlyer;
                for _ in 0..joint.kind.nv() {
                    s.lower.push(if bounded {
                        joint.lower + margin
                    } else {
                        f64::NEG_INFINITY
                    });
                    s.upper.push(if bounded {
                        joint.upper - margin
                    } else {
                        f64::INFINITY
                    });
                }
            }
            s.n_vars += nv;
        }
        if motion {
            p.nodes[n].var = p.nodes[n - 1].var;
        }
        for t in 0..n {
            let i = &mut p.intervals[t];
            i.phase = phase_of[t];
            i.dynamics = motion;
            (i.v, i.v_next) = if motion {
                (t > 0 && t < n - 1, t + 2 < n)
            } else {
                (true, false)
            };
        }
        s.elements = vec![ElementStructure::default(); n];
    }

    fn costs(&mut self) {
        let p = &mut self.program;
        let w = p.settings.weights.clone();
        let world = Carrier {
            body: Body::World,
            body_from_frame: Pose::identity(),
        };
        let base = Carrier {
            body: Body::Joint(0),
            body_from_frame: Pose::identity(),
        };
        p.frames
            .push(RelativeFrame::new(&p.system.model, base, world));
        self.keys.push((usize::MAX, usize::MAX));
        let last = p
            .nodes
            .iter()
            .rposition(|n| n.var.is_some())
            .map(|t| p.master_node(t));
        for t in 0..p.nodes.len() {
            if p.nodes[t].var.is_none() || p.master_node(t) != t {
                continue;
            }
            let is_last = last == Some(t);
            p.nodes[t].posture = if is_last { w.final_posture } else { w.posture };
            let slot = p.nodes[t].slot(0);
            p.nodes[t].costs.push(NodeCost {
                slot,
                term: Arc::new(Tilt),
                weights: vec![w.tilt],
            });
            if is_last && self.scene.objective == scene::Objective::BaseHeight {
                p.nodes[t].costs.push(NodeCost {
                    slot,
                    term: Arc::new(Height),
                    weights: vec![-w.height],
                });
            }
        }
    }

    /// Rows of M a + b − Σ Jᵀλ: base and objects zero, joints within the torque limits; with `momentum` the base's six are
    /// those of the robot's momentum. The first block of the element.
    fn equations_of_motion(&mut self, t: usize) {
        if !self.program.intervals[t].dynamics {
            return;
        }
        let p = &mut self.program;
        let share = p.settings.margins.torque;
        for joint in &p.system.model.joints {
            let free = joint.kind == JointKind::FreeFlyer;
            for k in 0..joint.kind.nv() {
                let i = joint.idx_v + k;
                let bound = if free {
                    0.0
                } else if p.settings.torque_limits && joint.torque_limit.is_finite() {
                    share
                } else {
                    f64::INFINITY
                };
                let element = &mut p.structure.elements[t];
                element.row_lower.push(-bound);
                element.row_upper.push(bound);
                let (category, unit) = match (free, p.momentum && i < 6, k < 3) {
                    (false, ..) => ("torque limit", "N m"),
                    (true, true, true) => ("momentum", "N s"),
                    (true, true, false) => ("momentum", "N m s"),
                    (true, false, true) => ("equations of motion", "N"),
                    (true, false, false) => ("equations of motion", "N m"),
                };
                let label = label(category, Subject::Coordinate(i), p.dynamics_scale[i], unit);
                self.labels[t].push(label);
            }
        }
        p.structure.elements[t].blocks.push(BlockStructure {
            first_row: 0,
            n_rows: p.system.model.nv,
            cols: vec![],
        });
    }

    fn velocity_limits(&mut self, t: usize) {
        let p = &mut self.program;
        if !p.intervals[t].dynamics || !p.intervals[t].v {
            return;
        }
        let share = p.settings.margins.velocity;
        let element = &mut p.structure.elements[t];
        p.intervals[t].velocity_rows = Some(element.n_rows());
        p.intervals[t].velocity_block = element.blocks.len();
        for joint in p.system.actuated() {
            let limit = if joint.velocity_limit.is_finite() {
                share
            } else {
                f64::INFINITY
            };
            let first_row = element.n_rows();
            element.row_lower.push(-limit);
            element.row_upper.push(limit);
            element.blocks.push(BlockStructure {
                first_row,
                n_rows: 1,
                cols: vec![],
            });
            self.labels[t].push(RowLabel {
                category: "joint velocity",
                subject: Subject::Coordinate(joint.idx_v),
                scale: joint.velocity_limit.min(1e3),
                unit: "rad/s",
            });
        }
    }

    /// Index of the relative frame of a contact's two interfaces.
    fn contact_frame(&mut self, contact: Contact) -> usize {
        let key = (contact.a.0, contact.b.0);
        if let Some(i) = self.keys.iter().position(|k| *k == key) {
            return i;
        }
        let carrier = |i: usize| {
            let interface = &self.scene.interfaces[i];
            self.program
                .system
                .carrier(interface.owner, &interface.body_from_interface)
        };
        let frame = RelativeFrame::new(&self.program.system.model, carrier(key.0), carrier(key.1));
        self.keys.push(key);
        self.program.frames.push(frame);
        self.keys.len() - 1
    }

    /// Contact rows of node t and sticking rows of interval t.
    fn contact_geometry(&mut self, t: usize, phases: &[Phase]) {
        let p = &self.program;
        let mut all: Vec<Contact> = Vec::new();
        for k in 0..phases.len() {
            all.extend(
                phases[k]
                    .state
                    .contacts
                    .iter()
                    .filter(|c| !all.contains(c))
                    .copied()
                    .collect::<Vec<_>>(),
            );
        }
        let n = p.n_intervals();
        let keyframes = p.grid.is_keyframes();
        for contact in all {
            let here = binds(phases, &self.program, contact, t);
            let before = t > 0 && binds(phases, &self.program, contact, t - 1);
            let frame = self.contact_frame(contact);
            if (here || before) && self.program.nodes[t].var.is_some() {
                self.contact_rows(t, t, contact, frame);
            }
            // The last keyframe has no element of its own; its rows sit in the last one.
            if keyframes && t + 1 == n && here {
                self.contact_rows(t, t + 1, contact, frame);
            }
            let by_velocity = !keyframes && self.program.settings.preset == Preset::Paper;
            let p = &mut self.program;
            if here && p.nodes[t + 1].var.is_some() && (keyframes || p.intervals[t].v) {
                if by_velocity {
                    self.slip_rows(t, contact, frame);
                    continue;
                }
                let slot_a = p.nodes[t].slot(frame);
                let slot_b = p.nodes[t + 1].slot(frame);
                let place = Arc::new(Place {
                    yaw: contact.kind.is_patch(),
                });
                let element = &mut p.structure.elements[t];
                let (first_row, block) = (element.n_rows(), element.blocks.len());
                for _ in 0..place.n_rows() {
                    element.row_lower.push(0.0);
                    element.row_upper.push(0.0);
                    self.labels[t].push(label("contact slip", Subject::Contact(contact), 1.0, "m"));
                }
                element.blocks.push(BlockStructure {
                    first_row,
                    n_rows: place.n_rows(),
                    cols: vec![],
                });
                p.intervals[t].sticks.push(Stick {
                    slot_a,
                    slot_b,
                    place,
                    first_row,
                    block,
                });
            }
        }
    }

    /// Tangential velocity and yaw rate at node t are zero.
    fn slip_rows(&mut self, t: usize, contact: Contact, frame: usize) {
        let p = &mut self.program;
        let slot = p.nodes[t].slot(frame);
        let yaw = contact.kind.is_patch();
        let n_rows = slip_velocity::n_rows(yaw);
        let element = &mut p.structure.elements[t];
        let (first_row, block) = (element.n_rows(), element.blocks.len());
        for r in 0..n_rows {
            element.row_lower.push(0.0);
            element.row_upper.push(0.0);
            let unit = if r < 2 { "m/s" } else { "rad/s" };
            self.labels[t].push(label("contact slip", Subject::Contact(contact), 1.0, unit));
        }
        element.blocks.push(BlockStructure {
            first_row,
            n_rows,
            cols: vec![],
        });
        p.intervals[t].slips.push(Slip {
            slot,
            yaw,
            first_row,
            block,
        });
    }

    /// The part of a contact in the robot's momentum; `None` if it acts on the robot not at all or at both ends.
    fn on_robot(&mut self, t: usize, contact: Contact) -> Option<OnRobot> {
        if !self.program.momentum {
            return None;
        }
        let carrier = |i: usize| {
            let interface = &self.scene.interfaces[i];
            self.program
                .system
                .carrier(interface.owner, &interface.body_from_interface)
        };
        let (a, b) = (carrier(contact.a.0), carrier(contact.b.0));
        let moves_robot = |carrier: &Carrier| match carrier.body {
            Body::Joint(j) => j < self.program.system.n_robot_joints,
            Body::World => false,
        };
        let sign = match (moves_robot(&a), moves_robot(&b)) {
            (true, false) => 1.0,
            (false, true) => -1.0,
            _ => return None,
        };
        let key = (contact.a.0, usize::MAX);
        let frame = self.keys.iter().position(|k| *k == key).unwrap_or_else(|| {
            let world = Carrier {
                body: Body::World,
                body_from_frame: Pose::identity(),
            };
            self.program
                .frames
                .push(RelativeFrame::new(&self.program.system.model, a, world));
            self.keys.push(key);
            self.keys.len() - 1
        });
        let slot = self.program.nodes[t].slot(frame);
        Some(OnRobot { frame, slot, sign })
    }

    fn contact_rows(&mut self, element: usize, node: usize, contact: Contact, frame: usize) {
        let (a, b) = (
            &self.scene.interfaces[contact.a.0],
            &self.scene.interfaces[contact.b.0],
        );
        let mut terms: Vec<Arc<dyn PoseTerm>> = vec![Arc::new(Height)];
        if contact.kind.is_patch() {
            terms.push(Arc::new(Alignment));
        } else {
            terms.push(Arc::new(HalfSpace { limb: a.limb }));
        }
        if let Some(half_b) = b.half_size {
            let margin = self.program.settings.margins.bounds;
            let half_a = if b.overhang || !contact.kind.is_patch() {
                [0.0; 2]
            } else {
                a.half_size.unwrap_or([0.0; 2])
            };
            let margin = |i: usize| margin.min(0.5 * (half_b[i] - half_a[i]).max(0.0));
            terms.push(Arc::new(Bounds {
                half_a,
                half_b: [half_b[0] - margin(0), half_b[1] - margin(1)],
            }));
        }
        for term in terms {
            let category = term.name();
            let unit = term.unit();
            self.node_term(
                element,
                node,
                frame,
                term,
                label(category, Subject::Contact(contact), 1.0, unit),
            );
        }
    }

    /// Adds rows of a pose term at a node to an element.
    #[allow(clippy::needless_pass_by_value)] // the label is made for this call
    fn node_term(
        &mut self,
        element: usize,
        node: usize,
        frame: usize,
        term: Arc<dyn PoseTerm>,
        label: RowLabel,
    ) {
        let p = &mut self.program;
        let bounds = term.bounds();
        let slot = p.nodes[node].slot(frame);
        let e = &mut p.structure.elements[element];
        let (first_row, block, n_rows) = (e.n_rows(), e.blocks.len(), bounds.len());
        for (l, u) in bounds {
            e.row_lower.push(l);
            e.row_upper.push(u);
            self.labels[element].push(label.clone());
        }
        e.blocks.push(BlockStructure {
            first_row,
            n_rows,
            cols: vec![],
        });
        p.nodes[node].terms.push(NodeTerm {
            slot,
            term,
            first_row,
            n_rows,
            block,
        });
    }

    #[allow(clippy::too_many_lines)] // one expression or layout, written down in its own order
    fn forces(&mut self, t: usize, phases: &[Phase]) {
        if !self.program.intervals[t].dynamics {
            return;
        }
        let phase = &phases[self.program.phase_of(t)];
        let feet = phase
            .state
            .contacts
            .iter()
            .filter(|c| self.scene.interfaces[c.a.0].role == Role::Foot)
            .count();
        for &contact in &phase.state.contacts {
            let frame = self.contact_frame(contact);
            let (a, b) = (
                &self.scene.interfaces[contact.a.0],
                &self.scene.interfaces[contact.b.0],
            );
            let g = self.scene.gravity.norm();
            let max_force = a.max_force.min(b.max_force);
            let (force, load) = match a.owner {
                Owner::Robot { .. } => {
                    let load = if a.role == Role::Foot {
                        self.program.system.robot_mass * g / feet as f64
                    } else {
                        0.0
                    };
                    (a.max_force / 6.0, load)
                }
                Owner::Object(o) => {
                    let weight = self.scene.objects[o].mass * g;
                    (weight.max(1.0), weight)
                }
                Owner::Static(_) => (10.0, 0.0),
            };
            let force = if force.is_finite() {
                force
            } else {
                self.program.system.robot_mass * g / 3.0
            };
            let moment = 0.1 * force;
            let margins = &self.program.settings.margins;
            let (mu, mu_r) = (
                a.mu.min(b.mu) * margins.friction,
                a.mu_r.min(b.mu_r) * margins.friction,
            );
            let epsilon = 0.01 * force;
            let mut terms: Vec<Arc<dyn ForceTerm>> = Vec::new();
            match contact.kind {
                ContactType::UnilateralPatch => {
                    terms.push(Arc::new(Friction {
                        mu,
                        epsilon,
                        scale: force,
                    }));
                    terms.push(Arc::new(Torsion::new(mu_r, moment)));
                    if let Some([x, y]) = a.half_size {
                        terms.push(Arc::new(Pressure::new(
                            [x * margins.pressure, y * margins.pressure],
                            moment,
                        )));
                    }
                    if let (true, Some([x, y])) = (b.overhang, b.half_size) {
                        let half_size = [x * margins.pressure, y * margins.pressure];
                        terms.push(Arc::new(SupportPressure {
                            half_size,
                            scale: moment,
                        }));
                    }
                }
                ContactType::BilateralPatch => {
                    terms.push(Arc::new(Grasp {
                        max_force,
                        max_moment: Some(a.max_moment.min(b.max_moment)),
                    }));
                }
                ContactType::UnilateralPoint => terms.push(Arc::new(PointFriction {
                    mu,
                    epsilon,
                    scale: force,
                })),
                ContactType::BilateralPoint => terms.push(Arc::new(Grasp {
                    max_force,
                    max_moment: None,
                })),
            }
            let on_robot = self.on_robot(t, contact);
            let p = &mut self.program;
            let interval = &mut p.intervals[t];
            let (first, n) = (
                interval.n_wrench,
                if contact.kind.is_patch() { 6 } else { 3 },
            );
            interval.n_wrench += n;
            if first == 0 {
                interval.wrench_var = p.structure.n_vars;
            }
            p.structure.n_vars += n;
            for i in 0..n {
                let normal = i == 2 && contact.kind == ContactType::UnilateralPatch;
                let limit = if max_force.is_finite() && i < 3 {
                    max_force / force
                } else {
                    f64::INFINITY
                };
                p.structure
                    .lower
                    .push(if i < 3 { -limit } else { f64::NEG_INFINITY });
                p.structure.upper.push(if normal {
                    0.0
                } else if i < 3 {
                    limit
                } else {
                    f64::INFINITY
                });
            }
            let slot = p.nodes[t].slot(frame);
            let element = &mut p.structure.elements[t];
            let mut rows = Vec::new();
            for term in terms {
                let bounds = term.bounds();
                let (first_row, block, n_rows) =
                    (element.n_rows(), element.blocks.len(), bounds.len());
                for (l, u) in bounds {
                    element.row_lower.push(l);
                    element.row_upper.push(u);
                    let (scale, unit) = if term.name() == "friction cone" {
                        (force, "N")
                    } else {
                        (moment, "N m")
                    };
                    self.labels[t].push(label(term.name(), Subject::Contact(contact), scale, unit));
                }
                element.blocks.push(BlockStructure {
                    first_row,
                    n_rows,
                    cols: vec![],
                });
                rows.push(ForceRows {
                    term,
                    first_row,
                    n_rows,
                    block,
                });
            }
            let mut scale = [force; 6];
            scale[3..].fill(moment);
            let reference = [0.0, 0.0, -load / force, 0.0, 0.0, 0.0];
            interval.forces.push(Force {
                contact,
                slot,
                frame,
                first,
                n,
                scale,
                reference,
                on_robot,
                rows,
            });
        }
    }

    fn goal(&mut self) {
        let n = self.program.n_intervals();
        let node = self.program.master_node(n);
        let element = node.min(n - 1);
        if self.program.grid == Grid::OpenKeyframes {
            return;
        }
        for region in &self.scene.goal_regions {
            let Some(body) = goal_body(self.scene, &self.program.system, &region.body) else {
                continue;
            };
            let world = Carrier {
                body: Body::World,
                body_from_frame: Pose::identity(),
            };
            let frame = self.program.frames.len();
            self.program
                .frames
                .push(RelativeFrame::new(&self.program.system.model, body, world));
            self.keys.push((usize::MAX, frame));
            let term = Arc::new(Region {
                lower: region.lower,
                upper: region.upper,
            });
            self.node_term(
                element,
                node,
                frame,
                term,
                label("goal region", Subject::Goal, 1.0, "m"),
            );
        }
    }

    fn collisions(
        &mut self,
        collisions: &CollisionModel,
        phases: &[Phase],
        near: &[Vec<f64>],
        extra: &ExtraClearance,
    ) {
        let n = self.program.n_intervals();
        let paper = self.program.settings.preset == Preset::Paper;
        let pairs = collisions.pairs(&self.program, self.scene, phases, near, extra);
        for pair in pairs {
            let key = (
                usize::MAX - 1 - pair.a,
                pair.b.map_or(usize::MAX, |b| usize::MAX - 1 - b),
            );
            let frame = self.keys.iter().position(|k| *k == key).unwrap_or_else(|| {
                self.program
                    .frames
                    .push(collisions.frame(&self.program.system, pair.a, pair.b));
                self.keys.push(key);
                self.keys.len() - 1
            });
            if paper {
                let slot = self.program.nodes[pair.node].slot(frame);
                let weights = vec![self.program.settings.weights.penalty];
                self.program.nodes[pair.node].costs.push(NodeCost {
                    slot,
                    term: pair.term,
                    weights,
                });
            } else {
                let label = label("clearance", Subject::Pair(pair.a, pair.b), 1.0, "m");
                self.node_term(pair.node.min(n - 1), pair.node, frame, pair.term, label);
            }
        }
        self.element_variables();
    }

    /// Lists the variables of every element and the columns of every block, now that all terms are known.
    #[allow(clippy::too_many_lines)] // one expression or layout, written down in its own order
    fn element_variables(&mut self) {
        let p = &mut self.program;
        let (n, nv) = (p.intervals.len(), p.system.model.nv);
        let motion = p.grid == Grid::Motion;
        p.duration_var = p.structure.n_vars;
        if motion {
            for _ in &p.steps {
                p.structure.n_vars += 1;
                p.structure.lower.push(p.settings.min_duration);
                p.structure.upper.push(p.settings.max_duration);
            }
        }
        for t in 0..n {
            let mut vars: Vec<usize> = Vec::new();
            let i = &mut p.intervals[t];
            vars.extend(i.wrench_var..i.wrench_var + i.n_wrench);
            let mut place = |var: Option<usize>, wanted: bool| -> Option<usize> {
                let first = var.filter(|_| wanted)?;
                if let Some(at) = vars.iter().position(|&v| v == first) {
                    return Some(at);
                }
                vars.extend(first..first + nv);
                Some(vars.len() - nv)
            };
            i.a = place(p.nodes[t].var, true);
            i.b = place(p.nodes[t + 1].var, i.v || i.v_next);
            i.c = if i.v_next {
                place(p.nodes[t + 2].var, true)
            } else {
                None
            };
            if motion && (i.v || i.v_next) {
                i.time = Some(vars.len());
                vars.push(p.duration_var + i.phase);
                if i.v_next {
                    let next = phase_of_next(&p.steps, i.phase, t);
                    i.time_next = if next == i.phase {
                        i.time
                    } else {
                        vars.push(p.duration_var + next);
                        Some(vars.len() - 1)
                    };
                }
            } else if motion {
                // The duration costs in every interval of its phase, so that it always has an element.
                i.time = Some(vars.len());
                vars.push(p.duration_var + i.phase);
            }
            let e = &mut p.structure.elements[t];
            e.vars = vars;
            if i.dynamics {
                e.blocks[0].cols = (0..e.vars.len()).collect();
            }
            if i.velocity_rows.is_some() {
                for (k, joint) in p.system.actuated().enumerate() {
                    let nodes = [i.a, i.b]
                        .into_iter()
                        .flatten()
                        .map(|first| first + joint.idx_v);
                    e.blocks[i.velocity_block + k].cols = nodes.chain(i.time).collect();
                }
            }
            let at =
                |first: usize, frame: usize| p.frames[frame].cols.iter().map(move |c| first + c);
            for stick in &i.sticks {
                let frame = p.nodes[t].frames[stick.slot_a];
                let cols = [i.a, i.b]
                    .into_iter()
                    .flatten()
                    .flat_map(|first| at(first, frame))
                    .collect();
                e.blocks[stick.block].cols = cols;
            }
            for slip in &i.slips {
                let frame = p.nodes[t].frames[slip.slot];
                let nodes = [i.a, i.b]
                    .into_iter()
                    .flatten()
                    .flat_map(|first| at(first, frame));
                e.blocks[slip.block].cols = nodes.chain(i.time).collect();
            }
            for force in &i.forces {
                for rows in &force.rows {
                    let mut cols: Vec<usize> = (force.first..force.first + force.n).collect();
                    if let (true, Some(first)) = (rows.term.uses_pose(), i.a) {
                        cols.extend(at(first, force.frame));
                    }
                    e.blocks[rows.block].cols = cols;
                }
            }
            for node in t..=(t + 1).min(n) {
                let Some(first) = (if node == t { i.a } else { i.b }) else {
                    continue;
                };
                if node == t + 1 && (motion || node != n) {
                    continue;
                }
                for term in &p.nodes[node].terms {
                    e.blocks[term.block].cols =
                        at(first, p.nodes[node].frames[term.slot]).collect();
                }
            }
        }
    }
}

fn phase_of_next(steps: &[usize], phase: usize, t: usize) -> usize {
    let end: usize = steps[..=phase].iter().sum();
    if t + 1 < end { phase } else { phase + 1 }
}

fn label(category: &'static str, subject: Subject, scale: f64, unit: &'static str) -> RowLabel {
    RowLabel {
        category,
        subject,
        scale,
        unit,
    }
}

/// The frame of a body that a goal names: "base", an object, a robot link or an interface.
pub fn goal_body(scene: &Scene, system: &System, name: &str) -> Option<Carrier> {
    if name == "base" {
        return Some(Carrier {
            body: Body::Joint(0),
            body_from_frame: Pose::identity(),
        });
    }
    if let Some(o) = scene.objects.iter().position(|o| o.name == name) {
        return Some(system.carrier(Owner::Object(o), &Pose::identity()));
    }
    if let Some(i) = scene.interfaces.iter().find(|i| i.name == name) {
        return Some(system.carrier(i.owner, &i.body_from_interface));
    }
    let frame = scene.robot.model.frame_id(name)?;
    Some(system.carrier(Owner::Robot { frame }, &Pose::identity()))
}
