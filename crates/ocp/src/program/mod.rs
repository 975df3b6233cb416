//! The nonlinear program of one contact sequence: which variables, terms and rows exist, and where.
//!
//! Nodes t = 0 … N carry configurations of the whole system (robot and objects), intervals t the wrenches of active
//! contacts, phases their durations. With explicit Euler and rest at both ends q₁ = q₀ and q_N = q_{N−1}
//! (formulation 2.16), so nodes 0 and 1 are fixed and the last two share their variables.
//!
//! One element of the solver per interval: wrenches λ_t, nodes A = t, B = t+1, C = t+2, durations of the phases of this
//! and the next interval. Terms of node t belong to element t.
//!
//! With the other integrators node velocities are unknowns too, tied to the configurations by rows; then an element has
//! wrenches λ_t, configurations and velocities of nodes t and t+1, and the duration of its phase.

mod contacts;
mod costs;
mod dynamics;
pub(crate) mod flight;
mod forces;
mod goal;
mod idle;
pub(crate) mod integrator;
mod interval;
mod label;
pub(crate) mod landing;
mod lasting;
mod layout;
mod loads;
mod node;
mod rest;
mod rows;
mod torque_speed;
mod variables;

use crate::collision::{Clearances, CollisionModel};
use crate::relative::RelativeFrame;
use crate::settings::{Preset, Settings};
use crate::system::System;
use multibody::{JointKind, Kinematics};
use scene::Scene;
use solver::Structure;
use symbolic::ContactState;

pub use goal::goal_body;
pub use interval::{
    Force, ForceRows, IntegratorRows, Interval, OnRobot, Passage, Slip, Stage, Stick, Touch,
};
pub use label::{RowLabel, Subject};
pub use node::{Node, NodeCost, NodeTerm, Variables};
pub use rest::Rests;

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
    /// One configuration that satisfies the contacts of a phase, wherever they are; the first node is only what it stays
    /// near.
    State,
    /// A path: several configurations per phase, with the clearances of a motion and no dynamics.
    Path,
}

impl Grid {
    /// True for configurations without dynamics.
    pub fn is_keyframes(self) -> bool {
        self != Self::Motion
    }
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
    /// In which phases nothing bears the robot, whatever it carries.
    pub flies: Vec<bool>,
    /// What its intervals let each phase last [s].
    pub longest: Vec<f64>,
    /// All relative frames.
    pub frames: Vec<RelativeFrame>,
    /// Nodes 0 … N.
    pub nodes: Vec<Node>,
    /// Intervals 0 … N−1.
    pub intervals: Vec<Interval>,
    /// Where objects are at rest.
    pub rests: Rests,
    /// First duration variable.
    pub duration_var: usize,
    /// A variable that is always zero, for what is at rest; `None` where nothing is.
    pub still_var: Option<usize>,
    /// Posture that costs nothing, per velocity index (0 for floating bodies).
    pub home: Vec<f64>,
    /// Weight of an interval or node of each phase in the costs that are sums over them.
    pub share: Vec<f64>,
    /// Velocity and acceleration weights per velocity index, by [`Stage`].
    pub motion_weights: [Vec<(f64, f64)>; 2],
    /// Scale of each row of the equations of motion.
    pub dynamics_scale: Vec<f64>,
    /// True if the first six rows of the equations of motion are the robot's momentum (`momentum.rs`).
    pub momentum: bool,
    /// For the solver.
    pub structure: Structure,
    /// One label per row of all elements.
    pub labels: Vec<RowLabel>,
}

/// Builds the program step by step.
struct Builder<'a> {
    scene: &'a Scene,
    program: Program,
    keys: Vec<(usize, usize)>,
    labels: Vec<Vec<RowLabel>>,
    /// Kinematics of the start.
    start: Kinematics,
}

/// Parts of a phase in which growth after and before contact changes is counted, and the most of them that one interval is.
const PARTS: f64 = 16.0;
const MOST_PARTS: f64 = 3.0;
/// Intervals of a phase whose costs have their plain weight.
const REFERENCE_STEPS: f64 = 16.0;
/// Longest steps of a grid on which what happens around a landing is shaped [s]: the finest grid and the one before it, since the shape
/// doubles the cost of a motion and takes many iterations to find (benches/runs/2026-11-28-all-threads.md).
pub(crate) const FINE_STEP: f64 = 0.065;

