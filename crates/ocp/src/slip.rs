//! Velocity-level sticking of an interval, with v = (B ⊖ A)/dt: rows of [`crate::terms::slip_velocity`] at node t.
//!
//! Their Hessian enters the [`Chain`] as a function of (q, v); the Jacobian by A, B and the duration is chained here.

use crate::chain::{Chain, Layout};
use crate::difference::{Difference, End};
use crate::program::Slip;
use crate::relative::{Relative, RelativeFrame};
use crate::terms::slip_velocity;
use solver::ElementData;

/// A slip's relative frame and its pose at node t.
#[derive(Clone, Copy)]
pub struct Place<'a> {
    /// The frame of the contact.
    pub frame: &'a RelativeFrame,
    /// At node t.
    pub relative: &'a Relative,
}

/// Workspace of the slip rows.
pub struct Slips {
    speeds: Vec<f64>,
    by_q: Vec<f64>,
    by_v: Vec<f64>,
    chained: Vec<f64>,
}

impl Slips {
    /// Buffers for `nv` increments per node.
    pub fn new(nv: usize) -> Self {
        let buffer = || vec![f64::NAN; nv];
        Self {
            speeds: buffer(),
            by_q: buffer(),
            by_v: buffer(),
            chained: buffer(),
        }
    }

    /// Row values [m/s, rad/s].
    pub fn values(&mut self, slip: &Slip, at: Place, v: &[f64], values: &mut [f64]) {
        let n = slip_velocity::n_rows(slip.yaw);
        self.gather(at.frame, v);
        let speeds = &self.speeds[..at.frame.cols.len()];
        slip_velocity::values(
            at.relative,
            speeds,
            &mut values[slip.first_row..slip.first_row + n],
        );
    }

    /// Jacobian rows, and the Hessian for the multipliers `y` of the element's rows.
    #[allow(clippy::too_many_arguments)] // the parts of one interval; one caller
    pub fn derivatives(
        &mut self,
        slip: &Slip,
        at: Place,
        here: Option<&Difference>,
        layout: &Layout,
        y: &[f64],
        chain: &mut Chain,
        out: &mut ElementData,
    ) {
        let Some(difference) = here else { return };
        let n = slip_velocity::n_rows(slip.yaw);
        let (dt, steps) = (chain.motion.dt, chain.motion.steps);
        self.gather(at.frame, &chain.motion.v);
        let cols = &at.frame.cols;
        let speeds = &self.speeds[..cols.len()];
        let jacobian = &mut out.jacobians[slip.block];
        for r in 0..n {
            let mut unit = [0.0; 3];
            unit[r] = 1.0;
            self.by_q.fill(0.0);
            self.by_v.fill(0.0);
            let mut value = 0.0;
            slip_velocity::gradient(
                at.frame,
                at.relative,
                speeds,
                &unit[..n],
                |l, by_q, by_v| {
                    self.by_q[cols[l]] = by_q;
                    self.by_v[cols[l]] = by_v;
                    value += by_v * speeds[l];
                },
            );
            let mut column = 0;
            for (end, first) in [(End::A, layout.a), (End::B, layout.b)] {
                if first.is_none() {
                    continue;
                }
                self.chained.copy_from_slice(&self.by_v);
                difference.recombine(&mut self.chained, end);
                for &col in cols {
                    let direct = if end == End::A { self.by_q[col] } else { 0.0 };
                    jacobian[column * n + r] = direct + end.sign() * self.chained[col] / dt;
                    column += 1;
                }
            }
            if layout.time.is_some() {
                jacobian[column * n + r] = -value / (dt * steps);
            }
        }
        let weights = &y[slip.first_row..slip.first_row + n];
        slip_velocity::gradient(at.frame, at.relative, speeds, weights, |l, _, by_v| {
            chain.by_v_gradient[cols[l]] += by_v;
        });
        let (qq, qv) = (&mut chain.qq, &mut chain.qv);
        slip_velocity::hessian(
            at.frame,
            at.relative,
            speeds,
            weights,
            |k, l, value| {
                qq[(cols[k], cols[l])] += value;
                if k != l {
                    qq[(cols[l], cols[k])] += value;
                }
            },
            |l, k, value| qv[(cols[l], cols[k])] += value,
        );
    }

    fn gather(&mut self, frame: &RelativeFrame, v: &[f64]) {
        for (speed, &col) in self.speeds.iter_mut().zip(&frame.cols) {
            *speed = v[col];
        }
    }
}
