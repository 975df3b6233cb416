//! Chain rule from (q, v, a) of one interval to its node variables A, B, C and durations T, T⁺.
//!
//! With v = (B ⊖ A)/dt, v⁺ = (C ⊖ B)/dt⁺, a = (v⁺ − v)/dt, dt = T/steps. The Hessian goes in two steps: from (q, v, a)
//! to (q, v, v⁺, dt), where a = (v⁺ − v)/dt is rational, then to (A, B, C, T, T⁺), where the differences of floating
//! bodies have curvature of their own ([`Difference::curvature`]).
//!
//! Legend: `qq, qv, vv, qa` blocks of the Hessian of wᵀ ID(q, v, a) (∂²/∂v∂a and ∂²/∂a² vanish), `dv`, `da` the diagonal
//! Hessians of the velocity and acceleration costs, `gv`, `ga` gradients of the Lagrangian by v and a.

mod durations;
mod hessian;
mod link;
mod states;
mod vectors;

use crate::difference::{Difference, End};
use crate::program::Interval;
use multibody::RneaHessian;
use nalgebra::DMatrix;
pub use states::StateLayout;
use vectors::Vectors;

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
    /// Hessian block by q and q, wrenches included.
    pub qq: DMatrix<f64>,
    /// Hessian block by q and v.
    pub qv: DMatrix<f64>,
    /// Gradient of the Lagrangian by v.
    pub by_v_gradient: Vec<f64>,
    by_a_gradient: Vec<f64>,
    cost_v: Vec<f64>,
    cost_a: Vec<f64>,
    dv: Vec<f64>,
    da: Vec<f64>,
    work: [DMatrix<f64>; 4],
    vectors: Vectors,
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
            qq: m(),
            qv: m(),
            by_v_gradient: v(),
            by_a_gradient: v(),
            cost_v: v(),
            cost_a: v(),
            dv: v(),
            da: v(),
            work: [m(), m(), m(), m()],
            vectors: Vectors::new(nv),
        }
    }

    /// Takes those derivatives of the inverse dynamics to which others add.
    pub fn start(&mut self, dynamics: &RneaHessian) {
        self.by_q.copy_from(dynamics.dtau_dq());
        self.qq.copy_from(dynamics.hessian_qq());
        self.qv.copy_from(dynamics.hessian_qv());
        self.by_v_gradient.copy_from_slice(dynamics.gradient_v());
        self.by_a_gradient.copy_from_slice(dynamics.gradient_a());
    }

    /// No equations of motion: only costs of v.
    pub fn start_empty(&mut self) {
        self.by_v_gradient.fill(0.0);
        self.by_a_gradient.fill(0.0);
    }

    /// Writes the columns A, B, C, T, T⁺ of the rows F/scale into a column-major Jacobian with `nv` rows.
    pub fn rows(
        &mut self,
        dynamics: &RneaHessian,
        here: Option<&Difference>,
        next: Option<&Difference>,
        layout: &Layout,
        scale: &[f64],
        jacobian: &mut [f64],
    ) {
        let nv = scale.len();
        let Motion { dt, dt_next, .. } = self.motion;
        // F by A ⊖ B and by C ⊖ B, up to the blocks of floating bodies: (Fv − M/dt)/dt and M/(dt dt⁺).
        let [by_here, by_next, to_a, to_b] = &mut self.work;
        by_here.copy_from(dynamics.dtau_dv());
        by_here.zip_apply(dynamics.dtau_da(), |x, m| *x = (*x - m / dt) / dt);
        by_next.copy_from(dynamics.dtau_da());
        *by_next /= dt * dt_next;
        let inverse_scale = &mut self.vectors.inverse_scale;
        for (inverse, scale) in inverse_scale.iter_mut().zip(scale) {
            *inverse = 1.0 / scale;
        }
        let mut write = |first: usize, m: &DMatrix<f64>| {
            let out = jacobian[first * nv..(first + nv) * nv].chunks_exact_mut(nv);
            for (out, column) in out.zip(m.as_slice().chunks_exact(nv)) {
                for ((o, x), s) in out.iter_mut().zip(column).zip(&*inverse_scale) {
                    *o = x * s;
                }
            }
        };
        if let Some(first) = layout.a {
            to_a.copy_from(&self.by_q);
            if let Some(difference) = here {
                to_b.copy_from(by_here);
                difference.recombine_columns(to_b, End::A);
                *to_a -= &*to_b;
            }
            write(first, to_a);
        }
        if let Some(first) = layout.b {
            to_b.fill(0.0);
            if let Some(difference) = here {
                to_b.copy_from(by_here);
                difference.recombine_columns(to_b, End::B);
            }
            if let Some(difference) = next {
                to_a.copy_from(by_next);
                difference.recombine_columns(to_a, End::A);
                *to_b -= &*to_a;
            }
            write(first, to_b);
        }
        if let (Some(first), Some(difference)) = (layout.c, next) {
            to_a.copy_from(by_next);
            difference.recombine_columns(to_a, End::B);
            write(first, to_a);
        }
        self.duration_columns(layout, jacobian);
    }

    /// The columns T and T⁺ of [`Chain::rows`].
    fn duration_columns(&self, layout: &Layout, jacobian: &mut [f64]) {
        let Some(time) = layout.time else { return };
        let Motion {
            v,
            v_next,
            a,
            dt_next,
            steps,
            steps_next,
            ..
        } = &self.motion;
        let (nv, scale) = (v.len(), &self.vectors.inverse_scale);
        for column in [Some(time), layout.time_next].into_iter().flatten() {
            jacobian[column * nv..(column + 1) * nv].fill(0.0);
        }
        let mut subtract = |column: usize, m: &DMatrix<f64>, x: &[f64], s: f64| {
            let out = &mut jacobian[column * nv..(column + 1) * nv];
            for (column, x) in m.as_slice().chunks_exact(nv).zip(x) {
                let factor = s * x;
                for ((o, m), scale) in out.iter_mut().zip(column).zip(scale) {
                    *o -= factor * m * scale;
                }
            }
        };
        let [by_here, by_next, ..] = &self.work;
        subtract(time, by_here, v, 1.0 / steps);
        subtract(time, by_next, a, dt_next / steps);
        if let Some(time_next) = layout.time_next {
            subtract(time_next, by_next, v_next, 1.0 / steps_next);
        }
    }

    /// Adds the quadratic costs of v and (with dynamics) a, their weights times `share`.
    pub fn add_costs(&mut self, weights: &[(f64, f64)], share: f64, dynamics: bool) {
        for (i, &(wv, wa)) in weights.iter().enumerate() {
            let (wv, wa) = (share * wv, if dynamics { share * wa } else { 0.0 });
            self.cost_v[i] = wv * self.motion.v[i];
            self.cost_a[i] = wa * self.motion.a[i];
            self.dv[i] = wv;
            self.da[i] = wa;
            self.by_v_gradient[i] += self.cost_v[i];
            self.by_a_gradient[i] += self.cost_a[i];
        }
    }
}
