//! Force and moment on a rigid body.

use crate::Twist;
use nalgebra::{Vector3, Vector6};
use std::ops::{Add, AddAssign, Mul, Neg, Sub};

/// Force [N] and moment about the origin of a frame [N·m], in the axes of that frame; momenta share the type.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wrench {
    /// Force.
    pub linear: Vector3<f64>,
    /// Moment about the origin of the frame.
    pub angular: Vector3<f64>,
}

impl Wrench {
    /// No force.
    #[inline]
    pub fn zero() -> Self {
        Self {
            linear: Vector3::zeros(),
            angular: Vector3::zeros(),
        }
    }

    /// `[force; moment]`.
    #[inline]
    pub fn to_vector(&self) -> Vector6<f64> {
        let (f, n) = (&self.linear, &self.angular);
        Vector6::new(f.x, f.y, f.z, n.x, n.y, n.z)
    }

    /// From `[force; moment]`.
    #[inline]
    pub fn from_vector(vector: &Vector6<f64>) -> Self {
        Self {
            linear: Vector3::new(vector[0], vector[1], vector[2]),
            angular: Vector3::new(vector[3], vector[4], vector[5]),
        }
    }

    /// The wrench of a force that acts at `point` (in the same frame).
    #[inline]
    pub fn of_force_at(force: Vector3<f64>, point: &Vector3<f64>) -> Self {
        Self {
            linear: force,
            angular: point.cross(&force),
        }
    }

    /// Power of the wrench on a body that moves with `twist`, both in one frame [W].
    #[inline]
    pub fn power(&self, twist: &Twist) -> f64 {
        self.linear.dot(&twist.linear) + self.angular.dot(&twist.angular)
    }
}

impl Add for Wrench {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self {
            linear: self.linear + other.linear,
            angular: self.angular + other.angular,
        }
    }
}

impl AddAssign for Wrench {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for Wrench {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self {
            linear: self.linear - other.linear,
            angular: self.angular - other.angular,
        }
    }
}

impl Neg for Wrench {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self {
            linear: -self.linear,
            angular: -self.angular,
        }
    }
}

impl Mul<f64> for Wrench {
    type Output = Self;
    #[inline]
    fn mul(self, factor: f64) -> Self {
        Self {
            linear: self.linear * factor,
            angular: self.angular * factor,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_force_on_a_lever_has_the_moment_of_the_lever() {
        let wrench =
            Wrench::of_force_at(Vector3::new(0.0, 10.0, 0.0), &Vector3::new(0.5, 0.0, 0.0));
        assert_eq!(wrench.angular, Vector3::new(0.0, 0.0, 5.0));
        let turning = Twist {
            linear: Vector3::zeros(),
            angular: Vector3::new(0.0, 0.0, 2.0),
        };
        assert_eq!(wrench.power(&turning), 10.0);
    }
}
