//! First derivatives of the centroidal momentum h(q, v), and the contracted Hessian of yᵀ h.
//!
//! Frames: world axes; sums over subtrees about the world origin, results about the centre of mass c.
//! Legend: p linear momentum, L angular momentum about the world origin, so h = (p, L − c × p); per subtree behind k: I_k
//! inertia, H_k momentum; ψ̇ = [V_λ, S]; for the Hessian χ = [Y, S] with Y the constant twist (y_lin − y_ang × c, y_ang)
//! about the world origin. Derivation: `docs/math/dynamics.md`, section 4.

use crate::centroidal::total_com;
use crate::path::{LANES, Path, angular_products, plus, products};
use crate::rnea::{NAN_TWIST, NAN_VECTOR, NAN_WRENCH};
use crate::world_inertia::WorldInertia;
use crate::{Kinematics, Model};
use nalgebra::{DMatrix, Matrix6xX, Vector3, Vector6};
use spatial::{Twist, Wrench};

/// Workspace for the derivatives of the centroidal momentum.
#[derive(Debug, Clone)]
pub struct CentroidalDerivatives {
    twist: Vec<Twist>,
    composite: Vec<WorldInertia>,
    momentum: Vec<Wrench>,
    directions: Vec<Directions>,
    com: Vector3<f64>,
    total: Wrench,
    h: Vector6<f64>,
    dh_dq: Matrix6xX<f64>,
    dh_dv: Matrix6xX<f64>,
    sides: Vec<Side>,
    /// χ, ψ̇, S of the indices from the root to the current joint.
    path: Path<3>,
    hessian_qq: DMatrix<f64>,
    hessian_qv: DMatrix<f64>,
}

/// A velocity index: column, ψ̇, momentum of a unit rate, ∂(p, L)/∂q about the world origin, ∂c/∂q.
#[derive(Debug, Clone, Copy)]
struct Directions {
    column: Twist,
    psi_dot: Twist,
    by_velocity: Wrench,
    by_position: Wrench,
    dc_dq: Vector3<f64>,
    /// χ, for the Hessian.
    chi: Twist,
    /// −y_ang × ∂c/∂q, for the Hessian.
    lever: Vector3<f64>,
}

/// How the gradient of one index answers to what its ancestors do.
#[derive(Debug, Clone, Copy)]
struct Side {
    /// Of ∂/∂q to y.
    q_by_weight: Wrench,
    /// Of ∂/∂q to x.
    by_velocity: Wrench,
    /// Of ∂/∂v to y.
    v_by_weight: Wrench,
    /// Of ∂c/∂q, weighted, to a turn.
    turned_com: Vector3<f64>,
}

const NAN_SIDE: Side = Side {
    q_by_weight: NAN_WRENCH,
    by_velocity: NAN_WRENCH,
    v_by_weight: NAN_WRENCH,
    turned_com: NAN_VECTOR,
};

const NAN_DIRECTIONS: Directions = Directions {
    column: NAN_TWIST,
    psi_dot: NAN_TWIST,
    by_velocity: NAN_WRENCH,
    by_position: NAN_WRENCH,
    dc_dq: NAN_VECTOR,
    chi: NAN_TWIST,
    lever: NAN_VECTOR,
};

impl CentroidalDerivatives {
    /// Room for a model; entries that depend on the state are NaN.
    pub fn new(model: &Model) -> Self {
        let (n, nv) = (model.joints.len(), model.nv);
        Self {
            twist: vec![NAN_TWIST; n],
            composite: vec![WorldInertia::NAN; n],
            momentum: vec![NAN_WRENCH; n],
            directions: vec![NAN_DIRECTIONS; nv],
            com: NAN_VECTOR,
            total: NAN_WRENCH,
            h: Vector6::repeat(f64::NAN),
            dh_dq: Matrix6xX::repeat(nv, f64::NAN),
            dh_dv: Matrix6xX::repeat(nv, f64::NAN),
            sides: vec![NAN_SIDE; nv],
            path: Path::new(model),
            hessian_qq: DMatrix::repeat(nv, nv, f64::NAN),
            hessian_qv: DMatrix::repeat(nv, nv, f64::NAN),
        }
    }

