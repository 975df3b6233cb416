//! Options of the trajectory problem in one place: preset, weights, margins, bounds.

use std::collections::BTreeMap;

/// Which problem is solved (formulation 2.14).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Preset {
    /// What users should execute: base rows, distance constraints, margins.
    #[default]
    Default,
    /// The paper's problem: momentum rows, sigmoid penalties, no margins; to the letter with [`Sticking::Velocity`].
    Paper,
}

/// How contacts stick over an interval (formulation 2.2).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Sticking {
    /// The place of a contact is the same at both ends: no drift.
    #[default]
    Displacement,
    /// The tangential velocity at its beginning is zero, as in the paper: explicit Euler drifts by O(dt²).
    Velocity,
}

/// How the state of a node follows from the one before; a the acceleration of the interval.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Integrator {
    /// q⁺ = q ⊕ v dt (paper, eq. robot_integration).
    #[default]
    Euler,
    /// q⁺ = q ⊕ v⁺ dt.
    SemiImplicitEuler,
    /// q⁺ = q ⊕ (v dt + ½ a dt²).
    ConstantAcceleration,
}

impl Integrator {
    /// Shares (β, γ) of the two node velocities in the displacement: q⁺ ⊖ q = dt (β v + γ v⁺), with v⁺ = v + a dt.
    pub fn shares(self) -> (f64, f64) {
        match self {
            Self::Euler => (1.0, 0.0),
            Self::SemiImplicitEuler => (0.0, 1.0),
            Self::ConstantAcceleration => (0.5, 0.5),
        }
    }

    /// True if node velocities are unknowns of their own; with explicit Euler they are differences of configurations.
    pub fn has_velocities(self) -> bool {
        self != Self::Euler
    }
}

/// Weights of the costs; each multiplies half a sum of squares over all nodes or intervals. Dimensionless after the
/// scaling that is named, so that they fit robots of any size.
#[derive(Debug, Clone, PartialEq)]
pub struct Weights {
    /// Joint angles about the home posture [1/rad²].
    pub posture: f64,
    /// The same at the last node.
    pub final_posture: f64,
    /// Tilt of the base.
    pub tilt: f64,
    /// Tilt of objects in the air away from how they stood, where velocities are unknowns.
    pub carried_tilt: f64,
    /// Velocities [s²/rad²].
    pub velocity: f64,
    /// Accelerations [s⁴/rad²].
    pub acceleration: f64,
    /// Linear accelerations of the robot's base [s⁴/m²], on grids with velocities of at most 65 ms: ground that gives spoils less
    /// of what a robot does slowly (benches/runs/2026-11-24-landings.md).
    pub base_acceleration: f64,
    /// The same from 0.3 s before a foot lands until 0.2 s after.
    pub landing_acceleration: f64,
    /// Contact wrenches in units of their scale.
    pub force: f64,
    /// Moments of a foot about the middle of its sole, in units of the robot's weight on its edge: keeps the centre of pressure
    /// from the edges, over which a robot tilts on any ground that gives (benches/runs/2026-11-23-calm-landings.md). Where
    /// velocities are unknowns.
    pub pressure: f64,
    /// The same in the last 0.3 s before another foot lands, on grids of at most 65 ms.
    pub landing_pressure: f64,
    /// Distance of the centre of mass from the middle of the feet that stand, in the last 0.4 s before another foot lands, on grids
    /// of at most 65 ms [1/m²]: a robot that falls into a landing comes too fast for any controller.
    pub landing_balance: f64,
    /// Tangential forces of feet, in units of the robot's weight, on grids of at most 65 ms: feet that push against each other slip
    /// where they bear little.
    pub shear: f64,
    /// Loads of feet away from equal shares, in units of the robot's weight, on grids of at most 65 ms: a foot that bears little
    /// rattles where a controller holds it fast. A twentieth where a foot lands or leaves, all of it from 0.2 s away from that
    /// (benches/runs/2026-11-29-shared-loads.md).
    pub sharing: f64,
    /// Changes of contact wrenches from one interval to the next, in units of their scale; where velocities are unknowns.
    pub force_rate: f64,
    /// Velocities of objects.
    pub object_velocity: f64,
    /// Accelerations of objects.
    pub object_acceleration: f64,
    /// Sum of the phase durations, w_T [1/s].
    pub time: f64,
    /// Collision penalties of the paper preset.
    pub penalty: f64,
    /// Distance along the direction of the objective at the end: height of the base, reach of a body [1/m].
    pub height: f64,
    /// The same distance in keyframes [1/m²].
    pub balance: f64,
}

