//! Clearance: the balls of a stay outside a primitive of b.
//!
//! One body is covered by balls (capsules by rows of balls), so every pair is ball against box, half-space or ball. The box's distance is smooth: with d_±i = ±p_i − h_i over its six faces,
//!
//! ```text
//! d(p) = ε ln Σ exp(d_±i / ε)  ≥  max_i (|p_i| − h_i)
//! ```
//!
//! convex and infinitely smooth; exact over faces, at most ε ln 3 too large at a corner, and smaller than the Euclidean
//! distance around edges by up to (1 − 1/√2) of it, which is the safe side. All pairs of a and b make one row, the
//! smooth minimum
//!
//! ```text
//! d = −η ln Σ_k exp(−d_k / η)  ≤  min_k d_k
//! ```
//!
//! too small by η ln n where n pairs are equally near, again on the safe side. What is far away does not matter and must
//! cost nothing, so the row is φ(d), which is d up to d₀ and, with u = (d − d₀)/(d₁ − d₀), levels out at d₁:
//!
//! ```text
//! φ = d₀ + (d₁ − d₀)(u − u³ + u⁴/2)
//! ```
//!
//! Source: ours, in place of the paper's sigmoids (eq. penalties), which exclude nothing.

use super::PoseTerm;
use super::pose_functions::{point_gradient, point_hessian, point_jacobian};
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use spatial::Pose;

/// ε [m].
const SHARPNESS: f64 = 0.006;
/// η [m].
pub const EVENNESS: f64 = 0.003;
/// d₀ and d₁ [m].
const LEVEL: (f64, f64) = (0.06, 0.12);
/// Balls farther away than the nearest one by more than this have no say: exp(−SEEN/η) is 1e-7 [m].
const SEEN: f64 = 16.0 * EVENNESS;

/// Share of a row below which a ball's curvature does not count.
const LEAST_SAY: f64 = 1e-10;

/// A primitive of b.
#[derive(Debug, Clone)]
pub enum Obstacle {
    /// A box with these half sizes, centred in b.
    Box(Vector3<f64>),
    /// The half-space z < 0 of b.
    HalfSpace,
    /// Several parts, such as those of a link.
    Parts(Vec<Part>),
}

/// A part of an obstacle.
#[derive(Debug, Clone)]
pub enum Part {
    /// Centre in b and radius.
    Ball(Vector3<f64>, f64),
    /// Pose of b in the box, and half sizes.
    Box(Pose, Vector3<f64>),
}

impl Part {
    /// Distance of a point, Euclidean to a ball, to the farthest-out face of a box [m].
    pub fn rough_distance(&self, p: &Vector3<f64>) -> f64 {
        match self {
            Self::Ball(centre, radius) => (p - centre).norm() - radius,
            Self::Box(pose, half) => (pose.act(*p).abs() - half).max(),
        }
    }

    fn distance(&self, p: &Vector3<f64>) -> f64 {
        match self {
            Self::Ball(centre, radius) => centre_distance(&(p - centre)).0 - radius,
            Self::Box(pose, half) => faces(&pose.act(*p), half).0,
        }
    }

    fn derivatives(&self, p: &Vector3<f64>) -> (f64, Vector3<f64>, Matrix3<f64>) {
        match self {
            Self::Ball(centre, radius) => {
                let (d, g, h) = centre_distance(&(p - centre));
                (d - radius, g, h)
            }
            Self::Box(pose, half) => {
                let (d, g, h) = box_distance(&pose.act(*p), half);
                let r = pose.rotation();
                (d, r.tr_mul(&g), r.tr_mul(&h) * r)
            }
        }
    }
}

/// One row: levelled smooth least distance ≥ clearance [m].
#[derive(Debug)]
pub struct Distance {
    balls: Vec<Ball>,
    bound: Ball,
    obstacle: Obstacle,
    obstacle_from_b: Pose,
    clearance: f64,
}

/// Centre [m] and radius [m].
pub type Ball = (Vector3<f64>, f64);

/// A ball around balls (around their centres' mean; the origin for none).
pub fn bounding_ball(balls: &[Ball]) -> Ball {
    let mean = balls.iter().map(|b| b.0).sum::<Vector3<f64>>() / balls.len().max(1) as f64;
    let radius = balls
        .iter()
        .map(|(c, r)| (c - mean).norm() + r)
        .fold(0.0, f64::max);
    (mean, radius)
}

/// φ and its first and second derivative.
fn level(d: f64) -> (f64, f64, f64) {
    let (from, to) = LEVEL;
    let u = (d - from) / (to - from);
    if u <= 0.0 {
        (d, 1.0, 0.0)
    } else if u < 1.0 {
        (
            from + (to - from) * (u - u.powi(3) + 0.5 * u.powi(4)),
            1.0 - 3.0 * u * u + 2.0 * u.powi(3),
            6.0 * (u * u - u) / (to - from),
        )
    } else {
        (0.5 * (from + to), 0.0, 0.0)
    }
}

