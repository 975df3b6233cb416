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
fn direction_block(u: &Vector3<f64>, e: &Vector3<f64>) -> Matrix3<f64> {
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
