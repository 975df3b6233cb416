//! Torque at speed: what a motor that drives can give falls linearly from a corner speed on.
//!
//! With the limit T, the corner speed v₁, the speed v₀ without load and the share m of the limits that may be used,
//! |τ| ≤ m T (v₀ − |v|)/(v₀ − v₁) where τ and v have the same sign is one row with two bounds,
//! |τ/T + σ v| ≤ σ v₀ with σ = m/(v₀ − v₁). Beside |τ| ≤ m T it takes nothing from a motor that brakes.
//!
//! τ is that of the interval. v is the velocity that the integrator uses in it: of its first node with explicit Euler, of its
//! last with semi-implicit Euler, of both, in two rows, with constant acceleration.

use crate::chain::{Layout, Motion};
use crate::point::Point;
use crate::problem::Trajectory;

/// The row of one joint and one velocity.
#[derive(Debug, Clone, Copy)]
pub struct TorqueSpeedRow {
    /// Row within the element.
    pub row: usize,
    /// Velocity index of the joint.
    pub coordinate: usize,
    /// σ [s/rad].
    pub slope: f64,
    /// True for the velocity of the interval's last node.
    pub next: bool,
}

/// All of an interval, in one block with the columns of the robot's equations of motion.
#[derive(Debug, Clone, Default)]
pub struct TorqueSpeedRows {
    /// One after the other.
    pub rows: Vec<TorqueSpeedRow>,
    /// Block within the element; `None` without rows.
    pub block: Option<usize>,
}

/// How velocities follow from the variables of an element.
pub(crate) enum Velocities<'a> {
    /// Differences of configurations over the interval.
    Differences(&'a Layout),
    /// Unknowns: local offsets of v and v⁺.
    Unknown(Option<usize>, Option<usize>),
}

impl TorqueSpeedRows {
    /// Row values from torques (per velocity index) and their scales.
    pub(crate) fn values(&self, tau: &[f64], scale: &[f64], motion: &Motion, out: &mut [f64]) {
        for row in &self.rows {
            let i = row.coordinate;
            let v = if row.next {
                motion.v_next[i]
            } else {
                motion.v[i]
            };
            out[row.row] = tau[i] / scale[i] + row.slope * v;
        }
    }

    /// Adds the multipliers `y` of the rows to those of the torques.
    pub(crate) fn add_weights(&self, y: &[f64], scale: &[f64], weights: &mut [f64]) {
        for row in &self.rows {
            weights[row.coordinate] += y[row.row] / scale[row.coordinate];
        }
    }

    /// Adds ∂(yᵀ rows)/∂v beside that of the torques, for the curvature of v in the durations. Velocities that are unknowns
    /// have none.
    pub(crate) fn add_gradient(&self, y: &[f64], by_v: &mut [f64]) {
        for row in self.rows.iter().filter(|row| !row.next) {
            by_v[row.coordinate] += row.slope * y[row.row];
        }
    }

    /// Writes the block with columns `cols`, ascending: the rows of the equations of motion (column-major, with their number
    /// of rows) and ∂(σ v).
    pub(crate) fn jacobian(
        &self,
        at: &Velocities<'_>,
        motion: &Motion,
        (torques, nv): (&[f64], usize),
        cols: &[usize],
        out: &mut [f64],
    ) {
        let n_rows = self.rows.len();
        for (out, &c) in out.chunks_exact_mut(n_rows).zip(cols) {
            for (o, row) in out.iter_mut().zip(&self.rows) {
                *o = torques[c * nv + row.coordinate];
            }
        }
        for (r, row) in self.rows.iter().enumerate() {
            let (i, slope) = (row.coordinate, row.slope);
            let mut add = |column: Option<usize>, value: f64| {
                if let Some(Ok(column)) = column.map(|c| cols.binary_search(&c)) {
                    out[column * n_rows + r] += value;
                }
            };
            match at {
                Velocities::Unknown(v, v_next) => {
                    let first = if row.next { v_next } else { v };
                    add(first.map(|first| first + i), slope);
                }
                Velocities::Differences(layout) => {
                    let by_node = slope / motion.dt;
                    add(layout.a.map(|a| a + i), -by_node);
                    add(layout.b.map(|b| b + i), by_node);
                    add(layout.time, -by_node * motion.v[i] / motion.steps);
                }
            }
        }
    }
}

impl Trajectory {
    /// Per joint of the robot with one degree of freedom, in the order of the model: |τ| of interval `t` over what is available
    /// at its speed; over the limit itself where the joint declares nothing or `at_speed` is false.
    pub fn torque_shares(&mut self, x: &Point, t: usize, at_speed: bool) -> Vec<f64> {
        let tau = self.torques(x, t);
        let (v, a) = self.velocity_and_acceleration(x, t);
        let (dt, (first, last)) = (self.dt(x, t), self.program.settings.integrator.shares());
        let share = |joint: &multibody::Joint| {
            let i = joint.idx_v;
            let fastest = [(first, v[i]), (last, v[i] + a[i] * dt)]
                .into_iter()
                .filter(|(used, _)| *used > 0.0)
                .map(|(_, v)| v * tau[i].signum())
                .fold(f64::NEG_INFINITY, f64::max);
            let curve = joint.torque_speed.filter(|_| at_speed);
            let available = curve.map_or(1.0, |curve| curve.available(fastest));
            tau[i].abs() / (joint.torque_limit * available.max(1e-9))
        };
        self.program.system.actuated().map(share).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Value of the row of a joint with limit 10, corner 4, no load at 8, all of it, and the bound on its size.
    fn row(tau: f64, v: f64) -> (f64, f64) {
        let slope = 1.0 / (8.0 - 4.0);
        let row = |row, next| TorqueSpeedRow {
            row,
            coordinate: 0,
            slope,
            next,
        };
        let rows = TorqueSpeedRows {
            rows: vec![row(0, false), row(1, true)],
            block: Some(1),
        };
        let motion = Motion {
            v: vec![v],
            v_next: vec![v],
            a: vec![0.0],
            dt: 0.1,
            dt_next: 0.1,
            steps: 1.0,
            steps_next: 1.0,
        };
        let mut values = [f64::NAN; 2];
        rows.values(&[tau], &[10.0], &motion, &mut values);
        assert_eq!(values[0].to_bits(), values[1].to_bits());
        (values[0].abs(), slope * 8.0)
    }

    #[test]
    fn the_row_bounds_a_motor_that_drives_and_not_one_that_brakes() {
        let inside = |tau: f64, v: f64| {
            let (size, bound) = row(tau, v);
            size <= bound + 1e-12
        };
        assert!(inside(5.0, 6.0) && !inside(5.1, 6.0));
        assert!(inside(-5.0, -6.0) && !inside(-5.1, -6.0));
        assert!(inside(10.0, 4.0) && inside(10.0, -8.0) && inside(-10.0, 8.0));
        assert!(inside(0.0, 8.0) && !inside(0.1, 8.0));
    }
}