/// Smooth box distance at p, the weights of the six faces and their sum.
fn faces(p: &Vector3<f64>, half: &Vector3<f64>) -> (f64, [f64; 6], f64) {
    let faces: [f64; 6] = std::array::from_fn(|i| {
        if i < 3 {
            p[i] - half[i]
        } else {
            -p[i - 3] - half[i - 3]
        }
    });
    let largest = faces.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let weights = faces.map(|d| {
        let far = (d - largest) / SHARPNESS;
        if far >= 0.0 {
            1.0
        } else if far < -20.0 {
            0.0
        } else {
            far.exp()
        }
    });
    let sum: f64 = weights.iter().sum();
    let blend = if sum > 1.0 { sum.ln() } else { 0.0 };
    (largest + SHARPNESS * blend, weights, sum)
}

/// Value, gradient and Hessian of the smooth box distance at p.
fn box_distance(p: &Vector3<f64>, half: &Vector3<f64>) -> (f64, Vector3<f64>, Matrix3<f64>) {
    let (d, weights, sum) = faces(p, half);
    let gradient = Vector3::from_fn(|i, _| (weights[i] - weights[i + 3]) / sum);
    let diagonal = Vector3::from_fn(|i, _| (weights[i] + weights[i + 3]) / sum);
    let hessian = (Matrix3::from_diagonal(&diagonal) - gradient * gradient.transpose()) / SHARPNESS;
    (d, gradient, hessian)
}

/// Smooth distance of two centres: √(|p|² + ε²) with ε = 1 mm, never smaller than the distance by more than it.
fn centre_distance(p: &Vector3<f64>) -> (f64, Vector3<f64>, Matrix3<f64>) {
    const EPSILON: f64 = 1e-3;
    let d = (p.norm_squared() + EPSILON * EPSILON).sqrt();
    let g = p / d;
    (d, g, (Matrix3::identity() - g * g.transpose()) / d)
}

impl Obstacle {
    /// Number of parts with a distance of their own.
    fn parts(&self) -> usize {
        match self {
            Self::Box(_) | Self::HalfSpace => 1,
            Self::Parts(parts) => parts.len(),
        }
    }

    /// A lower bound of the distance of a point to a part that is cheap, and no more than ε ln 6 below it.
    fn rough_distance(&self, part: usize, p: &Vector3<f64>) -> f64 {
        match self {
            Self::Box(half) => (p.abs() - half).max(),
            Self::HalfSpace => p.z,
            Self::Parts(parts) => parts[part].rough_distance(p),
        }
    }

    /// Distance of a point to a part.
    fn distance(&self, part: usize, p: &Vector3<f64>) -> f64 {
        match self {
            Self::Box(half) => faces(p, half).0,
            Self::HalfSpace => p.z,
            Self::Parts(parts) => parts[part].distance(p),
        }
    }

    /// Distance of a point to a part, gradient and Hessian.
    fn derivatives(&self, part: usize, p: &Vector3<f64>) -> (f64, Vector3<f64>, Matrix3<f64>) {
        match self {
            Self::Box(half) => box_distance(p, half),
            Self::HalfSpace => (p.z, Vector3::z(), Matrix3::zeros()),
            Self::Parts(parts) => parts[part].derivatives(p),
        }
    }

    /// Distance of a point to the nearest part, not smoothed and so at most ε ln 6 less [m].
    pub fn roughly_nearest(&self, p: &Vector3<f64>) -> f64 {
        (0..self.parts())
            .map(|part| self.rough_distance(part, p))
            .fold(f64::INFINITY, f64::min)
    }

    /// Distance of a point to the nearest part [m].
    pub fn nearest(&self, p: &Vector3<f64>) -> f64 {
        (0..self.parts())
            .map(|part| self.distance(part, p))
            .fold(f64::INFINITY, f64::min)
    }
}

impl Distance {
    /// `balls` of a with centres in a, `obstacle` in the frame that `obstacle_from_b` leads to, least distance
    /// `clearance` [m], which may be negative for a tolerated overlap.
    pub fn new(
        balls: Vec<Ball>,
        obstacle: Obstacle,
        obstacle_from_b: Pose,
        clearance: f64,
    ) -> Self {
        Self {
            bound: bounding_ball(&balls),
            balls,
            obstacle,
            obstacle_from_b,
            clearance,
        }
    }

    /// True if the row has levelled out whatever the details. `x` is the pose of a in the obstacle's frame.
    fn is_far(&self, x: &Pose) -> bool {
        let pairs = (self.balls.len() * self.obstacle.parts()) as f64;
        let blur = EVENNESS * pairs.ln();
        self.obstacle.roughly_nearest(&x.act(self.bound.0)) - self.bound.1 > LEVEL.1 + blur
    }

