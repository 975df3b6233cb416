//! What balls avoid: boxes, half-spaces and the parts of links, with smooth distances of points from them.
//!
//! The box's distance is smooth: with d_±i = ±p_i − h_i over its six faces,
//!
//! ```text
//! d(p) = ε ln Σ exp(d_±i / ε)  ≥  max_i (|p_i| − h_i)
//! ```
//!
//! convex and infinitely smooth; exact over faces, at most ε ln 3 too large at a corner, and smaller than the Euclidean
//! distance around edges by up to (1 − 1/√2) of it, which is the safe side.
//!
//! Second derivatives come as S − curb g gᵀ with g the gradient: S is diagonal in the axes of a box, a multiple of the
//! identity for a ball; over a plane, as over the middle of a face, there are none.
//!
//! Source: ours.

use nalgebra::{Matrix3, Vector3};
use spatial::Pose;

/// η [m]: evenness of the smooth minimum over distances.
pub const EVENNESS: f64 = 0.003;
/// ε [m]: twice η, so that exp(−d/η) of a box needs no logarithm.
const SHARPNESS: f64 = 2.0 * EVENNESS;

/// Faces below the farthest-out one by more than this, in multiples of ε, have no say: exp(UNSEEN) is 1e-7.
const UNSEEN: f64 = -16.0;

/// Numbers of this many points side by side, which the compiler computes at once.
pub(super) const LANES: usize = 4;
pub(super) type Lanes = [f64; LANES];

/// A primitive of b.
#[derive(Debug, Clone, PartialEq)]
pub enum Obstacle {
    /// A box with these half sizes, centred in b.
    Box(Vector3<f64>),
    /// The half-space z < 0 of b.
    HalfSpace,
    /// Several parts, such as those of a link.
    Parts(Vec<Part>),
}

/// A part of an obstacle.
#[derive(Debug, Clone, PartialEq)]
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
                base: centre_distance(&(p - centre)) - radius,
                sum: 1.0,
            },
            Self::Box(pose, half) => faces(&pose.act(*p), half).0,
        }
    }

    /// [`Part::rough_distance`] of several points, given by coordinate.
    #[inline]
    fn rough_distances(&self, p: &[Lanes; 3]) -> Lanes {
        match self {
            Self::Ball(centre, radius) => std::array::from_fn(|l| {
                let (x, y, z) = (p[0][l] - centre.x, p[1][l] - centre.y, p[2][l] - centre.z);
                (x * x + y * y + z * z).sqrt() - radius
            }),
            Self::Box(pose, half) => farthest_out_faces(&act(pose, p), half),
        }
    }

    fn derivatives(&self, p: &Vector3<f64>) -> Derivatives {
        match self {
            Self::Ball(centre, _) => {
                let q = p - centre;
                let d = centre_distance(&q);
                Derivatives {
                    gradient: q / d,
                    curved: Some(Matrix3::from_diagonal_element(1.0 / d)),
                    curb: 1.0 / d,
                }
            }
            Self::Box(pose, half) => {
                let of_box = box_derivatives(&pose.act(*p), half);
                let r = pose.rotation();
                Derivatives {
                    gradient: r.tr_mul(&of_box.gradient),
                    curved: of_box.curved.map(|diagonal| r.tr_mul(&diagonal) * r),
                    curb: of_box.curb,
                }
            }
        }
    }
}

/// Gradient g of a distance, and its Hessian S − curb g gᵀ.
#[derive(Debug, Clone, Copy)]
pub(super) struct Derivatives {
    pub gradient: Vector3<f64>,
    /// S; none over a plane.
    pub curved: Option<Matrix3<f64>>,
    pub curb: f64,
}

impl Derivatives {
    fn over_a_plane(gradient: Vector3<f64>) -> Self {
        Self {
            gradient,
            curved: None,
            curb: 0.0,
        }
    }
}

/// A distance base + ε ln sum [m].
#[derive(Debug, Clone, Copy)]
pub(super) struct Soft {
    base: f64,
    sum: f64,
}

impl Soft {
    /// The distance [m].
    pub fn value(self) -> f64 {
        self.base + SHARPNESS * self.sum.ln()
    }

    /// exp((reference − distance) / η), the weight in the smooth minimum.
    pub fn share(self, reference: f64) -> f64 {
        // exp(−ε/η ln sum) with ε = 2 η
        ((reference - self.base) / EVENNESS).exp() / (self.sum * self.sum)
    }
}

/// Distance of p to the farthest-out face of a box.
#[inline]
fn farthest_out(p: &Vector3<f64>, half: &Vector3<f64>) -> f64 {
    let out = |i: usize| p[i].abs() - half[i];
    out(0).max(out(1)).max(out(2))
}

/// The same for several points, given by coordinate.
#[inline]
fn farthest_out_faces(p: &[Lanes; 3], half: &Vector3<f64>) -> Lanes {
    std::array::from_fn(|l| {
        let out = |i: usize| p[i][l].abs() - half[i];
        out(0).max(out(1)).max(out(2))
    })
}

