//! Velocity of a rigid body.

use crate::Wrench;
use nalgebra::{Vector3, Vector6};
use std::ops::{Add, AddAssign, Mul, Neg, Sub};

/// Linear velocity at the origin of a frame [m/s] and angular velocity [rad/s], in the axes of that frame.
///
/// Accelerations and momenta's partners share the type; a [`Wrench`] does not mix with it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Twist {
    /// Velocity of the body point at the origin of the frame.
    pub linear: Vector3<f64>,
    /// Angular velocity.
    pub angular: Vector3<f64>,
}

impl Twist {
    /// No motion.
    #[inline]
    pub fn zero() -> Self {
        Self {
            linear: Vector3::zeros(),
            angular: Vector3::zeros(),
        }
    }

    /// `[linear; angular]`.
    #[inline]
    pub fn to_vector(&self) -> Vector6<f64> {
        let (v, w) = (&self.linear, &self.angular);
        Vector6::new(v.x, v.y, v.z, w.x, w.y, w.z)
    }

    /// From `[linear; angular]`.
    #[inline]
    pub fn from_vector(vector: &Vector6<f64>) -> Self {
        Self {
            linear: Vector3::new(vector[0], vector[1], vector[2]),
            angular: Vector3::new(vector[3], vector[4], vector[5]),
        }
    }

    /// Velocity of the body point at `point` (in the same frame).
    #[inline]
    pub fn at(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.linear + self.angular.cross(point)
    }

    /// Lie bracket [self, other]: the rate of `other` when it is carried along by the motion `self`.
    #[inline]
    #[must_use]
    pub fn cross(&self, other: &Self) -> Self {
        Self {
            linear: self.angular.cross(&other.linear) + self.linear.cross(&other.angular),
            angular: self.angular.cross(&other.angular),
        }
    }

    /// self ×* wrench: the rate of a wrench (or momentum) that is carried along by the motion `self`.
    #[inline]
    pub fn cross_wrench(&self, wrench: &Wrench) -> Wrench {
        Wrench {
            linear: self.angular.cross(&wrench.linear),
            angular: self.angular.cross(&wrench.angular) + self.linear.cross(&wrench.linear),
        }
    }
}

impl Add for Twist {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self {
            linear: self.linear + other.linear,
            angular: self.angular + other.angular,
        }
    }
}

impl AddAssign for Twist {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for Twist {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self {
            linear: self.linear - other.linear,
            angular: self.angular - other.angular,
        }
    }
}

impl Neg for Twist {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self {
            linear: -self.linear,
            angular: -self.angular,
        }
    }
}

impl Mul<f64> for Twist {
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
    use crate::ad;

    #[test]
    fn the_rim_of_a_spinning_wheel_moves_sideways() {
        let wheel = Twist {
            linear: Vector3::zeros(),
            angular: Vector3::new(0.0, 0.0, 2.0),
        };
        assert_eq!(
            wheel.at(&Vector3::new(0.5, 0.0, 0.0)),
            Vector3::new(0.0, 1.0, 0.0)
        );
    }

    #[test]
    fn crosses_are_the_bracket_and_minus_its_transpose() {
        let x = Vector6::new(0.3, -0.4, 0.5, 0.6, 0.7, -0.8);
        let y = Vector6::new(-1.0, 0.2, 0.4, 0.1, -0.3, 0.9);
        let bracket = Twist::from_vector(&x)
            .cross(&Twist::from_vector(&y))
            .to_vector();
        let dual = Twist::from_vector(&x)
            .cross_wrench(&Wrench::from_vector(&y))
            .to_vector();
        assert!((bracket - ad(&x) * y).norm() < 1e-15);
        assert!((dual + ad(&x).transpose() * y).norm() < 1e-15);
    }
}