    /// Evaluates h, ∂h/∂q and ∂h/∂v = A at (q, v); q through the kinematics. No allocation.
    ///
    /// # Panics
    /// If `v` is shorter than nv.
    pub fn compute(&mut self, model: &Model, kinematics: &Kinematics, v: &[f64]) {
        self.sweep(model, kinematics, v);
        self.com = total_com(model, &self.composite);
        let mass: f64 = model.total_mass();
        for (i, joint) in model.joints.iter().enumerate() {
            for k in joint.idx_v..joint.idx_v + joint.kind.nv() {
                let Directions {
                    column, psi_dot, ..
                } = self.directions[k];
                let by_velocity = self.composite[i].apply(&column);
                let by_position =
                    column.cross_wrench(&self.momentum[i]) + self.composite[i].apply(&psi_dot);
                let dc_dq = by_velocity.linear / mass;
                self.directions[k] = Directions {
                    column,
                    psi_dot,
                    by_velocity,
                    by_position,
                    dc_dq,
                    ..NAN_DIRECTIONS
                };
                let about_com = |wrench: &Wrench| wrench.angular - self.com.cross(&wrench.linear);
                let dq_angular = about_com(&by_position) - dc_dq.cross(&self.total.linear);
                set_column(
                    &mut self.dh_dv,
                    k,
                    &by_velocity.linear,
                    &about_com(&by_velocity),
                );
                set_column(&mut self.dh_dq, k, &by_position.linear, &dq_angular);
            }
        }
        let (p, l) = (
            self.total.linear,
            self.total.angular - self.com.cross(&self.total.linear),
        );
        self.h = Vector6::new(p.x, p.y, p.z, l.x, l.y, l.z);
    }

    /// Twists outward, inertia and momentum of subtrees inward.
    fn sweep(&mut self, model: &Model, kinematics: &Kinematics, v: &[f64]) {
        for (i, joint) in model.joints.iter().enumerate() {
            let above = joint
                .parent
                .map_or(Twist::zero(), |parent| self.twist[parent]);
            let mut twist = above;
            for k in joint.idx_v..joint.idx_v + joint.kind.nv() {
                let column = Twist::from_vector(&kinematics.column_in_world[k]);
                twist += column * v[k];
                self.directions[k] = Directions {
                    column,
                    psi_dot: above.cross(&column),
                    ..NAN_DIRECTIONS
                };
            }
            self.twist[i] = twist;
            self.composite[i] = WorldInertia::new(&joint.inertia, &kinematics.world_from_joint[i]);
            self.momentum[i] = self.composite[i].apply(&twist);
        }
        self.total = Wrench::zero();
        for (i, joint) in model.joints.iter().enumerate().rev() {
            let (inertia, momentum) = (self.composite[i], self.momentum[i]);
            match joint.parent {
                Some(parent) => {
                    self.composite[parent] += inertia;
                    self.momentum[parent] += momentum;
                }
                None => self.total += momentum,
            }
        }
    }

