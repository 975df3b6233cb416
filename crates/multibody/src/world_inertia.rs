//! Inertia of a body or of a subtree about the world origin, in world axes: such inertias add entry by entry.

use crate::symmetric3::Symmetric3;
use nalgebra::Vector3;
use spatial::{Inertia, Pose, Twist, Wrench};
use std::ops::AddAssign;

/// m, h = m c and the rotational inertia J about the origin: [m 1, −[h]×; [h]×, J].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct WorldInertia {
    pub mass: f64,
    /// Mass times centre of mass.
    pub moment: Vector3<f64>,
    pub rotational: Symmetric3,
}

impl WorldInertia {
    pub const NAN: Self = Self {
        mass: f64::NAN,
        moment: Vector3::new(f64::NAN, f64::NAN, f64::NAN),
        rotational: Symmetric3::NAN,
    };

    #[inline]
    pub fn new(inertia: &Inertia, world_from_body: &Pose) -> Self {
        let com = world_from_body.act(inertia.com);
        let moment = com * inertia.mass;
        let about_com = Symmetric3::rotated(world_from_body.rotation(), &inertia.inertia);
        let rotational = about_com.plus_scaled(&Symmetric3::lever(&moment, &com), 0.5);
        Self {
            mass: inertia.mass,
            moment,
            rotational,
        }
    }

    /// Momentum of the body that moves with `twist`.
    #[inline]
    pub fn apply(&self, twist: &Twist) -> Wrench {
        let (v, w, h) = (&twist.linear, &twist.angular, &self.moment);
        Wrench {
            linear: v * self.mass + w.cross(h),
            angular: self.rotational.times(w) + h.cross(v),
        }
    }

    /// J̇: the rate of J while the body moves with `twist`.
    #[inline]
    pub fn rate(&self, twist: &Twist) -> Symmetric3 {
        let mut rate = self.rotational.turning(&twist.angular);
        rate += Symmetric3::lever(&self.moment, &twist.linear);
        rate
    }
}

impl AddAssign for WorldInertia {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        self.mass += other.mass;
        self.moment += other.moment;
        self.rotational += other.rotational;
    }
}

/// The velocity-dependent part of how a force of inertia changes: ψ ↦ V ×* Iψ + ψ ×* IV − I[V, ψ].
///
/// It depends on V only through the momentum (p, L) = I V and on J̇ (`docs/math/dynamics.md`, section 2):
/// B ψ = (2 ψ_a × p, J̇ ψ_a + ψ_a × L). Sums over a subtree are sums of these nine numbers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Gyration<'a> {
    pub momentum: &'a Wrench,
    pub rate: &'a Symmetric3,
}

impl Gyration<'_> {
    /// B ψ
    #[inline]
    pub fn apply(&self, psi: &Twist) -> Wrench {
        let turn = &psi.angular;
        Wrench {
            linear: turn.cross(&self.momentum.linear) * 2.0,
            angular: self.rate.times(turn) + turn.cross(&self.momentum.angular),
        }
    }

    /// The angular part of Bᵀ ψ; the linear part is zero.
    #[inline]
    pub fn transposed(&self, psi: &Twist) -> Vector3<f64> {
        let (p, l) = (&self.momentum.linear, &self.momentum.angular);
        p.cross(&psi.linear) * 2.0 + self.rate.times(&psi.angular) + l.cross(&psi.angular)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Vector6};
    use spatial::ad;

    fn body() -> (WorldInertia, nalgebra::Matrix6<f64>) {
        let tensor = Matrix3::new(2.0, 0.3, -0.4, 0.3, 3.0, 0.5, -0.4, 0.5, 1.5);
        let inertia = Inertia {
            mass: 1.7,
            com: Vector3::new(0.3, -0.2, 0.6),
            inertia: tensor,
        };
        let pose = Pose::random(3);
        (
            WorldInertia::new(&inertia, &pose),
            inertia.transformed(&pose).matrix(),
        )
    }

    #[test]
    fn apply_is_the_product_with_the_spatial_inertia() {
        let (body, matrix) = body();
        let v = Vector6::new(0.3, -0.4, 0.5, 0.6, 0.7, -0.8);
        assert!((body.apply(&Twist::from_vector(&v)).to_vector() - matrix * v).norm() < 1e-13);
    }

    #[test]
    fn gyration_is_the_operator_of_its_definition() {
        let (body, matrix) = body();
        let v = Vector6::new(0.3, -0.4, 0.5, 0.6, 0.7, -0.8);
        let psi = Vector6::new(-1.0, 0.2, 0.4, 0.1, -0.3, 0.9);
        let y = Vector6::new(0.7, 0.1, -0.5, 0.2, 0.8, -0.6);
        let dual = |x: &Vector6<f64>| -ad(x).transpose();
        let expected = dual(&v) * matrix * psi + dual(&psi) * matrix * v - matrix * ad(&v) * psi;

        let twist = Twist::from_vector(&v);
        let gyration = Gyration {
            momentum: &body.apply(&twist),
            rate: &body.rate(&twist),
        };
        assert!((gyration.apply(&Twist::from_vector(&psi)).to_vector() - expected).norm() < 1e-13);
        let transposed = gyration.transposed(&Twist::from_vector(&y));
        assert!(
            (transposed.dot(&Twist::from_vector(&psi).angular) - expected.dot(&y)).abs() < 1e-13
        );
    }
}
