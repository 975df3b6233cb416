//! Values of the whole program for the solver; derivatives are in [`crate::derivatives`].
//!
//! Per node: kinematics and relative poses. Per interval: differences, inverse dynamics and wrenches. The chain rule
//! from (q, v, a) to the node variables is in [`crate::chain`].

use crate::chain::{Chain, Motion};
use crate::derivatives::PoseSum;
use crate::difference::Difference;
use crate::evaluated::Evaluated;
use crate::momentum::{Context, Momentum};
use crate::passages::Passages;
use crate::point::Point;
use crate::program::{Grid, Program, Variables};
use crate::relative::Relative;
use crate::slip::{self, Slips};
use crate::states::{self, At};
use crate::terms::PoseTerm;
use crate::terms::distance::Nearest;
use crate::terms::place::Place;
use multibody::{CenterOfMass, Kinematics, Rnea, RneaHessian};
use nalgebra::Vector6;
use solver::{ElementData, ElementStructure, Problem, Structure};

/// Relative poses and kinematics of one node.
#[derive(Debug, Clone)]
pub(crate) struct NodeState {
    pub(crate) kinematics: Kinematics,
    pub(crate) relatives: Vec<Relative>,
    /// What the values of each term leave for its derivatives.
    pub(crate) nearest: Vec<Nearest>,
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
}

/// The program with its scratch memory, ready for the solver.
pub struct Trajectory {
    /// What it evaluates.
    pub program: Program,
    pub(crate) nodes: Vec<NodeState>,
    pub(crate) differences: Vec<Difference>,
    pub(crate) passages: Passages,
    pub(crate) scratch: Scratch,
    /// Scratch of the two nodes of an interval, one per relative pose.
    pub(crate) pose_sums: [Vec<PoseSum>; 2],
    evaluated: Evaluated,
}

impl Trajectory {
    /// Allocates for a program.
    pub fn new(program: Program) -> Self {
        let model = &program.system.model;
        let nv = model.nv;
        let nodes = program
            .nodes
            .iter()
            .map(|node| NodeState {
                kinematics: Kinematics::new(model),
                relatives: node
                    .frames
                    .iter()
                    .map(|&f| program.frames[f].relative())
                    .collect(),
                nearest: (node.terms.iter())
                    .map(|term| Nearest::new(term.term.n_pairs()))
                    .collect(),
            })
            .collect();
        let floating = program.system.floating();
        let differences = vec![Difference::new(nv, &floating); program.n_intervals()];
        let most_rows = program
            .structure
            .elements
            .iter()
            .map(ElementStructure::n_rows)
            .max()
            .unwrap_or(0);
        let elements = program.structure.elements.iter();
        let most_variables = elements.map(|e| e.vars.len()).max();
        let scratch = Scratch {
            rnea: Rnea::new(model),
            hessian: RneaHessian::new(model),
            chain: Chain::new(nv),
            jacobian: vec![f64::NAN; most_variables.unwrap_or(0) * nv],
            tau: vec![f64::NAN; nv],
            weights: vec![0.0; nv],
            virtual_speeds: vec![0.0; nv],
            values: vec![0.0; most_rows.max(16)],
            gradients: vec![Vector6::zeros(); most_rows.max(16)],
            force_gradients: vec![(Vector6::zeros(), Vector6::zeros()); 16],
            momentum: Momentum::new(&program.system.robot, nv),
            slips: Slips::new(nv),
            balance: CenterOfMass::new(model),
        };
        let most_frames = (program.nodes.iter().map(|n| n.frames.len())).max();
        let pose_sums = vec![PoseSum::new(); most_frames.unwrap_or(0)];
        Self {
            evaluated: Evaluated::new(&program),
            pose_sums: [pose_sums.clone(), pose_sums],
            passages: Passages::new(&program),
            program,
            nodes,
            differences,
            scratch,
        }
    }

