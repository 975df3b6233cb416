//! First and second derivatives of the whole program; values are in [`crate::problem`].

use crate::chain::{Motion, StateLayout};
use crate::momentum::Context;
use crate::point::Point;
use crate::problem::{element_nodes, physical_wrench, velocity_scale};
use crate::slip::Place;
use crate::states::{self, At};
use crate::terms::PoseTerm;
use crate::torque_speed::Velocities;
use crate::worker::{NearestOfInterval, Scratch, Worker};
use nalgebra::{Matrix6, Vector6};
use solver::{BlockStructure, ElementData};

impl Worker<'_> {
    /// Gradient, Jacobians and Hessian of interval `t`; `y` are the multipliers of its rows.
    pub(crate) fn derivatives(
        &mut self,
        x: &Point,
        t: usize,
        y: &[f64],
        nearest: &NearestOfInterval,
        out: &mut ElementData,
    ) {
        out.gradient.fill(0.0);
        lower_triangle(out, |column| column.fill(0.0));
        self.motion_derivatives(x, t, y, out);
        self.clear_pose_sums();
        self.stick_derivatives(t, y, out);
        let program = self.program;
        let interval = &program.intervals[t];
        let s = &mut *self.scratch;
        for node in element_nodes(program, t) {
            if (if node == t { interval.a } else { interval.b }).is_none() {
                continue;
            }
            let sums = &mut s.pose_sums[node - t];
            let nearest = &nearest.nodes[node - t];
            for (term, nearest) in program.nodes[node].terms.iter().zip(nearest) {
                let relative = &self.nodes[node].relatives[term.slot];
                let gradients = &mut s.gradients[..term.n_rows];
                let weights = &y[term.first_row..term.first_row + term.n_rows];
                let hessian =
                    term.term
                        .derivatives_near(&relative.b_from_a, weights, nearest, gradients);
                let jacobian = &mut out.jacobians[term.block];
                if gradients.iter().all(|g| *g == Vector6::zeros()) {
                    // Such as a clearance that has levelled out.
                    jacobian.fill(0.0);
                } else {
                    for (c, j) in relative.columns.iter().enumerate() {
                        for r in 0..term.n_rows {
                            jacobian[c * term.n_rows + r] = gradients[r].dot(j);
                        }
                    }
                }
                if weights.iter().all(|w| w.abs() < 1e-9) {
                    continue;
                }
                sums[term.slot].add(&weighted_sum(gradients, weights), &hessian);
            }
        }
        self.node_cost_derivatives(x, t, out);
        let s = &mut *self.scratch;
        let place = (t, &self.differences[t], &nearest.passages[..]);
        let (way, gradients) = (&mut s.way, &mut s.gradients);
        self.passages
            .derivatives(program, place, y, (way, gradients), out);
        self.force_cost_derivatives(x, t, out);
        self.force_derivatives(x, t, y, out);
        self.chain_poses(t, out);
    }

    /// Multiplies what the rows have in the Hessian of interval `t` by `factor`, below one.
    pub(crate) fn scale_row_curvature(
        &mut self,
        x: &Point,
        t: usize,
        factor: f64,
        out: &mut ElementData,
    ) {
        // H becomes ((factor / rest) H + ∇²f) rest: what is added to H is the same as in `derivatives`.
        let rest = 1.0 - factor;
        lower_triangle(out, |column| {
            for h in column {
                *h *= factor / rest;
            }
        });
        out.gradient.fill(0.0);
        self.motion(x, t);
        self.scratch.chain.start_empty();
        self.chain_motion(t, false, out);
        self.clear_pose_sums();
        self.node_cost_derivatives(x, t, out);
        self.force_cost_derivatives(x, t, out);
        self.chain_poses(t, out);
        lower_triangle(out, |column| {
            for h in column {
                *h *= rest;
            }
        });
    }

    fn clear_pose_sums(&mut self) {
        for sum in self.scratch.pose_sums.iter_mut().flatten() {
            sum.clear();
        }
    }

    /// Sticking: −φ(X_t) + φ(X_{t+1}).
    fn stick_derivatives(&mut self, t: usize, y: &[f64], out: &mut ElementData) {
        let program = self.program;
        let interval = &program.intervals[t];
        let s = &mut *self.scratch;
        for stick in &interval.sticks {
            let rows = stick.place.n_rows();
            let jacobian = &mut out.jacobians[stick.block];
            let mut column = 0;
            let sides = [
                (interval.a, t, stick.slot_a, -1.0),
                (interval.b, t + 1, stick.slot_b, 1.0),
            ];
            for (first, node, slot, sign) in sides {
                if first.is_none() {
                    continue;
                }
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
                let weights = &mut s.values[..rows];
                for (r, w) in weights.iter_mut().enumerate() {
                    *w = sign * y[stick.first_row + r];
                }
                let gradient = weighted_sum(&s.gradients[..rows], weights);
                let hessian = stick.place.hessian(&relative.b_from_a, weights);
                s.pose_sums[node - t][slot].add(&gradient, &hessian);
            }
        }
    }

    /// Takes the sums of gradients and Hessians by relative poses to the increments of their nodes.
    fn chain_poses(&self, t: usize, out: &mut ElementData) {
        let program = self.program;
        let interval = &program.intervals[t];
        let n = out.gradient.len();
        let sides = [(interval.a, t), (interval.b, t + 1)];
        for ((first, node), sums) in sides.into_iter().zip(&self.scratch.pose_sums) {
            let Some(first) = first else { continue };
            let node_frames = program.nodes[node].frames.iter();
            for ((&frame, relative), sum) in node_frames.zip(&self.nodes[node].relatives).zip(sums)
            {
                if sum.is_zero {
                    continue;
                }
                let frame = &program.frames[frame];
                for (&col, j) in frame.cols.iter().zip(&relative.columns) {
                    out.gradient[first + col] += sum.cost_gradient.dot(j);
                }
                let cols = &frame.cols[..relative.columns.len()];
                frame.pose_hessian(relative, &sum.gradient, &sum.hessian, |k, l, value| {
                    let (i, j) = (first + cols[k], first + cols[l]);
                    out.hessian[i.min(j) * n + i.max(j)] += value;
                });
            }
        }
    }

    /// Equations of motion, velocity limits, motion and duration costs.
    #[allow(clippy::too_many_lines)] // one expression or layout, written down in its own order
    fn motion_derivatives(&mut self, x: &Point, t: usize, y: &[f64], out: &mut ElementData) {
        self.motion(x, t);
        let program = self.program;
        let interval = &program.intervals[t];
        let n = program.structure.elements[t].vars.len();
        let nv = program.system.model.nv;
        let s = &mut *self.scratch;
        let states = program
            .has_velocities()
            .then(|| StateLayout::of(interval))
            .flatten();
        let here = interval.v.then(|| &self.differences[t]);
        let next = interval.v_next.then(|| &self.differences[t + 1]);
        let layout = interval.into();
        let n_motion_blocks = program.system.motion_blocks().count();
        if interval.dynamics {
            for i in 0..nv {
                s.weights[i] = y[i] / program.dynamics_scale[i];
            }
            if program.momentum {
                s.weights[..6].fill(0.0);
            }
            let rows = &interval.torque_speed;
            rows.add_weights(y, &program.dynamics_scale, &mut s.weights);
            let Motion { v, a, .. } = &s.chain.motion;
            let model = &program.system.model;
            let kinematics = &self.nodes[t].kinematics;
            s.hessian.compute(model, kinematics, v, a, &s.weights);
            s.chain.start(&s.hessian);
            for force in &interval.forces {
                let wrench = physical_wrench(force, &x.wrenches[t]);
                let relative = &self.nodes[t].relatives[force.slot];
                let frame = &program.frames[force.frame];
                let cols = &frame.cols;
                let by_q = &mut s.chain.by_q;
                frame.wrench_jacobian(relative, &wrench, |k, l, value| {
                    by_q[(cols[k], cols[l])] -= value;
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
                for i in 0..force.n {
                    let column =
                        &mut s.jacobian[(force.first + i) * nv..(force.first + i + 1) * nv];
                    column.fill(0.0);
                    for (&col, j) in cols.iter().zip(&relative.columns) {
                        column[col] = -j[i] * force.scale[i] / program.dynamics_scale[col];
                    }
                }
            }
            let (scale, jacobian) = (&program.dynamics_scale, &mut s.jacobian[..]);
            match &states {
                Some(layout) => s.chain.state_rows(&s.hessian, layout, scale, jacobian),
                None => s
                    .chain
                    .rows(&s.hessian, here, next, &layout, scale, jacobian),
            }
            if program.momentum {
                let kinematics = [&self.nodes[t].kinematics, &self.nodes[t + 1].kinematics];
                let (relatives, wrenches) = (&self.nodes[t].relatives, &x.wrenches[t]);
                let at = Context::new(program, t, kinematics, [here, next], relatives, wrenches);
                s.momentum
                    .derivatives(&at, y, &mut s.chain, &mut s.jacobian, out);
            }
            let at = match &states {
                Some(layout) => Velocities::Unknown(layout.v, layout.v_next),
                None => Velocities::Differences(&layout),
            };
            let blocks = &program.structure.elements[t].blocks;
            let torques = (&s.jacobian[..], nv);
            for (block, jacobian) in blocks[..n_motion_blocks].iter().zip(&mut out.jacobians) {
                take_block(block, torques, jacobian);
            }
            if let Some(block) = rows.block {
                let cols = &blocks[block].cols;
                let jacobian = &mut out.jacobians[block];
                rows.jacobian(&at, &s.chain.motion, torques, cols, jacobian);
            }
            rows.add_gradient(y, &mut s.chain.by_v_gradient);
            for slip in &interval.slips {
                let frame = &program.frames[program.nodes[t].frames[slip.slot]];
                let at = Place {
                    frame,
                    relative: &self.nodes[t].relatives[slip.slot],
                };
                s.slips
                    .derivatives(slip, at, here, &layout, y, &mut s.chain, out);
            }
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
        self.chain_motion(t, interval.dynamics, out);
        if states.is_some() {
            self.state_derivatives(t, y, out);
        }
    }

    /// Adds the costs of velocities, accelerations and time, and takes them with what the chain has to the element; with the
    /// Hessian of the `equations` of motion, or without.
    fn chain_motion(&mut self, t: usize, equations: bool, out: &mut ElementData) {
        let program = self.program;
        let interval = &program.intervals[t];
        let (gradient, hessian) = (&mut out.gradient, &mut out.hessian);
        let Scratch {
            chain,
            hessian: of_equations,
            ..
        } = &mut *self.scratch;
        let equations = equations.then_some(&*of_equations);
        let share = program.share[interval.phase];
        chain.add_costs(program.motion_weights(t), share, interval.dynamics);
        let states = (program.has_velocities()).then(|| StateLayout::of(interval));
        if let Some(layout) = states.flatten() {
            chain.state_finish(equations, &layout, gradient, hessian);
        } else {
            let here = interval.v.then(|| &self.differences[t]);
            let next = interval.v_next.then(|| &self.differences[t + 1]);
            chain.finish(equations, here, next, &interval.into(), gradient, hessian);
        }
        if let (true, Some(time)) = (interval.dynamics, interval.time) {
            gradient[time] += program.settings.weights.time / chain.motion.steps;
        }
    }

    /// Rows of node velocities that are unknowns.
    fn state_derivatives(&mut self, t: usize, y: &[f64], out: &mut ElementData) {
        let program = self.program;
        let interval = &program.intervals[t];
        let s = &mut *self.scratch;
        let at = At {
            program,
            interval,
            difference: &self.differences[t],
            motion: &s.chain.motion,
        };
        if let Some(rows) = interval.integrator {
            at.integrator_derivatives(rows, y, out);
        }
        for touch in &interval.touches {
            let frame = &program.frames[program.nodes[t].frames[touch.slot]];
            let place = (frame, &self.nodes[t].relatives[touch.slot]);
            states::touch_derivatives(touch, place, &at, y, &mut s.virtual_speeds, out);
        }
    }

    fn force_derivatives(&mut self, x: &Point, t: usize, y: &[f64], out: &mut ElementData) {
        let program = self.program;
        let interval = &program.intervals[t];
        let n = program.structure.elements[t].vars.len();
        let s = &mut *self.scratch;
        for force in &interval.forces {
            let wrench = physical_wrench(force, &x.wrenches[t]);
            let relative = &self.nodes[t].relatives[force.slot];
            let frame = &program.frames[force.frame];
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
                s.pose_sums[0][force.slot].add(&gradient, &h.pose);
            }
        }
    }
}

/// What the terms of one relative pose add up to: gradients by increments of a and the Hessian.
#[derive(Debug, Clone)]
pub(crate) struct PoseSum {
    /// Of the costs alone.
    cost_gradient: Vector6<f64>,
    /// Of the Lagrangian.
    gradient: Vector6<f64>,
    hessian: Matrix6<f64>,
    is_zero: bool,
}

impl PoseSum {
    /// Nothing yet.
    pub fn new() -> Self {
        Self {
            cost_gradient: Vector6::zeros(),
            gradient: Vector6::zeros(),
            hessian: Matrix6::zeros(),
            is_zero: true,
        }
    }

    fn clear(&mut self) {
        if !self.is_zero {
            *self = Self::new();
        }
    }

    /// Adds a term of the costs.
    pub fn add_cost(&mut self, gradient: &Vector6<f64>, hessian: &Matrix6<f64>) {
        self.add(gradient, hessian);
        self.cost_gradient += gradient;
    }

    /// Adds a term; one far away, whose gradient is zero, costs nothing later.
    fn add(&mut self, gradient: &Vector6<f64>, hessian: &Matrix6<f64>) {
        if *gradient != Vector6::zeros() || *hessian != Matrix6::zeros() {
            self.gradient += gradient;
            self.hessian += hessian;
            self.is_zero = false;
        }
    }
}

/// The rows and columns of a block out of a column-major Jacobian with `n_rows` rows.
fn take_block(block: &BlockStructure, (all, n_rows): (&[f64], usize), out: &mut [f64]) {
    for (out, &c) in out.chunks_exact_mut(block.n_rows).zip(&block.cols) {
        let first = c * n_rows + block.first_row;
        out.copy_from_slice(&all[first..first + block.n_rows]);
    }
}

/// Does something with every column of the lower triangle of an element's Hessian.
fn lower_triangle(out: &mut ElementData, work: impl Fn(&mut [f64])) {
    let n = out.gradient.len();
    let columns = out.hessian.chunks_exact_mut(n.max(1)).enumerate();
    columns.for_each(|(j, column)| work(&mut column[j..]));
}

pub(crate) fn weighted_sum(gradients: &[Vector6<f64>], weights: &[f64]) -> Vector6<f64> {
    gradients.iter().zip(weights).map(|(g, w)| g * *w).sum()
}
