//! Rigid displacement of one frame relative to another: an element of SE(3).

use crate::se3::{angular, block_triangular, linear};
use crate::so3::{exp_so3, log_so3, quaternion, rotation_of, sin_cos_quotients, skew};
use crate::{Random, Twist, Wrench, bernoulli};
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use std::ops::Mul;

/// Pose of a frame, named `<to>_from_<of>`: it takes coordinates in the frame `of` to coordinates in the frame `to`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    rotation: Matrix3<f64>,
    translation: Vector3<f64>,
}

impl Pose {
    /// Both frames coincide.
    #[inline]
    pub fn identity() -> Self {
        Self {
            rotation: Matrix3::identity(),
            translation: Vector3::zeros(),
        }
    }

    /// Parallel axes, origin at (x, y, z) [m].
    #[inline]
    pub fn from_translation(x: f64, y: f64, z: f64) -> Self {
        Self {
            rotation: Matrix3::identity(),
            translation: Vector3::new(x, y, z),
        }
    }

    /// From a rotation matrix (must be orthonormal, see [`Pose::normalized`]) and the origin [m].
    #[inline]
    pub fn from_parts(rotation: Matrix3<f64>, translation: Vector3<f64>) -> Self {
        Self {
            rotation,
            translation,
        }
    }

    /// From `[x, y, z, qx, qy, qz, qw]`; the quaternion is normalised, one of zero length means no rotation.
    #[inline]
    pub fn from_xyzquat(xyzquat: &[f64; 7]) -> Self {
        let [x, y, z, qx, qy, qz, qw] = *xyzquat;
        let norm = (qx * qx + qy * qy + qz * qz + qw * qw).sqrt();
        let quat = if norm == 0.0 {
            [0.0, 0.0, 0.0, 1.0]
        } else {
            [qx, qy, qz, qw].map(|c| c / norm)
        };
        Self {
            rotation: rotation_of(quat),
            translation: Vector3::new(x, y, z),
        }
    }

    /// To `[x, y, z, qx, qy, qz, qw]` with a unit quaternion, qw ≥ 0.
    #[inline]
    pub fn to_xyzquat(&self) -> [f64; 7] {
        let [qx, qy, qz, qw] = quaternion(&self.rotation);
        let p = &self.translation;
        [p.x, p.y, p.z, qx, qy, qz, qw]
    }

    /// Rotation matrix: its columns are the axes of the frame `of` in the frame `to`.
    #[inline]
    pub fn rotation(&self) -> &Matrix3<f64> {
        &self.rotation
    }

    /// Origin of the frame `of` in the frame `to` [m].
    #[inline]
    pub fn origin(&self) -> Vector3<f64> {
        self.translation
    }

