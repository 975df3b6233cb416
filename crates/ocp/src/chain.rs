//! Chain rule from (q, v, a) of one interval to its node variables A, B, C and durations T, T⁺.
//!
//! With v = (B ⊖ A)/dt, v⁺ = (C ⊖ B)/dt⁺, a = (v⁺ − v)/dt, dt = T/steps. The Hessian goes in two steps: from (q, v, a)
//! to (q, v, v⁺, dt), where a = (v⁺ − v)/dt is rational, then to (A, B, C, T, T⁺), where the differences of floating
//! bodies have curvature of their own ([`Difference::curvature`]).
//!
//! Legend: `qq, qv, vv, qa` blocks of the Hessian of wᵀ ID(q, v, a) (∂²/∂v∂a and ∂²/∂a² vanish), `da` the diagonal
//! Hessian of the acceleration cost, `gv`, `ga` gradients of the Lagrangian by v and a.

use crate::difference::Difference;
use crate::program::Interval;
use multibody::{RneaDerivatives, RneaHessian};
use nalgebra::DMatrix;

/// Velocity, next velocity, acceleration and step lengths of an interval.
#[derive(Debug, Clone)]
pub struct Motion {
    /// v_t.
    pub v: Vec<f64>,
    /// v_{t+1}.
    pub v_next: Vec<f64>,
    /// a_t.
    pub a: Vec<f64>,
    /// Length of this interval [s].
    pub dt: f64,
    /// Length of the next interval [s].
    pub dt_next: f64,
    /// Intervals in this phase.
    pub steps: f64,
    /// Intervals in the phase of the next interval.
    pub steps_next: f64,
}

/// Local offsets of an element's variables.
#[derive(Debug, Clone, Copy)]
pub struct Layout {
    /// Node t.
    pub a: Option<usize>,
    /// Node t+1.
    pub b: Option<usize>,
    /// Node t+2.
    pub c: Option<usize>,
    /// Duration of this phase.
    pub time: Option<usize>,
    /// Duration of the next interval's phase.
    pub time_next: Option<usize>,
}

impl From<&Interval> for Layout {
    fn from(i: &Interval) -> Self {
        Self {
            a: i.a,
            b: i.b,
            c: i.c,
            time: i.time,
            time_next: i.time_next,
        }
    }
}

/// Buffers of the chain rule.
pub struct Chain {
    /// The interval's motion.
    pub motion: Motion,
    /// ∂F/∂q of the generalised forces, wrenches included.
    pub by_q: DMatrix<f64>,
    by_v: DMatrix<f64>,
    mass: DMatrix<f64>,
    /// Hessian block by q and q, wrenches included.
    pub qq: DMatrix<f64>,
    /// Hessian block by q and v.
    pub qv: DMatrix<f64>,
    vv: DMatrix<f64>,
    qa: DMatrix<f64>,
    /// Gradient of the Lagrangian by v.
    pub by_v_gradient: Vec<f64>,
    by_a_gradient: Vec<f64>,
    cost_v: Vec<f64>,
    cost_a: Vec<f64>,
    da: Vec<f64>,
    work: [DMatrix<f64>; 3],
    dynamics: bool,
}

impl Chain {
    /// Buffers for `nv` increments per node.
    pub fn new(nv: usize) -> Self {
        let m = || DMatrix::repeat(nv, nv, f64::NAN);
        let v = || vec![f64::NAN; nv];
        let motion = Motion {
            v: v(),
            v_next: v(),
            a: v(),
            dt: f64::NAN,
            dt_next: f64::NAN,
            steps: f64::NAN,
            steps_next: f64::NAN,
        };
        Self {
            motion,
            by_q: m(),
            by_v: m(),
            mass: m(),
            qq: m(),
            qv: m(),
            vv: m(),
            qa: m(),
            by_v_gradient: v(),
            by_a_gradient: v(),
            cost_v: v(),
            cost_a: v(),
            da: v(),
            work: [m(), m(), m()],
            dynamics: false,
        }
    }

    /// Takes the derivatives of the inverse dynamics.
    pub fn start(&mut self, first: &RneaDerivatives, second: &RneaHessian) {
        self.dynamics = true;
        self.by_q.copy_from(first.dtau_dq());
        self.by_v.copy_from(first.dtau_dv());
        self.mass.copy_from(first.dtau_da());
        self.qq.copy_from(second.hessian_qq());
        self.qv.copy_from(second.hessian_qv());
        self.vv.copy_from(second.hessian_vv());
        self.qa.copy_from(second.hessian_qa());
    }