    /// Hessian of yᵀ h by (q, v) at the state of the last [`CentroidalDerivatives::compute`]; `y` linear, then angular.
    ///
    /// Read it with [`CentroidalDerivatives::hessian_qq`] and [`CentroidalDerivatives::hessian_qv`]; ∂²/∂v² vanishes. No
    /// allocation.
    pub fn compute_hessian(&mut self, model: &Model, y: &Vector6<f64>) {
        let y = Twist::from_vector(y);
        let about_origin = Twist {
            linear: y.linear - y.angular.cross(&self.com),
            angular: y.angular,
        };
        // −y_ang·(c × p) bends with c too: this is its weight on ∂²c at constant p
        let com_weight = y.angular.cross(&self.total.linear);
        self.curvature_of_com_and_momentum(model.nv, &y.angular);
        for (i, joint) in model.joints.iter().enumerate() {
            let own = joint.idx_v..joint.idx_v + joint.kind.nv();
            let depth = model.supports[i].len() - joint.kind.nv();
            let weighted = self.composite[i].apply(&about_origin);
            for k in own.clone() {
                let Directions {
                    column,
                    psi_dot,
                    by_velocity,
                    by_position,
                    dc_dq,
                    ..
                } = self.directions[k];
                let chi = about_origin.cross(&column);
                self.directions[k].chi = chi;
                let side = Side {
                    q_by_weight: by_position,
                    by_velocity: self.composite[i].apply(&chi) + column.cross_wrench(&weighted),
                    v_by_weight: by_velocity,
                    turned_com: dc_dq.cross(&com_weight),
                };
                self.pairs_with_ancestors(model.nv, &model.supports[i][..depth], k, &side);
                self.sides[k] = side;
                self.path
                    .set(depth + k - own.start, [&chi, &psi_dot, &column]);
            }
            for k in own.clone() {
                own.clone().for_each(|l| self.pair_in_joint(l, k));
            }
        }
    }

    /// −y_ang·(∂c × ∂p), both orders: couples every index with every other. Overwrites both Hessians.
    fn curvature_of_com_and_momentum(&mut self, nv: usize, y_angular: &Vector3<f64>) {
        let (qq, qv) = (
            self.hessian_qq.as_mut_slice(),
            self.hessian_qv.as_mut_slice(),
        );
        for direction in &mut self.directions {
            direction.lever = direction.dc_dq.cross(y_angular);
        }
        for (k, at_k) in self.directions.iter().enumerate() {
            let column = k * nv..(k + 1) * nv;
            let entries = qq[column.clone()].iter_mut().zip(&mut qv[column]);
            for ((qq, qv), at_l) in entries.zip(&self.directions) {
                *qq = at_l.lever.dot(&at_k.by_position.linear)
                    + at_k.lever.dot(&at_l.by_position.linear);
                *qv = at_l.lever.dot(&at_k.by_velocity.linear);
            }
        }
    }

    #[inline]
    fn pairs_with_ancestors(&mut self, nv: usize, ancestors: &[usize], k: usize, side: &Side) {
        let (qq, qv) = (
            self.hessian_qq.as_mut_slice(),
            self.hessian_qv.as_mut_slice(),
        );
        let blocks = self.path.blocks(ancestors.len());
        for ([chi, psi_dot, column], indices) in blocks.iter().zip(ancestors.chunks(LANES)) {
            let qq_sum = plus(
                plus(
                    products(chi, &side.q_by_weight),
                    products(psi_dot, &side.by_velocity),
                ),
                angular_products(column, &side.turned_com),
            );
            let qv_upper = products(chi, &side.v_by_weight);
            let qv_lower = products(column, &side.by_velocity);
            for (lane, &l) in indices.iter().enumerate() {
                qq[l + k * nv] += qq_sum[lane];
                qq[k + l * nv] += qq_sum[lane];
                qv[l + k * nv] += qv_upper[lane];
                qv[k + l * nv] += qv_lower[lane];
            }
        }
    }

    /// Indices of one joint: the mean of both orders, see `rnea_hessian.rs`.
    #[inline]
    fn pair_in_joint(&mut self, l: usize, k: usize) {
        let side = &self.sides[k];
        let Directions {
            column,
            psi_dot,
            chi,
            ..
        } = &self.directions[l];
        let qq = side.q_by_weight.power(chi)
            + side.by_velocity.power(psi_dot)
            + side.turned_com.dot(&column.angular);
        self.hessian_qq[(l, k)] += 0.5 * qq;
        self.hessian_qq[(k, l)] += 0.5 * qq;
        self.hessian_qv[(l, k)] += side.v_by_weight.power(chi);
    }

