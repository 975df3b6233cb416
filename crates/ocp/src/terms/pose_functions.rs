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

/// Gradient and Hessian by increments of a of f(X ℓ), for f with gradient `g` and Hessian `h` by the point in b.
pub fn point_derivatives(
    x: &Pose,
    l: &Vector3<f64>,
    g: &Vector3<f64>,
    h: &Matrix3<f64>,
) -> (Vector6<f64>, Matrix6<f64>) {
    let r = x.rotation();
    let g = r.tr_mul(g);
    let h = r.tr_mul(h) * r;
    // The point moves by ρ + ω × ℓ = ρ − [ℓ] ω in axes of a.
    let arm = skew(l);
    let mixed = -h * arm;
    let mut hessian = Matrix6::zeros();
    hessian.fixed_view_mut::<3, 3>(0, 0).copy_from(&h);
    let upper = mixed + skew(&g) * 0.5;
    hessian.fixed_view_mut::<3, 3>(0, 3).copy_from(&upper);
    hessian
        .fixed_view_mut::<3, 3>(3, 0)
        .copy_from(&upper.transpose());
    let turned = arm * mixed + direction_block(&g, l);
    hessian.fixed_view_mut::<3, 3>(3, 3).copy_from(&turned);
    (stack(g, l.cross(&g)), hessian)
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
    let block = direction_block(&x.rotation().tr_mul(u), e);
    let mut h = Matrix6::zeros();
    h.fixed_view_mut::<3, 3>(3, 3).copy_from(&block);
    h
}

/// Hessian of u·exp(ω) e by ω at zero.
pub(super) fn direction_block(u: &Vector3<f64>, e: &Vector3<f64>) -> Matrix3<f64> {
    let outer = u * e.transpose();
    (outer + outer.transpose()) * 0.5 - Matrix3::identity() * u.dot(e)
}

/// Jacobian of the point ℓ (3×6).
pub fn point_jacobian(x: &Pose, l: &Vector3<f64>) -> nalgebra::Matrix3x6<f64> {
    let r = x.rotation();
    let mut j = nalgebra::Matrix3x6::zeros();
    j.fixed_view_mut::<3, 3>(0, 0).copy_from(r);
    j.fixed_view_mut::<3, 3>(0, 3).copy_from(&(-r * skew(l)));
    j
}

/// Angle of a's x axis in b's plane [rad], in (−π, π].
pub fn yaw(x: &Pose) -> f64 {
    let axis = x.rotation().column(0);
    axis.y.atan2(axis.x)
}

/// Gradient of [`yaw`]: d atan2(y, x) = (x dy − y dx)/(x² + y²).
pub fn yaw_gradient(x: &Pose) -> Vector6<f64> {
    let axis = x.rotation().column(0);
    let u = Vector3::new(-axis.y, axis.x, 0.0) / flat_norm(x);
    direction_gradient(x, &Vector3::x(), &u)
}

/// Hessian of [`yaw`].
pub fn yaw_hessian(pose: &Pose) -> Matrix6<f64> {
    let axis = pose.rotation().column(0);
    let (x, y, s) = (axis.x, axis.y, flat_norm(pose));
    let u = Vector3::new(-y, x, 0.0) / s;
    let gx = direction_gradient(pose, &Vector3::x(), &Vector3::x());
    let gy = direction_gradient(pose, &Vector3::x(), &Vector3::y());
    let cross = gx * gy.transpose();
    let products = (gx * gx.transpose() - gy * gy.transpose()) * (2.0 * x * y)
        + (cross + cross.transpose()) * (y * y - x * x);
    direction_hessian(pose, &Vector3::x(), &u) + products / (s * s)
}

/// x² + y² of a's x axis in b's plane, kept away from zero (a patch seen edge-on has no yaw).
fn flat_norm(x: &Pose) -> f64 {
    let axis = x.rotation().column(0);
    (axis.x * axis.x + axis.y * axis.y).max(1e-6)
}
