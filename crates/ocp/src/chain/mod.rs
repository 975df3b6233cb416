//! Chain rule from (q, v, a) of one interval to its node variables A, B, C and durations T, T⁺.
//!
//! With v = (B ⊖ A)/dt, v⁺ = (C ⊖ B)/dt⁺, a = (v⁺ − v)/dt, dt = T/steps. The Hessian goes in two steps: from (q, v, a)
//! to (q, v, v⁺, dt), where a = (v⁺ − v)/dt is rational, then to (A, B, C, T, T⁺), where the differences of floating
//! bodies have curvature of their own ([`Difference::curvature`]).
//!
//! Legend: `qq, qv, vv, qa` blocks of the Hessian of wᵀ ID(q, v, a) (∂²/∂v∂a and ∂²/∂a² vanish), `da` the diagonal
//! Hessian of the acceleration cost, `gv`, `ga` gradients of the Lagrangian by v and a.

mod hessian;
mod states;
mod vectors;

use crate::difference::Difference;
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
    vectors: Vectors,
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
            vectors: Vectors::new(nv),
            dynamics: false,
        }
    }

    /// Takes the first and second derivatives of the inverse dynamics.
    pub fn start(&mut self, dynamics: &RneaHessian) {
        self.dynamics = true;
        self.by_q.copy_from(dynamics.dtau_dq());
        self.by_v.copy_from(dynamics.dtau_dv());
        self.mass.copy_from(dynamics.dtau_da());
        self.qq.copy_from(dynamics.hessian_qq());
        self.qv.copy_from(dynamics.hessian_qv());
        self.vv.copy_from(dynamics.hessian_vv());
        self.qa.copy_from(dynamics.hessian_qa());
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

    /// Adds the quadratic costs of v and (with dynamics) a, their weights times `share`.
    pub fn add_costs(&mut self, weights: &[(f64, f64)], share: f64, dynamics: bool) {
        for (i, &(wv, wa)) in weights.iter().enumerate() {
            let (wv, wa) = (share * wv, if dynamics { share * wa } else { 0.0 });
            self.cost_v[i] = wv * self.motion.v[i];
            self.cost_a[i] = wa * self.motion.a[i];
            self.da[i] = wa;
            self.by_v_gradient[i] += self.cost_v[i];
            self.by_a_gradient[i] += self.cost_a[i];
            self.vv[(i, i)] += wv;
        }
    }
}