/// [`Pose::act`] on several points, given by coordinate.
#[inline]
pub(super) fn act(pose: &Pose, p: &[Lanes; 3]) -> [Lanes; 3] {
    let (r, t) = (pose.rotation(), pose.origin());
    std::array::from_fn(|i| {
        let (x, y, z) = (r[(i, 0)], r[(i, 1)], r[(i, 2)]);
        std::array::from_fn(|l| x * p[0][l] + y * p[1][l] + z * p[2][l] + t[i])
    })
}

/// Smooth box distance at p and, by axis, the weights of the face on p's side and of the one opposite.
#[inline]
fn faces(p: &Vector3<f64>, half: &Vector3<f64>) -> (Soft, [[f64; 2]; 3]) {
    let largest = farthest_out(p, half);
    let weight = |d: f64| {
        let below = (d - largest) * (1.0 / SHARPNESS);
        if below >= 0.0 {
            1.0
        } else if below < UNSEEN {
            0.0
        } else {
            below.exp()
        }
    };
    let weights = std::array::from_fn(|i| {
        let (out, half) = (p[i].abs(), half[i]);
        [weight(out - half), weight(-out - half)]
    });
    let soft = Soft {
        base: largest,
        sum: weights.as_flattened().iter().sum(),
    };
    (soft, weights)
}

/// Gradient and Hessian of the smooth box distance at p.
#[inline]
fn box_derivatives(p: &Vector3<f64>, half: &Vector3<f64>) -> Derivatives {
    let (soft, weights) = faces(p, half);
    let side = |i: usize| 1.0_f64.copysign(p[i]);
    let gradient = |i: usize| side(i) * (weights[i][0] - weights[i][1]) / soft.sum;
    let gradient = Vector3::from_fn(|i, _| gradient(i));
    if soft.sum == 1.0 {
        // Mostly only one face is near.
        return Derivatives::over_a_plane(gradient);
    }
    let scale = soft.sum * SHARPNESS;
    let diagonal = Vector3::from_fn(|i, _| (weights[i][0] + weights[i][1]) / scale);
    Derivatives {
        gradient,
        curved: Some(Matrix3::from_diagonal(&diagonal)),
        curb: 1.0 / SHARPNESS,
    }
}

/// Smooth distance of two centres: √(|p|² + ε²) with ε = 1 mm, never smaller than the distance by more than it.
fn centre_distance(p: &Vector3<f64>) -> f64 {
    const EPSILON: f64 = 1e-3;
    (p.norm_squared() + EPSILON * EPSILON).sqrt()
}

impl Obstacle {
    /// Number of parts with a distance of their own.
    pub(super) fn parts(&self) -> usize {
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

    /// The same for several points, given by coordinate.
    #[inline]
    pub(super) fn rough_distances(&self, part: usize, p: &[Lanes; 3]) -> Lanes {
        match self {
            Self::Box(half) => farthest_out_faces(p, half),
            Self::HalfSpace => p[2],
            Self::Parts(parts) => parts[part].rough_distances(p),
        }
    }

    /// Distance of a point to a part.
    pub(super) fn soft(&self, part: usize, p: &Vector3<f64>) -> Soft {
        match self {
            Self::Box(half) => faces(p, half).0,
            Self::HalfSpace => Soft {
                base: p.z,
                sum: 1.0,
            },
            Self::Parts(parts) => parts[part].soft(p),
        }
    }

    /// Gradient and Hessian of the distance of a point to a part.
    pub(super) fn derivatives(&self, part: usize, p: &Vector3<f64>) -> Derivatives {
        match self {
            Self::Box(half) => box_derivatives(p, half),
            Self::HalfSpace => Derivatives::over_a_plane(Vector3::z()),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn several_points_at_once_are_as_far_as_one_by_one() {
        let half = Vector3::new(0.3, 0.2, 0.1);
        let parts = vec![
            Part::Ball(Vector3::new(0.1, -0.2, 0.3), 0.05),
            Part::Box(Pose::random(3), half),
        ];
        let pose = Pose::random(5);
        let points: [Vector3<f64>; LANES] =
            std::array::from_fn(|l| Pose::random(l as u64).origin());
        let by_coordinate = std::array::from_fn(|i| points.map(|p| p[i]));
        let moved = act(&pose, &by_coordinate);
        for obstacle in [
            Obstacle::Box(half),
            Obstacle::HalfSpace,
            Obstacle::Parts(parts),
        ] {
            for part in 0..obstacle.parts() {
                let at_once = obstacle.rough_distances(part, &moved);
                for (d, p) in at_once.iter().zip(&points) {
                    let expected = obstacle.rough_distance(part, &pose.act(*p));
                    assert!((d - expected).abs() < 1e-12);
                }
            }
        }
    }
}
