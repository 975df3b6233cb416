//! The robot's centroidal momentum under explicit Euler: six rows per interval, in place of the base rows.
//!
//! ```text
//! h(q⁺, v⁺) − h(q, v) − dt · (m g + Σ F_i ;  Σ (r_i − c) × F_i + K_i) = 0
//! ```
//!
//! h = A(q) v, linear then angular about the centre of mass c, world axes; F_i, K_i: force and moment on the robot about
//! r_i, the origin of interface a, world axes. Everything but h⁺ at node t. Objects are not part of h.
//!
//! Source: paper, "eq:cmm", "eq:momentum_dynamics"; readings of formulation 2.14 and 2.16.
//!
//! Derivatives: h and the wrench's rate at node t enter the [`Chain`] as functions of (q, v); h⁺ is linear in
//! v⁺ = (C ⊖ B)/dt⁺ and is chained here. With Y the constant twist (y_lin − y_ang × c, y_ang) about the world origin and
//! z = Ad(X⁻¹) Y, X = world_from_a = (R, r), the rate's part of yᵀ(…) is λᵀz: gradient by increments ξ of a λᵀ[z, ξ],
//! second order ½ λᵀ[ξ, [ξ, z]]; by c it is (y_ang × R f)·c.

use crate::chain::{Chain, Layout};
use crate::difference::{Difference, End};
use crate::problem::physical_wrench;
use crate::program::{Force, Program};
use crate::relative::{Relative, RelativeFrame, bracket, bracket_transpose};
use multibody::{CenterOfMass, Centroidal, CentroidalDerivatives, Kinematics, Model};
use nalgebra::{DMatrix, Matrix3xX, Matrix6, Vector3, Vector6};
use solver::ElementData;

const ENDS: [End; 2] = [End::A, End::B];

/// A contact's wrench on the robot.
pub struct Push<'a> {
    /// Interface a in the world.
    pub frame: &'a RelativeFrame,
    /// Its pose and columns.
    pub relative: &'a Relative,
    /// Wrench on the robot in axes of a, about a's origin [N, N·m].
    pub wrench: Vector6<f64>,
    /// First local variable of the wrench.
    pub first: usize,
    /// Number of wrench variables.
    pub n: usize,
    /// Wrench per unit of a variable; negative where the robot carries b.
    pub scale: [f64; 6],
}

