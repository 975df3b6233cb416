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
use super::pose_functions::{point_derivatives, point_gradient};
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use spatial::Pose;

/// η [m].
pub const EVENNESS: f64 = 0.003;
/// ε [m]: twice η, so that exp(−d/η) of a box needs no logarithm.
const SHARPNESS: f64 = 2.0 * EVENNESS;
/// d₀ and d₁ [m].
const LEVEL: (f64, f64) = (0.06, 0.12);
/// Balls farther away than the nearest one by more than this have no say: exp(−SEEN/η) is 1e-7 [m].
const SEEN: f64 = 16.0 * EVENNESS;

/// Rough distances of a row that are kept; those of more pairs are found twice.
const KEPT: usize = 64;

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
    #[inline]
    pub fn rough_distance(&self, p: &Vector3<f64>) -> f64 {
        match self {
            Self::Ball(centre, radius) => (p - centre).norm() - radius,
            Self::Box(pose, half) => farthest_out(&pose.act(*p), half),
        }
    }

    fn soft(&self, p: &Vector3<f64>) -> Soft {
        match self {
            Self::Ball(centre, radius) => Soft {
                base: centre_distance(&(p - centre)).0 - radius,
                sum: 1.0,
            },
            Self::Box(pose, half) => faces(&pose.act(*p), half).0,
        }
    }

    fn derivatives(&self, p: &Vector3<f64>) -> (Soft, Vector3<f64>, Matrix3<f64>) {
        match self {
            Self::Ball(centre, radius) => {
                let (d, g, h) = centre_distance(&(p - centre));
                let base = d - radius;
                (Soft { base, sum: 1.0 }, g, h)
            }
            Self::Box(pose, half) => {
                let (d, g, h) = box_distance(&pose.act(*p), half);
                let r = pose.rotation();
                (d, r.tr_mul(&g), r.tr_mul(&h) * r)
            }
        }
    }
}

/// A distance base + ε ln sum [m].
#[derive(Debug, Clone, Copy)]
struct Soft {
    base: f64,
    sum: f64,
}

impl Soft {
    fn value(self) -> f64 {
        self.base + SHARPNESS * self.sum.ln()
    }

    /// exp((reference − distance) / η), the weight in the smooth minimum.
    fn share(self, reference: f64) -> f64 {
        // exp(−ε/η ln sum) with ε = 2 η
        ((reference - self.base) / EVENNESS).exp() / (self.sum * self.sum)
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
    /// Most by which the smooth least distance can be less than the least one [m].
    blur: f64,
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

/// Distance of p to the farthest-out face of a box.
#[inline]
fn farthest_out(p: &Vector3<f64>, half: &Vector3<f64>) -> f64 {
    let out = |i: usize| p[i].abs() - half[i];
    out(0).max(out(1)).max(out(2))
}

/// Smooth box distance at p and the weights of the six faces.
fn faces(p: &Vector3<f64>, half: &Vector3<f64>) -> (Soft, [f64; 6]) {
    let faces: [f64; 6] = std::array::from_fn(|i| {
        if i < 3 {
            p[i] - half[i]
        } else {
            -p[i - 3] - half[i - 3]
        }
    });
    let largest = farthest_out(p, half);
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
    let soft = Soft {
        base: largest,
        sum: weights.iter().sum(),
    };
    (soft, weights)
}

/// Value, gradient and Hessian of the smooth box distance at p.
fn box_distance(p: &Vector3<f64>, half: &Vector3<f64>) -> (Soft, Vector3<f64>, Matrix3<f64>) {
    let (soft, weights) = faces(p, half);
    let sum = soft.sum;
    let gradient = Vector3::from_fn(|i, _| (weights[i] - weights[i + 3]) / sum);
    let diagonal = Vector3::from_fn(|i, _| (weights[i] + weights[i + 3]) / sum);
    let hessian = (Matrix3::from_diagonal(&diagonal) - gradient * gradient.transpose()) / SHARPNESS;
    (soft, gradient, hessian)
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
            Self::Box(half) => farthest_out(p, half),
            Self::HalfSpace => p.z,
            Self::Parts(parts) => parts[part].rough_distance(p),
        }
    }

    /// Distance of a point to a part.
    fn soft(&self, part: usize, p: &Vector3<f64>) -> Soft {
        match self {
            Self::Box(half) => faces(p, half).0,
            Self::HalfSpace => Soft {
                base: p.z,
                sum: 1.0,
            },
            Self::Parts(parts) => parts[part].soft(p),
        }
    }