    /// Calls `see(centre in a, centre in the obstacle's frame, radius, part)` for all pairs near enough to the nearest
    /// one to have a say, and returns a lower bound of all distances.
    fn near(
        &self,
        x: &Pose,
        mut see: impl FnMut(f64, &Vector3<f64>, &Vector3<f64>, f64, usize),
    ) -> f64 {
        let parts = self.obstacle.parts();
        let mut least = f64::INFINITY;
        for (centre, radius) in &self.balls {
            let p = x.act(*centre);
            for part in 0..parts {
                least = least.min(self.obstacle.rough_distance(part, &p) - radius);
            }
        }
        for (centre, radius) in &self.balls {
            let p = x.act(*centre);
            for part in 0..parts {
                if self.obstacle.rough_distance(part, &p) - radius < least + SEEN {
                    see(least, centre, &p, *radius, part);
                }
            }
        }
        least
    }

    /// Smooth least distance.
    fn smooth(&self, x: &Pose) -> f64 {
        let mut sum = 0.0;
        let least = self.near(x, |least, _, p, radius, part| {
            let d = self.obstacle.distance(part, p) - radius;
            sum += ((least - d) / EVENNESS).exp();
        });
        least - EVENNESS * sum.ln()
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
        vec![(self.clearance, f64::INFINITY)]
    }
    fn values(&self, b_from_a: &Pose, out: &mut [f64]) {
        let x = self.obstacle_from_b * *b_from_a;
        let d = if self.is_far(&x) {
            f64::INFINITY
        } else {
            self.smooth(&x)
        };
        out[0] = level(d).0;
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
        if self.is_far(&x) {
            return Matrix6::zeros();
        }
        // A row far from its bound has a vanishing multiplier and no say in the curvature.
        let curved = weights[0].abs() > 1e-9;
        let (mut sum, mut mean) = (0.0, Vector6::zeros());
        let (mut curvature, mut squares) = (Matrix6::zeros(), Matrix6::zeros());
        let least = self.near(&x, |least, centre, p, radius, part| {
            let (d, g, h) = self.obstacle.derivatives(part, p);
            let share = ((least - d + radius) / EVENNESS).exp();
            let gradient = point_gradient(&x, centre, &g);
            sum += share;
            mean += gradient * share;
            if curved && share > LEAST_SAY {
                let j = point_jacobian(&x, centre);
                curvature += (j.transpose() * h * j + point_hessian(&x, centre, &g)) * share;
                squares += gradient * gradient.transpose() * share;
            }
        });
        let (_, slope, bend) = level(least - EVENNESS * sum.ln());
        mean /= sum;
        gradients[0] = mean * slope;
        if !curved || slope == 0.0 {
            return Matrix6::zeros();
        }
        let square_of_mean = mean * mean.transpose();
        let even = curvature / sum - (squares / sum - square_of_mean) / EVENNESS;
        (even * slope + square_of_mean * bend) * weights[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(balls: Vec<Ball>, obstacle: Obstacle, pose: &Pose) -> f64 {
        let term = Distance::new(balls, obstacle, Pose::identity(), 0.0);
        let mut out = [f64::NAN];
        term.values(pose, &mut out);
        out[0]
    }

    #[test]
    fn a_ball_over_the_middle_of_a_box_reads_its_gap() {
        let half = Vector3::new(0.3, 0.2, 0.1);
        let ball = vec![(Vector3::zeros(), 0.05)];
        let d = row(
            ball,
            Obstacle::Box(half),
            &Pose::from_translation(0.0, 0.0, 0.2),
        );
        assert!((d - 0.05).abs() < 1e-9, "{d}");
    }

    #[test]
    fn balls_equally_near_read_a_little_less_and_far_ones_nothing() {
        let at = |x: f64| (Vector3::new(x, 0.0, 0.0), 0.05);
        let high = Pose::from_translation(0.0, 0.0, 0.1);
        let two = row(vec![at(-0.1), at(0.1)], Obstacle::HalfSpace, &high);
        assert!((two - (0.05 - EVENNESS * 2.0_f64.ln())).abs() < 1e-12);
        let away = row(
            vec![at(0.0)],
            Obstacle::HalfSpace,
            &Pose::from_translation(0.0, 0.0, 5.0),
        );
        assert!((away - 0.09).abs() < 1e-12, "levelled out: {away}");
        let far = (Vector3::new(0.0, 0.0, 0.5), 0.05);
        let one = row(vec![at(0.0), far], Obstacle::HalfSpace, &high);
        assert!((one - 0.05).abs() < 1e-12);
    }
}