/// With the default preset the costs of a phase do not depend on its number of intervals; the paper sums over nodes.
fn shares(settings: &Settings, grid: Grid, steps: &[usize]) -> Vec<f64> {
    let share = |&n: &usize| match (settings.preset, grid) {
        (Preset::Default, Grid::Motion) => REFERENCE_STEPS / n as f64,
        _ => 1.0,
    };
    steps.iter().map(share).collect()
}

impl Program {
    /// The program of a contact sequence; `clearances` says which collision pairs are worth a row.
    #[allow(clippy::too_many_arguments)] // the parts of a problem; one caller in this crate
    pub fn new(
        scene: &Scene,
        system: &System,
        collisions: &CollisionModel,
        phases: &[Phase],
        settings: &Settings,
        grid: Grid,
        clearances: Clearances<'_>,
    ) -> Self {
        let steps: Vec<usize> = phases
            .iter()
            .map(|p| match grid {
                Grid::Motion | Grid::Path => p.steps,
                Grid::Keyframes | Grid::OpenKeyframes | Grid::State => 1,
            })
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
                rests: Rests::default(),
                duration_var: 0,
                still_var: None,
                home: vec![0.0; nv],
                share: shares(settings, grid, &steps),
                motion_weights: [vec![(0.0, 0.0); nv], vec![(0.0, 0.0); nv]],
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
                flies: vec![],
                longest: vec![],
            },
            keys: vec![],
            labels: vec![vec![]; n],
            start: Kinematics::new(&system.model),
        };
        builder.start.update(&system.model, &system.start(scene));
        builder.flights(phases);
        builder.scales(phases);
        builder.intervals();
        builder.rests(phases);
        builder.idle(phases);
        builder.variables();
        builder.around_landings(phases);
        builder.costs();
        for t in 0..n {
            builder.equations_of_motion(t);
            builder.torque_speed(t);
            builder.velocity_limits(t);
            builder.integrator(t);
            builder.contact_geometry(t, phases);
            builder.forces(t, phases);
        }
        builder.landings(phases);
        builder.soles_outside(phases);
        builder.hands_turned(phases);
        builder.approaches(phases);
        builder.carried(phases);
        builder.carried_upright(phases);
        builder.balanced(phases);
        builder.goal();
        builder.clearances(collisions, phases, clearances);
        builder.layout();
        builder.program.labels = builder.labels.into_iter().flatten().collect();
        builder.program
    }

    /// Phase of an interval.
    pub fn phase_of(&self, t: usize) -> usize {
        self.intervals[t].phase
    }

    /// True if node velocities are unknowns of their own.
    pub fn has_velocities(&self) -> bool {
        self.grid == Grid::Motion && self.settings.integrator.has_velocities()
    }

    /// True if node velocities are unknowns and steps short enough to shape what happens around a landing.
    pub fn is_fine(&self) -> bool {
        self.has_velocities() && self.settings.max_step <= FINE_STEP
    }

    /// Velocity and acceleration weights of an interval per velocity index.
    pub fn motion_weights(&self, t: usize) -> &[(f64, f64)] {
        &self.motion_weights[self.intervals[t].stage as usize]
    }

    /// True if nodes t and t+1 can differ: with explicit Euler rest fixes the first two, always the last two.
    pub fn moves(&self, t: usize) -> bool {
        if self.has_velocities() {
            t + 1 < self.n_intervals()
        } else {
            self.intervals[t].v
        }
    }

    /// Number of intervals.
    pub fn n_intervals(&self) -> usize {
        self.intervals.len()
    }

    /// Sixteenths of a phase from the start to each node, where few intervals count as at most three each.
    pub fn along(&self) -> Vec<f64> {
        let mut along = vec![0.0];
        for interval in &self.intervals {
            let parts = (PARTS / self.steps[interval.phase] as f64).min(MOST_PARTS);
            along.push(along[along.len() - 1] + parts);
        }
        along
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
