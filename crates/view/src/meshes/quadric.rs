//! How far a place is from planes: a sum of squared distances as a quadratic form.
//!
//! Source: M. Garland, P. Heckbert, "Surface simplification using quadric error metrics", 1997.

use nalgebra::{Matrix3, Vector3};
use std::ops::AddAssign;

/// Pull of the best place towards a given one, relative to the planes': settles it along directions that no plane fixes.
const PULL: f64 = 1e-3;

/// Q(x) = Σ w (n·x + d)² = xᵀ A x + 2 bᵀ x + c, of planes with unit normals n and weights w.
#[derive(Debug, Clone, Copy)]
pub(super) struct Quadric {
    a: Matrix3<f64>,
    b: Vector3<f64>,
    c: f64,
    /// Σ w.
    weight: f64,
}

impl Quadric {
    /// No plane.
    pub const ZERO: Self = Self {
        a: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        b: Vector3::new(0.0, 0.0, 0.0),
        c: 0.0,
        weight: 0.0,
    };

    /// The plane through `place` with a unit normal.
    pub fn plane(normal: &Vector3<f64>, place: &Vector3<f64>, weight: f64) -> Self {
        let d = -normal.dot(place);
        Self {
            a: normal * normal.transpose() * weight,
            b: normal * (d * weight),
            c: d * d * weight,
            weight,
        }
    }

    /// Q(x): weight times squared distance.
    pub fn value(&self, x: &Vector3<f64>) -> f64 {
        (x.dot(&(self.a * x)) + 2.0 * self.b.dot(x) + self.c).max(0.0)
    }

    /// Root of the mean squared distance from the planes [m], for a value of Q.
    pub fn distance(&self, value: f64) -> f64 {
        if self.weight > 0.0 {
            (value / self.weight).sqrt()
        } else {
            0.0
        }
    }

    /// The place with the least Q, near `guess` where planes leave it free.
    pub fn best(&self, guess: &Vector3<f64>) -> Vector3<f64> {
        let pull = PULL * self.weight;
        let form = self.a + Matrix3::identity() * pull;
        let inverse = form.try_inverse();
        inverse.map_or(*guess, |inverse| inverse * (guess * pull - self.b))
    }
}

impl AddAssign for Quadric {
    fn add_assign(&mut self, other: Self) {
        self.a += other.a;
        self.b += other.b;
        self.c += other.c;
        self.weight += other.weight;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_place_of_three_planes_is_their_corner() {
        let corner = Vector3::new(0.3, -0.2, 0.5);
        let mut quadric = Quadric::ZERO;
        for axis in 0..3 {
            quadric += Quadric::plane(&Vector3::ith(axis, 1.0), &corner, 2.0);
        }
        assert!(quadric.value(&corner) < 1e-15);
        let off = corner + Vector3::new(0.0, 0.1, 0.0);
        assert!((quadric.value(&off) - 2.0 * 0.01).abs() < 1e-12);
        assert!((quadric.distance(quadric.value(&off)) - 0.1 / 3f64.sqrt()).abs() < 1e-12);
        assert!((quadric.best(&off) - corner).norm() < 0.1 * 4.0 * PULL);
    }

    #[test]
    fn where_planes_leave_it_free_it_stays_near_the_guess() {
        let quadric = Quadric::plane(&Vector3::z(), &Vector3::zeros(), 1.0);
        let best = quadric.best(&Vector3::new(3.0, 4.0, 0.1));
        assert!((best - Vector3::new(3.0, 4.0, 0.0)).norm() < 1e-3);
        let guess = Vector3::x();
        assert_eq!(Quadric::ZERO.best(&guess), guess);
        assert_eq!(Quadric::ZERO.distance(0.0), 0.0);
    }
}
