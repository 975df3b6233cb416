//! Mass distribution of a rigid body.

use crate::{Pose, Twist, Wrench, skew};
use nalgebra::{Matrix3, Matrix6, Vector3};
use std::ops::Add;

/// Mass, centre of mass and rotational inertia of a rigid body, in one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inertia {
    /// Mass [kg].
    pub mass: f64,
    /// Centre of mass in the frame [m].
    pub com: Vector3<f64>,
    /// Rotational inertia about the centre of mass, axes of the frame, symmetric [kg·m²].
    pub inertia: Matrix3<f64>,
}

impl Inertia {
    /// A body without mass.
    #[inline]
    pub fn zero() -> Self {
        Self {
            mass: 0.0,
            com: Vector3::zeros(),
            inertia: Matrix3::zeros(),
        }
    }

    /// Spatial inertia about the frame origin, 6×6: `matrix() * twist` is the momentum, linear before angular.
    ///
    /// [m I, −m[c]×; m[c]×, I_c − m[c]×²], symmetric, positive definite for a body with volume and mass.
    #[rustfmt::skip]
    pub fn matrix(&self) -> Matrix6<f64> {
        let c = skew(&self.com);
        let mut matrix = Matrix6::zeros();
        matrix.fixed_view_mut::<3, 3>(0, 0).copy_from(&(Matrix3::identity() * self.mass));
        matrix.fixed_view_mut::<3, 3>(0, 3).copy_from(&(c * -self.mass));
        matrix.fixed_view_mut::<3, 3>(3, 0).copy_from(&(c *  self.mass));
        matrix.fixed_view_mut::<3, 3>(3, 3).copy_from(&self.about_origin());
        matrix
    }

    /// Rotational inertia about the frame origin [kg·m²].
    #[inline]
    pub fn about_origin(&self) -> Matrix3<f64> {
        let c = skew(&self.com);
        self.inertia - c * c * self.mass
    }

    /// Momentum of the body that moves with `twist`, about the frame origin [N·s; N·m·s].
    #[inline]
    pub fn apply(&self, twist: &Twist) -> Wrench {
        let linear = twist.at(&self.com) * self.mass;
        Wrench {
            linear,
            angular: self.inertia * twist.angular + self.com.cross(&linear),
        }
    }

    /// The same body in another frame.
    #[inline]
    #[must_use]
    pub fn transformed(&self, to_from_of: &Pose) -> Self {
        let r = to_from_of.rotation();
        Self {
            mass: self.mass,
            com: to_from_of.act(self.com),
            inertia: r * self.inertia * r.transpose(),
        }
    }
}

impl Default for Inertia {
    fn default() -> Self {
        Self::zero()
    }
}

impl Add for Inertia {
    type Output = Self;

    /// Both bodies as one rigid body. Two massless bodies keep the mean of nothing: the centre stays at the origin.
    fn add(self, other: Self) -> Self {
        let mass = self.mass + other.mass;
        if mass == 0.0 {
            return Self {
                mass,
                com: Vector3::zeros(),
                inertia: self.inertia + other.inertia,
            };
        }
        let com = (self.com * self.mass + other.com * other.mass) / mass;
        // Parallel axes: each part is moved from its own centre to the common one.
        let moved = |part: &Self| {
            let offset = skew(&(part.com - com));
            part.inertia - offset * offset * part.mass
        };
        Self {
            mass,
            com,
            inertia: moved(&self) + moved(&other),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;
    use nalgebra::Vector6;

    fn random_inertia(seed: u64) -> Inertia {
        let mut random = Random::new(seed);
        let root = Matrix3::from_fn(|_, _| random.uniform(-1.0, 1.0));
        let com = Vector3::from_fn(|_, _| random.uniform(-1.0, 1.0));
        Inertia {
            mass: random.uniform(0.1, 5.0),
            com,
            inertia: root * root.transpose(),
        }
    }

    fn twist() -> Twist {
        Twist::from_vector(&Vector6::new(0.3, -0.4, 0.5, 0.6, 0.7, -0.8))
    }

    #[test]
    fn two_half_kilograms_on_a_bar_have_the_inertia_of_a_dumbbell() {
        let ball = |x| Inertia {
            mass: 0.5,
            com: Vector3::new(x, 0.0, 0.0),
            inertia: Matrix3::zeros(),
        };
        let dumbbell = ball(1.0) + ball(-1.0);
        assert_eq!(dumbbell.mass, 1.0);
        assert_eq!(dumbbell.com, Vector3::zeros());
        assert_eq!(
            dumbbell.inertia,
            Matrix3::from_diagonal(&Vector3::new(0.0, 1.0, 1.0))
        );
    }

    #[test]
    fn apply_is_the_product_with_the_matrix() {
        let inertia = random_inertia(1);
        let difference =
            inertia.apply(&twist()).to_vector() - inertia.matrix() * twist().to_vector();
        assert!(difference.norm() < 1e-14);
    }

    #[test]
    fn momentum_transforms_like_a_wrench() {
        let (inertia, pose) = (random_inertia(2), Pose::random(3));
        let there = inertia.transformed(&pose).apply(&pose.act_twist(&twist()));
        assert!(
            (there.to_vector() - pose.act_wrench(&inertia.apply(&twist())).to_vector()).norm()
                < 1e-14
        );
    }

    #[test]
    fn inertias_add_like_their_matrices() {
        let (a, b) = (random_inertia(4), random_inertia(5));
        assert!(((a + b).matrix() - a.matrix() - b.matrix()).norm() < 1e-14);
        assert_eq!((a + Inertia::zero()).mass, a.mass);
        assert_eq!(Inertia::zero() + Inertia::zero(), Inertia::zero());
    }
}
