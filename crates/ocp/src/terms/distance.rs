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
//! and Σ share (∇²d_k − ∇d_k ∇d_kᵀ/η) + ∇d ∇dᵀ/η.
//!
//! Source: ours, in place of the paper's sigmoids (eq. penalties), which exclude nothing.

use super::PoseTerm;
use super::obstacle::{Curved, LANES, Lanes, act};
pub use super::obstacle::{EVENNESS, Obstacle, Part};
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

/// Sums of gradients and Hessians of functions of points that are fixed to a, by the linear and angular motion of a, in its axes.
///
/// The point at the end of `arm` moves by ρ + ω × arm + ½ ω × (ρ + ω × arm).
struct Sums {
    gradient: [f64; 6],
    /// Σ c J Jᵀ, a column of the lower triangle each, from an even row on.
    squares: [[f64; 6]; 6],
    /// Σ g armᵀ.
    levers: Matrix3<f64>,
}

/// Gradient by the motion of a for gradient `g` by the motion of the point at the end of `arm`.
#[inline]
fn by_motion(arm: &Vector3<f64>, g: &Vector3<f64>) -> [f64; 6] {
    let moment = arm.cross(g);
    [g.x, g.y, g.z, moment.x, moment.y, moment.z]
}

impl Sums {
    fn new() -> Self {
        Self {
            gradient: [0.0; 6],
            squares: [[0.0; 6]; 6],
            levers: Matrix3::zeros(),
        }
    }

    /// c J for the gradient J of a point with gradient `g`.
    #[inline]
    fn add_gradient(&mut self, (arm, g): (&Vector3<f64>, &Vector3<f64>), c: f64) {
        for (sum, j) in self.gradient.iter_mut().zip(by_motion(arm, g)) {
            *sum += c * j;
        }
    }

    /// What turning the arm has in the Hessian of a point with gradient c `g`.
    #[inline]
    fn add_lever(&mut self, (arm, g): (&Vector3<f64>, &Vector3<f64>), c: f64) {
        for i in 0..3 {
            let scaled = c * arm[i];
            for j in 0..3 {
                self.levers[(j, i)] += scaled * g[j];
            }
        }
    }

    /// c J Jᵀ for the gradient J of a point with gradient `g`.
    #[inline]
    fn add_square(&mut self, (arm, g): (&Vector3<f64>, &Vector3<f64>), c: f64) {
        let j = by_motion(arm, g);
        for (k, column) in self.squares.iter_mut().enumerate() {
            let scaled = c * j[k];
            for i in k & !1..6 {
                column[i] += scaled * j[i];
            }
        }
    }

    /// The same for three points at that place with the axes as gradients.
    #[inline]
    fn add_squares_around(&mut self, arm: &Vector3<f64>, c: f64) {
        let moved = arm * c;
        let [linear_x, linear_y, linear_z, angular @ ..] = &mut self.squares;
        linear_x[0] += c;
        linear_y[1] += c;
        linear_z[2] += c;
        // the columns of [arm]
        linear_x[4] += moved.z;
        linear_x[5] -= moved.y;
        linear_y[3] -= moved.z;
        linear_y[5] += moved.x;
        linear_z[3] += moved.y;
        linear_z[4] -= moved.x;
        let square = moved.dot(arm);
        for (k, column) in angular.iter_mut().enumerate() {
            column[3 + k] += square;
            for i in k..3 {
                column[3 + i] -= moved[k] * arm[i];
            }
        }
    }

