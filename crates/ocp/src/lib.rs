//! The paper's trajectory optimisation problem for one contact sequence, robot and objects together.
//!
//! Data flow: a [`scene::Scene`] and a sequence of [`Phase`]s become a [`Program`] (which variables and rows exist), a
//! [`Trajectory`] evaluates it, the solver moves a [`Point`], [`motion`] solves it from keyframes to a checked result.

mod aloft;
mod balance;
mod between;
mod carried;
mod chain;
pub mod collision;
mod derivatives;
mod difference;
mod evaluated;
mod guess;
mod keyframes;
mod lean;
mod momentum;
pub mod motion;
mod objective;
mod pace;
mod packing;
mod passages;
mod path;
mod point;
mod problem;
mod program;
mod refine;
mod relative;
mod relative_motion;
mod resistance;
mod resting;
mod rounds;
mod settings;
mod slip;
mod stagnation;
mod state_guess;
mod states;
mod system;
pub mod terms;
mod torque_speed;
mod turn;
mod ways;
mod worker;

pub use between::Between;
pub use keyframes::Keyframes;
pub use motion::{Motion, Planner};
pub use objective::{CostTerm, CostTerms};
pub use point::Point;
pub use problem::{Trajectory, physical_wrench};
pub use program::{
    Force, Grid, Interval, Node, Phase, Program, Rests, RowLabel, Stage, Subject, Variables,
    goal_body,
};
pub use refine::Refinement;
pub use relative::{Body, Carrier};
pub use relative_motion::Relative;
pub use resistance::{Pull, Worst, pulls, violations, worst_row};
pub use settings::{
    Arrangement, Ending, Integrator, Margins, NEARLY_SOLVED, Preset, Settings, Sticking, Weights,
};
pub use system::System;
pub use ways::{Ways, base_height};
