//! One interval: its wrenches, sticking contacts and the layout of its element.

use std::sync::Arc;

use super::NodeTerm;
use crate::terms::{ForceTerm, place::Place};
use crate::torque_speed::TorqueSpeedRows;
use symbolic::Contact;

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

/// q⁺ ⊖ q = dt (β v + γ v⁺): one block per joint, six rows for a floating body.
#[derive(Debug, Clone, Copy)]
pub struct IntegratorRows {
    /// First row within the element.
    pub first_row: usize,
    /// First block within the element.
    pub first_block: usize,
}

/// Twist of the interfaces of a contact relative to one another, in axes of the first: zero at the node where the contact
/// comes into being, bounded shortly before and after.
#[derive(Debug, Clone)]
pub struct Touch {
    /// Position in the frames of node t.
    pub slot: usize,
    /// 6 for patches, 3 for points.
    pub n_rows: usize,
    /// First row within the element.
    pub first_row: usize,
    /// Block within the element: increments of node t, then its velocities.
    pub block: usize,
}

/// A configuration on the way from node t to node t+1, where rows hold as at nodes.
#[derive(Debug, Clone)]
pub struct Passage {
    /// Share of the way, between 0 and 1.
    pub share: f64,
    /// Relative frames evaluated here, indices into [`super::Program::frames`].
    pub frames: Vec<usize>,
    /// Rows; blocks: increments of nodes t and t+1.
    pub terms: Vec<NodeTerm>,
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
    /// Weights of the squares of what differs from it.
    pub weights: [f64; 6],
    /// True if it is given.
    pub known: bool,
    /// Its part in the robot's momentum rows.
    pub on_robot: Option<OnRobot>,
    /// Rows.
    pub rows: Vec<ForceRows>,
}

/// Weights of the motion by what feet do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Stage {
    /// Nothing that counts.
    #[default]
    Away,
    /// One lands soon or has just landed.
    Landing,
}

/// One interval and the layout of its element.
#[derive(Debug, Clone, Default)]
pub struct Interval {
    /// Its phase.
    pub phase: usize,
    /// Which weights its motion has.
    pub stage: Stage,
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
    /// Local offset of v_t, where it is an unknown of its own.
    pub velocity: Option<usize>,
    /// Local offset of v_{t+1}, where it is an unknown of its own.
    pub velocity_next: Option<usize>,
    /// Wrench variables of this interval (local) and of the next one (local) whose differences cost.
    pub changes: Vec<(usize, usize)>,
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
    /// Torque at speed, where joints declare it.
    pub torque_speed: TorqueSpeedRows,
    /// First row and block of the integrator, where velocities are unknowns.
    pub integrator: Option<IntegratorRows>,
    /// Contacts that come into being at node t and are at rest there.
    pub touches: Vec<Touch>,
    /// Contacts that stick by displacement.
    pub sticks: Vec<Stick>,
    /// Contacts that stick by velocity.
    pub slips: Vec<Slip>,
    /// Configurations on the way to the next node.
    pub passages: Vec<Passage>,
    /// Objects that only what they stand on touches, in a known way.
    pub idle: Vec<usize>,
    /// Wrenches.
    pub forces: Vec<Force>,
}
