//! Clearance: the balls of a stay outside a primitive of b.
//!
//! One body is covered by balls (capsules by rows of balls), so every pair is ball against box, half-space or ball
//! ([`super::obstacle`]). All pairs of a and b make one row, the smooth minimum
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
//! The shares exp(−d_k/η)/Σ of the pairs that matter are found with the value and kept for the derivatives, Σ share ∇d_k
//! and Σ share (∇²d_k − ∇d_k ∇d_kᵀ/η) + ∇d ∇dᵀ/η. Those are summed in the obstacle's axes, as by the motion ρ + ω × arm
//! of each ball, and turned into those of a at the end.
//!
//! Source: ours, in place of the paper's sigmoids (eq. penalties), which exclude nothing.

use super::PoseTerm;
pub use super::obstacle::{EVENNESS, Obstacle, Part};
use super::obstacle::{LANES, Lanes, act};
use super::pose_functions::direction_block;
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use spatial::{Pose, skew};
use std::sync::Arc;

/// d₀ and d₁ [m].
const LEVEL: (f64, f64) = (MOST_CLEARANCE, 0.12);
/// The most that can be demanded [m]: beyond it rows level out, and what they say never comes to 0.09 m.
pub const MOST_CLEARANCE: f64 = 0.06;
/// Balls farther away than the nearest one by more than this have no say: exp(−SEEN/η) is 1e-7 [m].
const SEEN: f64 = 16.0 * EVENNESS;

/// One row: levelled smooth least distance ≥ clearance [m].
#[derive(Debug)]
pub struct Distance {
    balls: Arc<Balls>,
    obstacle: Arc<Obstacle>,
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

/// Some balls side by side: centres by coordinate, and radii. Those that fill up the last row are nowhere near.
#[derive(Debug, PartialEq)]
struct RowOfBalls {
    centres: [Lanes; 3],
    radii: Lanes,
}

impl RowOfBalls {
    fn new(balls: &[Ball]) -> Self {
        let lane = |of: &dyn Fn(&Ball) -> f64, none: f64| -> Lanes {
            std::array::from_fn(|l| balls.get(l).map_or(none, of))
        };
        Self {
            centres: std::array::from_fn(|i| lane(&|ball| ball.0[i], 0.0)),
            radii: lane(&|ball| ball.1, f64::NEG_INFINITY),
        }
    }
}

/// Balls of a body, with what makes a search among them fast.
#[derive(Debug, PartialEq)]
pub struct Balls {
    all: Vec<Ball>,
    /// The same side by side.
    rows: Vec<RowOfBalls>,
    bound: Ball,
}

impl Balls {
    /// From centres and radii.
    pub fn new(balls: Vec<Ball>) -> Self {
        Self {
            rows: balls.chunks(LANES).map(RowOfBalls::new).collect(),
            bound: bounding_ball(&balls),
            all: balls,
        }
    }
}

/// A ball and a part of the obstacle that matter, and how much.
#[derive(Debug, Clone, Copy)]
struct Share {
    ball: u32,
    part: u32,
    /// exp(−d_k/η)/Σ.
    weight: f64,
}

/// What a row's value leaves for its derivatives at the same pose.
#[derive(Debug, Clone)]
pub struct Nearest {
    /// Smooth least distance [m]; infinite if the row has levelled out.
    distance: f64,
    shares: Vec<Share>,
}

impl Nearest {
    /// Nothing found yet, with room for `n_pairs` pairs ([`PoseTerm::n_pairs`]).
    pub fn new(n_pairs: usize) -> Self {
        Self {
            distance: f64::NAN,
            shares: Vec::with_capacity(n_pairs),
        }
    }
}

/// Sums of gradients and Hessians of the balls' distances by the linear and angular motion of a, in the obstacle's axes.
struct Sums {
    linear: Vector3<f64>,
    angular: Vector3<f64>,
    linear_linear: Matrix3<f64>,
    linear_angular: Matrix3<f64>,
    angular_angular: Matrix3<f64>,
}

impl Sums {
    fn new() -> Self {
        Self {
            linear: Vector3::zeros(),
            angular: Vector3::zeros(),
            linear_linear: Matrix3::zeros(),
            linear_angular: Matrix3::zeros(),
            angular_angular: Matrix3::zeros(),
        }
    }

    /// Gradient `g` at the end of `arm`, which moves by ρ + ω × arm.
    #[inline]
    fn add_gradient(&mut self, arm: &Vector3<f64>, g: &Vector3<f64>) {
        self.linear += g;
        self.angular += arm.cross(g);
    }