    fn hessian(&self) -> Matrix6<f64> {
        let mut out = Matrix6::from_fn(|i, j| self.squares[i.min(j)][i.max(j)]);
        let [x, y, z, ..] = self.gradient;
        let half = skew(&Vector3::new(x, y, z)) * 0.5;
        let mut upper = out.fixed_view_mut::<3, 3>(0, 3);
        upper += half;
        let mut lower = out.fixed_view_mut::<3, 3>(3, 0);
        lower -= half;
        let turned = (self.levers + self.levers.transpose()) * 0.5
            - Matrix3::from_diagonal_element(self.levers.trace());
        let mut angular = out.fixed_view_mut::<3, 3>(3, 3);
        angular += turned;
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
            let arm = &self.balls.all[ball as usize].0;
            let d = self.obstacle.derivatives(part as usize, &x.act(*arm));
            let own = |v: &Vector3<f64>| x.rotation().tr_mul(v);
            let g = own(&d.gradient);
            sums.add_gradient((arm, &g), weight);
            if curved {
                sums.add_lever((arm, &g), weight);
                sums.add_square((arm, &g), -weight * (d.curb + 1.0 / EVENNESS));
                match d.curved {
                    Curved::No => {}
                    Curved::Around(c) => sums.add_squares_around(arm, weight * c),
                    Curved::Along(c, axes) => {
                        for (c, axis) in c.iter().zip(axes.column_iter()) {
                            if *c > 0.0 {
                                sums.add_square((arm, &own(&axis.into_owned())), weight * c);
                            }
                        }
                    }
                }
            }
        }
        let gradient = Vector6::from(sums.gradient);
        gradients[0] = gradient * slope;
        if !curved {
            return Matrix6::zeros();
        }
        let even = sums.hessian() * slope;
        let square = (gradient * (slope / EVENNESS + bend)) * gradient.transpose();
        (even + square) * weights[0]
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

    /// Against second differences of f(X exp(ξ)).
    fn assert_hessian(balls: Vec<Ball>, obstacle: Obstacle, pose: &Pose) {
        let term = Distance::new(balls, obstacle, Pose::identity(), 0.0);
        let hessian = term.hessian(pose, &[1.0]);
        let h = 2e-5;
        let f = |xi: &Vector6<f64>| {
            let mut out = [f64::NAN];
            term.values(&(*pose * Pose::exp(xi)), &mut out);
            out[0]
        };
        let e = |i: usize, s: f64| Vector6::from_fn(|k, _| if k == i { s * h } else { 0.0 });
        for i in 0..6 {
            for j in 0..6 {
                let at = |s: f64, t: f64| f(&(e(i, s) + e(j, t)));
                let found =
                    (at(1.0, 1.0) - at(1.0, -1.0) - at(-1.0, 1.0) + at(-1.0, -1.0)) / (4.0 * h * h);
                let off = (hessian[(i, j)] - found).abs();
                assert!(
                    off < 1e-5 / EVENNESS,
                    "{i} {j}: {} {found}",
                    hessian[(i, j)]
                );
            }
        }
    }

    #[test]
    fn second_derivatives_are_those_of_the_value() {
        let half = Vector3::new(0.1, 0.08, 0.03);
        let balls = || {
            vec![
                (Vector3::new(0.02, -0.03, 0.05), 0.02),
                (Vector3::new(0.025, 0.03, 0.05), 0.02),
                (Vector3::new(-0.02, 0.0, 0.05), 0.02),
            ]
        };
        let tilted = Pose::exp(&Vector6::new(0.0, 0.0, 0.0, 0.1, -0.2, 0.3));
        let over = |x: f64, y: f64, z: f64| Pose::from_translation(x, y, z) * tilted;
        assert_hessian(balls(), Obstacle::HalfSpace, &over(0.0, 0.0, -0.02));
        assert_hessian(balls(), Obstacle::Box(half), &over(0.01, 0.0, 0.01));
        assert_hessian(balls(), Obstacle::Box(half), &over(0.1, 0.07, 0.01));
        let parts = || {
            vec![
                Part::Ball(Vector3::new(0.01, 0.0, 0.02), 0.03),
                Part::Box(
                    Pose::exp(&Vector6::new(0.01, 0.0, 0.0, 0.3, 0.1, 0.0)),
                    half,
                ),
            ]
        };
        assert_hessian(balls(), Obstacle::Parts(parts()), &over(0.1, 0.07, 0.01));
        assert_hessian(
            balls(),
            Obstacle::Parts(vec![Part::Ball(Vector3::new(0.01, 0.0, 0.02), 0.03)]),
            &over(0.02, 0.03, 0.03),
        );
    }
}
