//! Values and derivatives of the whole program for the solver.
//!
//! Per node: kinematics and relative poses. Per interval: differences, inverse dynamics and wrenches. The chain rule
//! from (q, v, a) to the node variables is in [`crate::chain`].

use crate::chain::{Chain, Motion};
use crate::difference::Difference;
use crate::point::Point;
use crate::program::{Grid, Program};
use crate::relative::Relative;
use crate::terms::place::Place;
use multibody::{Kinematics, Rnea, RneaDerivatives, RneaHessian};
use nalgebra::{DMatrix, Vector6};
use solver::{ElementData, Problem, Structure};

/// Relative poses and kinematics of one node.
#[derive(Debug, Clone)]
struct NodeState {
    kinematics: Kinematics,
    relatives: Vec<Relative>,
}

/// Scratch of one interval's evaluation.
struct Scratch {
    rnea: Rnea,
    derivatives: RneaDerivatives,
    hessian: RneaHessian,
    chain: Chain,
    tau: Vec<f64>,
    weights: Vec<f64>,
    virtual_speeds: Vec<f64>,
    values: Vec<f64>,
    gradients: Vec<Vector6<f64>>,
    force_gradients: Vec<(Vector6<f64>, Vector6<f64>)>,
    rows: DMatrix<f64>,
}

