//! Symmetric 3×3 matrices, six numbers.

use nalgebra::{Matrix3, Vector3};
use std::ops::AddAssign;

/// [xx xy xz; xy yy yz; xz yz zz]
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Symmetric3 {
    pub xx: f64,
    pub xy: f64,
    pub xz: f64,
    pub yy: f64,
    pub yz: f64,
    pub zz: f64,
}

impl Symmetric3 {
    pub const NAN: Self = Self::diagonal(f64::NAN);

    const fn diagonal(d: f64) -> Self {
        Self {
            xx: d,
            xy: 0.0,
            xz: 0.0,
            yy: d,
            yz: 0.0,
            zz: d,
        }
    }

    /// R C Rᵀ of a symmetric C.
    #[inline]
    pub fn rotated(r: &Matrix3<f64>, c: &Matrix3<f64>) -> Self {
        let t = r * c;
        let entry = |i: usize, j: usize| {
            t[(i, 0)] * r[(j, 0)] + t[(i, 1)] * r[(j, 1)] + t[(i, 2)] * r[(j, 2)]
        };
        Self {
            xx: entry(0, 0),
            xy: entry(0, 1),
            xz: entry(0, 2),
            yy: entry(1, 1),
            yz: entry(1, 2),
            zz: entry(2, 2),
        }
    }

    /// 2(a·b) 1 − a bᵀ − b aᵀ; half of it for a = b turns a point mass into its inertia.
    #[inline]
    pub fn lever(a: &Vector3<f64>, b: &Vector3<f64>) -> Self {
        let (x, y, z) = (a.x * b.x, a.y * b.y, a.z * b.z);
        Self {
            xx: 2.0 * (y + z),
            xy: -(a.x * b.y + a.y * b.x),
            xz: -(a.x * b.z + a.z * b.x),
            yy: 2.0 * (x + z),
            yz: -(a.y * b.z + a.z * b.y),
            zz: 2.0 * (x + y),
        }
    }

    /// [w]× J − J [w]×: the rate of an inertia J that turns with w.
    #[inline]
    pub fn turning(&self, w: &Vector3<f64>) -> Self {
        Self {
            xx: 2.0 * (w.y * self.xz - w.z * self.xy),
            yy: 2.0 * (w.z * self.xy - w.x * self.yz),
            zz: 2.0 * (w.x * self.yz - w.y * self.xz),
            xy: w.z * (self.xx - self.yy) + w.y * self.yz - w.x * self.xz,
            xz: w.y * (self.zz - self.xx) + w.x * self.xy - w.z * self.yz,
            yz: w.x * (self.yy - self.zz) + w.z * self.xz - w.y * self.xy,
        }
    }

    #[inline]
    pub fn times(&self, v: &Vector3<f64>) -> Vector3<f64> {
        Vector3::new(
            self.xx * v.x + self.xy * v.y + self.xz * v.z,
            self.xy * v.x + self.yy * v.y + self.yz * v.z,
            self.xz * v.x + self.yz * v.y + self.zz * v.z,
        )
    }

    #[inline]
    pub fn plus_scaled(&self, other: &Self, factor: f64) -> Self {
        Self {
            xx: self.xx + factor * other.xx,
            xy: self.xy + factor * other.xy,
            xz: self.xz + factor * other.xz,
            yy: self.yy + factor * other.yy,
            yz: self.yz + factor * other.yz,
            zz: self.zz + factor * other.zz,
        }
    }
}

impl AddAssign for Symmetric3 {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = self.plus_scaled(&other, 1.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use spatial::{Pose, skew};

    fn full(s: &Symmetric3) -> Matrix3<f64> {
        Matrix3::new(s.xx, s.xy, s.xz, s.xy, s.yy, s.yz, s.xz, s.yz, s.zz)
    }

    #[test]
    fn entries_agree_with_full_matrices() {
        let c = Matrix3::new(2.0, 0.3, -0.4, 0.3, 3.0, 0.5, -0.4, 0.5, 1.5);
        let (a, b) = (Vector3::new(0.3, -0.7, 1.1), Vector3::new(-0.2, 0.9, 0.4));
        let pose = Pose::random(1);
        let r = pose.rotation();
        let j = Symmetric3::rotated(r, &c);
        assert!((full(&j) - r * c * r.transpose()).norm() < 1e-14);
        assert!((j.times(&a) - full(&j) * a).norm() < 1e-14);
        assert!(
            (full(&j.turning(&a)) - (skew(&a) * full(&j) - full(&j) * skew(&a))).norm() < 1e-14
        );
        let lever = Matrix3::identity() * (2.0 * a.dot(&b)) - a * b.transpose() - b * a.transpose();
        assert!((full(&Symmetric3::lever(&a, &b)) - lever).norm() < 1e-14);
    }
}
