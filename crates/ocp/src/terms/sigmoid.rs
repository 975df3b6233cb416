//! Collision penalties with sigmoids, for the paper's preset.
//!
//! Source: paper, eq. (frame_plane) and (frame_box): L = W σ(−z) and L = W Π_i σ(H_i − |p_i|), with a length scale
//! (formulation 2.9) of 1/slope.

use super::PoseTerm;
use super::distance::Obstacle;
use super::pose_functions::point_derivatives;
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use spatial::Pose;

/// Smoothing of |p_i| [m].
const SMOOTHING: f64 = 1e-3;

/// Penalties below exp(−FAR) = 1e-13 are not evaluated.
const FAR: f64 = 30.0;

/// Sum over points of a of the penalty against a box or plane of b; a cost, one row.
#[derive(Debug)]
pub struct Sigmoid {
    /// Points of a and their radii, which enlarge the obstacle.
    pub points: Vec<(Vector3<f64>, f64)>,
    /// Box or half-space.
    pub obstacle: Obstacle,
    /// Where that is: pose of b in the obstacle's own frame.
    pub obstacle_from_b: Pose,
    /// Slope of σ [1/m].
    pub slope: f64,
}

/// σ(x), σ′, σ″.
fn sigma(x: f64) -> (f64, f64, f64) {
    let s = 1.0 / (1.0 + (-x).exp());
    let d = s * (1.0 - s);
    (s, d, d * (1.0 - 2.0 * s))
}

impl Sigmoid {
    /// True if the penalty at a point of b, with each σ(x) ≤ exp(x), is too small to count.
    fn is_far(&self, p: &Vector3<f64>, radius: f64) -> bool {
        let outside = match &self.obstacle {
            Obstacle::Box(half) => (0..3)
                .map(|i| (p[i].abs() - half[i] - radius).max(0.0))
                .sum(),
            Obstacle::HalfSpace => p.z - radius,
            Obstacle::Parts(_) => f64::INFINITY,
        };
        self.slope * outside > FAR
    }

    /// Penalty at a point of b, its gradient and Hessian.
    fn penalty(&self, p: &Vector3<f64>, radius: f64) -> (f64, Vector3<f64>, Matrix3<f64>) {
        match &self.obstacle {
            Obstacle::Box(half) => {
                let mut factors = [(0.0, 0.0, 0.0); 3];
                for i in 0..3 {
                    let norm = (p[i] * p[i] + SMOOTHING * SMOOTHING).sqrt();
                    let (s, d, dd) = sigma(self.slope * (half[i] + radius - norm));
                    let (n1, n2) = (p[i] / norm, SMOOTHING * SMOOTHING / (norm * norm * norm));
                    let k = self.slope;
                    factors[i] = (s, -k * d * n1, k * k * dd * n1 * n1 - k * d * n2);
                }
                let [a, b, c] = factors;
                let value = a.0 * b.0 * c.0;
                let gradient = Vector3::new(a.1 * b.0 * c.0, a.0 * b.1 * c.0, a.0 * b.0 * c.1);
                let (xy, xz, yz) = (a.1 * b.1 * c.0, a.1 * b.0 * c.1, a.0 * b.1 * c.1);
                #[rustfmt::skip]
                let hessian = Matrix3::new(
                    a.2 * b.0 * c.0, xy, xz,
                    xy, a.0 * b.2 * c.0, yz,
                    xz, yz, a.0 * b.0 * c.2,
                );
                (value, gradient, hessian)
            }
            Obstacle::HalfSpace => {
                let (s, d, dd) = sigma(-self.slope * (p.z - radius));
                let mut hessian = Matrix3::zeros();
                hessian[(2, 2)] = self.slope * self.slope * dd;
                (s, Vector3::new(0.0, 0.0, -self.slope * d), hessian)
            }
            Obstacle::Parts(_) => (0.0, Vector3::zeros(), Matrix3::zeros()),
        }
    }
}

impl PoseTerm for Sigmoid {
    fn name(&self) -> &'static str {
        "collision penalty"
    }
    fn unit(&self) -> &'static str {
        ""
    }
    fn bounds(&self) -> Vec<(f64, f64)> {
        vec![(f64::NEG_INFINITY, f64::INFINITY)]
    }
    fn values(&self, b_from_a: &Pose, out: &mut [f64]) {
        let x = self.obstacle_from_b * *b_from_a;
        out[0] = self
            .points
            .iter()
            .map(|(l, r)| (x.act(*l), *r))
            .filter(|(p, r)| !self.is_far(p, *r))
            .map(|(p, r)| self.penalty(&p, r).0)
            .sum();
    }
    fn gradients(&self, b_from_a: &Pose, out: &mut [Vector6<f64>]) {
        self.derivatives(b_from_a, &[0.0], out);
    }
    fn hessian(&self, b_from_a: &Pose, weights: &[f64]) -> Matrix6<f64> {
        self.derivatives(b_from_a, weights, &mut [Vector6::zeros()])
    }
    fn derivatives(
        &self,
        b_from_a: &Pose,
        weights: &[f64],
        gradients: &mut [Vector6<f64>],
    ) -> Matrix6<f64> {
        let x = self.obstacle_from_b * *b_from_a;
        gradients[0] = Vector6::zeros();
        let mut sum = Matrix6::zeros();
        for (l, r) in &self.points {
            let p = x.act(*l);
            if self.is_far(&p, *r) {
                continue;
            }
            let (_, g, h) = self.penalty(&p, *r);
            let (gradient, hessian) = point_derivatives(&x, l, &g, &h);
            gradients[0] += gradient;
            sum += hessian;
        }
        sum * weights[0]
    }
}