    /// `a_from_b` of `b_from_a`.
    #[inline]
    #[must_use]
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        Self {
            rotation,
            translation: -(rotation * self.translation),
        }
    }

    /// Coordinates of a point in `to`, given those in `of` [m].
    #[inline]
    pub fn act(&self, point: Vector3<f64>) -> Vector3<f64> {
        self.rotation * point + self.translation
    }

    /// Coordinates of a free vector in `to`, given those in `of`.
    #[inline]
    pub fn rotate(&self, vector: Vector3<f64>) -> Vector3<f64> {
        self.rotation * vector
    }

    /// Coordinates of a free vector in `of`, given those in `to`.
    #[inline]
    pub fn rotate_inverse(&self, vector: Vector3<f64>) -> Vector3<f64> {
        self.rotation.tr_mul(&vector)
    }

    /// Coordinates of a twist in `to` (taken at its origin), given those in `of`.
    #[inline]
    pub fn act_twist(&self, twist: &Twist) -> Twist {
        let angular = self.rotation * twist.angular;
        Twist {
            linear: self.rotation * twist.linear + self.translation.cross(&angular),
            angular,
        }
    }

    /// Coordinates of a wrench in `to` (about its origin), given those in `of`.
    #[inline]
    pub fn act_wrench(&self, wrench: &Wrench) -> Wrench {
        let linear = self.rotation * wrench.linear;
        Wrench {
            linear,
            angular: self.rotation * wrench.angular + self.translation.cross(&linear),
        }
    }

    /// Matrix of [`Pose::act_twist`], 6×6: [R, [p]×R; 0, R].
    #[inline]
    pub fn adjoint(&self) -> Matrix6<f64> {
        block_triangular(&self.rotation, &(skew(&self.translation) * self.rotation))
    }

    /// pose ⊕ ξ = pose · exp ξ, with ξ in the axes of the frame `of` [m; rad].
    #[inline]
    #[must_use]
    pub fn plus(&self, xi: &Vector6<f64>) -> Self {
        *self * Self::exp(xi)
    }

    /// The ξ with `other.plus(ξ)` = self: log(other⁻¹ · self) [m; rad]; jumps where the two are a half turn apart.
    #[inline]
    pub fn minus(&self, other: &Self) -> Vector6<f64> {
        (other.inverse() * *self).log()
    }

    /// Exponential of ξ = [linear; angular]: the displacement after one unit of time of the constant body twist ξ.
    #[inline]
    pub fn exp(xi: &Vector6<f64>) -> Self {
        let (v, w) = (linear(xi), angular(xi));
        let u = w.norm_squared();
        let (a, b) = sin_cos_quotients(u);
        // V v = v + b ω × v + c ω × (ω × v), and c θ² = 1 − a
        let wv = w.cross(&v);
        let c = if u < 1e-4 {
            1.0 / 6.0 * (1.0 - u / 20.0 * (1.0 - u / 42.0))
        } else {
            (1.0 - a) / u
        };
        Self {
            rotation: exp_so3(&w),
            translation: v + wv * b + w.cross(&wv) * c,
        }
    }

    /// Logarithm ξ = [linear; angular], |angular| ≤ π: `Pose::exp(&pose.log())` = pose; jumps at half turns.
    #[inline]
    pub fn log(&self) -> Vector6<f64> {
        let w = log_so3(&self.rotation);
        let (d, _, _) = bernoulli::bernoulli(w.norm_squared());
        let wp = w.cross(&self.translation);
        let v = self.translation - wp * 0.5 + w.cross(&wp) * d;
        Vector6::new(v.x, v.y, v.z, w.x, w.y, w.z)
    }

    /// The same pose with its rotation made orthonormal again (through the unit quaternion), after many products.
    #[must_use]
    pub fn normalized(&self) -> Self {
        Self {
            rotation: rotation_of(quaternion(&self.rotation)),
            translation: self.translation,
        }
    }

    /// A random pose: origin within 1 m along each axis, rotation uniform; the same for the same seed.
    pub fn random(seed: u64) -> Self {
        let mut random = Random::new(seed);
        let [x, y, z] = [0; 3].map(|_| random.uniform(-1.0, 1.0));
        let [qx, qy, qz, qw] = random.unit_quaternion();
        Self::from_xyzquat(&[x, y, z, qx, qy, qz, qw])
    }
}

impl Default for Pose {
    fn default() -> Self {
        Self::identity()
    }
}

impl Mul for Pose {
    type Output = Self;

