//! Why a contact sequence has no motion, and which number would change that: the key `explanation` of a plan.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Why there is no motion. Phases count from 1; amounts are in SI units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Explanation {
    /// Where the sequence failed.
    pub stage: FailedStage,
    /// What resists in the first place.
    pub cause: Obstacle,
    /// What is violated where the solver gave up, the worst first.
    pub violated: Vec<Obstacle>,
    /// Which constraints pull hardest against what is violated, by their multipliers.
    pub pulls: Vec<Pull>,
    /// Single numbers whose change makes the sequence feasible, each found and confirmed by solving again; the smallest
    /// change first.
    pub remedies: Vec<Remedy>,
    /// Numbers that were changed as far as sensible without success.
    pub in_vain: Vec<String>,
    /// How many solves it took.
    pub solves: usize,
    /// False if it was stopped before all candidates were tried.
    pub complete: bool,
    /// All of it in plain words.
    pub text: String,
}

/// Where a sequence failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FailedStage {
    /// Bounds contradict each other.
    Contradiction,
    /// No configurations satisfy contacts, joint ranges, clearances and goal regions.
    Keyframes,
    /// There are configurations, but no motion through them.
    Motion,
}

/// A constraint that does not hold.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Obstacle {
    /// Phase, from 1.
    pub phase: usize,
    /// What happens on entering that phase.
    pub action: String,
    /// Group of constraints: geometry, friction, torque, weight, contact force, duration, joint range, joint velocity,
    /// clearance, goal, dynamics.
    pub group: String,
    /// The constraint as the checker names it.
    pub constraint: String,
    /// Contact ("a on b"), joint, body or pair of bodies.
    pub subject: String,
    /// By how much it does not hold.
    pub amount: f64,
    /// Unit of the amount.
    pub unit: String,
}

/// A constraint that pulls.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Pull {
    /// Phase, from 1.
    pub phase: usize,
    /// The constraint as the checker names it.
    pub constraint: String,
    /// Contact ("a on b"), joint, body or pair of bodies.
    pub subject: String,
    /// Its part of the sum of all multipliers (of scaled constraints), 0 to 1.
    pub share: f64,
}

/// A number of the scene or the robot, and the value that would do.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Remedy {
    /// Which number: mass, friction, torsional friction, torque limit, largest force, largest moment, longest phase,
    /// shortest phase, height, position, goal, joint range, velocity limit.
    pub quantity: String,
    /// Names of what has it, as in the file: objects, surfaces, joints, interfaces, static bodies.
    pub of: Vec<String>,
    /// Where it stands: the key of the scene file, or the place in the robot's files.
    pub key: String,
    /// Its value now.
    pub from: f64,
    /// A value that makes the sequence feasible: with it keyframes and motion were found.
    pub to: f64,
    /// Unit of both.
    pub unit: String,
    /// The remedy in plain words.
    pub text: String,
}