    /// No equations of motion: only costs of v.
    pub fn start_empty(&mut self) {
        self.dynamics = false;
        for m in [&mut self.qq, &mut self.qv, &mut self.vv, &mut self.qa] {
            m.fill(0.0);
        }
        self.by_v_gradient.fill(0.0);
        self.by_a_gradient.fill(0.0);
    }

    /// Gradients of wᵀF by v and a.
    pub fn gradients_from_weights(&mut self, w: &[f64]) {
        let dot =
            |column: nalgebra::DVectorView<f64>| column.iter().zip(w).map(|(x, w)| x * w).sum();
        for i in 0..w.len() {
            self.by_v_gradient[i] = dot(self.by_v.column(i));
            self.by_a_gradient[i] = dot(self.mass.column(i));
        }
    }

    /// Writes the columns A, B, C, T, T⁺ of the rows F/scale into a column-major Jacobian with `nv` rows.
    pub fn rows(
        &mut self,
        here: Option<&Difference>,
        next: Option<&Difference>,
        layout: &Layout,
        scale: &[f64],
        work: &mut DMatrix<f64>,
        jacobian: &mut [f64],
    ) {
        let Motion {
            v,
            v_next,
            a,
            dt,
            dt_next,
            steps,
            steps_next,
        } = &self.motion;
        let nv = v.len();
        let mut write = |first: usize, m: &DMatrix<f64>| {
            for (c, column) in m.column_iter().enumerate() {
                let out = &mut jacobian[(first + c) * nv..(first + c + 1) * nv];
                for ((o, x), s) in out.iter_mut().zip(column.iter()).zip(scale) {
                    *o = x / s;
                }
            }
        };
        // by v at fixed v⁺: Fv − M/dt
        let [by_velocity, chained, _] = &mut self.work;
        by_velocity.copy_from(&self.by_v);
        by_velocity.zip_apply(&self.mass, |x, m| *x -= m / dt);
        if let Some(first) = layout.a {
            work.copy_from(&self.by_q);
            if let Some(difference) = here {
                chained.copy_from(by_velocity);
                difference.chain_columns(chained, false);
                work.zip_apply(chained, |x, y| *x += y / dt);
            }
            write(first, work);
        }
        if let Some(first) = layout.b {
            work.fill(0.0);
            if let Some(difference) = here {
                chained.copy_from(by_velocity);
                difference.chain_columns(chained, true);
                work.zip_apply(chained, |x, y| *x += y / dt);
            }
            if let Some(difference) = next {
                chained.copy_from(&self.mass);
                difference.chain_columns(chained, false);
                work.zip_apply(chained, |x, y| *x += y / (dt * dt_next));
            }
            write(first, work);
        }
        if let (Some(first), Some(difference)) = (layout.c, next) {
            work.copy_from(&self.mass);
            difference.chain_columns(work, true);
            *work /= dt * dt_next;
            write(first, work);
        }
        let Some(time) = layout.time else { return };
        for column in [Some(time), layout.time_next].into_iter().flatten() {
            jacobian[column * nv..(column + 1) * nv].fill(0.0);
        }
        for i in 0..nv {
            let (mut by_dt, mut by_dt_next) = (0.0, 0.0);
            for k in 0..nv {
                by_dt -= by_velocity[(i, k)] * v[k] + self.mass[(i, k)] * a[k];
                by_dt_next -= self.mass[(i, k)] * v_next[k];
            }
            jacobian[time * nv + i] += by_dt / (dt * steps * scale[i]);
            if let Some(time_next) = layout.time_next {
                jacobian[time_next * nv + i] += by_dt_next / (dt * dt_next * steps_next * scale[i]);
            }
        }
    }

    /// Adds the quadratic costs of v and (with dynamics) a.
    pub fn add_costs(&mut self, weights: &[(f64, f64)], dynamics: bool) {
        for (i, &(wv, wa)) in weights.iter().enumerate() {
            let wa = if dynamics { wa } else { 0.0 };
            self.cost_v[i] = wv * self.motion.v[i];
            self.cost_a[i] = wa * self.motion.a[i];
            self.da[i] = wa;
            self.by_v_gradient[i] += self.cost_v[i];
            self.by_a_gradient[i] += self.cost_a[i];
            self.vv[(i, i)] += wv;
        }
    }

