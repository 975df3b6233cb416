//! Balance: what the feet bear is to be above the middle of them, in keyframes, and on fine grids before another foot lands.
//!
//! Keyframes know no statics, so that they refuse nothing that a motion can do. A cost alone draws the centre of mass of the robot
//! and of the objects in the air to where the feet can hold it still: what remains of it says how far a sequence is from what can
//! be done slowly, and a motion begins from configurations that bear themselves. On fine grids it draws a robot back that would fall
//! into a landing ([`crate::settings::Weights::landing_balance`], benches/runs/2026-11-24-strides.md).

use multibody::{CenterOfMass, Kinematics, Model, WeightedPoint};
use nalgebra::Vector3;

/// Cost ½ w d² of the horizontal distance d between a centre of mass and the middle of some contacts.
#[derive(Debug, Clone)]
pub struct Balance {
    /// w [1/m²].
    pub weight: f64,
    /// Up, a unit vector in the world.
    pub up: Vector3<f64>,
    /// The difference of the two, as a sum of points.
    pub points: Vec<WeightedPoint>,
}

impl Balance {
    /// The cost at a configuration.
    pub fn cost(&self, model: &Model, kinematics: &Kinematics, scratch: &mut CenterOfMass) -> f64 {
        let away = scratch.compute_sum(model, kinematics, &self.points).0;
        0.5 * self.weight * self.horizontal(away).norm_squared()
    }

    /// The distance as a share of the height of the centre of mass above the contacts; infinite below them.
    pub fn lean(&self, model: &Model, kinematics: &Kinematics, scratch: &mut CenterOfMass) -> f64 {
        let away = scratch.compute_sum(model, kinematics, &self.points).0;
        let height = self.up.dot(&away);
        if height > 0.0 {
            self.horizontal(away).norm() / height
        } else {
            f64::INFINITY
        }
    }

    /// Gives gradient (index, value) and Hessian (row, column, value; parts of its lower triangle) to `first` and `second`.
    pub fn derivatives(
        &self,
        model: &Model,
        kinematics: &Kinematics,
        scratch: &mut CenterOfMass,
        mut first: impl FnMut(usize, f64),
        mut second: impl FnMut(usize, usize, f64),
    ) {
        let away = scratch.compute_sum(model, kinematics, &self.points).0;
        let pull = self.horizontal(away) * self.weight;
        let curvature = scratch.hessian(model, kinematics, &pull);
        for k in 0..model.nv {
            for l in k..model.nv {
                second(l, k, curvature[(l, k)]);
            }
        }
        let jacobian = scratch.jacobian();
        for (k, by_k) in jacobian.column_iter().enumerate() {
            first(k, pull.dot(&by_k));
            let across = self.horizontal(by_k.into_owned()) * self.weight;
            for (l, by_l) in jacobian.column_iter().enumerate().skip(k) {
                second(l, k, across.dot(&by_l));
            }
        }
    }

    fn horizontal(&self, v: Vector3<f64>) -> Vector3<f64> {
        v - self.up * self.up.dot(&v)
    }
}