impl Default for Weights {
    fn default() -> Self {
        Self {
            posture: 0.05,
            final_posture: 1.0,
            tilt: 4.0,
            carried_tilt: 1.0,
            velocity: 0.05,
            acceleration: 1e-3,
            base_acceleration: 0.3,
            landing_acceleration: 100.0,
            force: 1e-3,
            pressure: 0.5,
            landing_pressure: 100.0,
            landing_balance: 300.0,
            shear: 100.0,
            sharing: 20.0,
            force_rate: 0.02,
            object_velocity: 0.01,
            object_acceleration: 1e-3,
            time: 1.0,
            penalty: 1.0,
            height: 50.0,
            balance: 0.0,
        }
    }
}

/// What a plan keeps in reserve; all neutral in the paper preset.
#[derive(Debug, Clone, PartialEq)]
pub struct Margins {
    /// Share of the friction coefficients that may be used.
    pub friction: f64,
    /// Share of a foot's or palm's extent that the centre of pressure may use.
    pub pressure: f64,
    /// The same where an object stands on something.
    pub support: f64,
    /// Share of the torque limits that may be used.
    pub torque: f64,
    /// Distance kept from joint limits [rad or m].
    pub joint_range: f64,
    /// Share of the joint velocity limits that may be used.
    pub velocity: f64,
    /// Distance between the robot or an object and what it does not touch [m].
    pub clearance: f64,
    /// Distance between links of the robot [m].
    pub self_clearance: f64,
    /// Height of a foot between its contacts [m].
    pub swing: f64,
    /// Speed with which contacts begin and end on grids with velocities [m/s].
    pub landing: f64,
    /// Sixteenths of a phase in which a contact that bears the robot or an object takes up its load after a change, and gives
    /// it away before one; 0: at once.
    pub ramp: f64,
    /// Share of the robot's weight that a foot in contact bears at least; half of what the ramp allows where that is less.
    pub load: f64,
    /// Share of the robot's weight whose moment at the edge of the area for a foot's centre of pressure stays in reserve on fine
    /// grids; less on the ramp.
    pub spare: f64,
    /// Distance that a contact's edge keeps from the edge of its support [m].
    pub bounds: f64,
}

impl Margins {
    /// Margins of an executable plan. Half of the sole for the centre of pressure is what a tracking controller in a
    /// physics simulator needed (benches/runs/2026-11-21-pick-place.md), `spare` what kept feet that bear little from rattling there
    /// (benches/runs/2026-11-27-spare-load.md).
    pub fn executable() -> Self {
        Self {
            friction: 0.8,
            pressure: 0.5,
            support: 0.9,
            torque: 0.9,
            joint_range: 0.02,
            velocity: 0.8,
            clearance: 0.02,
            self_clearance: 0.015,
            swing: 0.03,
            landing: 0.003,
            ramp: 3.0,
            load: 0.05,
            spare: 0.06,
            bounds: 0.005,
        }
    }

    /// No margins.
    pub fn none() -> Self {
        Self {
            friction: 1.0,
            pressure: 1.0,
            support: 1.0,
            torque: 1.0,
            joint_range: 0.0,
            velocity: 1.0,
            clearance: 0.0,
            self_clearance: 0.0,
            swing: 0.0,
            landing: f64::INFINITY,
            ramp: 0.0,
            load: 0.0,
            spare: 0.0,
            bounds: 0.0,
        }
    }
}

/// How near to a solution of its problem a motion ends; every row of it holds unless it is [`Ending::Rough`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// At a solution.
    Exact,
    /// Where every row holds and the last per cent of the cost is left, which can take as many iterations as all that is before.
    Good,
    /// Where rows miss up to 3e-3 (scaled), since a finer grid follows that changes more.
    Rough,
}

/// Which of several objects on a support stands on the side that it comes from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Arrangement {
    /// What comes later: it need not pass what stands there.
    #[default]
    LaterBeside,
    /// What came first: it is carried less far.
    EarlierBeside,
}