/// The program with its scratch memory, ready for the solver.
pub struct Trajectory {
    /// What it evaluates.
    pub program: Program,
    nodes: Vec<NodeState>,
    differences: Vec<Difference>,
    scratch: Scratch,
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
            })
            .collect();
        let floating = program.system.floating();
        let differences = vec![Difference::new(nv, &floating); program.n_intervals()];
        let most_rows = program
            .structure
            .elements
            .iter()
            .map(solver::ElementStructure::n_rows)
            .max()
            .unwrap_or(0);
        let scratch = Scratch {
            rnea: Rnea::new(model),
            derivatives: RneaDerivatives::new(model),
            hessian: RneaHessian::new(model),
            chain: Chain::new(nv),
            tau: vec![f64::NAN; nv],
            weights: vec![0.0; nv],
            virtual_speeds: vec![0.0; nv],
            values: vec![0.0; most_rows.max(16)],
            gradients: vec![Vector6::zeros(); most_rows.max(16)],
            force_gradients: vec![(Vector6::zeros(), Vector6::zeros()); 16],
            rows: DMatrix::zeros(nv, nv),
        };
        Self {
            nodes,
            differences,
            scratch,
            program,
        }
    }

    /// Kinematics, relative poses and differences at a point.
    fn update(&mut self, x: &Point) {
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
    }

    /// Interval length [s].
    pub fn dt(&self, x: &Point, t: usize) -> f64 {
        let phase = self.program.phase_of(t);
        x.durations[phase] / self.program.steps[phase] as f64
    }

    /// Velocities and accelerations of interval `t` from the differences.
    fn motion(&mut self, x: &Point, t: usize) {
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
        let xi = &self.differences[t].xi;
        for i in 0..motion.v.len() {
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
    fn values(&mut self, x: &Point, t: usize, out: &mut ElementData) {
        self.motion(x, t);
        let dynamics = self.program.intervals[t].dynamics;
        if dynamics {
            self.generalised_forces(x, t);
        }
        let program = &self.program;
        let interval = &program.intervals[t];
        let s = &mut self.scratch;
        let mut objective = 0.0;
        if dynamics {
            for i in 0..s.tau.len() {
                out.values[i] = s.tau[i] / program.dynamics_scale[i];
            }
            objective += program.settings.weights.time * s.chain.motion.dt;
        }
        for (i, (wv, wa)) in program.motion_weights.iter().enumerate() {
            let (v, a) = (
                s.chain.motion.v[i],
                if dynamics { s.chain.motion.a[i] } else { 0.0 },
            );
            objective += 0.5 * (wv * v * v + wa * a * a);
        }
        if let Some(first) = interval.velocity_rows {
            for (k, joint) in program.system.actuated().enumerate() {
                out.values[first + k] =
                    s.chain.motion.v[joint.idx_v] / velocity_scale(joint.velocity_limit);
            }
        }
        for stick in &interval.sticks {
            let n = stick.place.n_rows();
            let (mut from, mut to) = ([0.0; 3], [0.0; 3]);
            use crate::terms::PoseTerm;
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
        for force in &interval.forces {
            let scaled = &x.wrenches[t][force.first..force.first + force.n];
            let wrench = physical_wrench(force, &x.wrenches[t]);
            let pose = &self.nodes[t].relatives[force.slot].b_from_a;
            for rows in &force.rows {
                rows.term.values(
                    pose,
                    &wrench,
                    &mut out.values[rows.first_row..rows.first_row + rows.n_rows],
                );
            }
            for (l, r) in scaled.iter().zip(&force.reference) {
                objective += 0.5 * program.settings.weights.force * (l - r) * (l - r);
            }
        }
        for node in element_nodes(program, t) {
            for term in &program.nodes[node].terms {
                let pose = &self.nodes[node].relatives[term.slot].b_from_a;
                term.term.values(
                    pose,
                    &mut out.values[term.first_row..term.first_row + term.n_rows],
                );
            }
            for cost in &program.nodes[node].costs {
                let pose = &self.nodes[node].relatives[cost.slot].b_from_a;
                cost.term.values(pose, &mut s.values);
                objective += cost
                    .weights
                    .iter()
                    .zip(&s.values)
                    .map(|(w, v)| w * v)
                    .sum::<f64>();
            }
            objective += posture_cost(program, node, &x.nodes[node], |_, _, _| ());
        }
        out.objective = objective;
    }

    /// Gradient, Jacobians and Hessian of interval `t`; `y` are the multipliers of its rows.
    fn derivatives(&mut self, x: &Point, t: usize, y: &[f64], out: &mut ElementData) {
        let n = self.program.structure.elements[t].vars.len();
        out.gradient.fill(0.0);
        out.hessian.fill(0.0);
        self.motion_derivatives(x, t, y, out);
        let program = &self.program;
        let interval = &program.intervals[t];
        let s = &mut self.scratch;
        // Sticking: −φ(X_t) + φ(X_{t+1}).
        for stick in &interval.sticks {
            use crate::terms::PoseTerm;
            let rows = stick.place.n_rows();
            let frame = &program.frames[program.nodes[t].frames[stick.slot_a]];
            let jacobian = &mut out.jacobians[stick.block];
            let mut column = 0;
            let sides = [
                (interval.a, t, stick.slot_a, -1.0),
                (interval.b, t + 1, stick.slot_b, 1.0),
            ];
            for (first, node, slot, sign) in sides {
                let Some(first) = first else { continue };
                let relative = &self.nodes[node].relatives[slot];
                stick
                    .place
                    .gradients(&relative.b_from_a, &mut s.gradients[..rows]);
                for j in &relative.columns {
                    for r in 0..rows {
                        jacobian[column * rows + r] = sign * s.gradients[r].dot(j);
                    }
                    column += 1;
                }
                let weights: Vec<f64> = (0..rows).map(|r| sign * y[stick.first_row + r]).collect();
                let gradient = weighted_sum(&s.gradients[..rows], &weights);
                let hessian = stick.place.hessian(&relative.b_from_a, &weights);
                frame.pose_hessian(relative, &gradient, &hessian, |k, l, value| {
                    let (i, j) = (first + frame.cols[k], first + frame.cols[l]);
                    out.hessian[i.min(j) * n + i.max(j)] += value;
                });
            }
        }
        for node in element_nodes(program, t) {
            let Some(first) = (if node == t { interval.a } else { interval.b }) else {
                continue;
            };
            for term in &program.nodes[node].terms {
                let frame = &program.frames[program.nodes[node].frames[term.slot]];
                let relative = &self.nodes[node].relatives[term.slot];
                let gradients = &mut s.gradients[..term.n_rows];
                term.term.gradients(&relative.b_from_a, gradients);
                let jacobian = &mut out.jacobians[term.block];
                for (c, j) in relative.columns.iter().enumerate() {
                    for r in 0..term.n_rows {
                        jacobian[c * term.n_rows + r] = gradients[r].dot(j);
                    }
                }
                let weights = &y[term.first_row..term.first_row + term.n_rows];
                if weights.iter().all(|w| w.abs() < 1e-9) {
                    continue;
                }
                let gradient = weighted_sum(gradients, weights);
                let hessian = term.term.hessian(&relative.b_from_a, weights);
                frame.pose_hessian(relative, &gradient, &hessian, |k, l, value| {
                    let (i, j) = (first + frame.cols[k], first + frame.cols[l]);
                    out.hessian[i.min(j) * n + i.max(j)] += value;
                });
            }
            for cost in &program.nodes[node].costs {
                let frame = &program.frames[program.nodes[node].frames[cost.slot]];
                let relative = &self.nodes[node].relatives[cost.slot];
                let gradients = &mut s.gradients[..cost.weights.len()];
                cost.term.gradients(&relative.b_from_a, gradients);
                let gradient = weighted_sum(gradients, &cost.weights);
                for (&col, j) in frame.cols.iter().zip(&relative.columns) {
                    out.gradient[first + col] += gradient.dot(j);
                }
                let hessian = cost.term.hessian(&relative.b_from_a, &cost.weights);
                frame.pose_hessian(relative, &gradient, &hessian, |k, l, value| {
                    let (i, j) = (first + frame.cols[k], first + frame.cols[l]);
                    out.hessian[i.min(j) * n + i.max(j)] += value;
                });
            }
            posture_cost(program, node, &x.nodes[node], |i, gradient, curvature| {
                out.gradient[first + i] += gradient;
                out.hessian[(first + i) * n + first + i] += curvature;
            });
        }
        self.force_derivatives(x, t, y, out);
    }

    /// Equations of motion, velocity limits, motion and duration costs.
    fn motion_derivatives(&mut self, x: &Point, t: usize, y: &[f64], out: &mut ElementData) {
        self.motion(x, t);
        let program = &self.program;
        let interval = &program.intervals[t];
        let n = program.structure.elements[t].vars.len();
        let nv = program.system.model.nv;
        let s = &mut self.scratch;
        if interval.v {
            self.differences[t].linearise();
        }
        if interval.v_next {
            self.differences[t + 1].linearise();
        }
        let here = interval.v.then(|| &self.differences[t]);
        let next = interval.v_next.then(|| &self.differences[t + 1]);
        let layout = interval.into();
        if interval.dynamics {
            for i in 0..nv {
                s.weights[i] = y[i] / program.dynamics_scale[i];
            }
            let Motion { v, a, .. } = &s.chain.motion;
            let model = &program.system.model;
            let kinematics = &self.nodes[t].kinematics;
            s.derivatives.compute(model, kinematics, v, a);
            s.hessian.compute(model, kinematics, v, a, &s.weights);
            s.chain.start(&s.derivatives, &s.hessian);
            for force in &interval.forces {
                let wrench = physical_wrench(force, &x.wrenches[t]);
                let relative = &self.nodes[t].relatives[force.slot];
                let frame = &program.frames[force.frame];
                let cols = &frame.cols;
                let by_q = &mut s.chain.by_q;
                frame.wrench_jacobian(relative, &wrench, |k, l, value| {
                    by_q[(cols[k], cols[l])] -= value
                });
                for (k, &col) in cols.iter().enumerate() {
                    s.virtual_speeds[k] = s.weights[col];
                }
                let qq = &mut s.chain.qq;
                frame.virtual_power_hessian(
                    relative,
                    &wrench,
                    &s.virtual_speeds[..cols.len()],
                    |l, by_wrench| {
                        if let Some(first) = interval.a {
                            for i in 0..force.n {
                                out.hessian[(force.first + i) * n + first + cols[l]] -=
                                    by_wrench[i] * force.scale[i];
                            }
                        }
                    },
                    |m, l, value| {
                        qq[(cols[m], cols[l])] -= value;
                        if m != l {
                            qq[(cols[l], cols[m])] -= value;
                        }
                    },
                );
                // Columns of the wrench.
                let jacobian = &mut out.jacobians[0];
                for i in 0..force.n {
                    let column = &mut jacobian[(force.first + i) * nv..(force.first + i + 1) * nv];
                    column.fill(0.0);
                    for (&col, j) in cols.iter().zip(&relative.columns) {
                        column[col] = -j[i] * force.scale[i] / program.dynamics_scale[col];
                    }
                }
            }
            s.chain.rows(
                here,
                next,
                &layout,
                &program.dynamics_scale,
                &mut s.rows,
                &mut out.jacobians[0],
            );
            s.chain.gradients_from_weights(&s.weights);
        } else {
            s.chain.start_empty();
        }
        // Velocity limits: rows and their part of ∂L/∂v.
        if let Some(first) = interval.velocity_rows {
            for (k, joint) in program.system.actuated().enumerate() {
                let scale = velocity_scale(joint.velocity_limit);
                let i = joint.idx_v;
                let dt = s.chain.motion.dt;
                let jacobian = &mut out.jacobians[interval.velocity_block + k];
                let mut c = 0;
                if interval.a.is_some() {
                    jacobian[c] = -1.0 / (dt * scale);
                    c += 1;
                }
                if interval.b.is_some() {
                    jacobian[c] = 1.0 / (dt * scale);
                    c += 1;
                }
                jacobian[c] = -s.chain.motion.v[i] / (dt * s.chain.motion.steps * scale);
                s.chain.by_v_gradient[i] += y[first + k] / scale;
            }
        }
        s.chain
            .add_costs(&program.motion_weights, interval.dynamics);
        s.chain
            .finish(here, next, &layout, &mut out.gradient, &mut out.hessian);
        if let (true, Some(time)) = (interval.dynamics, interval.time) {
            out.gradient[time] += program.settings.weights.time / s.chain.motion.steps;
        }
    }

    fn force_derivatives(&mut self, x: &Point, t: usize, y: &[f64], out: &mut ElementData) {
        let program = &self.program;
        let interval = &program.intervals[t];
        let n = program.structure.elements[t].vars.len();
        let s = &mut self.scratch;
        for force in &interval.forces {
            let wrench = physical_wrench(force, &x.wrenches[t]);
            let relative = &self.nodes[t].relatives[force.slot];
            let frame = &program.frames[force.frame];
            for i in 0..force.n {
                let v = force.first + i;
                let difference = x.wrenches[t][v] - force.reference[i];
                out.gradient[v] += program.settings.weights.force * difference;
                out.hessian[v * n + v] += program.settings.weights.force;
            }
            for rows in &force.rows {
                let m = rows.n_rows;
                let gradients = &mut s.force_gradients[..m];
                rows.term.gradients(&relative.b_from_a, &wrench, gradients);
                let jacobian = &mut out.jacobians[rows.block];
                for i in 0..force.n {
                    for r in 0..m {
                        jacobian[i * m + r] = gradients[r].1[i] * force.scale[i];
                    }
                }
                let weights = &y[rows.first_row..rows.first_row + m];
                let h = rows.term.hessian(&relative.b_from_a, &wrench, weights);
                for j in 0..force.n {
                    for i in j..force.n {
                        out.hessian[(force.first + j) * n + force.first + i] +=
                            h.wrench[(i, j)] * force.scale[i] * force.scale[j];
                    }
                }
                let (true, Some(first)) = (rows.term.uses_pose(), interval.a) else {
                    continue;
                };
                for (c, j) in relative.columns.iter().enumerate() {
                    for r in 0..m {
                        jacobian[(force.n + c) * m + r] = gradients[r].0.dot(j);
                    }
                }
                for (&col, j) in frame.cols.iter().zip(&relative.columns) {
                    let mixed = h.mixed.tr_mul(j);
                    for i in 0..force.n {
                        out.hessian[(force.first + i) * n + first + col] +=
                            mixed[i] * force.scale[i];
                    }
                }
                let gradient = gradients.iter().zip(weights).map(|(g, w)| g.0 * *w).sum();
                frame.pose_hessian(relative, &gradient, &h.pose, |k, l, value| {
                    let (i, j) = (first + frame.cols[k], first + frame.cols[l]);
                    out.hessian[i.min(j) * n + i.max(j)] += value;
                });
            }
        }
    }
}

/// Nodes whose terms belong to element `t`: its own, and for keyframes the last one too.
fn element_nodes(program: &Program, t: usize) -> impl Iterator<Item = usize> + use<> {
    let last = program.grid == Grid::Keyframes && t + 1 == program.n_intervals();
    let own = program.nodes[t].var.is_some();
    (own.then_some(t)).into_iter().chain(last.then_some(t + 1))
}

/// ½ w Σ (q − home)² over the robot's joints; calls `each(i, gradient, curvature)`.
fn posture_cost(
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
fn velocity_scale(limit: f64) -> f64 {
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

fn weighted_sum(gradients: &[Vector6<f64>], weights: &[f64]) -> Vector6<f64> {
    gradients.iter().zip(weights).map(|(g, w)| g * *w).sum()
}

impl Problem for Trajectory {
    type Point = Point;

    fn structure(&self) -> &Structure {
        &self.program.structure
    }

    fn retract(&self, x: &Point, dx: &[f64], step: f64, out: &mut Point) {
        let model = &self.program.system.model;
        let mut increment = vec![0.0; model.nv];
        for (t, node) in self.program.nodes.iter().enumerate() {
            match node.var {
                None => out.nodes[t].copy_from_slice(&x.nodes[t]),
                Some(first) => {
                    for (i, d) in increment.iter_mut().enumerate() {
                        *d = step * dx[first + i];
                    }
                    model.integrate_into(&x.nodes[t], &increment, &mut out.nodes[t]);
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
            if let Some(first) = node.var {
                for joint in self.program.system.actuated() {
                    out[first + joint.idx_v] = x.nodes[t][joint.idx_q];
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
            self.values(x, t, data);
        }
    }

    fn linearise(&mut self, x: &Point, multipliers: &[f64], out: &mut [ElementData]) {
        self.update(x);
        let mut first = 0;
        for (t, data) in out.iter_mut().enumerate() {
            let rows = data.values.len();
            self.values(x, t, data);
            self.derivatives(x, t, &multipliers[first..first + rows], data);
            first += rows;
        }
    }
}