    /// Puts objects that are at rest where they are at the first node of their rest.
    pub(crate) fn settle(&self, x: &mut Point) {
        let (system, rests) = (&self.program.system, &self.program.rests);
        for object in 0..system.model.joints.len() - system.n_robot_joints {
            let (q, v) = (system.object_q(object), system.object_v(object));
            for t in 0..x.nodes.len() {
                let Some(first) = rests.since(object, t) else {
                    continue;
                };
                let (before, here) = x.nodes.split_at_mut(t);
                if let Some(there) = before.get(first) {
                    here[0][q..q + 7].copy_from_slice(&there[q..q + 7]);
                }
                if let Some(velocity) = x.velocities.get_mut(t) {
                    velocity[v..v + 6].fill(0.0);
                }
            }
        }
    }

    /// Kinematics, relative poses and differences at a point.
    pub(crate) fn update(&mut self, x: &Point) {
        if self.evaluated.is_at(x) {
            return;
        }
        let program = &self.program;
        for (t, (node, state)) in program.nodes.iter().zip(&mut self.nodes).enumerate() {
            state.kinematics.update(&program.system.model, &x.nodes[t]);
            for (&frame, relative) in node.frames.iter().zip(&mut state.relatives) {
                program.frames[frame].update(&state.kinematics, relative);
            }
        }
        for (t, difference) in self.differences.iter_mut().enumerate() {
            program
                .system
                .model
                .difference_into(&x.nodes[t], &x.nodes[t + 1], &mut difference.xi);
        }
        self.passages.update(program, x, &self.differences);
    }

    /// Interval length [s].
    pub fn dt(&self, x: &Point, t: usize) -> f64 {
        let phase = self.program.phase_of(t);
        x.durations[phase] / self.program.steps[phase] as f64
    }