    /// Centre of mass in the world [m].
    pub fn com(&self) -> Vector3<f64> {
        self.com
    }

    /// ∂c/∂q_k in the world, by body increments.
    pub fn dc_dq(&self, k: usize) -> Vector3<f64> {
        self.directions[k].dc_dq
    }

    /// h(q, v): linear, then angular about the centre of mass [N·s; N·m·s].
    pub fn h(&self) -> &Vector6<f64> {
        &self.h
    }

    /// ∂h/∂q by body increments, 6×nv.
    pub fn dh_dq(&self) -> &Matrix6xX<f64> {
        &self.dh_dq
    }

    /// ∂h/∂v = A(q), 6×nv.
    pub fn dh_dv(&self) -> &Matrix6xX<f64> {
        &self.dh_dv
    }

    /// Hessian of δ ↦ yᵀ h(q ⊕ δ, v), nv×nv, symmetric.
    pub fn hessian_qq(&self) -> &DMatrix<f64> {
        &self.hessian_qq
    }

    /// ∂²(yᵀh)/∂q∂v, nv×nv, rows q, columns v.
    pub fn hessian_qv(&self) -> &DMatrix<f64> {
        &self.hessian_qv
    }
}

#[inline]
fn set_column(
    matrix: &mut Matrix6xX<f64>,
    k: usize,
    linear: &Vector3<f64>,
    angular: &Vector3<f64>,
) {
    let column = Vector6::new(
        linear.x, linear.y, linear.z, angular.x, angular.y, angular.z,
    );
    matrix.set_column(k, &column);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Centroidal;
    use crate::samples::samples;
    use derivcheck::{assert_hessian_of_value, assert_jacobian};

    fn momentum(model: &Model, kinematics: &Kinematics, v: &[f64]) -> Vector6<f64> {
        let mut centroidal = Centroidal::new(model);
        centroidal.compute(model, kinematics);
        centroidal.momentum(v)
    }

    #[test]
    fn first_derivatives_match_finite_differences() {
        for sample in samples() {
            let (model, kinematics, v) = (&sample.model, sample.kinematics(), &sample.v);
            let mut derivatives = CentroidalDerivatives::new(model);
            derivatives.compute(model, &kinematics, v);
            let h = momentum(model, &kinematics, v);
            assert!((derivatives.h() - h).norm() < 1e-12 * h.norm());
            let by_q = |dq: &[f64]| {
                momentum(model, &sample.kinematics_at(dq), v)
                    .as_slice()
                    .to_vec()
            };
            let by_v = |v: &[f64]| momentum(model, &kinematics, v).as_slice().to_vec();
            assert_jacobian(
                by_q,
                &vec![0.0; model.nv],
                derivatives.dh_dq().as_slice(),
                1e-9,
            );
            assert_jacobian(by_v, v, derivatives.dh_dv().as_slice(), 1e-9);
        }
    }

    #[test]
    fn hessians_match_finite_differences() {
        let y = Vector6::new(0.3, -0.8, 0.5, 0.9, -0.2, 0.6);
        for sample in samples() {
            let (model, v) = (&sample.model, &sample.v);
            let mut derivatives = CentroidalDerivatives::new(model);
            derivatives.compute(model, &sample.kinematics(), v);
            derivatives.compute_hessian(model, &y);
            let zero = vec![0.0; model.nv];
            let value = |dq: &[f64]| y.dot(&momentum(model, &sample.kinematics_at(dq), v));
            assert_hessian_of_value(value, &zero, derivatives.hessian_qq().as_slice(), 1e-7);
            let gradient_v = |dq: &[f64]| {
                let mut centroidal = Centroidal::new(model);
                centroidal
                    .compute(model, &sample.kinematics_at(dq))
                    .tr_mul(&y)
                    .as_slice()
                    .to_vec()
            };
            let qv = derivatives.hessian_qv().transpose();
            assert_jacobian(gradient_v, &zero, qv.as_slice(), 1e-9);
        }
    }
}