/// One interval as seen by the momentum rows.
pub struct Context<'a> {
    /// The robot alone.
    pub robot: &'a Model,
    /// m g [N], world axes.
    pub weight: Vector3<f64>,
    /// Kinematics of nodes t and t+1 (of the whole system, robot first).
    pub kinematics: [&'a Kinematics; 2],
    /// Differences of the two intervals, where not at rest.
    pub differences: [Option<&'a Difference>; 2],
    /// Local offsets.
    pub layout: Layout,
    /// Momentum that counts as one, per row [N·s, N·m·s].
    pub scale: &'a [f64],
    frames: &'a [RelativeFrame],
    forces: &'a [Force],
    relatives: &'a [Relative],
    wrenches: &'a [f64],
}

impl<'a> Context<'a> {
    /// Interval `t` of a program, with the relative poses of node t and the interval's scaled wrenches.
    pub fn new(
        program: &'a Program,
        t: usize,
        kinematics: [&'a Kinematics; 2],
        differences: [Option<&'a Difference>; 2],
        relatives: &'a [Relative],
        wrenches: &'a [f64],
    ) -> Self {
        let system = &program.system;
        Self {
            robot: &system.robot,
            weight: system.model.gravity * system.robot_mass,
            kinematics,
            differences,
            layout: (&program.intervals[t]).into(),
            scale: &program.dynamics_scale[..6],
            frames: &program.frames,
            forces: &program.intervals[t].forces,
            relatives,
            wrenches,
        }
    }

    /// The wrenches on the robot.
    fn pushes(&self) -> impl Iterator<Item = Push<'a>> {
        self.forces.iter().filter_map(|force| {
            let on = force.on_robot?;
            Some(Push {
                frame: &self.frames[on.frame],
                relative: &self.relatives[on.slot],
                wrench: physical_wrench(force, self.wrenches) * on.sign,
                first: force.first,
                n: force.n,
                scale: force.scale.map(|s| s * on.sign),
            })
        })
    }
}

/// Workspace of the momentum rows.
pub struct Momentum {
    centroidal: Centroidal,
    derivatives: CentroidalDerivatives,
    com: CenterOfMass,
    six: DMatrix<f64>,
    chained: DMatrix<f64>,
    square: DMatrix<f64>,
    transposed: DMatrix<f64>,
    force_by_q: Matrix3xX<f64>,
    by_v: Vec<f64>,
    by_v_chained: Vec<f64>,
}

impl Momentum {
    /// Buffers for a robot within a system of `nv` increments.
    pub fn new(robot: &Model, nv: usize) -> Self {
        Self {
            centroidal: Centroidal::new(robot),
            derivatives: CentroidalDerivatives::new(robot),
            com: CenterOfMass::new(robot),
            six: DMatrix::repeat(6, nv, f64::NAN),
            chained: DMatrix::repeat(6, nv, f64::NAN),
            square: DMatrix::repeat(nv, nv, f64::NAN),
            transposed: DMatrix::repeat(nv, nv, f64::NAN),
            force_by_q: Matrix3xX::repeat(nv, f64::NAN),
            by_v: vec![f64::NAN; nv],
            by_v_chained: vec![f64::NAN; nv],
        }
    }

    /// The six rows, scaled; velocities v_t and v_{t+1}.
    pub fn values(&mut self, at: &Context, v: &[f64], v_next: &[f64], dt: f64, out: &mut [f64]) {
        let mut rows = Vector6::zeros();
        if at.differences[1].is_some() {
            self.centroidal.compute(at.robot, at.kinematics[1]);
            rows += self.centroidal.momentum(v_next);
        }
        self.centroidal.compute(at.robot, at.kinematics[0]);
        rows -= self.centroidal.momentum(v);
        rows -= rate(at, &self.centroidal.com()) * dt;
        for r in 0..6 {
            out[r] = rows[r] / at.scale[r];
        }
    }

    /// Rows 0 … 5 of the Jacobian of the equations of motion, and the Hessian of yᵀ rows: what is of node t goes to `chain`,
    /// the rest to `out`. `y` are the multipliers of the element's rows.
    pub fn derivatives(
        &mut self,
        at: &Context,
        y: &[f64],
        chain: &mut Chain,
        jacobian: &mut [f64],
        out: &mut ElementData,
    ) {
        let y = Vector6::from_fn(|r, _| y[r] / at.scale[r]);
        let nv = chain.qq.nrows();
        for column in jacobian.chunks_exact_mut(nv) {
            column[..6].fill(0.0);
        }
        self.here(at, &y, chain, jacobian);
        self.rate(at, &y, chain, jacobian, out);
        self.next(at, &y, chain, jacobian, out);
    }

    /// −h(q_t, v_t).
    fn here(&mut self, at: &Context, y: &Vector6<f64>, chain: &mut Chain, jacobian: &mut [f64]) {
        let Some(difference) = at.differences[0] else {
            return;
        };
        let robot_nv = at.robot.nv;
        let (v, dt, steps) = (&chain.motion.v, chain.motion.dt, chain.motion.steps);
        self.derivatives.compute(at.robot, at.kinematics[0], v);
        self.derivatives.compute_hessian(at.robot, y);
        let by_dt = self.speed_of_change(v) / -dt;
        let (firsts, nv) = ([at.layout.a, at.layout.b], chain.qq.nrows());
        self.add_rows(at, firsts, difference, -1.0, dt, jacobian);
        if let Some(time) = at.layout.time {
            add_column(at, time, &(by_dt * (-1.0 / steps)), nv, jacobian);
        }
        let mut qq = chain.qq.view_mut((0, 0), (robot_nv, robot_nv));
        qq -= self.derivatives.hessian_qq();
        let mut qv = chain.qv.view_mut((0, 0), (robot_nv, robot_nv));
        qv -= self.derivatives.hessian_qv();
        for (i, column) in self.derivatives.dh_dv().column_iter().enumerate() {
            chain.by_v_gradient[i] -= column.dot(y);
        }
    }

    /// −dt · (weight and wrenches about the centre of mass at node t).
    #[allow(clippy::too_many_lines)] // by the wrench, by increments of a, by the centre of mass: one derivation
    fn rate(
        &mut self,
        at: &Context,
        y: &Vector6<f64>,
        chain: &mut Chain,
        jacobian: &mut [f64],
        out: &mut ElementData,
    ) {
        let nv = chain.qq.nrows();
        let n = out.gradient.len();
        let (dt, steps) = (chain.motion.dt, chain.motion.steps);
        let (y_lin, y_ang) = (linear(y), angular(y));
        let (com, com_by_q) = self.com.compute(at.robot, at.kinematics[0]);
        if let Some(time) = at.layout.time {
            add_column(at, time, &(rate(at, &com) * (-1.0 / steps)), nv, jacobian);
        }
        self.force_by_q.fill(0.0);
        self.six.fill(0.0);
        let mut force = Vector3::zeros();
        for push in at.pushes() {
            let x = &push.relative.b_from_a;
            let (rot, arm) = (x.rotation(), x.origin() - com);
            let (f, k) = (linear(&push.wrench), angular(&push.wrench));
            force += rot * f;
            let z = stack(
                &rot.tr_mul(&(y_lin + y_ang.cross(&arm))),
                &rot.tr_mul(&y_ang),
            );
            // By the wrench.
            for i in 0..push.n {
                let column = push.first + i;
                let unit = Vector3::ith(i % 3, push.scale[i]);
                let by_wrench = if i < 3 {
                    stack(&(rot * unit), &arm.cross(&(rot * unit)))
                } else {
                    stack(&Vector3::zeros(), &(rot * unit))
                };
                add_column(at, column, &(by_wrench * -dt), nv, jacobian);
                if let Some(time) = at.layout.time {
                    out.hessian[column * n + time] -= z[i] * push.scale[i] / steps;
                }
                if let (Some(first), true) = (at.layout.a, i < 3) {
                    let turned = y_ang.cross(&(rot * unit));
                    for (l, by_q) in com_by_q.column_iter().enumerate() {
                        out.hessian[column * n + first + l] -= dt * turned.dot(&by_q);
                    }
                }
            }
            // By increments of a.
            for (&col, j) in push.frame.cols.iter().zip(&push.relative.columns) {
                let (rho, omega) = (linear(j), angular(j));
                let df = rot * omega.cross(&f);
                let moment = (rot * rho).cross(&(rot * f)) + arm.cross(&df) + rot * omega.cross(&k);
                let mut column = self.six.column_mut(col);
                column += stack(&df, &moment);
                let mut column = self.force_by_q.column_mut(col);
                column += df;
                if let Some(first) = at.layout.a {
                    let mixed = bracket(&z, j);
                    for i in 0..push.n {
                        out.hessian[(push.first + i) * n + first + col] -=
                            dt * mixed[i] * push.scale[i];
                    }
                }
            }
            let gradient = bracket_transpose(&z, &push.wrench);
            let qq = &mut chain.qq;
            push.frame.pose_hessian(
                push.relative,
                &gradient,
                &coadjoint_hessian(&push.wrench, &z),
                |k, l, value| {
                    let (k, l) = (push.frame.cols[k], push.frame.cols[l]);
                    qq[(k, l)] -= dt * value;
                    if k != l {
                        qq[(l, k)] -= dt * value;
                    }
                },
            );
        }
        // By the centre of mass, with (∂c/∂q_l × y_ang)·∂f/∂q_k at (l, k) and at (k, l).
        for (l, by_q) in com_by_q.column_iter().enumerate() {
            let moment = force.cross(&by_q);
            let mut column = self.six.column_mut(l);
            column += stack(&Vector3::zeros(), &moment);
        }
        let columns = chain.qq.as_mut_slice().chunks_exact_mut(nv);
        for (l, (column, force_by_l)) in columns.zip(self.force_by_q.column_iter()).enumerate() {
            let turned = y_ang.cross(&force_by_l) * dt;
            for (q, by_k) in column.iter_mut().zip(com_by_q.column_iter()) {
                *q -= by_k.dot(&turned);
            }
            if l < at.robot.nv {
                let turned = com_by_q.column(l).cross(&y_ang) * dt;
                for (q, by_k) in column.iter_mut().zip(self.force_by_q.column_iter()) {
                    *q -= turned.dot(&by_k);
                }
            }
        }
        let hessian = self
            .com
            .hessian(at.robot, at.kinematics[0], &y_ang.cross(&force));
        let columns = chain.qq.as_mut_slice().chunks_exact_mut(nv);
        for (column, by_l) in columns.zip(hessian.as_slice().chunks_exact(at.robot.nv)) {
            for (q, h) in column.iter_mut().zip(by_l) {
                *q -= dt * h;
            }
        }
        if let Some(first) = at.layout.a {
            for (l, column) in self.six.column_iter().enumerate() {
                let column = column.fixed_rows::<6>(0).into_owned();
                add_column(at, first + l, &(column * -dt), nv, jacobian);
                if let Some(time) = at.layout.time {
                    out.hessian[(first + l) * n + time] -= column.dot(y) / steps;
                }
            }
        }
    }

    /// h(q_{t+1}, v_{t+1}), with v⁺ = (C ⊖ B)/dt⁺.
    fn next(
        &mut self,
        at: &Context,
        y: &Vector6<f64>,
        chain: &Chain,
        jacobian: &mut [f64],
        out: &mut ElementData,
    ) {
        let Some(difference) = at.differences[1] else {
            return;
        };
        let nv = chain.qq.nrows();
        let n = out.gradient.len();
        let robot_nv = at.robot.nv;
        let (v, dt, steps) = (
            &chain.motion.v_next,
            chain.motion.dt_next,
            chain.motion.steps_next,
        );
        self.derivatives.compute(at.robot, at.kinematics[1], v);
        self.derivatives.compute_hessian(at.robot, y);
        let firsts = [at.layout.b, at.layout.c];
        self.add_rows(at, firsts, difference, 1.0, dt, jacobian);
        self.by_v.fill(0.0);
        for (g, column) in self
            .by_v
            .iter_mut()
            .zip(self.derivatives.dh_dv().column_iter())
        {
            *g = column.dot(y) / dt;
        }
        let [b, c] = firsts;
        let (qq, qv) = (self.derivatives.hessian_qq(), self.derivatives.hessian_qv());
        if let Some(b) = b {
            by_speeds(&mut self.square, qv, difference, End::A);
            self.square.transpose_to(&mut self.transposed);
            for l in 0..nv {
                let column = &mut out.hessian[(b + l) * n + b..(b + l) * n + b + nv];
                let (square, transposed) = (self.square.column(l), self.transposed.column(l));
                let mixed = square.iter().zip(&transposed);
                for (h, (x, y)) in column.iter_mut().zip(mixed).skip(l) {
                    *h -= (x + y) / dt;
                }
                if l < robot_nv {
                    for (h, x) in column.iter_mut().zip(&qq.column(l)).skip(l) {
                        *h += x;
                    }
                }
            }
            if let Some(c) = c {
                by_speeds(&mut self.square, qv, difference, End::B);
                self.square.transpose_to(&mut self.transposed);
                for l in 0..nv {
                    let column = &mut out.hessian[(b + l) * n + c..(b + l) * n + c + nv];
                    for (h, x) in column.iter_mut().zip(&self.transposed.column(l)) {
                        *h += x / dt;
                    }
                }
            }
        }
        difference.curvature(&self.by_v, |block_row, i, block_col, j, value| {
            if let (Some(r), Some(c)) = (firsts[block_row], firsts[block_col]) {
                let (row, col) = (r + i, c + j);
                out.hessian[row.min(col) * n + row.max(col)] += value;
            }
        });
        // By the duration.
        let Some(time) = at.layout.time_next else {
            return;
        };
        let by_dt = self.speed_of_change(v) / -dt;
        add_column(at, time, &(by_dt / steps), nv, jacobian);
        for (end, first) in ENDS.into_iter().zip(firsts) {
            let Some(first) = first else { continue };
            self.by_v_chained.copy_from_slice(&self.by_v);
            difference.recombine(&mut self.by_v_chained, end);
            for (l, chained) in self.by_v_chained.iter().enumerate() {
                let mut value = end.sign() * chained / dt;
                if end == End::A && l < robot_nv {
                    value += (0..robot_nv).map(|k| qv[(l, k)] * v[k]).sum::<f64>() / dt;
                }
                out.hessian[(first + l) * n + time] -= value / steps;
            }
        }
        let twice: f64 = self.by_v.iter().zip(v).map(|(g, v)| 2.0 * g * v).sum();
        out.hessian[time * n + time] += twice / (dt * steps * steps);
    }

    /// A v of the last derivatives.
    fn speed_of_change(&self, v: &[f64]) -> Vector6<f64> {
        self.derivatives
            .dh_dv()
            .column_iter()
            .zip(v)
            .map(|(column, rate)| column * *rate)
            .sum()
    }

    /// Adds sign · ∂h/∂(first node, second node) with v = ξ/dt.
    fn add_rows(
        &mut self,
        at: &Context,
        firsts: [Option<usize>; 2],
        difference: &Difference,
        sign: f64,
        dt: f64,
        jacobian: &mut [f64],
    ) {
        let nv = self.six.ncols();
        let robot_nv = at.robot.nv;
        for (end, first) in ENDS.into_iter().zip(firsts) {
            let Some(first) = first else { continue };
            self.chained.fill(0.0);
            self.chained
                .columns_mut(0, robot_nv)
                .copy_from(self.derivatives.dh_dv());
            difference.recombine_columns(&mut self.chained, end);
            for l in 0..robot_nv {
                let mut column = self.chained.fixed_view::<6, 1>(0, l) * (end.sign() / dt);
                if end == End::A {
                    column += self.derivatives.dh_dq().column(l);
                }
                add_column(at, first + l, &(column * sign), nv, jacobian);
            }
        }
    }
}

/// ∂²/∂q∂v of the robot chained from v to increments of one end, up to sign and dt; zero beyond the robot.
fn by_speeds(out: &mut DMatrix<f64>, qv: &DMatrix<f64>, difference: &Difference, end: End) {
    out.fill(0.0);
    out.view_mut((0, 0), qv.shape()).copy_from(qv);
    difference.recombine_columns(out, end);
}

/// Force and moment about the centre of mass on the robot, world axes.
fn rate(at: &Context, com: &Vector3<f64>) -> Vector6<f64> {
    let mut sum = stack(&at.weight, &Vector3::zeros());
    for push in at.pushes() {
        let x = &push.relative.b_from_a;
        let force = x.rotation() * linear(&push.wrench);
        let moment = x.rotation() * angular(&push.wrench);
        sum += stack(&force, &((x.origin() - com).cross(&force) + moment));
    }
    sum
}

/// Hessian of ξ ↦ λᵀ Ad(exp(−ξ)) z: the symmetric part of λᵀ[ξ, [ξ, z]].
fn coadjoint_hessian(wrench: &Vector6<f64>, z: &Vector6<f64>) -> Matrix6<f64> {
    let (mut m, mut n) = (Matrix6::zeros(), Matrix6::zeros());
    for i in 0..6 {
        let unit = Vector6::ith(i, 1.0);
        m.set_column(i, &bracket_transpose(&unit, wrench));
        n.set_column(i, &bracket(&unit, z));
    }
    let product = m.tr_mul(&n);
    (product + product.transpose()) * 0.5
}

/// Adds a column of the unscaled rows to a column-major Jacobian with `nv` rows.
fn add_column(at: &Context, column: usize, x: &Vector6<f64>, nv: usize, jacobian: &mut [f64]) {
    let out = &mut jacobian[column * nv..column * nv + 6];
    for r in 0..6 {
        out[r] += x[r] / at.scale[r];
    }
}

fn linear(x: &Vector6<f64>) -> Vector3<f64> {
    Vector3::new(x[0], x[1], x[2])
}

fn angular(x: &Vector6<f64>) -> Vector3<f64> {
    Vector3::new(x[3], x[4], x[5])
}

fn stack(linear: &Vector3<f64>, angular: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(
        linear.x, linear.y, linear.z, angular.x, angular.y, angular.z,
    )
}
