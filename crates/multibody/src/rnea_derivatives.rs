//! First derivatives of inverse dynamics: ∂τ/∂q, ∂τ/∂v, ∂τ/∂a = M, and τ itself.
//!
//! Frames: world axes, world origin. Derivation: `docs/math/dynamics.md`, section 2. For index k with column S, parent
//! twist V_λ and parent acceleration A_λ (gravity included): ψ̇ = [V_λ, S], ψ̈ = [A_λ, S] + [V_λ, ψ̇], σ = ψ̇ + [V, S].
//! With the subtree sums I (inertia), B (gyration), F (force), and j an ancestor of k:
//! ∂τ_j/∂q_k = S_j · (S_k ×* F_k + I_k ψ̈_k + B_k ψ̇_k),  ∂τ_k/∂q_j = I_k S_k · ψ̈_j + B_kᵀS_k · ψ̇_j,
//! ∂τ_j/∂v_k = S_j · (I_k σ_k + B_k S_k),                 ∂τ_k/∂v_j = I_k S_k · σ_j + B_kᵀS_k · S_j.
//! Same result as Carpentier, Mansard, *Analytical derivatives of rigid body dynamics algorithms* (RSS 2018).

use crate::crba::branch_pattern;
use crate::path::{LANES, Path, add_angular_products, add_products};
use crate::subtree::{Directions, Subtree};
use crate::world_inertia::Gyration;
use crate::{Kinematics, Model};
use nalgebra::{DMatrix, Vector3};
use spatial::{Twist, Wrench};

/// Workspace for the derivatives of inverse dynamics.
#[derive(Debug, Clone)]
pub struct RneaDerivatives {
    subtree: Subtree,
    /// ψ̈, ψ̇, σ, S of the indices from the root to the current joint.
    path: Path<4>,
    tau: Vec<f64>,
    dtau_dq: DMatrix<f64>,
    dtau_dv: DMatrix<f64>,
    dtau_da: DMatrix<f64>,
}

/// What the pairs of one index with its ancestors need.
struct Side {
    inertia_column: Wrench,
    gyration_column: Vector3<f64>,
    by_position: Wrench,
    by_velocity: Wrench,
}

impl RneaDerivatives {
    /// Room for a model; entries that depend on the state are NaN, those of different branches zero for good.
    pub fn new(model: &Model) -> Self {
        let pattern = branch_pattern(model);
        Self {
            subtree: Subtree::new(model),
            path: Path::new(model),
            tau: vec![f64::NAN; model.nv],
            dtau_dq: pattern.clone(),
            dtau_dv: pattern.clone(),
            dtau_da: pattern,
        }
    }

    /// Evaluates τ and its derivatives at (q, v, a); q through the kinematics. No allocation.
    ///
    /// # Panics
    /// If `v` or `a` is shorter than nv.
    pub fn compute(&mut self, model: &Model, kinematics: &Kinematics, v: &[f64], a: &[f64]) {
        self.subtree.compute(model, kinematics, v, a);
        for (i, joint) in model.joints.iter().enumerate() {
            let depth = model.supports[i].len() - joint.kind.nv();
            for (c, k) in (joint.idx_v..joint.idx_v + joint.kind.nv()).enumerate() {
                let side = self.side(i, k);
                self.tau[k] = self.subtree.force[i].power(&self.subtree.directions[k].column);
                self.pairs_with_ancestors(model.nv, &model.supports[i][..depth], k, &side);
                for j in joint.idx_v..joint.idx_v + joint.kind.nv() {
                    self.pair_in_joint(k, j, &side);
                }
                let Directions {
                    psi_dot,
                    psi_ddot,
                    sigma,
                    column,
                } = &self.subtree.directions[k];
                self.path.set(depth + c, [psi_ddot, psi_dot, sigma, column]);
            }
        }
    }

    #[inline]
    fn side(&self, i: usize, k: usize) -> Side {
        let Directions {
            psi_dot,
            psi_ddot,
            sigma,
            column,
        } = &self.subtree.directions[k];
        let inertia = &self.subtree.inertia[i];
        let gyration = Gyration {
            momentum: &self.subtree.momentum[i],
            rate: &self.subtree.rate[i],
        };
        let turned_force = column.cross_wrench(&self.subtree.force[i]);
        Side {
            inertia_column: inertia.apply(column),
            gyration_column: gyration.transposed(column),
            by_position: turned_force + inertia.apply(psi_ddot) + gyration.apply(psi_dot),
            by_velocity: inertia.apply(sigma) + gyration.apply(column),
        }
    }

    #[inline]
    fn pairs_with_ancestors(&mut self, nv: usize, ancestors: &[usize], k: usize, side: &Side) {
        let dq = self.dtau_dq.as_mut_slice();
        let dv = self.dtau_dv.as_mut_slice();
        let da = self.dtau_da.as_mut_slice();
        let blocks = self.path.blocks(ancestors.len());
        for ([psi_ddot, psi_dot, sigma, column], indices) in
            blocks.iter().zip(ancestors.chunks(LANES))
        {
            let mut sums = [[0.0; LANES]; 5];
            let [q_upper, q_lower, v_upper, v_lower, mass] = &mut sums;
            add_products(q_upper, column, &side.by_position);
            add_products(v_upper, column, &side.by_velocity);
            add_products(mass, column, &side.inertia_column);
            add_products(q_lower, psi_ddot, &side.inertia_column);
            add_angular_products(q_lower, psi_dot, &side.gyration_column);
            add_products(v_lower, sigma, &side.inertia_column);
            add_angular_products(v_lower, column, &side.gyration_column);
            for (lane, &j) in indices.iter().enumerate() {
                let (upper, lower) = (j + k * nv, k + j * nv);
                dq[upper] = q_upper[lane];
                dq[lower] = q_lower[lane];
                dv[upper] = v_upper[lane];
                dv[lower] = v_lower[lane];
                da[upper] = mass[lane];
                da[lower] = mass[lane];
            }
        }
    }

    /// Row k, column j of one joint: the column moves along with S_k, so the turned force cancels.
    #[inline]
    fn pair_in_joint(&mut self, k: usize, j: usize, side: &Side) {
        let Directions {
            psi_dot,
            psi_ddot,
            sigma,
            column,
        } = &self.subtree.directions[j];
        let gyration = |psi: &Twist| side.gyration_column.dot(&psi.angular);
        self.dtau_dq[(k, j)] = side.inertia_column.power(psi_ddot) + gyration(psi_dot);
        self.dtau_dv[(k, j)] = side.inertia_column.power(sigma) + gyration(column);
        self.dtau_da[(k, j)] = side.inertia_column.power(column);
    }

    /// τ = ID(q, v, a), length nv.
    pub fn tau(&self) -> &[f64] {
        &self.tau
    }

    /// ∂τ/∂q by body increments, nv×nv.
    pub fn dtau_dq(&self) -> &DMatrix<f64> {
        &self.dtau_dq
    }

    /// ∂τ/∂v, nv×nv.
    pub fn dtau_dv(&self) -> &DMatrix<f64> {
        &self.dtau_dv
    }

    /// ∂τ/∂a = M(q), nv×nv, both triangles.
    pub fn dtau_da(&self) -> &DMatrix<f64> {
        &self.dtau_da
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
