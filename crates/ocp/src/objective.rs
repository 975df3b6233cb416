//! The objective of one interval, term by term, and its derivatives.
//!
//! The terms of an interval are those of its element: time, velocities, accelerations, wrenches and their changes, and the
//! costs of the nodes that belong to it ([`element_nodes`]). All are non-negative but the last, [`CostTerm::Goal`].
//! Source: the paper's objective, formulation 2.14; weights in [`crate::Weights`].

use crate::chain::Motion;
use crate::derivatives::weighted_sum;
use crate::point::Point;
use crate::problem::{element_nodes, posture_cost};
use crate::worker::Worker;
use solver::ElementData;

/// A term of the objective.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum CostTerm {
    /// Duration.
    Time,
    /// Joint angles about the home posture.
    #[default]
    Posture,
    /// Tilt of the base.
    Tilt,
    /// Velocities of the robot.
    Velocity,
    /// Accelerations of the robot.
    Acceleration,
    /// Velocities of objects.
    ObjectVelocity,
    /// Accelerations of objects.
    ObjectAcceleration,
    /// Contact wrenches.
    Force,
    /// Changes of contact wrenches from one interval to the next.
    ForceRate,
    /// Collision penalties of the paper's problem.
    Collision,
    /// What guides keyframes and paths, and on fine grids draws a robot over its feet before a landing.
    Guide,
    /// Joint angles about the home posture at the last node.
    FinalPosture,
    /// The scene's objective at the last node, negative: height of the base, reach of a body.
    Goal,
}

impl CostTerm {
    /// All terms in the order of [`CostTerms::of`].
    pub const ALL: [Self; 13] = [
        Self::Time,
        Self::Posture,
        Self::Tilt,
        Self::Velocity,
        Self::Acceleration,
        Self::ObjectVelocity,
        Self::ObjectAcceleration,
        Self::Force,
        Self::ForceRate,
        Self::Collision,
        Self::Guide,
        Self::FinalPosture,
        Self::Goal,
    ];

    /// True for what counts once, at the last node.
    pub fn is_at_the_end(self) -> bool {
        matches!(self, Self::FinalPosture | Self::Goal)
    }

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Posture => "posture",
            Self::Tilt => "tilt",
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
            Self::ObjectVelocity => "object_velocity",
            Self::ObjectAcceleration => "object_acceleration",
            Self::Force => "force",
            Self::ForceRate => "force_rate",
            Self::Collision => "collision",
            Self::Guide => "guide",
            Self::FinalPosture => "final_posture",
            Self::Goal => "goal",
        }
    }
}

/// The objective of one interval.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CostTerms {
    /// The sum, as the solver sees it.
    pub sum: f64,
    terms: [f64; CostTerm::ALL.len()],
}

impl CostTerms {
    /// The part of one term.
    pub fn of(&self, term: CostTerm) -> f64 {
        self.terms[term as usize]
    }

    fn add(&mut self, term: CostTerm, value: f64) {
        self.sum += value;
        self.terms[term as usize] += value;
    }
}

