//! Second derivatives of inverse dynamics, contracted with a weight: the Hessian of L(q, v, a) = wᵀ ID(q, v, a), with the
//! values and first derivatives of ID on the way.
//!
//! Frames: world axes, world origin. Derivation: `docs/math/dynamics.md`, section 3. With W the velocity field that `w`
//! would generate, L = Σ_i W_i · f_i. An increment of an ancestor l turns the whole subtree with S_l, which changes no
//! product, and adds x = ψ̇_l to its twists, y = χ_l = [W_λ, S_l] to W and z = ψ̈_l to its accelerations; a rate adds
//! x = S_l, z = σ_l, an acceleration z = S_l. The gradient of index k answers linearly: z·Z_k + y·Q_k + x·X_k. So each
//! pair of an index with an ancestor is visited once and costs ten products of six-vectors.
//! Base columns do not commute; the exponential chart q ⊕ δ takes the mean of both orders.

use crate::crba::branch_pattern;
use crate::path::{LANES, Path, plus, products};
use crate::rnea::{NAN_TWIST, NAN_VECTOR, NAN_WRENCH};
use crate::rnea_derivatives::FirstDerivatives;
use crate::subtree::{Directions, Subtree};
use crate::symmetric3::Symmetric3;
use crate::world_inertia::Gyration;
use crate::{Kinematics, Model};
use nalgebra::{DMatrix, Vector3};
use spatial::{Twist, Wrench};

/// Workspace for the contracted second derivatives of inverse dynamics.
#[derive(Debug, Clone)]
pub struct RneaHessian {
    subtree: Subtree,
    /// W per joint.
    weight: Vec<Twist>,
    /// χ per index.
    chi: Vec<Twist>,
    /// Σ I W per joint: the momentum of the weights.
    weight_momentum: Vec<Wrench>,
    /// Σ J̇ with W in place of V, per joint.
    weight_rate: Vec<Symmetric3>,
    /// Σ BᵀW per joint; its linear part is zero.
    weight_gyration: Vec<Vector3<f64>>,
    /// ψ̈, ψ̇, σ, S, χ of the indices from the root to the current joint.
    path: Path<5>,
    first: FirstDerivatives,
    value: f64,
    gradient_q: Vec<f64>,
    gradient_v: Vec<f64>,
    gradient_a: Vec<f64>,
    hessian_qq: DMatrix<f64>,
    hessian_qv: DMatrix<f64>,
    hessian_vv: DMatrix<f64>,
    hessian_qa: DMatrix<f64>,
}

/// How the gradient of one index answers to what its ancestors do. The answers to y are those of [`FirstSide`]:
/// of ∂L/∂q `by_position`, of ∂L/∂v `by_velocity`, of ∂L/∂a `inertia_column`.
#[derive(Debug, Clone, Copy)]
struct Side {
    /// Of ∂L/∂q to z.
    q_by_acceleration: Wrench,
    /// Of ∂L/∂q to x.
    q_by_velocity: Wrench,
    /// Of ∂L/∂v to x.
    v_by_velocity: Wrench,
}

impl RneaHessian {
    /// Room for a model; entries that depend on the state are NaN, those of different branches zero for good.
    pub fn new(model: &Model) -> Self {
        let (n, nv) = (model.joints.len(), model.nv);
        let pattern = branch_pattern(model);
        let gradient = vec![f64::NAN; nv];
        Self {
            subtree: Subtree::new(model),
            weight: vec![NAN_TWIST; n],
            chi: vec![NAN_TWIST; nv],
            weight_momentum: vec![NAN_WRENCH; n],
            weight_rate: vec![Symmetric3::NAN; n],
            weight_gyration: vec![NAN_VECTOR; n],
            path: Path::new(model),
            first: FirstDerivatives::new(model),
            value: f64::NAN,
            gradient_q: gradient.clone(),
            gradient_v: gradient.clone(),
            gradient_a: gradient,
            hessian_qq: pattern.clone(),
            hessian_qv: pattern.clone(),
            hessian_vv: pattern.clone(),
            hessian_qa: pattern,
        }
    }