    /// Adds the cost gradient and the Hessian of the Lagrangian to the element.
    #[allow(clippy::too_many_lines)] // one block of the derivation after the other, as in the module's text
    pub fn finish(
        &mut self,
        here: Option<&Difference>,
        next: Option<&Difference>,
        layout: &Layout,
        gradient: &mut [f64],
        hessian: &mut [f64],
    ) {
        let n = gradient.len();
        let Motion {
            v,
            v_next,
            a,
            dt,
            dt_next,
            steps,
            steps_next,
        } = self.motion.clone();
        let nv = v.len();
        let (da, ga) = (self.da.clone(), self.by_a_gradient.clone());
        let gv: Vec<f64> = (0..nv)
            .map(|i| self.by_v_gradient[i] - ga[i] / dt)
            .collect();
        let gp: Vec<f64> = ga.iter().map(|g| g / dt).collect();

        // Cost gradient.
        let cv: Vec<f64> = (0..nv)
            .map(|i| self.cost_v[i] - self.cost_a[i] / dt)
            .collect();
        let cp: Vec<f64> = self.cost_a.iter().map(|c| c / dt).collect();
        let mut add_vector = |first: Option<usize>,
                              difference: Option<&Difference>,
                              x: &[f64],
                              by_b: bool,
                              s: f64| {
            if let (Some(first), Some(difference)) = (first, difference) {
                let mut chained = x.to_vec();
                difference.chain_vector(&mut chained, by_b);
                for i in 0..nv {
                    gradient[first + i] += s * chained[i];
                }
            }
        };
        add_vector(layout.a, here, &cv, false, 1.0 / dt);
        add_vector(layout.b, here, &cv, true, 1.0 / dt);
        add_vector(layout.b, next, &cp, false, 1.0 / dt_next);
        add_vector(layout.c, next, &cp, true, 1.0 / dt_next);
        if let Some(time) = layout.time {
            let by_dt: f64 = (0..nv).map(|i| -cv[i] * v[i] - self.cost_a[i] * a[i]).sum();
            gradient[time] += by_dt / (dt * steps);
        }
        if let Some(time) = layout.time_next {
            let by_dt: f64 = (0..nv).map(|i| -cp[i] * v_next[i]).sum();
            gradient[time] += by_dt / (dt_next * steps_next);
        }

        // (q, v, a) → (q, v, v⁺): Hqv − Hqa/dt, Hqa/dt, Hvv + da/dt², −da/dt², da/dt².
        let vv = &mut self.vv;
        for i in 0..nv {
            vv[(i, i)] += da[i] / (dt * dt);
        }
        let mut put = |first_row: usize, first_col: usize, m: &DMatrix<f64>, s: f64| {
            for c in 0..nv {
                for r in (if first_row == first_col { c } else { 0 })..nv {
                    hessian[(first_col + c) * n + first_row + r] += s * m[(r, c)];
                }
            }
        };
        let [qv, work, other] = &mut self.work;
        qv.copy_from(&self.qv);
        qv.zip_apply(&self.qa, |x, y| *x -= y / dt);
        if let Some(first_a) = layout.a {
            if self.dynamics {
                put(first_a, first_a, &self.qq, 1.0);
            }
            if let Some(here) = here {
                // P = Hqv V_A; E = Hvv V_A; U = Hqvᵀ + E
                work.copy_from(qv);
                here.chain_columns(work, false);
                *work /= dt;
                put(first_a, first_a, work, 1.0);
                put(first_a, first_a, &work.transpose(), 1.0);
                work.copy_from(vv);
                here.chain_columns(work, false);
                *work /= dt;
                other.copy_from(work);
                here.chain_rows(other, false);
                put(first_a, first_a, other, 1.0 / dt);
                if let Some(first_b) = layout.b {
                    for c in 0..nv {
                        for r in 0..nv {
                            work[(r, c)] += qv[(c, r)];
                        }
                    }
                    here.chain_rows(work, true);
                    put(first_b, first_a, work, 1.0 / dt);
                }
            }
            if let Some(next) = next {
                // W = Hqp ᵀ + Hpv V_A, rows v⁺, columns A
                for c in 0..nv {
                    for r in 0..nv {
                        work[(r, c)] = self.qa[(c, r)] / dt;
                    }
                }
                if let Some(here) = here {
                    other.fill(0.0);
                    for i in 0..nv {
                        other[(i, i)] = -da[i] / (dt * dt);
                    }
                    here.chain_columns(other, false);
                    work.zip_apply(other, |x, y| *x += y / dt);
                }
                if let Some(first_b) = layout.b {
                    other.copy_from(work);
                    next.chain_rows(other, false);
                    put(first_b, first_a, other, 1.0 / dt_next);
                }
                if let Some(first_c) = layout.c {
                    next.chain_rows(work, true);
                    put(first_c, first_a, work, 1.0 / dt_next);
                }
            }
        }
        if let Some(first_b) = layout.b {
            if let Some(here) = here {
                work.copy_from(vv);
                here.chain_columns(work, true);
                here.chain_rows(work, true);
                put(first_b, first_b, work, 1.0 / (dt * dt));
            }
            if let Some(next) = next {
                // Hpv V_B and Hpp V⁺_B, rows v⁺, columns B
                work.fill(0.0);
                other.fill(0.0);
                for i in 0..nv {
                    work[(i, i)] = -da[i] / (dt * dt);
                    other[(i, i)] = da[i] / (dt * dt);
                }
                next.chain_columns(other, false);
                *other /= dt_next;
                if let Some(here) = here {
                    here.chain_columns(work, true);
                    *work /= dt;
                    qv.copy_from(work);
                    next.chain_rows(qv, false);
                    *qv /= dt_next;
                    put(first_b, first_b, qv, 1.0);
                    put(first_b, first_b, &qv.transpose(), 1.0);
                    if let Some(first_c) = layout.c {
                        next.chain_rows(work, true);
                        put(first_c, first_b, work, 1.0 / dt_next);
                    }
                }
                if let Some(first_c) = layout.c {
                    qv.copy_from(other);
                    next.chain_rows(qv, true);
                    put(first_c, first_b, qv, 1.0 / dt_next);
                }
                next.chain_rows(other, false);
                put(first_b, first_b, other, 1.0 / dt_next);
            }
        }
        if let (Some(first_c), Some(next)) = (layout.c, next) {
            work.fill(0.0);
            for i in 0..nv {
                work[(i, i)] = da[i] / (dt * dt);
            }
            next.chain_columns(work, true);
            next.chain_rows(work, true);
            put(first_c, first_c, work, 1.0 / (dt_next * dt_next));
        }

        // Curvature of the differences.
        if let Some(here) = here {
            let firsts = [layout.a, layout.b];
            let weights: Vec<f64> = gv.iter().map(|g| g / dt).collect();
            here.curvature(&weights, |br, i, bc, j, value| {
                add_curvature(hessian, n, firsts, (br, i), (bc, j), value);
            });
        }
        if let Some(next) = next {
            let firsts = [layout.b, layout.c];
            let weights: Vec<f64> = gp.iter().map(|g| g / dt_next).collect();
            next.curvature(&weights, |br, i, bc, j, value| {
                add_curvature(hessian, n, firsts, (br, i), (bc, j), value);
            });
        }
        let Some(time) = layout.time else { return };
        self.time_blocks(here, next, layout, time, (&gv, &gp, &ga), hessian, n);
    }