    /// `c_from_b * b_from_a` = `c_from_a`.
    #[inline]
    fn mul(self, other: Self) -> Self {
        Self {
            rotation: self.rotation * other.rotation,
            translation: self.rotation * other.translation + self.translation,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn distance(a: &Pose, b: &Pose) -> f64 {
        (a.rotation - b.rotation).norm() + (a.translation - b.translation).norm()
    }

    #[test]
    fn a_quarter_turn_with_an_offset_moves_points_as_expected() {
        let half = (0.5f64).sqrt();
        let b_from_a = Pose::from_xyzquat(&[1.0, 2.0, 3.0, 0.0, 0.0, half, half]);
        assert!(
            (b_from_a.act(Vector3::new(1.0, 0.0, 0.0)) - Vector3::new(1.0, 3.0, 3.0)).norm()
                < 1e-15
        );
        assert!((b_from_a.rotate(Vector3::x()) - Vector3::y()).norm() < 1e-15);
        assert!((b_from_a.rotate_inverse(Vector3::y()) - Vector3::x()).norm() < 1e-15);
    }

    #[test]
    fn a_screw_motion_advances_along_its_axis() {
        let pose = Pose::exp(&Vector6::new(0.0, 0.0, 0.7, 0.0, 0.0, PI / 2.0));
        assert!((pose.origin() - Vector3::new(0.0, 0.0, 0.7)).norm() < 1e-15);
        // a unit quarter circle about z that starts along x ends at (2/π, 2/π)
        let circle = Pose::exp(&Vector6::new(1.0, 0.0, 0.0, 0.0, 0.0, PI / 2.0));
        assert!((circle.origin() - Vector3::new(2.0 / PI, 2.0 / PI, 0.0)).norm() < 1e-15);
    }

    #[test]
    fn exp_and_log_undo_each_other() {
        for seed in 0..200 {
            let pose = Pose::random(seed);
            assert!(distance(&Pose::exp(&pose.log()), &pose) < 1e-13);
        }
        for angle in [0.0, 1e-9, 1e-4, 0.0099, 0.0101, 0.3, 1.2, 3.0, PI - 1e-9] {
            let xi = Vector6::new(
                0.3,
                -2.0,
                0.7,
                angle / 3.0,
                angle * 2.0 / 3.0,
                -angle * 2.0 / 3.0,
            );
            assert!((Pose::exp(&xi).log() - xi).norm() < 1e-12, "angle {angle}");
        }
    }

    #[test]
    fn plus_and_minus_undo_each_other() {
        let (a, b) = (Pose::random(1), Pose::random(2));
        assert!(distance(&a.plus(&b.minus(&a)), &b) < 1e-14);
    }

    #[test]
    fn inverse_and_quaternion_form_undo_themselves() {
        for seed in 0..50 {
            let pose = Pose::random(seed);
            assert!(distance(&(pose * pose.inverse()), &Pose::identity()) < 1e-15 * 4.0);
            assert!(distance(&Pose::from_xyzquat(&pose.to_xyzquat()), &pose) < 1e-14);
        }
    }

    #[test]
    fn adjoint_is_the_matrix_of_the_action_on_twists_and_a_homomorphism() {
        let (a, b) = (Pose::random(3), Pose::random(4));
        let twist = Twist::from_vector(&Vector6::new(0.1, 0.2, -0.3, 0.4, -0.5, 0.6));
        assert!((a.act_twist(&twist).to_vector() - a.adjoint() * twist.to_vector()).norm() < 1e-15);
        assert!(((a * b).adjoint() - a.adjoint() * b.adjoint()).norm() < 1e-14);
    }

    #[test]
    fn power_does_not_depend_on_the_frame() {
        let pose = Pose::random(5);
        let twist = Twist::from_vector(&Vector6::new(0.1, 0.2, -0.3, 0.4, -0.5, 0.6));
        let wrench = Wrench::from_vector(&Vector6::new(3.0, -1.0, 2.0, 0.5, 0.7, -0.2));
        let moved = pose.act_wrench(&wrench).power(&pose.act_twist(&twist));
        assert!((moved - wrench.power(&twist)).abs() < 1e-14);
    }

    #[test]
    fn a_drifted_rotation_is_repaired() {
        let pose = Pose::random(6);
        let drifted = Pose::from_parts(pose.rotation * 1.001, pose.translation);
        assert!(distance(&drifted.normalized(), &pose) < 1e-3);
        let r = drifted.normalized().rotation;
        assert!((r * r.transpose() - Matrix3::identity()).norm() < 1e-15 * 4.0);
    }

    #[test]
    fn a_zero_quaternion_means_no_rotation() {
        assert_eq!(
            *Pose::from_xyzquat(&[0.0; 7]).rotation(),
            Matrix3::identity()
        );
    }
}