/// Everything that shapes the problem beside the scene and the contact sequence.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Which problem.
    pub preset: Preset,
    /// How states follow from one another; the preset `paper` has explicit Euler only.
    pub integrator: Integrator,
    /// How contacts stick.
    pub sticking: Sticking,
    /// Longest interval [s], which bounds the phases too; ∞: bounded by the phases only.
    pub max_step: f64,
    /// The same of flights and of the phases beside them, where it is less.
    pub push_step: f64,
    /// Shortest phase [s].
    pub min_duration: f64,
    /// Longest phase [s].
    pub max_duration: f64,
    /// Are the torque limits enforced, and with them what the robot declares of torque at speed.
    pub torque_limits: bool,
    /// Weights of the costs.
    pub weights: Weights,
    /// Margins.
    pub margins: Margins,
    /// Are collisions between the nodes of a motion repaired; not on a coarse grid that a finer one follows, whose nodes lie
    /// there.
    pub between: bool,
    /// Phases, from 0, in which the path between keyframes lifts objects and feet high over what they leave or come to, with
    /// configurations at both ends that tell where that is.
    pub lifts: BTreeMap<usize, [Vec<f64>; 2]>,
    /// Clearance that keyframes keep between objects where the margins ask for less [m]: no motion parts what rests too near.
    pub objects_apart: f64,
    /// Are keyframes that are nearly found given no more time than others: where many questions near the border of what is possible
    /// are asked, most of which have no answer.
    pub hurries: bool,
    /// Where keyframes begin with objects that share a support.
    pub arrangement: Arrangement,
    /// How near to a solution a motion ends.
    pub ending: Ending,
    /// First barrier parameter of a motion from keyframes; zero: the solver's own. Another one is another way to a motion: the
    /// solver finds local solutions, and ends without one by accident at times.
    pub first_barrier: f64,
    /// Iteration limit of one solve.
    pub max_iterations: usize,
    /// Smallest barrier parameter; zero: as small as the solver's own. A motion that solves a barrier problem satisfies every row
    /// and costs a few per cent more than the optimum, for a third of the iterations
    /// (benches/runs/2026-11-21-barrier.md); refinement finds its own optimum.
    pub barrier: f64,
    /// Threads that work on one motion; the result is the same.
    pub threads: usize,
}

/// Violation (scaled rows) below which a motion is nearly one.
pub const NEARLY_SOLVED: f64 = 3e-3;

/// Longest interval of a coarse motion of the preset `default` [s]: what explicit Euler does with longer ones is no motion of a
/// robot. Refinement lets phases grow that this keeps short.
const LONGEST_STEP: f64 = 0.15;
/// The same for flights, pushes and landings: a push takes a quarter of a second
/// (benches/runs/2026-12-01-pushes.md).
const LONGEST_PUSH_STEP: f64 = 0.05;
/// Barrier parameter of the preset `default`.
const BARRIER: f64 = 3e-4;
/// Barrier parameter of the preset `paper`: costs up to 0.1 % above the optimum, for a quarter fewer iterations
/// (benches/runs/2026-11-23-double-support.md).
const PAPER_BARRIER: f64 = 2e-5;

impl Settings {
    /// The given preset with the options of a scene.
    pub fn new(preset: Preset, options: &scene::OptimiserOptions) -> Self {
        Self {
            preset,
            integrator: Integrator::Euler,
            sticking: Sticking::Displacement,
            max_step: if preset == Preset::Default {
                LONGEST_STEP
            } else {
                f64::INFINITY
            },
            push_step: if preset == Preset::Default {
                LONGEST_PUSH_STEP
            } else {
                f64::INFINITY
            },
            min_duration: options.min_duration,
            max_duration: options.max_duration,
            torque_limits: options.torque_limits,
            weights: Weights::default(),
            margins: if preset == Preset::Default {
                Margins::executable()
            } else {
                Margins::none()
            },
            between: preset == Preset::Default,
            lifts: BTreeMap::new(),
            objects_apart: 0.0,
            hurries: false,
            arrangement: Arrangement::default(),
            ending: Ending::Exact,
            first_barrier: 0.0,
            max_iterations: options.max_iterations,
            barrier: if preset == Preset::Default {
                BARRIER
            } else {
                PAPER_BARRIER
            },
            threads: 1,
        }
    }

    /// Does the torque that is available fall with speed, where the robot says so: wherever torque limits are enforced, but
    /// not in the paper's problem, which has none of it.
    pub fn torque_speed(&self) -> bool {
        self.torque_limits && self.preset == Preset::Default
    }
}
