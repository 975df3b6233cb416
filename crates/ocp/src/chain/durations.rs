//! Rows and columns of the two durations, dt = T/steps and dt⁺ = T⁺/steps⁺.

use super::link::Link;
use super::vectors::Vectors;
use super::{Chain, Layout, Motion};
use multibody::RneaHessian;
use nalgebra::DMatrix;

impl Chain {
    /// Cost gradient and Hessian by the durations; `vectors` hold the gradients by v and v⁺ and the diagonals.
    #[allow(clippy::too_many_lines)] // one expression or layout, written down in its own order
    pub(super) fn durations(
        &mut self,
        dynamics: Option<&RneaHessian>,
        links: &[Option<Link>; 4],
        layout: &Layout,
        time: usize,
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
        } = &self.motion;
        let nv = v.len();
        let ga = &self.by_a_gradient;
        let Vectors {
            gv,
            gp,
            cv,
            cp,
            vv,
            pp,
            vd,
            pd,
            q_dt,
            v_dt,
            p_dt,
            q_next,
            v_next: v_by_next,
            p_next: p_by_next,
            chained,
            ..
        } = &mut self.vectors;
        let mut by_dt = (0.0, 0.0);
        for i in 0..nv {
            by_dt.0 -= cv[i] * v[i] + self.cost_a[i] * a[i];
            by_dt.1 -= cp[i] * v_next[i];
            vd[i] = -v[i] / dt;
            pd[i] = -v_next[i] / dt_next;
            v_dt[i] = vv[i] * vd[i];
        }
        gradient[time] += by_dt.0 / (dt * steps);
        if let Some(time_next) = layout.time_next {
            gradient[time_next] += by_dt.1 / (dt_next * steps_next);
        }
        // Hessian times ∂v/∂dt = −v/dt, by rows q, v, v⁺; and the direct terms of dt: a changes by −a/dt at fixed v, v⁺.
        for sum in [&mut *q_dt, p_dt, q_next] {
            sum.fill(0.0);
        }
        if let Some(dynamics) = dynamics {
            multiply_add(&self.qv, vd, 1.0, q_dt);
            multiply_add(dynamics.hessian_qa(), vd, -1.0 / dt, q_dt);
            multiply_add(dynamics.hessian_qa(), a, -1.0 / dt, q_dt);
            multiply_add(dynamics.hessian_qa(), pd, 1.0 / dt, q_next);
            multiply_add(dynamics.hessian_vv(), vd, 1.0, v_dt);
        }
        let (mut dt_dt, mut dt_next_dt, mut next_next) = (0.0, 0.0, 0.0);
        for i in 0..nv {
            let direct = pp[i] * a[i] + ga[i] / (dt * dt);
            dt_dt += 2.0 * direct * vd[i] + pp[i] * a[i] * a[i] + 2.0 * ga[i] * a[i] / (dt * dt);
            dt_dt += vd[i] * v_dt[i] + 2.0 * gv[i] * v[i] / (dt * dt);
            v_dt[i] += direct - gv[i] / dt;
            p_dt[i] += -direct - pp[i] * vd[i];
            v_by_next[i] = -pp[i] * pd[i];
            p_by_next[i] = pp[i] * pd[i] - gp[i] / dt_next;
            dt_next_dt += p_dt[i] * pd[i];
            next_next += pp[i] * pd[i] * pd[i] + 2.0 * gp[i] * v_next[i] / (dt_next * dt_next);
        }
        let mut column = |time: usize, steps: f64, by: [&[f64]; 3]| {
            if let Some(first) = layout.a {
                for (i, x) in by[0].iter().enumerate() {
                    hessian[(first + i) * n + time] += x / steps;
                }
            }
            for link in links.iter().flatten() {
                chained.copy_from_slice(by[if link.next { 2 } else { 1 }]);
                link.difference.recombine(chained, link.end);
                for (i, x) in chained.iter().enumerate() {
                    hessian[(link.first + i) * n + time] += link.slope / steps * x;
                }
            }
        };
        column(time, *steps, [q_dt, v_dt, p_dt]);
        if let Some(time_next) = layout.time_next {
            column(time_next, *steps_next, [q_next, v_by_next, p_by_next]);
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

/// `out += s · m x`.
fn multiply_add(m: &DMatrix<f64>, x: &[f64], s: f64, out: &mut [f64]) {
    for (column, x) in m.as_slice().chunks_exact(m.nrows()).zip(x) {
        let factor = s * x;
        for (o, m) in out.iter_mut().zip(column) {
            *o += factor * m;
        }
    }
}
