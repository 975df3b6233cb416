//! Mass matrix M(q) by the composite rigid body algorithm.
//!
//! Frames: world axes, world origin. M_jk = S_j · I_k S_k for j an ancestor of k (or k itself), I_k the inertia of the
//! subtree behind k. Source: Featherstone, *Rigid Body Dynamics Algorithms*, section 6.2.

use crate::path::{LANES, Path, products};
use crate::world_inertia::WorldInertia;
use crate::{Kinematics, Model};
use nalgebra::DMatrix;
use spatial::Twist;

/// Workspace of the composite rigid body algorithm.
#[derive(Debug, Clone)]
pub struct Crba {
    composite: Vec<WorldInertia>,
    path: Path<1>,
    mass_matrix: DMatrix<f64>,
}

impl Crba {
    /// Room for a model; entries that depend on q are NaN, those of joints on different branches are zero for good.
    pub fn new(model: &Model) -> Self {
        Self {
            composite: vec![WorldInertia::NAN; model.joints.len()],
            path: Path::new(model),
            mass_matrix: branch_pattern(model),
        }
    }

    /// M(q), nv×nv, symmetric positive definite, both triangles filled. No allocation.
    pub fn compute(&mut self, model: &Model, kinematics: &Kinematics) -> &DMatrix<f64> {
        composite_inertias(model, kinematics, &mut self.composite);
        let nv = model.nv;
        let matrix = self.mass_matrix.as_mut_slice();
        for (i, joint) in model.joints.iter().enumerate() {
            let support = &model.supports[i];
            let depth = support.len() - joint.kind.nv();
            for (c, k) in (joint.idx_v..joint.idx_v + joint.kind.nv()).enumerate() {
                let column = Twist::from_vector(&kinematics.column_in_world[k]);
                self.path.set(depth + c, [&column]);
                let momentum = self.composite[i].apply(&column);
                let upto = &support[..=depth + c];
                for ([block], indices) in
                    self.path.blocks(upto.len()).iter().zip(upto.chunks(LANES))
                {
                    for (&j, x) in indices.iter().zip(products(block, &momentum)) {
                        matrix[j + k * nv] = x;
                        matrix[k + j * nv] = x;
                    }
                }
            }
        }
        &self.mass_matrix
    }
}

/// Inertia of the subtree behind every joint.
#[inline]
pub(crate) fn composite_inertias(
    model: &Model,
    kinematics: &Kinematics,
    composite: &mut [WorldInertia],
) {
    for (i, joint) in model.joints.iter().enumerate() {
        composite[i] = WorldInertia::new(&joint.inertia, &kinematics.world_from_joint[i]);
    }
    for (i, joint) in model.joints.iter().enumerate().rev() {
        if let Some(parent) = joint.parent {
            let behind = composite[i];
            composite[parent] += behind;
        }
    }
}

/// nv×nv, NaN where one index is behind the other and zero elsewhere.
pub(crate) fn branch_pattern(model: &Model) -> DMatrix<f64> {
    let mut pattern = DMatrix::zeros(model.nv, model.nv);
    for (joint, support) in model.joints.iter().zip(&model.supports) {
        for k in joint.idx_v..joint.idx_v + joint.kind.nv() {
            for &j in support {
                pattern[(j, k)] = f64::NAN;
                pattern[(k, j)] = f64::NAN;
            }
        }
    }
    pattern
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Rnea;
    use crate::samples::samples;

    #[test]
    fn columns_are_inverse_dynamics_of_unit_accelerations() {
        for sample in samples() {
            let (model, kinematics) = (&sample.model, sample.kinematics());
            let (mut crba, mut rnea) = (Crba::new(model), Rnea::new(model));
            let matrix = crba.compute(model, &kinematics);
            let bias = rnea
                .compute(model, &kinematics, &sample.v, &vec![0.0; model.nv])
                .to_vec();
            for k in 0..model.nv {
                let mut unit = vec![0.0; model.nv];
                unit[k] = 1.0;
                let tau = rnea.compute(model, &kinematics, &sample.v, &unit);
                for j in 0..model.nv {
                    let gap = tau[j] - bias[j] - matrix[(j, k)];
                    assert!(
                        gap.abs() < 1e-11 * (1.0 + bias[j].abs()),
                        "({j}, {k}): {gap}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_mass_matrix_is_symmetric_and_positive_definite() {
        for sample in samples() {
            let mut crba = Crba::new(&sample.model);
            let matrix = crba.compute(&sample.model, &sample.kinematics());
            assert_eq!(*matrix, matrix.transpose());
            assert!(matrix.clone().cholesky().is_some());
        }
    }
}
