//! Centroidal momentum h = A(q) v: linear, then angular about the centre of mass, world axes.
//!
//! Column k of A is the momentum of the subtree behind k when it moves with S_k, moved from the world origin to the
//! centre of mass. Source: Orin, Goswami, Lee, *Centroidal dynamics of a humanoid robot* (2013), section 3.

use crate::crba::composite_inertias;
use crate::rnea::NAN_VECTOR;
use crate::world_inertia::WorldInertia;
use crate::{Kinematics, Model};
use nalgebra::{Matrix6xX, Vector3, Vector6};
use spatial::Twist;

/// Workspace for the centroidal momentum matrix.
#[derive(Debug, Clone)]
pub struct Centroidal {
    composite: Vec<WorldInertia>,
    com: Vector3<f64>,
    matrix: Matrix6xX<f64>,
}

impl Centroidal {
    /// Room for a model; filled with NaN.
    pub fn new(model: &Model) -> Self {
        Self {
            composite: vec![WorldInertia::NAN; model.joints.len()],
            com: NAN_VECTOR,
            matrix: Matrix6xX::repeat(model.nv, f64::NAN),
        }
    }

    /// Centroidal momentum matrix A(q), 6×nv [kg, kg·m, kg·m²]. No allocation.
    pub fn compute(&mut self, model: &Model, kinematics: &Kinematics) -> &Matrix6xX<f64> {
        composite_inertias(model, kinematics, &mut self.composite);
        self.com = total_com(model, &self.composite);
        for (i, joint) in model.joints.iter().enumerate() {
            for k in joint.idx_v..joint.idx_v + joint.kind.nv() {
                let column = Twist::from_vector(&kinematics.column_in_world[k]);
                let momentum = self.composite[i].apply(&column);
                let (p, l) = (
                    momentum.linear,
                    momentum.angular - self.com.cross(&momentum.linear),
                );
                self.matrix
                    .set_column(k, &Vector6::new(p.x, p.y, p.z, l.x, l.y, l.z));
            }
        }
        &self.matrix
    }

    /// A(q) of the last [`Centroidal::compute`].
    pub fn matrix(&self) -> &Matrix6xX<f64> {
        &self.matrix
    }

    /// Centre of mass in the world [m] of the last [`Centroidal::compute`].
    pub fn com(&self) -> Vector3<f64> {
        self.com
    }

    /// Momentum h = A(q) v [N·s; N·m·s] with the A of the last [`Centroidal::compute`].
    ///
    /// # Panics
    /// If `v` is shorter than nv.
    pub fn momentum(&self, v: &[f64]) -> Vector6<f64> {
        self.matrix
            .column_iter()
            .zip(v)
            .map(|(column, rate)| column * *rate)
            .sum()
    }
}

/// Centre of mass of all roots together.
#[inline]
pub(crate) fn total_com(model: &Model, composite: &[WorldInertia]) -> Vector3<f64> {
    let (mut mass, mut moment) = (0.0, Vector3::zeros());
    for (joint, inertia) in model.joints.iter().zip(composite) {
        if joint.parent.is_none() {
            mass += inertia.mass;
            moment += inertia.moment;
        }
    }
    moment / mass
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CenterOfMass;
    use crate::samples::samples;

    #[test]
    fn momentum_is_the_sum_over_the_bodies() {
        for sample in samples() {
            let (model, kinematics) = (&sample.model, sample.kinematics());
            let mut centroidal = Centroidal::new(model);
            centroidal.compute(model, &kinematics);
            let mut expected = Vector6::zeros();
            for (i, joint) in model.joints.iter().enumerate() {
                let inertia = joint.inertia.transformed(&kinematics.world_from_joint[i]);
                let momentum = inertia.apply(&kinematics.joint_twist_in_world(model, i, &sample.v));
                let angular = momentum.angular - centroidal.com().cross(&momentum.linear);
                let (p, l) = (momentum.linear, angular);
                expected += Vector6::new(p.x, p.y, p.z, l.x, l.y, l.z);
            }
            let h = centroidal.momentum(&sample.v);
            assert!((h - expected).norm() < 1e-12 * expected.norm());
        }
    }

    #[test]
    fn linear_rows_are_the_mass_times_the_jacobian_of_the_centre() {
        for sample in samples() {
            let (model, kinematics) = (&sample.model, sample.kinematics());
            let (mut centroidal, mut com) = (Centroidal::new(model), CenterOfMass::new(model));
            let matrix = centroidal.compute(model, &kinematics);
            let jacobian = com.compute(model, &kinematics).1;
            assert!((matrix.rows(0, 3) - jacobian * model.total_mass()).norm() < 1e-12);
        }
    }
}