    /// Velocities and accelerations of interval `t` from the differences.
    pub(crate) fn motion(&mut self, x: &Point, t: usize) {
        let interval = &self.program.intervals[t];
        let (dt, dt_next) = (
            self.dt(x, t),
            if t + 1 < self.program.n_intervals() {
                self.dt(x, t + 1)
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

    /// Velocity and acceleration of interval `t` at a point, for export.
    pub fn velocity_and_acceleration(&mut self, x: &Point, t: usize) -> (Vec<f64>, Vec<f64>) {
        if t == 0 {
            self.update(x);
        }
        self.motion(x, t);
        (
            self.scratch.chain.motion.v.clone(),
            self.scratch.chain.motion.a.clone(),
        )
    }

    /// Generalised forces M a + b − Σ Jᵀλ of interval `t`; `update` and `motion` have been called.
    fn generalised_forces(&mut self, x: &Point, t: usize) {
        let program = &self.program;
        let s = &mut self.scratch;
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

    /// Generalised forces of interval `t` at a point, for export: base and object rows zero at a solution.
    pub fn torques(&mut self, x: &Point, t: usize) -> Vec<f64> {
        if t == 0 {
            self.update(x);
        }
        self.motion(x, t);
        self.generalised_forces(x, t);
        self.scratch.tau.clone()
    }

    /// Objective and row values of interval `t`.
    #[allow(clippy::too_many_lines)] // one expression or layout, written down in its own order
    fn values(&mut self, x: &Point, t: usize, out: &mut ElementData) {
        self.motion(x, t);
        let dynamics = self.program.intervals[t].dynamics;
        if dynamics {
            self.generalised_forces(x, t);
        }
        let program = &self.program;
        let interval = &program.intervals[t];
        let s = &mut self.scratch;
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
            let state = &mut self.nodes[node];
            for (term, nearest) in program.nodes[node].terms.iter().zip(&mut state.nearest) {
                let values = &mut out.values[term.first_row..term.first_row + term.n_rows];
                let pose = &state.relatives[term.slot].b_from_a;
                term.term.values_near(pose, values, nearest);
            }
        }
        self.passages.values(interval, t, &mut out.values);
        out.objective = self.interval_costs(x, t).sum;
    }
}

/// Nodes whose terms belong to element `t`: its own, and for keyframes the last one too.
pub(crate) fn element_nodes(program: &Program, t: usize) -> impl Iterator<Item = usize> + use<> {
    let last = program.grid.is_keyframes() && t + 1 == program.n_intervals();
    let own = program.nodes[t].var.is_some();
    (own.then_some(t)).into_iter().chain(last.then_some(t + 1))
}

/// ½ w Σ (q − home)² over the robot's joints; calls `each(i, gradient, curvature)`.
pub(crate) fn posture_cost(
    program: &Program,
    node: usize,
    q: &[f64],
    mut each: impl FnMut(usize, f64, f64),
) -> f64 {
    let w = program.nodes[node].posture;
    let mut cost = 0.0;
    for joint in program.system.actuated() {
        let difference = q[joint.idx_q] - program.home[joint.idx_v];
        cost += 0.5 * w * difference * difference;
        each(joint.idx_v, w * difference, w);
    }
    cost
}

/// Velocity that counts as one.
pub(crate) fn velocity_scale(limit: f64) -> f64 {
    if limit.is_finite() {
        limit.max(1e-3)
    } else {
        10.0
    }
}

/// Wrench in newtons and newton metres, axes of a.
pub fn physical_wrench(force: &crate::program::Force, scaled: &[f64]) -> Vector6<f64> {
    let mut wrench = Vector6::zeros();
    for i in 0..force.n {
        wrench[i] = scaled[force.first + i] * force.scale[i];
    }
    wrench
}

impl Problem for Trajectory {
    type Point = Point;

    fn structure(&self) -> &Structure {
        &self.program.structure
    }

    fn retract(&self, x: &Point, dx: &[f64], step: f64, out: &mut Point) {
        let model = &self.program.system.model;
        for (t, node) in self.program.nodes.iter().enumerate() {
            let change = |of: &Variables, i: usize| of.get(i).map_or(0.0, |v| step * dx[v]);
            match &node.var {
                None => out.nodes[t].copy_from_slice(&x.nodes[t]),
                Some(vars) => {
                    let dq = |i: usize| change(vars, i);
                    model.integrate_by_into(&x.nodes[t], dq, &mut out.nodes[t]);
                }
            }
            if let Some(vars) = &node.velocity_var {
                for i in 0..model.nv {
                    out.velocities[t][i] = x.velocities[t][i] + change(vars, i);
                }
            }
        }
        for (t, interval) in self.program.intervals.iter().enumerate() {
            for i in 0..interval.n_wrench {
                out.wrenches[t][i] = x.wrenches[t][i] + step * dx[interval.wrench_var + i];
            }
        }
        if self.program.grid == Grid::Motion {
            for k in 0..x.durations.len() {
                out.durations[k] = x.durations[k] + step * dx[self.program.duration_var + k];
            }
        }
    }

    fn coordinates(&self, x: &Point, out: &mut [f64]) {
        let model = &self.program.system.model;
        for (t, node) in self.program.nodes.iter().enumerate() {
            if let Some(vars) = &node.var {
                for joint in self.program.system.actuated() {
                    out[vars.robot + joint.idx_v] = x.nodes[t][joint.idx_q];
                }
            }
            if let Some(vars) = &node.velocity_var {
                for (i, v) in x.velocities[t].iter().enumerate() {
                    vars.get(i).into_iter().for_each(|at| out[at] = *v);
                }
            }
        }
        debug_assert_eq!(model.nq, x.nodes[0].len());
        for (t, interval) in self.program.intervals.iter().enumerate() {
            out[interval.wrench_var..interval.wrench_var + interval.n_wrench]
                .copy_from_slice(&x.wrenches[t]);
        }
        if self.program.grid == Grid::Motion {
            let first = self.program.duration_var;
            out[first..first + x.durations.len()].copy_from_slice(&x.durations);
        }
    }

    fn evaluate(&mut self, x: &Point, out: &mut [ElementData]) {
        self.update(x);
        for (t, data) in out.iter_mut().enumerate() {
            if self.evaluated.fresh {
                let (objective, values) = &self.evaluated.values[t];
                data.objective = *objective;
                data.values.copy_from_slice(values);
            } else {
                self.values(x, t, data);
                let (objective, values) = &mut self.evaluated.values[t];
                *objective = data.objective;
                values.copy_from_slice(&data.values);
            }
        }
        self.evaluated.fresh = true;
    }

    fn linearise(&mut self, x: &Point, multipliers: &[f64], out: &mut [ElementData]) {
        self.evaluate(x, out);
        for difference in &mut self.differences {
            difference.linearise();
        }
        let mut first = 0;
        for (t, data) in out.iter_mut().enumerate() {
            let rows = data.values.len();
            self.derivatives(x, t, &multipliers[first..first + rows], data);
            first += rows;
        }
    }
}
