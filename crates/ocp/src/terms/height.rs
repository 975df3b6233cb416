//! Contact height: the origin of interface `a` stays in the plane of interface `b`.
//!
//! Source: paper, eq. (point_position) and (patch_patch_position), first part: (ʲr_i)_z = 0 with i → a, j → b.

use super::PoseTerm;
use super::pose_functions::{point_gradient, point_hessian};
use nalgebra::{Matrix6, Vector3, Vector6};
use spatial::Pose;

/// (ʲr_i)_z = 0 [m].
#[derive(Debug)]
pub struct Height;

impl PoseTerm for Height {
    fn name(&self) -> &'static str {
        "contact distance"
    }
    fn unit(&self) -> &'static str {
        "m"
    }
    fn bounds(&self) -> Vec<(f64, f64)> {
        vec![(0.0, 0.0)]
    }
    fn values(&self, b_from_a: &Pose, out: &mut [f64]) {
        out[0] = b_from_a.origin().z;
    }
    fn gradients(&self, b_from_a: &Pose, out: &mut [Vector6<f64>]) {
        out[0] = point_gradient(b_from_a, &Vector3::zeros(), &Vector3::z());
    }
    fn hessian(&self, b_from_a: &Pose, weights: &[f64]) -> Matrix6<f64> {
        point_hessian(b_from_a, &Vector3::zeros(), &Vector3::z()) * weights[0]
    }
}

/// Height ≥ 0 of points of interface `a`, as the corners of a sole: what lands next, or has just left, is beyond the plane.
#[derive(Debug)]
pub struct Beyond {
    /// Points in the frame of `a` [m].
    pub points: Vec<Vector3<f64>>,
}

impl PoseTerm for Beyond {
    fn name(&self) -> &'static str {
        "contact approach"
    }
    fn unit(&self) -> &'static str {
        "m"
    }
    fn bounds(&self) -> Vec<(f64, f64)> {
        vec![(0.0, f64::INFINITY); self.points.len()]
    }
    fn values(&self, b_from_a: &Pose, out: &mut [f64]) {
        for (out, point) in out.iter_mut().zip(&self.points) {
            *out = b_from_a.act(*point).z;
        }
    }
    fn gradients(&self, b_from_a: &Pose, out: &mut [Vector6<f64>]) {
        for (out, point) in out.iter_mut().zip(&self.points) {
            *out = point_gradient(b_from_a, point, &Vector3::z());
        }
    }
    fn hessian(&self, b_from_a: &Pose, weights: &[f64]) -> Matrix6<f64> {
        let of_point = |(p, w): (_, &f64)| point_hessian(b_from_a, p, &Vector3::z()) * *w;
        self.points.iter().zip(weights).map(of_point).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_foot_five_centimetres_over_the_table_reads_five_centimetres() {
        let mut out = [0.0];
        Height.values(&Pose::from_translation(0.3, 0.1, 0.05), &mut out);
        assert!((out[0] - 0.05).abs() < 1e-15);
    }
}
