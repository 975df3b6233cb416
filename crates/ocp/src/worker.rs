//! Values of one interval's rows and costs; derivatives are in [`crate::derivatives`].
//!
//! What depends on the point alone is shared ([`Trajectory::update`]); all else is scratch, so that every thread works on intervals
//! of its own.

use crate::chain::{Chain, Motion};
use crate::derivatives::PoseSum;
use crate::difference::Difference;
use crate::momentum::{Context, Momentum};
use crate::passages::{Passages, WayScratch};
use crate::point::Point;
use crate::problem::{element_nodes, interval_length, physical_wrench, velocity_scale};
use crate::program::{NodeTerm, Program};
use crate::relative::Relative;
use crate::slip::{self, Slips};
use crate::states::{self, At};
use crate::terms::PoseTerm;
use crate::terms::distance::Nearest;
use crate::terms::place::Place;
use multibody::{CenterOfMass, Kinematics, Rnea, RneaHessian};
use nalgebra::Vector6;
use solver::{ElementData, ElementStructure};

/// Relative poses and kinematics of one node.
#[derive(Debug, Clone)]
pub(crate) struct NodeState {
    pub(crate) kinematics: Kinematics,
    pub(crate) relatives: Vec<Relative>,
}

/// Scratch of one interval's evaluation.
pub(crate) struct Scratch {
    pub(crate) rnea: Rnea,
    pub(crate) hessian: RneaHessian,
    pub(crate) chain: Chain,
    /// Of the equations of motion by all that they may depend on, column-major.
    pub(crate) jacobian: Vec<f64>,
    pub(crate) tau: Vec<f64>,
    pub(crate) weights: Vec<f64>,
    pub(crate) virtual_speeds: Vec<f64>,
    pub(crate) values: Vec<f64>,
    pub(crate) gradients: Vec<Vector6<f64>>,
    pub(crate) force_gradients: Vec<(Vector6<f64>, Vector6<f64>)>,
    pub(crate) momentum: Momentum,
    pub(crate) slips: Slips,
    pub(crate) balance: CenterOfMass,
    pub(crate) way: WayScratch,
    /// Of the two nodes of the interval, one per relative pose.
    pub(crate) pose_sums: [Vec<PoseSum>; 2],
}

impl Scratch {
    /// For any interval of a program.
    pub(crate) fn new(program: &Program) -> Self {
        let model = &program.system.model;
        let nv = model.nv;
        let elements = || program.structure.elements.iter();
        let most_rows = elements().map(ElementStructure::n_rows).max().unwrap_or(0);
        let most_variables = elements().map(|e| e.vars.len()).max().unwrap_or(0);
        let most_frames = (program.nodes.iter().map(|n| n.frames.len())).max();
        let pose_sums = vec![PoseSum::new(); most_frames.unwrap_or(0)];
        Self {
            rnea: Rnea::new(model),
            hessian: RneaHessian::new(model),
            chain: Chain::new(nv),
            jacobian: vec![f64::NAN; most_variables * nv],
            tau: vec![f64::NAN; nv],
            weights: vec![0.0; nv],
            virtual_speeds: vec![0.0; nv],
            values: vec![0.0; most_rows.max(16)],
            gradients: vec![Vector6::zeros(); most_rows.max(16)],
            force_gradients: vec![(Vector6::zeros(), Vector6::zeros()); 16],
            momentum: Momentum::new(&program.system.robot, nv),
            slips: Slips::new(nv),
            balance: CenterOfMass::new(model),
            way: WayScratch::new(program),
            pose_sums: [pose_sums.clone(), pose_sums],
        }
    }
}

/// What the values of the pose terms of one interval leave for their derivatives.
#[derive(Debug, Clone)]
pub(crate) struct NearestOfInterval {
    /// Per term of the two nodes, where these are the interval's.
    pub(crate) nodes: [Vec<Nearest>; 2],
    /// Per passage and term.
    pub(crate) passages: Vec<Vec<Nearest>>,
}

impl NearestOfInterval {
    pub(crate) fn new(program: &Program, t: usize) -> Self {
        let of = |terms: &[NodeTerm]| {
            let nearest = terms.iter().map(|term| Nearest::new(term.term.n_pairs()));
            nearest.collect::<Vec<_>>()
        };
        Self {
            nodes: [t, t + 1].map(|node| {
                let own = element_nodes(program, t).any(|n| n == node);
                of(if own { &program.nodes[node].terms } else { &[] })
            }),
            passages: (program.intervals[t].passages.iter())
                .map(|passage| of(&passage.terms))
                .collect(),
        }
    }
}

/// One thread at work on intervals.
pub(crate) struct Worker<'a> {
    pub(crate) program: &'a Program,
    pub(crate) nodes: &'a [NodeState],
    pub(crate) differences: &'a [Difference],
    pub(crate) passages: &'a Passages,
    /// First row of each interval among those of all.
    pub(crate) first_row: &'a [usize],
    pub(crate) scratch: &'a mut Scratch,
}

