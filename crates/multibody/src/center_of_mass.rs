//! Centre of mass and other weighted sums of points, their Jacobian, and the contracted Hessian yᵀ ∂²c.
//!
//! Frames: world. A unit rate of index k moves the masses behind it as points of one rigid body, so with M_k, h_k mass and
//! first moment of the subtree and m the total mass: m ∂c/∂q_k = M_k S_k,lin + S_k,ang × h_k. A further increment of an
//! ancestor l only turns this vector: ∂²c/∂q_l∂q_k = S_l,ang × ∂c/∂q_k, symmetrised within the six base columns
//! (`docs/math/dynamics.md`, section 1).

use crate::crba::branch_pattern;
use crate::rnea::NAN_VECTOR;
use crate::{Kinematics, Model};
use nalgebra::{DMatrix, Matrix3xX, Vector3};
use spatial::Twist;

/// A point fixed to a body, and what it counts for in a sum of points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WeightedPoint {
    /// The joint that carries it.
    pub joint: usize,
    /// Its place in the joint frame [m].
    pub in_joint: Vector3<f64>,
    /// Its weight.
    pub weight: f64,
}

/// Workspace for the centre of mass, and for other sums of points.
#[derive(Debug, Clone)]
pub struct CenterOfMass {
    mass: Vec<f64>,
    moment: Vec<Vector3<f64>>,
    com: Vector3<f64>,
    jacobian: Matrix3xX<f64>,
    hessian: DMatrix<f64>,
}

impl CenterOfMass {
    /// Room for a model; filled with NaN.
    pub fn new(model: &Model) -> Self {
        let n = model.joints.len();
        Self {
            mass: vec![f64::NAN; n],
            moment: vec![NAN_VECTOR; n],
            com: NAN_VECTOR,
            jacobian: Matrix3xX::repeat(model.nv, f64::NAN),
            hessian: branch_pattern(model),
        }
    }

    /// Centre of mass in the world [m] and its Jacobian by body increments of q, 3×nv. No allocation.
    pub fn compute(
        &mut self,
        model: &Model,
        kinematics: &Kinematics,
    ) -> (Vector3<f64>, &Matrix3xX<f64>) {
        let total = model.total_mass();
        for (i, joint) in model.joints.iter().enumerate() {
            let inertia = &joint.inertia;
            self.mass[i] = inertia.mass / total;
            self.moment[i] = kinematics.world_from_joint[i].act(inertia.com) * self.mass[i];
        }
        self.accumulate(model, kinematics)
    }

    /// The same of Σ w p over points with weights of either sign in place of masses.
    pub fn compute_sum(
        &mut self,
        model: &Model,
        kinematics: &Kinematics,
        points: &[WeightedPoint],
    ) -> (Vector3<f64>, &Matrix3xX<f64>) {
        self.mass.fill(0.0);
        self.moment.fill(Vector3::zeros());
        for point in points {
            let place = kinematics.world_from_joint[point.joint].act(point.in_joint);
            self.mass[point.joint] += point.weight;
            self.moment[point.joint] += place * point.weight;
        }
        self.accumulate(model, kinematics)
    }

    /// From what each joint carries itself to all that is behind it, and to the Jacobian.
    fn accumulate(
        &mut self,
        model: &Model,
        kinematics: &Kinematics,
    ) -> (Vector3<f64>, &Matrix3xX<f64>) {
        self.com = Vector3::zeros();
        for (i, joint) in model.joints.iter().enumerate().rev() {
            let (mass_behind, moment_behind) = (self.mass[i], self.moment[i]);
            if let Some(parent) = joint.parent {
                self.mass[parent] += mass_behind;
                self.moment[parent] += moment_behind;
            } else {
                self.com += moment_behind;
            }
        }
        for (i, joint) in model.joints.iter().enumerate() {
            for k in joint.idx_v..joint.idx_v + joint.kind.nv() {
                let column = Twist::from_vector(&kinematics.column_in_world[k]);
                let moved = column.linear * self.mass[i] + column.angular.cross(&self.moment[i]);
                self.jacobian.set_column(k, &moved);
            }
        }
        (self.com, &self.jacobian)
    }

    /// Jacobian of the last computation, 3×nv.
    pub fn jacobian(&self) -> &Matrix3xX<f64> {
        &self.jacobian
    }

    /// Hessian of δ ↦ yᵀ c(q ⊕ δ) at 0, nv×nv, symmetric; uses the Jacobian of the last computation.
    pub fn hessian(
        &mut self,
        model: &Model,
        kinematics: &Kinematics,
        y_in_world: &Vector3<f64>,
    ) -> &DMatrix<f64> {
        for (i, joint) in model.joints.iter().enumerate() {
            let own = joint.idx_v..joint.idx_v + joint.kind.nv();
            for k in own.clone() {
                let dc_dqk = self.jacobian.column(k);
                let turned = dc_dqk.cross(y_in_world);
                for &l in &model.supports[i] {
                    let axis = Twist::from_vector(&kinematics.column_in_world[l]).angular;
                    let value = axis.dot(&turned);
                    if own.contains(&l) {
                        // visited from both sides: l turns k, and k turns l
                        let other = Twist::from_vector(&kinematics.column_in_world[k]).angular;
                        let reversed = other.dot(&self.jacobian.column(l).cross(y_in_world));
                        self.hessian[(l, k)] = 0.5 * (value + reversed);
                    } else {
                        self.hessian[(l, k)] = value;
                        self.hessian[(k, l)] = value;
                    }
                }
            }
        }
        &self.hessian
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::samples;
    use derivcheck::{assert_hessian_of_value, assert_jacobian};

    #[test]
    fn jacobian_and_hessian_match_finite_differences() {
        for sample in samples() {
            let (model, kinematics) = (&sample.model, sample.kinematics());
            let mut here = CenterOfMass::new(model);
            let jacobian = here.compute(model, &kinematics).1.clone();
            let com_at = |dq: &[f64]| {
                let mut there = CenterOfMass::new(model);
                there.compute(model, &sample.kinematics_at(dq)).0
            };
            let zero = vec![0.0; model.nv];
            assert_jacobian(
                |dq| com_at(dq).as_slice().to_vec(),
                &zero,
                jacobian.as_slice(),
                1e-9,
            );

            // The masses as weights of points make the same.
            let total = model.total_mass();
            let point = |(joint, of): (usize, &crate::Joint)| WeightedPoint {
                joint,
                in_joint: of.inertia.com,
                weight: of.inertia.mass / total,
            };
            let points: Vec<_> = model.joints.iter().enumerate().map(point).collect();
            let mut sum = CenterOfMass::new(model);
            let (place, by_points) = sum.compute_sum(model, &kinematics, &points);
            assert!((place - com_at(&zero)).norm() < 1e-12);
            assert!((by_points - &jacobian).norm() < 1e-12);

            let y = Vector3::new(0.4, -0.7, 0.9);
            let hessian = here.hessian(model, &kinematics, &y);
            let value = |dq: &[f64]| y.dot(&com_at(dq));
            assert_hessian_of_value(value, &zero, hessian.as_slice(), 1e-7);
        }
    }
}