    /// Distance of a point to a part, gradient and Hessian.
    fn derivatives(&self, part: usize, p: &Vector3<f64>) -> (Soft, Vector3<f64>, Matrix3<f64>) {
        match self {
            Self::Box(half) => box_distance(p, half),
            Self::HalfSpace => (self.soft(part, p), Vector3::z(), Matrix3::zeros()),
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
            .map(|part| self.soft(part, p).value())
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
        let pairs = (balls.len() * obstacle.parts()).max(1);
        Self {
            blur: EVENNESS * (pairs as f64).ln(),
            bound: bounding_ball(&balls),
            balls,
            obstacle,
            obstacle_from_b,
            clearance,
        }
    }

    /// True if the row has levelled out whatever the details. `x` is the pose of a in the obstacle's frame.
    fn is_far(&self, x: &Pose) -> bool {
        let nearest = self.obstacle.roughly_nearest(&x.act(self.bound.0));
        nearest - self.bound.1 > LEVEL.1 + self.blur
    }

    /// Lower bound of the distances of all pairs; those of the first pairs are kept in `rough`, part by part of each ball.
    fn least(&self, x: &Pose, rough: &mut [f64; KEPT]) -> f64 {
        let (mut least, mut pair) = (f64::INFINITY, 0);
        for (centre, radius) in &self.balls {
            let p = x.act(*centre);
            for part in 0..self.obstacle.parts() {
                let distance = self.obstacle.rough_distance(part, &p) - radius;
                least = least.min(distance);
                if let Some(kept) = rough.get_mut(pair) {
                    *kept = distance;
                }
                pair += 1;
            }
        }
        least
    }

    /// The parts near enough to a ball, which is at `p` in the obstacle's frame, to have a say.
    fn seen(
        &self,
        ball: usize,
        p: Vector3<f64>,
        least: f64,
        rough: &[f64; KEPT],
    ) -> impl Iterator<Item = usize> {
        let parts = self.obstacle.parts();
        (0..parts).filter(move |&part| {
            let distance = match rough.get(ball * parts + part) {
                Some(kept) => *kept,
                None => self.obstacle.rough_distance(part, &p) - self.balls[ball].1,
            };
            distance < least + SEEN
        })
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
        out[0] = level(f64::INFINITY).0;
        if self.is_far(&x) {
            return;
        }
        let mut rough = [0.0; KEPT];
        let least = self.least(&x, &mut rough);
        if least > LEVEL.1 + self.blur {
            return;
        }
        let mut sum = 0.0;
        for (ball, (centre, radius)) in self.balls.iter().enumerate() {
            let p = x.act(*centre);
            for part in self.seen(ball, p, least, &rough) {
                sum += self.obstacle.soft(part, &p).share(least + radius);
            }
        }
        out[0] = level(least - EVENNESS * sum.ln()).0;
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
        let mut rough = [0.0; KEPT];
        let least = self.least(&x, &mut rough);
        if least > LEVEL.1 + self.blur {
            return Matrix6::zeros();
        }
        // A row far from its bound has a vanishing multiplier and no say in the curvature.
        let curved = weights[0].abs() > 1e-9;
        let (mut sum, mut mean, mut curvature) = (0.0, Vector6::zeros(), Matrix6::zeros());
        for (ball, (centre, radius)) in self.balls.iter().enumerate() {
            let p = x.act(*centre);
            // By the position of this ball: Σ share ∇d and Σ share (∇²d − ∇d ∇dᵀ/η).
            let (mut by_point, mut squares) = (Vector3::zeros(), Matrix3::zeros());
            for part in self.seen(ball, p, least, &rough) {
                let (d, g, h) = self.obstacle.derivatives(part, &p);
                let share = d.share(least + radius);
                sum += share;
                by_point += g * share;
                squares += (h - g * g.transpose() / EVENNESS) * share;
            }
            if by_point == Vector3::zeros() && squares == Matrix3::zeros() {
                continue;
            }
            if curved {
                let (gradient, hessian) = point_derivatives(&x, centre, &by_point, &squares);
                mean += gradient;
                curvature += hessian;
            } else {
                mean += point_gradient(&x, centre, &by_point);
            }
        }
        let (_, slope, bend) = level(least - EVENNESS * sum.ln());
        mean /= sum;
        gradients[0] = mean * slope;
        if !curved || slope == 0.0 {
            return Matrix6::zeros();
        }
        let square_of_mean = mean * mean.transpose();
        let even = curvature / sum + square_of_mean / EVENNESS;
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
