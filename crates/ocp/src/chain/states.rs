//! Chain rule from (q, v, a) of one interval to (q, v, v⁺, T), where node velocities are unknowns: a = (v⁺ − v)/dt,
//! dt = T/steps.
//!
//! With H the Hessian of the Lagrangian by (q, v, a), its blocks by (q, v, v⁺) are Hqq, Hqv − Hqa/dt, Hqa/dt,
//! Hvv + da/dt², −da/dt², da/dt². Derivatives by dt go through ∂a/∂dt = −a/dt.

use super::{Chain, Motion};
use crate::program::Interval;
use multibody::RneaHessian;
use nalgebra::DMatrix;

/// Local offsets of an element's variables; `None` for what is fixed.
#[derive(Debug, Clone, Copy)]
pub struct StateLayout {
    /// q of node t.
    pub q: Option<usize>,
    /// v of node t.
    pub v: Option<usize>,
    /// v of node t+1.
    pub v_next: Option<usize>,
    /// Duration of the phase.
    pub time: usize,
}

impl StateLayout {
    /// Of an interval; `None` if it has no duration.
    pub fn of(interval: &Interval) -> Option<Self> {
        Some(Self {
            q: interval.a,
            v: interval.velocity,
            v_next: interval.velocity_next,
            time: interval.time?,
        })
    }
}

impl Chain {
    /// Writes the columns q, v, v⁺, T of the rows F/scale into a column-major Jacobian with `nv` rows.
    pub fn state_rows(
        &self,
        dynamics: &RneaHessian,
        layout: &StateLayout,
        scale: &[f64],
        jacobian: &mut [f64],
    ) {
        let (by_v, mass) = (dynamics.dtau_dv(), dynamics.dtau_da());
        let Motion { a, dt, steps, .. } = &self.motion;
        let (dt, nv) = (*dt, a.len());
        let mut write = |first: Option<usize>, value: &dyn Fn(usize, usize) -> f64| {
            let Some(first) = first else { return };
            for c in 0..nv {
                let out = &mut jacobian[(first + c) * nv..(first + c + 1) * nv];
                for (r, o) in out.iter_mut().enumerate() {
                    *o = value(r, c) / scale[r];
                }
            }
        };
        write(layout.q, &|r, c| self.by_q[(r, c)]);
        write(layout.v, &|r, c| by_v[(r, c)] - mass[(r, c)] / dt);
        write(layout.v_next, &|r, c| mass[(r, c)] / dt);
        let column = &mut jacobian[layout.time * nv..(layout.time + 1) * nv];
        for (r, o) in column.iter_mut().enumerate() {
            let by_dt: f64 = (0..nv).map(|k| -mass[(r, k)] * a[k] / dt).sum();
            *o = by_dt / (steps * scale[r]);
        }
    }

    /// Adds the cost gradient and the Hessian of the Lagrangian to the element; `dynamics` as given to [`Chain::start`], if it was.
    pub fn state_finish(
        &mut self,
        dynamics: Option<&RneaHessian>,
        layout: &StateLayout,
        gradient: &mut [f64],
        hessian: &mut [f64],
    ) {
        let n = gradient.len();
        let Motion { a, dt, steps, .. } = &self.motion;
        let (dt, steps, nv) = (*dt, *steps, a.len());
        let StateLayout { q, v, v_next, time } = *layout;
        for i in 0..nv {
            let by_a = self.cost_a[i] / dt;
            if let Some(v) = v {
                gradient[v + i] += self.cost_v[i] - by_a;
            }
            if let Some(v_next) = v_next {
                gradient[v_next + i] += by_a;
            }
            gradient[time] -= by_a * a[i] / steps;
        }
        let mut add = |row: usize, col: usize, value: f64| {
            hessian[row.min(col) * n + row.max(col)] += value;
        };
        let mut lower = |first: Option<usize>, m: &DMatrix<f64>| {
            let Some(first) = first else { return };
            for c in 0..nv {
                for r in c..nv {
                    add(first + r, first + c, m[(r, c)]);
                }
            }
        };
        if let Some(dynamics) = dynamics {
            lower(q, &self.qq);
            lower(v, dynamics.hessian_vv());
        }
        for i in 0..nv {
            let curvature = self.da[i] / (dt * dt);
            if let Some(v) = v {
                add(v + i, v + i, self.dv[i] + curvature);
            }
            if let Some(v_next) = v_next {
                add(v_next + i, v_next + i, curvature);
            }
            if let (Some(v), Some(v_next)) = (v, v_next) {
                add(v + i, v_next + i, -curvature);
            }
            // By dt.
            let by_dt = (self.by_a_gradient[i] + self.da[i] * a[i]) / (dt * dt * steps);
            if let Some(v) = v {
                add(v + i, time, by_dt);
            }
            if let Some(v_next) = v_next {
                add(v_next + i, time, -by_dt);
            }
            let twice = (2.0 * self.by_a_gradient[i] + self.da[i] * a[i]) * a[i];
            add(time, time, twice / (dt * dt * steps * steps));
        }
        let (Some(q), Some(dynamics)) = (q, dynamics) else {
            return;
        };
        let qa = dynamics.hessian_qa();
        for c in 0..nv {
            for r in 0..nv {
                let by_a = qa[(r, c)] / dt;
                if let Some(v) = v {
                    add(q + r, v + c, self.qv[(r, c)] - by_a);
                }
                if let Some(v_next) = v_next {
                    add(q + r, v_next + c, by_a);
                }
                add(q + r, time, -by_a * a[c] / steps);
            }
        }
    }
}