    /// The part of the Hessian −c g gᵀ at the end of `arm`, which moves by ρ + ω × arm.
    #[inline]
    fn subtract_square(&mut self, arm: &Vector3<f64>, g: &Vector3<f64>, c: f64) {
        let (moment, scaled) = (arm.cross(g), g * c);
        self.linear_linear -= scaled * g.transpose();
        self.linear_angular -= scaled * moment.transpose();
        self.angular_angular -= (moment * c) * moment.transpose();
    }

    /// The part of the Hessian `h` at the end of `arm`, which moves by ρ + ω × arm.
    fn add_hessian(&mut self, arm: &Vector3<f64>, h: &Matrix3<f64>) {
        self.linear_linear += h;
        // h [arm]ᵀ and [arm] h [arm]ᵀ: rows, then columns, of cross products.
        let cross = |i: usize| arm.cross(&h.column(i));
        let turned = Matrix3::from_columns(&[cross(0), cross(1), cross(2)]);
        self.linear_angular += turned.transpose();
        let cross = |i: usize| arm.cross(&turned.row(i).transpose());
        self.angular_angular += Matrix3::from_columns(&[cross(0), cross(1), cross(2)]);
    }

    /// The gradient in the axes of a.
    fn gradient(&self, obstacle_from_a: &Matrix3<f64>) -> Vector6<f64> {
        let (v, w) = (
            obstacle_from_a.tr_mul(&self.linear),
            obstacle_from_a.tr_mul(&self.angular),
        );
        Vector6::new(v.x, v.y, v.z, w.x, w.y, w.z)
    }

    /// The Hessian in the axes of a.
    fn hessian(&self, obstacle_from_a: &Matrix3<f64>) -> Matrix6<f64> {
        let turned = |m: &Matrix3<f64>| obstacle_from_a.tr_mul(m) * obstacle_from_a;
        let mixed = turned(&(self.linear_angular + skew(&self.linear) * 0.5));
        let mut out = Matrix6::zeros();
        out.fixed_view_mut::<3, 3>(0, 0)
            .copy_from(&turned(&self.linear_linear));
        out.fixed_view_mut::<3, 3>(0, 3).copy_from(&mixed);
        out.fixed_view_mut::<3, 3>(3, 0)
            .copy_from(&mixed.transpose());
        out.fixed_view_mut::<3, 3>(3, 3)
            .copy_from(&turned(&self.angular_angular));
        out
    }
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

impl Distance {
    /// `balls` of a with centres in a, `obstacle` in the frame that `obstacle_from_b` leads to, least distance
    /// `clearance` [m], which may be negative for a tolerated overlap.
    pub fn new(
        balls: Vec<Ball>,
        obstacle: Obstacle,
        obstacle_from_b: Pose,
        clearance: f64,
    ) -> Self {
        let (balls, obstacle) = (Arc::new(Balls::new(balls)), Arc::new(obstacle));
        Self::sharing(balls, obstacle, obstacle_from_b, clearance)
    }

    /// The same with balls and an obstacle that other rows have too. Rows are many, and what they share stays in the
    /// processor's caches.
    pub fn sharing(
        balls: Arc<Balls>,
        obstacle: Arc<Obstacle>,
        obstacle_from_b: Pose,
        clearance: f64,
    ) -> Self {
        let pairs = (balls.all.len() * obstacle.parts()).max(1);
        Self {
            blur: EVENNESS * (pairs as f64).ln(),
            balls,
            obstacle,
            obstacle_from_b,
            clearance,
        }
    }

    /// The same row demanding another distance [m].
    #[must_use]
    pub fn demanding(&self, clearance: f64) -> Self {
        Self {
            balls: self.balls.clone(),
            obstacle: self.obstacle.clone(),
            clearance,
            ..*self
        }
    }

    /// True if the row has levelled out whatever the details. `x` is the pose of a in the obstacle's frame.
    fn is_far(&self, x: &Pose) -> bool {
        let nearest = self.obstacle.roughly_nearest(&x.act(self.balls.bound.0));
        nearest - self.balls.bound.1 > LEVEL.1 + self.blur
    }