impl Worker<'_> {
    /// The objective of interval `t` at a point, term by term; its motion is known.
    pub(crate) fn costs(&mut self, x: &Point, t: usize) -> CostTerms {
        let program = self.program;
        let interval = &program.intervals[t];
        let weights = &program.settings.weights;
        let share = program.share[interval.phase];
        let s = &mut *self.scratch;
        let Motion { v, a, dt, .. } = &s.chain.motion;
        let mut costs = CostTerms::default();
        if interval.dynamics {
            costs.add(CostTerm::Time, weights.time * dt);
        }
        for (i, (wv, wa)) in program.motion_weights(t).iter().enumerate() {
            let a = if interval.dynamics { a[i] } else { 0.0 };
            let (of_v, of_a) = (wv * v[i] * v[i], wa * a * a);
            let [by_v, by_a] = if i < program.system.robot_nv {
                [CostTerm::Velocity, CostTerm::Acceleration]
            } else {
                [CostTerm::ObjectVelocity, CostTerm::ObjectAcceleration]
            };
            costs.sum += 0.5 * share * (of_v + of_a);
            costs.terms[by_v as usize] += 0.5 * share * of_v;
            costs.terms[by_a as usize] += 0.5 * share * of_a;
        }
        for force in &interval.forces {
            let scaled = &x.wrenches[t][force.first..force.first + force.n];
            for ((l, r), w) in scaled.iter().zip(&force.reference).zip(&force.weights) {
                costs.add(CostTerm::Force, 0.5 * w * share * (l - r) * (l - r));
            }
        }
        if !interval.changes.is_empty() {
            let weight = weights.force_rate / share;
            let first = program.intervals[t + 1].wrench_var;
            let vars = &program.structure.elements[t].vars;
            for &(here, next) in &interval.changes {
                let change = x.wrenches[t + 1][vars[next] - first] - x.wrenches[t][here];
                costs.add(CostTerm::ForceRate, 0.5 * weight * change * change);
            }
        }
        for node in element_nodes(program, t) {
            for cost in &program.nodes[node].costs {
                let pose = &self.nodes[node].relatives[cost.slot].b_from_a;
                cost.term.values(pose, &mut s.values);
                let rows = cost.weights.iter().zip(&s.values);
                costs.add(cost.kind, rows.map(|(w, v)| w * v).sum());
            }
            if let Some(balance) = &program.nodes[node].balance {
                let kinematics = &self.nodes[node].kinematics;
                let cost = balance.cost(&program.system.model, kinematics, &mut s.balance);
                costs.add(CostTerm::Guide, cost);
            }
            let posture = posture_cost(program, node, &x.nodes[node], |_, _, _| ());
            costs.add(program.nodes[node].posture_kind, posture);
        }
        costs
    }

    /// Adds the derivatives of the costs of relative poses to their sums, and of balance and posture to the element.
    pub(crate) fn node_cost_derivatives(&mut self, x: &Point, t: usize, out: &mut ElementData) {
        let program = self.program;
        let interval = &program.intervals[t];
        let n = out.gradient.len();
        let s = &mut *self.scratch;
        for node in element_nodes(program, t) {
            let Some(first) = (if node == t { interval.a } else { interval.b }) else {
                continue;
            };
            let sums = &mut s.pose_sums[node - t];
            for cost in &program.nodes[node].costs {
                let pose = &self.nodes[node].relatives[cost.slot].b_from_a;
                let gradients = &mut s.gradients[..cost.weights.len()];
                let hessian = cost.term.derivatives(pose, &cost.weights, gradients);
                sums[cost.slot].add_cost(&weighted_sum(gradients, &cost.weights), &hessian);
            }
            if let Some(balance) = &program.nodes[node].balance {
                let kinematics = &self.nodes[node].kinematics;
                let (gradient, hessian) = (&mut out.gradient, &mut out.hessian);
                balance.derivatives(
                    &program.system.model,
                    kinematics,
                    &mut s.balance,
                    |i, value| gradient[first + i] += value,
                    |i, j, value| hessian[(first + j) * n + first + i] += value,
                );
            }
            posture_cost(program, node, &x.nodes[node], |i, gradient, curvature| {
                out.gradient[first + i] += gradient;
                out.hessian[(first + i) * n + first + i] += curvature;
            });
        }
    }

    /// Adds the derivatives of the costs of wrenches and of their changes.
    pub(crate) fn force_cost_derivatives(&self, x: &Point, t: usize, out: &mut ElementData) {
        let program = self.program;
        let interval = &program.intervals[t];
        let n = out.gradient.len();
        let share = program.share[interval.phase];
        for &(here, next) in &interval.changes {
            let weight = program.settings.weights.force_rate / share;
            let first = program.intervals[t + 1].wrench_var;
            let variable = program.structure.elements[t].vars[next] - first;
            let change = x.wrenches[t + 1][variable] - x.wrenches[t][here];
            out.gradient[here] -= weight * change;
            out.gradient[next] += weight * change;
            out.hessian[here * n + here] += weight;
            out.hessian[next * n + next] += weight;
            out.hessian[here * n + next] -= weight;
        }
        for force in &interval.forces {
            for i in 0..force.n {
                let v = force.first + i;
                let difference = x.wrenches[t][v] - force.reference[i];
                let weight = force.weights[i] * share;
                out.gradient[v] += weight * difference;
                out.hessian[v * n + v] += weight;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_term_has_its_own_place_and_name() {
        for (i, term) in CostTerm::ALL.into_iter().enumerate() {
            assert_eq!(term as usize, i);
            let same = |other: &&CostTerm| other.name() == term.name();
            assert_eq!(CostTerm::ALL.iter().filter(same).count(), 1);
        }
    }
}
