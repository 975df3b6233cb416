//! Rows of intervals whose node velocities are unknowns: the integrator, and rest at new contacts.
//!
//! ```text
//! r = (q⁺ ⊖ q) − dt (β v + γ v⁺),   dt = T / steps            ([`crate::Integrator::shares`])
//! s = J(q) v                                                  (twist of a relative to b, axes of a)
//! ```
//!
//! Source: plan format, "Integrator"; formulation 2.19.

use crate::chain::Motion;
use crate::difference::Difference;
use crate::program::integrator::DISPLACEMENT_SCALE;
use crate::program::{IntegratorRows, Interval, Program, Touch};
use crate::relative::{Relative, RelativeFrame};
use nalgebra::Vector6;
use solver::ElementData;

/// What the rows of one interval depend on.
pub(crate) struct At<'a> {
    pub(crate) program: &'a Program,
    pub(crate) interval: &'a Interval,
    pub(crate) difference: &'a Difference,
    pub(crate) motion: &'a Motion,
}

impl At<'_> {
    /// Values of the integrator's rows.
    pub(crate) fn integrator_values(&self, rows: IntegratorRows, values: &mut [f64]) {
        let (beta, gamma) = self.program.settings.integrator.shares();
        let Motion { v, v_next, dt, .. } = self.motion;
        let out = &mut values[rows.first_row..rows.first_row + v.len()];
        for (i, o) in out.iter_mut().enumerate() {
            let moved = dt * (beta * v[i] + gamma * v_next[i]);
            *o = (self.difference.xi[i] - moved) / DISPLACEMENT_SCALE;
        }
    }

    /// Jacobian of the integrator's rows, and their Hessian for the multipliers `y` of the element's rows.
    pub(crate) fn integrator_derivatives(
        &self,
        rows: IntegratorRows,
        y: &[f64],
        out: &mut ElementData,
    ) {
        let (beta, gamma) = self.program.settings.integrator.shares();
        let Motion {
            v,
            v_next,
            dt,
            steps,
            ..
        } = self.motion;
        let interval = self.interval;
        let y = &y[rows.first_row..rows.first_row + v.len()];
        let n = out.gradient.len();
        let joints = &self.program.system.model.joints;
        let mut floating = 0;
        for (k, joint) in joints.iter().enumerate() {
            let m = joint.kind.nv();
            let jacobian = &mut out.jacobians[rows.first_block + k];
            jacobian.fill(0.0);
            let mut first = 0;
            let displaced = [(interval.a, false), (interval.b, true)];
            for (_, by_b) in displaced.into_iter().filter(|(node, _)| node.is_some()) {
                if m == 1 {
                    jacobian[first] = if by_b { 1.0 } else { -1.0 };
                } else {
                    let d = self.difference;
                    let block = if by_b {
                        d.by_b[floating]
                    } else {
                        -d.by_a[floating]
                    };
                    jacobian[first * m..(first + m) * m].copy_from_slice(block.as_slice());
                }
                first += m;
            }
            let speeds = [(interval.velocity, beta), (interval.velocity_next, gamma)];
            for (_, share) in speeds.into_iter().filter(|(node, _)| node.is_some()) {
                for i in 0..m {
                    jacobian[(first + i) * m + i] = -dt * share;
                }
                first += m;
            }
            for i in 0..m {
                let c = joint.idx_v + i;
                jacobian[first * m + i] = -(beta * v[c] + gamma * v_next[c]) / steps;
            }
            for value in jacobian.iter_mut() {
                *value /= DISPLACEMENT_SCALE;
            }
            floating += usize::from(m == 6);
        }
        if let Some(time) = interval.time {
            let speeds = [(interval.velocity, beta), (interval.velocity_next, gamma)];
            for (first, share) in speeds {
                let Some(first) = first else { continue };
                for (i, y) in y.iter().enumerate() {
                    let (row, col) = (first + i, time);
                    out.hessian[row.min(col) * n + row.max(col)] -=
                        y * share / (steps * DISPLACEMENT_SCALE);
                }
            }
        }
        let firsts = [interval.a, interval.b];
        self.difference
            .curvature(y, |block_row, i, block_col, j, value| {
                if let (Some(r), Some(c)) = (firsts[block_row], firsts[block_col]) {
                    let (row, col) = (r + i, c + j);
                    out.hessian[row.min(col) * n + row.max(col)] += value / DISPLACEMENT_SCALE;
                }
            });
    }
}

/// Relative twist of a contact's interfaces, of `a`, in axes of `a` [m/s, rad/s].
fn twist(frame: &RelativeFrame, relative: &Relative, v: &[f64]) -> Vector6<f64> {
    let columns = frame.cols.iter().zip(&relative.columns);
    columns.map(|(&col, j)| j * v[col]).sum()
}

/// Values of the rows of a new contact.
pub(crate) fn touch_values(
    touch: &Touch,
    frame: &RelativeFrame,
    relative: &Relative,
    v: &[f64],
    values: &mut [f64],
) {
    let twist = twist(frame, relative, v);
    values[touch.first_row..touch.first_row + touch.n_rows]
        .copy_from_slice(&twist.as_slice()[..touch.n_rows]);
}

/// Jacobian of the rows of a new contact, and their Hessian for the multipliers `y` of the element's rows; `speeds` is
/// scratch of at least as many entries as the frame has columns.
pub(crate) fn touch_derivatives(
    touch: &Touch,
    (frame, relative): (&RelativeFrame, &Relative),
    at: &At,
    y: &[f64],
    speeds: &mut [f64],
    out: &mut ElementData,
) {
    let (interval, n, m) = (at.interval, out.gradient.len(), touch.n_rows);
    let cols = &frame.cols;
    let speeds = &mut speeds[..cols.len()];
    for (speed, &col) in speeds.iter_mut().zip(cols) {
        *speed = at.motion.v[col];
    }
    let mut weights = Vector6::zeros();
    for r in 0..m {
        weights[r] = y[touch.first_row + r];
    }
    let jacobian = &mut out.jacobians[touch.block];
    let mut first = 0;
    if interval.a.is_some() {
        frame.virtual_power_gradient(relative, speeds, |l, moved| {
            jacobian[l * m..(l + 1) * m].copy_from_slice(&moved.as_slice()[..m]);
        });
        first = cols.len();
    }
    for (l, column) in relative.columns.iter().enumerate() {
        let at = (first + l) * m;
        jacobian[at..at + m].copy_from_slice(&column.as_slice()[..m]);
    }
    let Some(q) = interval.a else { return };
    let mut add = |row: usize, col: usize, value: f64| {
        out.hessian[row.min(col) * n + row.max(col)] += value;
    };
    frame.virtual_power_hessian(
        relative,
        &weights,
        speeds,
        |_, _| (),
        |k, l, value| add(q + cols[k], q + cols[l], value),
    );
    if let Some(velocity) = interval.velocity {
        frame.wrench_jacobian(relative, &weights, |k, l, value| {
            add(q + cols[l], velocity + cols[k], value);
        });
    }
}
