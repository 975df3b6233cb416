//! First derivatives of inverse dynamics: ∂τ/∂q, ∂τ/∂v, ∂τ/∂a = M, and τ itself.
//!
//! Frames: world axes, world origin. Derivation: `docs/math/dynamics.md`, section 2. For index k with column S, parent
//! twist V_λ and parent acceleration A_λ (gravity included): ψ̇ = [V_λ, S], ψ̈ = [A_λ, S] + [V_λ, ψ̇], σ = ψ̇ + [V, S].
//! With the subtree sums I (inertia), B (gyration), F (force), and j an ancestor of k:
//! ∂τ_j/∂q_k = S_j · (S_k ×* F_k + I_k ψ̈_k + B_k ψ̇_k),  ∂τ_k/∂q_j = I_k S_k · ψ̈_j + B_kᵀS_k · ψ̇_j,
//! ∂τ_j/∂v_k = S_j · (I_k σ_k + B_k S_k),                 ∂τ_k/∂v_j = I_k S_k · σ_j + B_kᵀS_k · S_j.
//! Same result as Carpentier, Mansard, *Analytical derivatives of rigid body dynamics algorithms* (RSS 2018).

use crate::crba::branch_pattern;
use crate::path::{Block, LANES, Path, angular_products, plus, products};
use crate::subtree::{Directions, Subtree};
use crate::{Kinematics, Model};
use nalgebra::{DMatrix, Vector3};
use spatial::Wrench;

/// Workspace for the derivatives of inverse dynamics.
#[derive(Debug, Clone)]
pub struct RneaDerivatives {
    subtree: Subtree,
    /// ψ̈, ψ̇, σ, S of the indices from the root to the current joint.
    path: Path<4>,
    first: FirstDerivatives,
}

/// τ and its first derivatives, written index by index.
#[derive(Debug, Clone)]
pub(crate) struct FirstDerivatives {
    pub tau: Vec<f64>,
    pub dtau_dq: DMatrix<f64>,
    pub dtau_dv: DMatrix<f64>,
    pub dtau_da: DMatrix<f64>,
}

/// What the pairs of one index with its ancestors need: products with the sums of the subtree behind it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FirstSide {
    /// I S
    pub inertia_column: Wrench,
    /// Bᵀ S, angular part.
    pub gyration_column: Vector3<f64>,
    /// S ×* F + I ψ̈ + B ψ̇
    pub by_position: Wrench,
    /// I σ + B S
    pub by_velocity: Wrench,
}

impl RneaDerivatives {
    /// Room for a model; entries that depend on the state are NaN, those of different branches zero for good.
    pub fn new(model: &Model) -> Self {
        Self {
            subtree: Subtree::new(model),
            path: Path::new(model),
            first: FirstDerivatives::new(model),
        }
    }

    /// Evaluates τ and its derivatives at (q, v, a); q through the kinematics. No allocation.
    ///
    /// # Panics
    /// If `v` or `a` is shorter than nv.
    pub fn compute(&mut self, model: &Model, kinematics: &Kinematics, v: &[f64], a: &[f64]) {
        self.subtree.compute(model, kinematics, v, a);
        for (i, joint) in model.joints.iter().enumerate() {
            let (support, own) = (
                &model.supports[i],
                joint.idx_v..joint.idx_v + joint.kind.nv(),
            );
            let depth = support.len() - own.len();
            for k in own.clone() {
                let Directions {
                    psi_dot,
                    psi_ddot,
                    sigma,
                    column,
                } = &self.subtree.directions[k];
                self.path
                    .set(depth + k - own.start, [psi_ddot, psi_dot, sigma, column]);
            }
            for k in own.clone() {
                let side = self.subtree.first_side(i, k);
                self.first.tau[k] = self.subtree.force[i].power(&self.subtree.directions[k].column);
                let blocks = self
                    .path
                    .blocks(support.len())
                    .iter()
                    .zip(support.chunks(LANES));
                for ([psi_ddot, psi_dot, sigma, column], indices) in blocks {
                    self.first.write(
                        [psi_ddot, psi_dot, sigma, column],
                        indices,
                        own.start,
                        k,
                        &side,
                    );
                }
            }
        }
    }

    /// τ = ID(q, v, a), length nv.
    pub fn tau(&self) -> &[f64] {
        &self.first.tau
    }

    /// ∂τ/∂q by body increments, nv×nv.
    pub fn dtau_dq(&self) -> &DMatrix<f64> {
        &self.first.dtau_dq
    }

    /// ∂τ/∂v, nv×nv.
    pub fn dtau_dv(&self) -> &DMatrix<f64> {
        &self.first.dtau_dv
    }

