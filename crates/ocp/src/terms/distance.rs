//! Clearance: a ball of a stays outside a primitive of b.
//!
//! The robot's links are covered by balls (capsules by rows of balls), so every pair is ball against box, half-space
//! or ball. The box's distance is smooth: with d_±i = ±p_i − h_i over its six faces,
//!
//! ```text
//! d(p) = ε ln Σ exp(d_±i / ε)  ≥  max_i (|p_i| − h_i)
//! ```
//!
//! convex and infinitely smooth; exact over faces, at most ε ln 3 too large at a corner, and smaller than the Euclidean
//! distance around edges by up to (1 − 1/√2) of it, which is the safe side.
//!
//! Source: ours, in place of the paper's sigmoids (eq. penalties), which exclude nothing.

use super::PoseTerm;
use super::pose_functions::{point_gradient, point_hessian, point_jacobian};
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use spatial::Pose;

/// ε [m].
const SHARPNESS: f64 = 0.006;

/// A primitive of b.
#[derive(Debug, Clone)]
pub enum Obstacle {
    /// A box with these half sizes, centred in b.
    Box(Vector3<f64>),
    /// The half-space z < 0 of b.
    HalfSpace,
    /// Balls: centres in b and radii.
    Balls(Vec<(Vector3<f64>, f64)>),
}

/// One row per ball (and per ball of b): distance − radii ≥ clearance [m].
#[derive(Debug)]
pub struct Distance {
    /// Balls of a: centres in a and radii.
    pub balls: Vec<(Vector3<f64>, f64)>,
    /// What they avoid.
    pub obstacle: Obstacle,
    /// Where that is: pose of b in the obstacle's own frame.
    pub obstacle_from_b: Pose,
    /// Least distance [m]; may be negative for a tolerated overlap.
    pub clearance: f64,
}

/// Value, gradient and Hessian of the smooth box distance at p.
pub fn box_distance(p: &Vector3<f64>, half: &Vector3<f64>) -> (f64, Vector3<f64>, Matrix3<f64>) {
    let faces: [f64; 6] = std::array::from_fn(|i| {
        if i < 3 {
            p[i] - half[i]
        } else {
            -p[i - 3] - half[i - 3]
        }
    });
    let largest = faces.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let weights = faces.map(|d| ((d - largest) / SHARPNESS).exp());
    let sum: f64 = weights.iter().sum();
    let gradient = Vector3::from_fn(|i, _| (weights[i] - weights[i + 3]) / sum);
    let diagonal = Vector3::from_fn(|i, _| (weights[i] + weights[i + 3]) / sum);
    let hessian = (Matrix3::from_diagonal(&diagonal) - gradient * gradient.transpose()) / SHARPNESS;
    (largest + SHARPNESS * sum.ln(), gradient, hessian)
}

/// Smooth distance of two centres: √(|p|² + ε²) with ε = 1 mm, never smaller than the distance by more than it.
fn centre_distance(p: &Vector3<f64>) -> (f64, Vector3<f64>, Matrix3<f64>) {
    const EPSILON: f64 = 1e-3;
    let d = (p.norm_squared() + EPSILON * EPSILON).sqrt();
    let g = p / d;
    (d, g, (Matrix3::identity() - g * g.transpose()) / d)
}

impl Distance {
    /// Number of rows.
    pub fn n_rows(&self) -> usize {
        match &self.obstacle {
            Obstacle::Balls(b) => self.balls.len() * b.len(),
            _ => self.balls.len(),
        }
    }

    /// Calls `row(index, centre of the ball in a, (distance, gradient, Hessian) by the centre in b)`.
    fn for_each(
        &self,
        x: &Pose,
        mut row: impl FnMut(usize, &Vector3<f64>, (f64, Vector3<f64>, Matrix3<f64>)),
    ) {
        let mut i = 0;
        for (centre, radius) in &self.balls {
            let p = self.obstacle_from_b.act(x.act(*centre));
            match &self.obstacle {
                Obstacle::Box(half) => {
                    let (d, g, h) = box_distance(&p, half);
                    row(i, centre, (d - radius, g, h));
                    i += 1;
                }
                Obstacle::HalfSpace => {
                    row(i, centre, (p.z - radius, Vector3::z(), Matrix3::zeros()));
                    i += 1;
                }
                Obstacle::Balls(others) => {
                    for (other, r) in others {
                        let (d, g, h) = centre_distance(&(p - other));
                        row(i, centre, (d - radius - r, g, h));
                        i += 1;
                    }
                }
            }
        }
    }
}

impl PoseTerm for Distance {
    fn name(&self) -> &'static str {
        "clearance"
    }
    fn unit(&self) -> &'static str {
        "m"
    }
    fn bounds(&self) -> Vec<(f64, f64)> {
        vec![(self.clearance, f64::INFINITY); self.n_rows()]
    }
    fn values(&self, b_from_a: &Pose, out: &mut [f64]) {
        self.for_each(b_from_a, |i, _, (d, _, _)| out[i] = d);
    }
    fn gradients(&self, b_from_a: &Pose, out: &mut [Vector6<f64>]) {
        let x = self.obstacle_from_b * *b_from_a;
        self.for_each(b_from_a, |i, centre, (_, g, _)| {
            out[i] = point_gradient(&x, centre, &g);
        });
    }
    fn hessian(&self, b_from_a: &Pose, weights: &[f64]) -> Matrix6<f64> {
        let x = self.obstacle_from_b * *b_from_a;
        let mut sum = Matrix6::zeros();
        self.for_each(b_from_a, |i, centre, (_, g, h)| {
            // A row far from its bound has a vanishing multiplier and no say in the curvature.
            if weights[i].abs() > 1e-9 {
                let j = point_jacobian(&x, centre);
                sum += (j.transpose() * h * j + point_hessian(&x, centre, &g)) * weights[i];
            }
        });
        sum
    }
}
