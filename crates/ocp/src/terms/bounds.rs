//! Contact bounds: all of a's rectangle (or a point) stays inside b's extent.
//!
//! Source: paper, eq. (point_position_bounds) and (patch_patch_bounds), with absolute values of the in-plane rotation
//! (formulation 2.4): |r_xy| ≤ ξ_b − |R_2×2| ξ_a.
//! **Departs:** |x| is √(x² + 0.01²), which asks for at most one per cent of ξ_a more room.

use super::PoseTerm;
use super::pose_functions::{direction_gradient, direction_hessian, point_gradient, point_hessian};
use nalgebra::{Matrix6, Vector3, Vector6};
use spatial::Pose;

const SMOOTHING: f64 = 0.01;

/// Four rows ≥ 0: ξ_b − |R| ξ_a ∓ r for x and y [m].
#[derive(Debug)]
pub struct Bounds {
    /// Half extents of a; zero for a point or where a may overhang.
    pub half_a: [f64; 2],
    /// Half extents of b.
    pub half_b: [f64; 2],
}

fn unit(i: usize) -> Vector3<f64> {
    Vector3::ith(i, 1.0)
}

impl PoseTerm for Bounds {
    fn name(&self) -> &'static str {
        "contact bounds"
    }
    fn unit(&self) -> &'static str {
        "m"
    }
    fn bounds(&self) -> Vec<(f64, f64)> {
        vec![(0.0, f64::INFINITY); 4]
    }
    fn values(&self, b_from_a: &Pose, out: &mut [f64]) {
        let (rot, r) = (b_from_a.rotation(), b_from_a.origin());
        for i in 0..2 {
            let extent: f64 = (0..2)
                .map(|j| rot[(i, j)].hypot(SMOOTHING) * self.half_a[j])
                .sum();
            out[2 * i] = self.half_b[i] - extent - r[i];
            out[2 * i + 1] = self.half_b[i] - extent + r[i];
        }
    }
    fn gradients(&self, b_from_a: &Pose, out: &mut [Vector6<f64>]) {
        let rot = b_from_a.rotation();
        for i in 0..2 {
            let mut extent = Vector6::zeros();
            for j in 0..2 {
                let x = rot[(i, j)];
                let slope = x / x.hypot(SMOOTHING) * self.half_a[j];
                extent += direction_gradient(b_from_a, &unit(j), &unit(i)) * slope;
            }
            let r = point_gradient(b_from_a, &Vector3::zeros(), &unit(i));
            out[2 * i] = -extent - r;
            out[2 * i + 1] = -extent + r;
        }
    }
    fn hessian(&self, b_from_a: &Pose, weights: &[f64]) -> Matrix6<f64> {
        let rot = b_from_a.rotation();
        let mut h = Matrix6::zeros();
        for i in 0..2 {
            let both = weights[2 * i] + weights[2 * i + 1];
            let difference = weights[2 * i + 1] - weights[2 * i];
            h += point_hessian(b_from_a, &Vector3::zeros(), &unit(i)) * difference;
            for j in 0..2 {
                let x = rot[(i, j)];
                let norm = x.hypot(SMOOTHING);
                let g = direction_gradient(b_from_a, &unit(j), &unit(i));
                h -= (direction_hessian(b_from_a, &unit(j), &unit(i)) * (x / norm)
                    + g * g.transpose() * (SMOOTHING * SMOOTHING / norm.powi(3)))
                    * (self.half_a[j] * both);
            }
        }
        h
    }
}