    /// ∂τ/∂a = M(q), nv×nv, both triangles.
    pub fn dtau_da(&self) -> &DMatrix<f64> {
        &self.first.dtau_da
    }
}

impl FirstDerivatives {
    pub fn new(model: &Model) -> Self {
        let pattern = branch_pattern(model);
        let tau = vec![f64::NAN; model.nv];
        Self {
            tau,
            dtau_dq: pattern.clone(),
            dtau_dv: pattern.clone(),
            dtau_da: pattern,
        }
    }

    /// Rows and columns of index k against one block of its support; `first_own` is the first index of its joint.
    ///
    /// Within a joint the columns move along with S_k and the turned force cancels: those pairs have the lower formula
    /// for all orders.
    #[inline]
    pub fn write(
        &mut self,
        [psi_ddot, psi_dot, sigma, column]: [&Block; 4],
        indices: &[usize],
        first_own: usize,
        k: usize,
        side: &FirstSide,
    ) {
        let q_upper = products(column, &side.by_position);
        let v_upper = products(column, &side.by_velocity);
        let mass = products(column, &side.inertia_column);
        let q_lower = plus(
            products(psi_ddot, &side.inertia_column),
            angular_products(psi_dot, &side.gyration_column),
        );
        let v_lower = plus(
            products(sigma, &side.inertia_column),
            angular_products(column, &side.gyration_column),
        );
        let nv = self.tau.len();
        let (dq, dv) = (self.dtau_dq.as_mut_slice(), self.dtau_dv.as_mut_slice());
        let da = self.dtau_da.as_mut_slice();
        for (lane, &j) in indices.iter().enumerate() {
            let (upper, lower) = (j + k * nv, k + j * nv);
            dq[lower] = q_lower[lane];
            dv[lower] = v_lower[lane];
            da[lower] = mass[lane];
            if j < first_own {
                dq[upper] = q_upper[lane];
                dv[upper] = v_upper[lane];
                da[upper] = mass[lane];
            }
        }
    }
}

impl Subtree {
    #[inline]
    pub fn first_side(&self, i: usize, k: usize) -> FirstSide {
        let Directions {
            psi_dot,
            psi_ddot,
            sigma,
            column,
        } = &self.directions[k];
        let inertia = &self.inertia[i];
        let gyration = self.gyration(i);
        let turned_force = column.cross_wrench(&self.force[i]);
        FirstSide {
            inertia_column: inertia.apply(column),
            gyration_column: gyration.transposed(column),
            by_position: turned_force + inertia.apply(psi_ddot) + gyration.apply(psi_dot),
            by_velocity: inertia.apply(sigma) + gyration.apply(column),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::samples;
    use crate::{Crba, Rnea};
    use derivcheck::assert_jacobian;

    #[test]
    fn derivatives_match_finite_differences() {
        for sample in samples() {
            let (model, kinematics, v, a) =
                (&sample.model, sample.kinematics(), &sample.v, &sample.a);
            let mut derivatives = RneaDerivatives::new(model);
            derivatives.compute(model, &kinematics, v, a);
            let tau = |kinematics: &Kinematics, v: &[f64], a: &[f64]| {
                Rnea::new(model).compute(model, kinematics, v, a).to_vec()
            };
            let zero = vec![0.0; model.nv];
            let by_q = |dq: &[f64]| tau(&sample.kinematics_at(dq), v, a);
            assert_jacobian(by_q, &zero, derivatives.dtau_dq().as_slice(), 1e-9);
            assert_jacobian(
                |v| tau(&kinematics, v, a),
                v,
                derivatives.dtau_dv().as_slice(),
                1e-9,
            );
            assert_jacobian(
                |a| tau(&kinematics, v, a),
                a,
                derivatives.dtau_da().as_slice(),
                1e-9,
            );
        }
    }

    #[test]
    fn value_and_mass_matrix_are_those_of_the_other_algorithms() {
        for sample in samples() {
            let (model, kinematics) = (&sample.model, sample.kinematics());
            let mut derivatives = RneaDerivatives::new(model);
            derivatives.compute(model, &kinematics, &sample.v, &sample.a);
            let mut rnea = Rnea::new(model);
            let tau = rnea.compute(model, &kinematics, &sample.v, &sample.a);
            let largest = tau.iter().fold(0.0, |max: f64, x| max.max(x.abs()));
            assert!(
                tau.iter()
                    .zip(derivatives.tau())
                    .all(|(x, y)| (x - y).abs() < 1e-13 * largest)
            );
            let mut crba = Crba::new(model);
            assert!((crba.compute(model, &kinematics) - derivatives.dtau_da()).norm() < 1e-11);
        }
    }
}
