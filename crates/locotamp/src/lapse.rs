//! What a motion on the coarse grid lacks between its nodes.
//!
//! A few long intervals per phase with explicit Euler let a robot seem to do what no robot can: a lunge onto a platform gains from what
//! the integrator leaves out, and costs less than a climb by way of a box. With accelerations and wrenches held from each node on, such
//! a motion lacks forces of the order of the robot's weight between its nodes, or torques far beyond their limits: on the grid on which
//! it must hold it has no motion, or becomes a contorted one with a lapse there too, which is no plan: those that are lack less than a
//! tenth of the weight (benches/runs/2026-11-28-lapses.md).

use ocp::{Between, Motion};
use serde::{Deserialize, Serialize};

/// Gravity by which a robot's weight is meant: a scene may have another one, or none [m/s²].
const GRAVITY: f64 = 9.81;
/// Time between samples [s].
const SAMPLE: f64 = 0.02;
/// Torque over its limit between nodes from which on a lapse is serious, and up to which it is slight.
const SERIOUS_TORQUE: f64 = 1.4;
const SLIGHT_TORQUE: f64 = 1.1;
/// The same of the force that is missing at the base, over the robot's weight on Earth.
const SERIOUS_FORCE: f64 = 1.0;
const SLIGHT_FORCE: f64 = 0.6;

/// The largest lapse of a motion.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Lapse {
    /// Largest torque over its limit between the nodes; 0 without limits.
    pub torque: f64,
    /// Largest force that is missing at the base, over the robot's weight on Earth.
    pub force: f64,
    /// Where the larger of the two is, in what is serious: a phase, from 0.
    pub phase: usize,
}

impl Lapse {
    /// Of a motion.
    pub(crate) fn of(motion: &mut Motion) -> Self {
        let Motion {
            trajectory, point, ..
        } = motion;
        let mut most = Self::default();
        for t in 0..trajectory.program.n_intervals() {
            let between = trajectory.between_of(point, t, SAMPLE);
            let program = &trajectory.program;
            let weight = program.system.robot_mass * GRAVITY;
            let limited = program.settings.torque_limits;
            let here = Self::new(&between, (weight, limited), program.phase_of(t));
            if here.size() > most.size() {
                most.phase = here.phase;
            }
            most.torque = most.torque.max(here.torque);
            most.force = most.force.max(here.force);
        }
        most
    }

    fn new(between: &Between, (weight, limited): (f64, bool), phase: usize) -> Self {
        Self {
            torque: if limited { between.torque_share } else { 0.0 },
            force: between.base_force / weight,
            phase,
        }
    }

    fn size(&self) -> f64 {
        (self.torque / SERIOUS_TORQUE).max(self.force / SERIOUS_FORCE)
    }

    /// True if the motion will hardly hold on a finer grid as it is.
    pub(crate) fn is_serious(&self) -> bool {
        self.size() > 1.0
    }

    /// What is missing.
    pub(crate) fn words(&self) -> String {
        format!(
            "between nodes, {:.0} % of a torque limit, and {:.0} % of the robot's weight missing at its base, in phase {}",
            100.0 * self.torque,
            100.0 * self.force,
            self.phase + 1
        )
    }

    /// True if the motion is likely to hold on a finer grid.
    pub(crate) fn is_slight(&self) -> bool {
        self.torque <= SLIGHT_TORQUE && self.force <= SLIGHT_FORCE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn either_torque_or_force_makes_a_lapse_serious_and_both_must_be_small_for_a_slight_one() {
        let lapse = |torque, force| Lapse {
            torque,
            force,
            phase: 0,
        };
        let both = |lapse: Lapse| (lapse.is_serious(), lapse.is_slight());
        assert_eq!(both(lapse(3.9, 0.3)), (true, false));
        assert_eq!(both(lapse(0.9, 2.0)), (true, false));
        assert_eq!(both(lapse(1.04, 0.42)), (false, true));
        assert_eq!(both(lapse(1.04, 0.8)), (false, false));
        assert_eq!(both(Lapse::default()), (false, true));
    }
}