impl Worker<'_> {
    /// Velocities and accelerations of interval `t` from the differences.
    pub(crate) fn motion(&mut self, x: &Point, t: usize) {
        let interval = &self.program.intervals[t];
        let (dt, dt_next) = (
            interval_length(self.program, x, t),
            if t + 1 < self.program.n_intervals() {
                interval_length(self.program, x, t + 1)
            } else {
                1.0
            },
        );
        let motion = &mut self.scratch.chain.motion;
        motion.dt = dt;
        motion.dt_next = dt_next;
        motion.steps = self.program.steps[interval.phase] as f64;
        motion.steps_next = if t + 1 < self.program.n_intervals() {
            self.program.steps[self.program.phase_of(t + 1)] as f64
        } else {
            1.0
        };
        let states = self.program.has_velocities();
        let xi = &self.differences[t].xi;
        for i in 0..motion.v.len() {
            if states {
                motion.v[i] = x.velocities[t][i];
                motion.v_next[i] = x.velocities[t + 1][i];
                motion.a[i] = (motion.v_next[i] - motion.v[i]) / dt;
                continue;
            }
            motion.v[i] = if interval.v { xi[i] / dt } else { 0.0 };
            motion.v_next[i] = if interval.v_next {
                self.differences[t + 1].xi[i] / dt_next
            } else {
                0.0
            };
            motion.a[i] = (motion.v_next[i] - motion.v[i]) / dt;
        }
    }

    /// Generalised forces M a + b − Σ Jᵀλ of interval `t`; `update` and `motion` have been called.
    pub(crate) fn generalised_forces(&mut self, x: &Point, t: usize) {
        let program = self.program;
        let s = &mut *self.scratch;
        let Motion { v, a, .. } = &s.chain.motion;
        s.tau.copy_from_slice(s.rnea.compute(
            &program.system.model,
            &self.nodes[t].kinematics,
            v,
            a,
        ));
        for force in &program.intervals[t].forces {
            let wrench = physical_wrench(force, &x.wrenches[t]);
            let relative = &self.nodes[t].relatives[force.slot];
            for (&col, column) in program.frames[force.frame]
                .cols
                .iter()
                .zip(&relative.columns)
            {
                s.tau[col] -= column.dot(&wrench);
            }
        }
    }

    /// Objective and row values of interval `t`.
    #[allow(clippy::too_many_lines)] // one expression or layout, written down in its own order
    pub(crate) fn values(
        &mut self,
        x: &Point,
        t: usize,
        nearest: &mut NearestOfInterval,
        out: &mut ElementData,
    ) {
        self.motion(x, t);
        let dynamics = self.program.intervals[t].dynamics;
        if dynamics {
            self.generalised_forces(x, t);
        }
        let program = self.program;
        let interval = &program.intervals[t];
        let s = &mut *self.scratch;
        if dynamics {
            for i in 0..s.tau.len() {
                out.values[i] = s.tau[i] / program.dynamics_scale[i];
            }
            if program.momentum {
                let kinematics = [&self.nodes[t].kinematics, &self.nodes[t + 1].kinematics];
                let differences = [
                    interval.v.then(|| &self.differences[t]),
                    interval.v_next.then(|| &self.differences[t + 1]),
                ];
                let (relatives, wrenches) = (&self.nodes[t].relatives, &x.wrenches[t]);
                let at = Context::new(program, t, kinematics, differences, relatives, wrenches);
                let Motion { v, v_next, dt, .. } = &s.chain.motion;
                s.momentum.values(&at, v, v_next, *dt, &mut out.values);
            }
            let scale = &program.dynamics_scale;
            (interval.torque_speed).values(&s.tau, scale, &s.chain.motion, &mut out.values);
        }
        if let Some(first) = interval.velocity_rows {
            for (k, joint) in program.system.actuated().enumerate() {
                out.values[first + k] =
                    s.chain.motion.v[joint.idx_v] / velocity_scale(joint.velocity_limit);
            }
        }
        let at = At {
            program,
            interval,
            difference: &self.differences[t],
            motion: &s.chain.motion,
        };
        if let Some(rows) = interval.integrator {
            at.integrator_values(rows, &mut out.values);
        }
        for touch in &interval.touches {
            let frame = &program.frames[program.nodes[t].frames[touch.slot]];
            let relative = &self.nodes[t].relatives[touch.slot];
            let v = &s.chain.motion.v;
            states::touch_values(touch, frame, relative, v, &mut out.values);
        }
        for stick in &interval.sticks {
            let n = stick.place.n_rows();
            let (mut from, mut to) = ([0.0; 3], [0.0; 3]);
            stick.place.values(
                &self.nodes[t].relatives[stick.slot_a].b_from_a,
                &mut from[..n],
            );
            stick.place.values(
                &self.nodes[t + 1].relatives[stick.slot_b].b_from_a,
                &mut to[..n],
            );
            Place::difference(
                &from,
                &to,
                &mut out.values[stick.first_row..stick.first_row + n],
            );
        }
        for slip in &interval.slips {
            let frame = &program.frames[program.nodes[t].frames[slip.slot]];
            let at = slip::Place {
                frame,
                relative: &self.nodes[t].relatives[slip.slot],
            };
            s.slips.values(slip, at, &s.chain.motion.v, &mut out.values);
        }
        for force in &interval.forces {
            let wrench = physical_wrench(force, &x.wrenches[t]);
            let pose = &self.nodes[t].relatives[force.slot].b_from_a;
            for rows in &force.rows {
                rows.term.values(
                    pose,
                    &wrench,
                    &mut out.values[rows.first_row..rows.first_row + rows.n_rows],
                );
            }
        }
        for node in element_nodes(program, t) {
            let state = &self.nodes[node];
            let nearest = &mut nearest.nodes[node - t];
            for (term, nearest) in program.nodes[node].terms.iter().zip(nearest) {
                let values = &mut out.values[term.first_row..term.first_row + term.n_rows];
                let pose = &state.relatives[term.slot].b_from_a;
                term.term.values_near(pose, values, nearest);
            }
        }
        self.passages
            .values(interval, t, &mut nearest.passages, &mut out.values);
        out.objective = self.costs(x, t).sum;
    }
}