    /// Rows and columns of the two durations.
    #[allow(clippy::too_many_arguments)] // continues `finish`
    #[allow(clippy::too_many_lines)] // one expression or layout, written down in its own order
    fn time_blocks(
        &mut self,
        here: Option<&Difference>,
        next: Option<&Difference>,
        layout: &Layout,
        time: usize,
        (gv, gp, ga): (&[f64], &[f64], &[f64]),
        hessian: &mut [f64],
        n: usize,
    ) {
        let Motion {
            v,
            v_next,
            a,
            dt,
            dt_next,
            steps,
            steps_next,
        } = &self.motion;
        let nv = v.len();
        let da = &self.da;
        // Hessian times −v/dt (self.vv already holds + da/dt²), by rows q, v, v⁺; and the direct terms of dt.
        let vd: Vec<f64> = v.iter().map(|x| -x / dt).collect();
        let pd: Vec<f64> = v_next.iter().map(|x| -x / dt_next).collect();
        let mut q_dt = vec![0.0; nv];
        let mut v_dt = vec![0.0; nv];
        let mut p_dt = vec![0.0; nv];
        let mut q_next = vec![0.0; nv];
        for k in 0..nv {
            for i in 0..nv {
                let (qv, qa) = (self.qv[(i, k)] - self.qa[(i, k)] / dt, self.qa[(i, k)]);
                q_dt[i] += qv * vd[k] - qa * a[k] / dt;
                q_next[i] += qa / dt * pd[k];
                v_dt[i] += self.vv[(i, k)] * vd[k];
            }
        }
        let mut v_next_cross = vec![0.0; nv];
        let mut p_next_cross = vec![0.0; nv];
        let (mut dt_dt, mut dt_next_dt, mut next_next) = (0.0, 0.0, 0.0);
        for i in 0..nv {
            let direct = da[i] * a[i] / (dt * dt) + ga[i] / (dt * dt);
            dt_dt += 2.0 * direct * vd[i]
                + da[i] * a[i] * a[i] / (dt * dt)
                + 2.0 * ga[i] * a[i] / (dt * dt);
            dt_dt += vd[i] * v_dt[i] + 2.0 * gv[i] * v[i] / (dt * dt);
            v_dt[i] += direct - gv[i] / dt;
            p_dt[i] += -direct - da[i] / (dt * dt) * vd[i];
            v_next_cross[i] = -da[i] / (dt * dt) * pd[i];
            p_next_cross[i] = da[i] / (dt * dt) * pd[i] - gp[i] / dt_next;
            dt_next_dt += p_dt[i] * pd[i];
            next_next +=
                da[i] / (dt * dt) * pd[i] * pd[i] + 2.0 * gp[i] * v_next[i] / (dt_next * dt_next);
        }
        let mut add = |column: usize, first: Option<usize>, x: &[f64], s: f64| {
            if let Some(first) = first {
                for i in 0..nv {
                    hessian[(first + i) * n + column] += s * x[i];
                }
            }
        };
        let chained = |difference: &Difference, x: &[f64], by_b: bool| {
            let mut out = x.to_vec();
            difference.chain_vector(&mut out, by_b);
            out
        };
        add(time, layout.a, &q_dt, 1.0 / steps);
        if let Some(here) = here {
            add(
                time,
                layout.a,
                &chained(here, &v_dt, false),
                1.0 / (dt * steps),
            );
            add(
                time,
                layout.b,
                &chained(here, &v_dt, true),
                1.0 / (dt * steps),
            );
        }
        if let Some(next) = next {
            add(
                time,
                layout.b,
                &chained(next, &p_dt, false),
                1.0 / (dt_next * steps),
            );
            add(
                time,
                layout.c,
                &chained(next, &p_dt, true),
                1.0 / (dt_next * steps),
            );
        }
        if let Some(time_next) = layout.time_next {
            add(time_next, layout.a, &q_next, 1.0 / steps_next);
            if let Some(here) = here {
                add(
                    time_next,
                    layout.a,
                    &chained(here, &v_next_cross, false),
                    1.0 / (dt * steps_next),
                );
                add(
                    time_next,
                    layout.b,
                    &chained(here, &v_next_cross, true),
                    1.0 / (dt * steps_next),
                );
            }
            if let Some(next) = next {
                add(
                    time_next,
                    layout.b,
                    &chained(next, &p_next_cross, false),
                    1.0 / (dt_next * steps_next),
                );
                add(
                    time_next,
                    layout.c,
                    &chained(next, &p_next_cross, true),
                    1.0 / (dt_next * steps_next),
                );
            }
            let cross = dt_next_dt / (steps * steps_next);
            if time_next == time {
                hessian[time * n + time] += 2.0 * cross;
            } else {
                hessian[time.min(time_next) * n + time.max(time_next)] += cross;
            }
            hessian[time_next * n + time_next] += next_next / (steps_next * steps_next);
        }
        hessian[time * n + time] += dt_dt / (steps * steps);
    }
}

/// Adds one entry of a difference's curvature, where both of its nodes are variable.
fn add_curvature(
    hessian: &mut [f64],
    n: usize,
    firsts: [Option<usize>; 2],
    (block_row, i): (usize, usize),
    (block_col, j): (usize, usize),
    value: f64,
) {
    if let (Some(r), Some(c)) = (firsts[block_row], firsts[block_col]) {
        let (row, col) = (r + i, c + j);
        hessian[row.min(col) * n + row.max(col)] += value;
    }
}