    /// Evaluates τ, its first derivatives, and L = wᵀτ with gradient and Hessian; q through the kinematics. No allocation.
    ///
    /// # Panics
    /// If `v`, `a` or `w` is shorter than nv.
    pub fn compute(
        &mut self,
        model: &Model,
        kinematics: &Kinematics,
        v: &[f64],
        a: &[f64],
        w: &[f64],
    ) {
        self.sweep(model, kinematics, v, a, w);
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
                self.path.set(
                    depth + k - own.start,
                    [psi_ddot, psi_dot, sigma, column, &self.chi[k]],
                );
            }
            for k in own.clone() {
                self.pairs(model, i, k);
            }
            for k in own.clone() {
                for l in own.start..k {
                    take_mean(&mut self.hessian_qq, l, k);
                    take_mean(&mut self.hessian_vv, l, k);
                }
            }
        }
    }

    /// L and its gradient alone, a fifth of the work of [`RneaHessian::compute`]; all matrices keep their old values.
    ///
    /// # Panics
    /// If `v`, `a` or `w` is shorter than nv.
    pub fn compute_gradient(
        &mut self,
        model: &Model,
        kinematics: &Kinematics,
        v: &[f64],
        a: &[f64],
        w: &[f64],
    ) {
        self.sweep(model, kinematics, v, a, w);
    }

    /// Motion outward, subtree sums inward, gradient.
    fn sweep(&mut self, model: &Model, kinematics: &Kinematics, v: &[f64], a: &[f64], w: &[f64]) {
        for (i, joint) in model.joints.iter().enumerate() {
            self.subtree.forward(model, kinematics, v, a, i);
            let above = joint
                .parent
                .map_or(Twist::zero(), |parent| self.weight[parent]);
            let mut weight = above;
            for k in joint.idx_v..joint.idx_v + joint.kind.nv() {
                let column = self.subtree.directions[k].column;
                self.chi[k] = above.cross(&column);
                weight += column * w[k];
            }
            let inertia = &self.subtree.inertia[i];
            let gyration = self.subtree.gyration(i);
            self.weight[i] = weight;
            self.weight_momentum[i] = inertia.apply(&weight);
            self.weight_rate[i] = inertia.rate(&weight);
            self.weight_gyration[i] = gyration.transposed(&weight);
        }
        self.value = 0.0;
        for (i, joint) in model.joints.iter().enumerate().rev() {
            for k in joint.idx_v..joint.idx_v + joint.kind.nv() {
                let Directions {
                    psi_dot,
                    psi_ddot,
                    sigma,
                    column,
                } = &self.subtree.directions[k];
                let (force, momentum, gyration) = (
                    &self.subtree.force[i],
                    &self.weight_momentum[i],
                    &self.weight_gyration[i],
                );
                self.gradient_q[k] = momentum.power(psi_ddot)
                    + gyration.dot(&psi_dot.angular)
                    + force.power(&self.chi[k]);
                self.gradient_v[k] = gyration.dot(&column.angular) + momentum.power(sigma);
                self.gradient_a[k] = momentum.power(column);
                self.value += w[k] * force.power(column);
            }
            if let Some(parent) = joint.parent {
                self.subtree.add_to(parent, i);
                let (momentum, rate) = (self.weight_momentum[i], self.weight_rate[i]);
                let gyration = self.weight_gyration[i];
                self.weight_momentum[parent] += momentum;
                self.weight_rate[parent] += rate;
                self.weight_gyration[parent] += gyration;
            }
        }
    }

    #[inline]
    fn side(&self, i: usize, k: usize) -> Side {
        let Directions {
            psi_dot, column, ..
        } = &self.subtree.directions[k];
        let chi = &self.chi[k];
        let momentum = &self.weight_momentum[i];
        let of_weight = Gyration {
            momentum,
            rate: &self.weight_rate[i],
        };
        let turned = column.cross_wrench(momentum);
        let moment = column.angular.cross(&self.weight_gyration[i])
            + self.subtree.gyration(i).transposed(chi);
        let mut q_by_velocity = psi_dot.cross_wrench(momentum) * 2.0 - of_weight.apply(psi_dot);
        q_by_velocity.angular += moment;
        Side {
            q_by_acceleration: turned + self.subtree.inertia[i].apply(chi),
            q_by_velocity,
            v_by_velocity: turned * 2.0 - of_weight.apply(column),
        }
    }

    /// All pairs of index k (of joint i) with the indices of its support.
    #[inline]
    fn pairs(&mut self, model: &Model, i: usize, k: usize) {
        let (support, first_own, nv) = (&model.supports[i], model.joints[i].idx_v, model.nv);
        let first_side = self.subtree.first_side(i, k);
        let side = self.side(i, k);
        self.first.tau[k] = self.subtree.force[i].power(&self.subtree.directions[k].column);
        let (qq, qv) = (
            self.hessian_qq.as_mut_slice(),
            self.hessian_qv.as_mut_slice(),
        );
        let (vv, qa) = (
            self.hessian_vv.as_mut_slice(),
            self.hessian_qa.as_mut_slice(),
        );
        let blocks = self
            .path
            .blocks(support.len())
            .iter()
            .zip(support.chunks(LANES));
        for ([psi_ddot, psi_dot, sigma, column, chi], indices) in blocks {
            self.first.write(
                [psi_ddot, psi_dot, sigma, column],
                indices,
                first_own,
                k,
                &first_side,
            );
            let qq_both = plus(
                plus(
                    products(psi_ddot, &side.q_by_acceleration),
                    products(chi, &first_side.by_position),
                ),
                products(psi_dot, &side.q_by_velocity),
            );
            let qv_upper = plus(
                products(chi, &first_side.by_velocity),
                products(psi_dot, &side.v_by_velocity),
            );
            let qv_lower = plus(
                products(sigma, &side.q_by_acceleration),
                products(column, &side.q_by_velocity),
            );
            let vv_both = products(column, &side.v_by_velocity);
            let qa_upper = products(chi, &first_side.inertia_column);
            let qa_lower = products(column, &side.q_by_acceleration);
            for (lane, &l) in indices.iter().enumerate() {
                let (upper, lower) = (l + k * nv, k + l * nv);
                qq[upper] = qq_both[lane];
                qv[upper] = qv_upper[lane];
                vv[upper] = vv_both[lane];
                qa[upper] = qa_upper[lane];
                // within a joint every ordered pair comes as an upper one
                if l < first_own {
                    qq[lower] = qq_both[lane];
                    qv[lower] = qv_lower[lane];
                    vv[lower] = vv_both[lane];
                    qa[lower] = qa_lower[lane];
                }
            }
        }
    }

    /// τ = ID(q, v, a), length nv; like the first derivatives written by [`RneaHessian::compute`] only.
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

    /// wᵀτ.
    pub fn value(&self) -> f64 {
        self.value
    }

    /// ∂(wᵀτ)/∂q by body increments, length nv.
    pub fn gradient_q(&self) -> &[f64] {
        &self.gradient_q
    }

    /// ∂(wᵀτ)/∂v, length nv.
    pub fn gradient_v(&self) -> &[f64] {
        &self.gradient_v
    }

    /// ∂(wᵀτ)/∂a = M w, length nv.
    pub fn gradient_a(&self) -> &[f64] {
        &self.gradient_a
    }

    /// Hessian of δ ↦ wᵀ ID(q ⊕ δ, v, a), nv×nv, symmetric.
    pub fn hessian_qq(&self) -> &DMatrix<f64> {
        &self.hessian_qq
    }

    /// ∂²(wᵀτ)/∂q∂v, nv×nv, rows q, columns v.
    pub fn hessian_qv(&self) -> &DMatrix<f64> {
        &self.hessian_qv
    }

    /// ∂²(wᵀτ)/∂v², nv×nv, symmetric.
    pub fn hessian_vv(&self) -> &DMatrix<f64> {
        &self.hessian_vv
    }

    /// ∂²(wᵀτ)/∂q∂a, nv×nv, rows q, columns a. (∂²/∂v∂a and ∂²/∂a² vanish.)
    pub fn hessian_qa(&self) -> &DMatrix<f64> {
        &self.hessian_qa
    }
}