    /// Pairs whose rough distance is less than that of the roughly nearest one so far plus [`SEEN`], with that distance in
    /// place of their share. Returns the roughly least distance.
    fn candidates(&self, x: &Pose, out: &mut Vec<Share>) -> f64 {
        let mut least = f64::INFINITY;
        for (row, balls) in self.balls.rows.iter().enumerate() {
            let p = act(x, &balls.centres);
            for part in 0..self.obstacle.parts() {
                let mut distances = self.obstacle.rough_distances(part, &p);
                for (d, radius) in distances.iter_mut().zip(&balls.radii) {
                    *d -= radius;
                }
                let nearest = distances.iter().fold(f64::INFINITY, |a, b| a.min(*b));
                least = least.min(nearest);
                if nearest >= least + SEEN {
                    continue;
                }
                for (l, &weight) in distances.iter().enumerate() {
                    if weight < least + SEEN {
                        let (ball, part) = ((row * LANES + l) as u32, part as u32);
                        out.push(Share { ball, part, weight });
                    }
                }
            }
        }
        least
    }

    /// Finds the pairs that matter, their shares, and the smooth least distance. `x` is the pose of a in the obstacle's frame.
    fn find(&self, x: &Pose, out: &mut Nearest) {
        let Nearest { distance, shares } = out;
        shares.clear();
        *distance = f64::INFINITY;
        if self.is_far(x) {
            return;
        }
        let least = self.candidates(x, shares);
        if least > LEVEL.1 + self.blur {
            shares.clear();
            return;
        }
        let mut sum = 0.0;
        shares.retain_mut(|pair| {
            if pair.weight >= least + SEEN {
                return false;
            }
            let (centre, radius) = &self.balls.all[pair.ball as usize];
            let soft = self.obstacle.soft(pair.part as usize, &x.act(*centre));
            pair.weight = soft.share(least + radius);
            sum += pair.weight;
            true
        });
        for pair in shares {
            pair.weight /= sum;
        }
        *distance = least - EVENNESS * sum.ln();
    }

    /// By how much the smooth least distance is less than the least one where a is at `b_from_a` [m]; zero far away.
    pub fn falls_short(&self, b_from_a: &Pose) -> f64 {
        let x = self.obstacle_from_b * *b_from_a;
        let smooth = self.found(b_from_a).distance;
        if smooth.is_finite() {
            (self.candidates(&x, &mut vec![]) - smooth).max(0.0)
        } else {
            0.0
        }
    }

    /// Nothing kept from the value: finds what matters again.
    fn found(&self, b_from_a: &Pose) -> Nearest {
        let mut nearest = Nearest::new(0);
        self.find(&(self.obstacle_from_b * *b_from_a), &mut nearest);
        nearest
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
    fn n_pairs(&self) -> usize {
        self.balls.all.len() * self.obstacle.parts()
    }
    fn values(&self, b_from_a: &Pose, out: &mut [f64]) {
        out[0] = level(self.found(b_from_a).distance).0;
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
        self.derivatives_near(b_from_a, weights, &self.found(b_from_a), gradients)
    }
    fn values_near(&self, b_from_a: &Pose, out: &mut [f64], nearest: &mut Nearest) {
        self.find(&(self.obstacle_from_b * *b_from_a), nearest);
        out[0] = level(nearest.distance).0;
    }
    fn derivatives_near(
        &self,
        b_from_a: &Pose,
        weights: &[f64],
        nearest: &Nearest,
        gradients: &mut [Vector6<f64>],
    ) -> Matrix6<f64> {
        let (_, slope, bend) = level(nearest.distance);
        if slope == 0.0 {
            gradients[0] = Vector6::zeros();
            return Matrix6::zeros();
        }
        let x = self.obstacle_from_b * *b_from_a;
        // A row far from its bound has a vanishing multiplier and no say in the curvature.
        let curved = weights[0].abs() > 1e-9;
        let mut sums = Sums::new();
        for &Share { ball, part, weight } in &nearest.shares {
            let arm = x.rotate(self.balls.all[ball as usize].0);
            let d = (self.obstacle).derivatives(part as usize, &(arm + x.origin()));
            let g = d.gradient * weight;
            sums.add_gradient(&arm, &g);
            if curved {
                // The end of the arm moves by ρ + ω × arm + ½ ω × (ρ + ω × arm).
                sums.angular_angular += direction_block(&g, &arm);
                sums.subtract_square(&arm, &d.gradient, weight * (d.curb + 1.0 / EVENNESS));
                if let Some(h) = d.curved {
                    sums.add_hessian(&arm, &(h * weight));
                }
            }
        }
        let gradient = sums.gradient(x.rotation());
        gradients[0] = gradient * slope;
        if !curved {
            return Matrix6::zeros();
        }
        let even = sums.hessian(x.rotation()) * slope;
        let square = (gradient * (slope / EVENNESS + bend)) * gradient.transpose();
        (even + square) * weights[0]
    }
}

#[cfg(test)]
mod tests;
