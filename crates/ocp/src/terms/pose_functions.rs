//! Building blocks: coordinates of a point and of a direction fixed to a, seen in b, with exact derivatives.
//!
//! With X = (R, r) and X·exp(ξ), ξ = (ρ, ω): a point ℓ of a moves to r + Rℓ + R(ρ + ω×ℓ + ½ω×ρ + ½ω×(ω×ℓ)) + …, a
//! direction e to R(e + ω×e + ½ω×(ω×e)) + ….

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use spatial::{Pose, skew};

fn stack(linear: Vector3<f64>, angular: Vector3<f64>) -> Vector6<f64> {
    Vector6::new(
        linear.x, linear.y, linear.z, angular.x, angular.y, angular.z,
    )
}

/// Gradient of u·(X ℓ): the point ℓ of a, along u in b.
pub fn point_gradient(x: &Pose, l: &Vector3<f64>, u: &Vector3<f64>) -> Vector6<f64> {
    let u = x.rotation().tr_mul(u);
    stack(u, l.cross(&u))
}

/// Hessian of u·(X ℓ).
pub fn point_hessian(x: &Pose, l: &Vector3<f64>, u: &Vector3<f64>) -> Matrix6<f64> {
    let mut h = direction_hessian(x, l, u);
    let half = skew(&x.rotation().tr_mul(u)) * 0.5;
    h.fixed_view_mut::<3, 3>(0, 3).copy_from(&half);
    h.fixed_view_mut::<3, 3>(3, 0).copy_from(&-half);
    h
}

/// Gradient of u·(R e): the direction e of a, along u in b.
pub fn direction_gradient(x: &Pose, e: &Vector3<f64>, u: &Vector3<f64>) -> Vector6<f64> {
    stack(Vector3::zeros(), e.cross(&x.rotation().tr_mul(u)))
}

/// Hessian of u·(R e).
pub fn direction_hessian(x: &Pose, e: &Vector3<f64>, u: &Vector3<f64>) -> Matrix6<f64> {
    let u = x.rotation().tr_mul(u);
    let outer = u * e.transpose();
    let block = (outer + outer.transpose()) * 0.5 - Matrix3::identity() * u.dot(e);
    let mut h = Matrix6::zeros();
    h.fixed_view_mut::<3, 3>(3, 3).copy_from(&block);
    h
}

/// Jacobian of the point ℓ (3×6).
pub fn point_jacobian(x: &Pose, l: &Vector3<f64>) -> nalgebra::Matrix3x6<f64> {
    let r = x.rotation();
    let mut j = nalgebra::Matrix3x6::zeros();
    j.fixed_view_mut::<3, 3>(0, 0).copy_from(r);
    j.fixed_view_mut::<3, 3>(0, 3).copy_from(&(-r * skew(l)));
    j
}