#[inline]
fn take_mean(matrix: &mut DMatrix<f64>, l: usize, k: usize) {
    let mean = 0.5 * (matrix[(l, k)] + matrix[(k, l)]);
    matrix[(l, k)] = mean;
    matrix[(k, l)] = mean;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::samples;
    use crate::{Rnea, RneaDerivatives};
    use derivcheck::{assert_hessian_of_value, assert_jacobian};

    #[test]
    fn value_and_gradient_are_those_of_the_first_derivatives() {
        for sample in samples() {
            let (model, kinematics) = (&sample.model, sample.kinematics());
            let (v, a, w) = (&sample.v, &sample.a, &sample.w);
            let mut hessian = RneaHessian::new(model);
            hessian.compute_gradient(model, &kinematics, v, a, w);
            let mut derivatives = RneaDerivatives::new(model);
            derivatives.compute(model, &kinematics, v, a);
            let weights = nalgebra::DVector::from_column_slice(w);
            let value: f64 = derivatives.tau().iter().zip(w).map(|(x, y)| x * y).sum();
            assert!((hessian.value() - value).abs() < 1e-11 * (1.0 + value.abs()));
            let pairs = [
                (hessian.gradient_q(), derivatives.dtau_dq()),
                (hessian.gradient_v(), derivatives.dtau_dv()),
                (hessian.gradient_a(), derivatives.dtau_da()),
            ];
            for (gradient, jacobian) in pairs {
                let expected = jacobian.tr_mul(&weights);
                let gap = nalgebra::DVector::from_column_slice(gradient) - &expected;
                assert!(
                    gap.norm() < 1e-12 * expected.norm(),
                    "{}",
                    gap.norm() / expected.norm()
                );
            }
        }
    }

    #[test]
    fn first_derivatives_come_along() {
        for sample in samples() {
            let (model, kinematics) = (&sample.model, sample.kinematics());
            let (v, a, w) = (&sample.v, &sample.a, &sample.w);
            let mut hessian = RneaHessian::new(model);
            hessian.compute(model, &kinematics, v, a, w);
            let mut derivatives = RneaDerivatives::new(model);
            derivatives.compute(model, &kinematics, v, a);
            assert_eq!(hessian.tau(), derivatives.tau());
            assert_eq!(hessian.dtau_dq(), derivatives.dtau_dq());
            assert_eq!(hessian.dtau_dv(), derivatives.dtau_dv());
            assert_eq!(hessian.dtau_da(), derivatives.dtau_da());
        }
    }

    #[test]
    fn hessians_match_finite_differences_of_the_gradient() {
        for sample in samples() {
            let (model, kinematics) = (&sample.model, sample.kinematics());
            let (v, a, w) = (&sample.v, &sample.a, &sample.w);
            let mut hessian = RneaHessian::new(model);
            hessian.compute(model, &kinematics, v, a, w);
            let gradients = |kinematics: &Kinematics, v: &[f64], a: &[f64]| {
                let mut there = RneaHessian::new(model);
                there.compute_gradient(model, kinematics, v, a, w);
                there
            };
            let zero = vec![0.0; model.nv];
            let of_v = |v: &[f64]| gradients(&kinematics, v, a);
            let of_a = |a: &[f64]| gradients(&kinematics, v, a);
            let of_q = |dq: &[f64]| gradients(&sample.kinematics_at(dq), v, a);
            assert_jacobian(
                |x| of_v(x).gradient_q().to_vec(),
                v,
                hessian.hessian_qv().as_slice(),
                1e-9,
            );
            assert_jacobian(
                |x| of_v(x).gradient_v().to_vec(),
                v,
                hessian.hessian_vv().as_slice(),
                1e-9,
            );
            assert_jacobian(
                |x| of_a(x).gradient_q().to_vec(),
                a,
                hessian.hessian_qa().as_slice(),
                1e-9,
            );
            assert_jacobian(
                |x| of_a(x).gradient_a().to_vec(),
                a,
                &vec![0.0; model.nv * model.nv],
                1e-9,
            );
            // by q the mixed blocks again, from the other side
            let qv = hessian.hessian_qv().transpose();
            let qa = hessian.hessian_qa().transpose();
            assert_jacobian(
                |x| of_q(x).gradient_v().to_vec(),
                &zero,
                qv.as_slice(),
                1e-9,
            );
            assert_jacobian(
                |x| of_q(x).gradient_a().to_vec(),
                &zero,
                qa.as_slice(),
                1e-9,
            );
            assert_eq!(*hessian.hessian_qq(), hessian.hessian_qq().transpose());
        }
    }

    #[test]
    fn the_position_block_is_the_hessian_in_the_exponential_chart() {
        for sample in samples() {
            let (model, kinematics) = (&sample.model, sample.kinematics());
            let (v, a, w) = (&sample.v, &sample.a, &sample.w);
            let mut hessian = RneaHessian::new(model);
            hessian.compute(model, &kinematics, v, a, w);
            // the gradient of the chart differs from `gradient_q` away from its origin, so differences of the value
            let value = |dq: &[f64]| {
                let mut rnea = Rnea::new(model);
                let tau = rnea.compute(model, &sample.kinematics_at(dq), v, a);
                tau.iter().zip(w).map(|(x, y)| x * y).sum()
            };
            assert_hessian_of_value(
                value,
                &vec![0.0; model.nv],
                hessian.hessian_qq().as_slice(),
                1e-7,
            );
        }
    }
}
