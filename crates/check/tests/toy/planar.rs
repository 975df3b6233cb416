//! Motion and forces of the toy robot in its plane of symmetry, written down by hand.

use nalgebra::Vector3;
use plan::Row6;

/// Gravity [m/s²].
pub(super) const G: f64 = 9.81;

pub(super) fn xz(x: f64, z: f64) -> Vector3<f64> {
    Vector3::new(x, 0.0, z)
}

/// A vector of the x–z plane turned by `angle` about y.
pub(super) fn turned(v: Vector3<f64>, angle: f64) -> Vector3<f64> {
    xz(
        angle.cos() * v.x + angle.sin() * v.z,
        -angle.sin() * v.x + angle.cos() * v.z,
    )
}

/// ω ŷ × r
pub(super) fn spin(omega: f64, r: Vector3<f64>) -> Vector3<f64> {
    xz(omega * r.z, -omega * r.x)
}

/// y component of r × f
pub(super) fn moment(r: Vector3<f64>, f: Vector3<f64>) -> f64 {
    r.z * f.x - r.x * f.z
}

/// Height of the base, angles of shoulder and wrist; or their rates.
pub(super) type Coordinates = [f64; 3];

/// A point with its velocity and acceleration.
#[derive(Clone, Copy)]
pub(super) struct Point {
    pub(super) p: Vector3<f64>,
    pub(super) v: Vector3<f64>,
    pub(super) a: Vector3<f64>,
}

impl Point {
    /// The point `r` further along a rod at `angle` that turns with `rate` and `accel`.
    pub(super) fn along(self, r: Vector3<f64>, [angle, rate, accel]: [f64; 3]) -> Self {
        let r = turned(r, angle);
        let v = spin(rate, r);
        Self {
            p: self.p + r,
            v: self.v + v,
            a: self.a + spin(accel, r) + spin(rate, v),
        }
    }
}

pub(super) struct Body {
    pub(super) mass: f64,
    pub(super) inertia: f64,
    pub(super) at: Point,
    pub(super) rate: f64,
    pub(super) accel: f64,
}

impl Body {
    /// Force that moves it so against gravity.
    pub(super) fn force(&self) -> Vector3<f64> {
        (self.at.a + xz(0.0, G)) * self.mass
    }

    /// Moment about `point` that moves it so.
    pub(super) fn moment_about(&self, point: Vector3<f64>) -> f64 {
        self.inertia * self.accel + moment(self.at.p - point, self.force())
    }
}

/// The robot at one node.
pub(super) struct Snapshot {
    pub(super) bodies: [Body; 6],
    pub(super) shoulder: Vector3<f64>,
    pub(super) wrist: Vector3<f64>,
    pub(super) palm: Vector3<f64>,
    pub(super) stick_tip: Vector3<f64>,
}

impl Snapshot {
    pub(super) fn new(x: Coordinates, v: Coordinates, a: Coordinates) -> Self {
        let fixed = |p| Point {
            p,
            v: Vector3::zeros(),
            a: Vector3::zeros(),
        };
        let base = Point {
            p: xz(0.0, x[0]),
            v: xz(0.0, v[0]),
            a: xz(0.0, a[0]),
        };
        let upright = [0.0; 3];
        let arm_turn = [x[1], v[1], a[1]];
        let hand_turn = [x[1] + x[2], v[1] + v[2], a[1] + a[2]];
        let shoulder = base.along(xz(0.12, 0.1), upright);
        let wrist = shoulder.along(xz(0.3, 0.0), arm_turn);
        let body = |mass, inertia, at, [_, rate, accel]: [f64; 3]| Body {
            mass,
            inertia,
            at,
            rate,
            accel,
        };
        // The legs stand: their joints follow the base. Their lateral places cancel.
        let leg = || body(1.5, 0.02, fixed(xz(0.0, 0.1)), upright);
        let bodies = [
            body(10.0, 0.10, base, upright),
            leg(),
            leg(),
            body(0.2, 0.003, base.along(xz(-0.28, 0.0), upright), upright),
            body(
                1.0,
                0.008,
                shoulder.along(xz(0.15, 0.0), arm_turn),
                arm_turn,
            ),
            body(
                0.4,
                0.0006,
                wrist.along(xz(0.05, 0.0), hand_turn),
                hand_turn,
            ),
        ];
        let palm = wrist.along(xz(0.08, -0.03), hand_turn).p;
        let stick_tip = base.p + xz(-0.48, -0.015);
        Self {
            bodies,
            shoulder: shoulder.p,
            wrist: wrist.p,
            palm,
            stick_tip,
        }
    }

    pub(super) fn mass(&self) -> f64 {
        self.bodies.iter().map(|b| b.mass).sum()
    }

    pub(super) fn com(&self) -> Vector3<f64> {
        self.bodies
            .iter()
            .map(|b| b.at.p * b.mass)
            .sum::<Vector3<f64>>()
            / self.mass()
    }

    /// Linear momentum and angular momentum about the centre of mass.
    pub(super) fn momentum(&self) -> (Vector3<f64>, f64) {
        let com = self.com();
        let linear = self.bodies.iter().map(|b| b.at.v * b.mass).sum();
        let angular = self
            .bodies
            .iter()
            .map(|b| b.inertia * b.rate + moment(b.at.p - com, b.at.v * b.mass))
            .sum();
        (linear, angular)
    }
}

/// A wrench in the plane: force, and moment about y.
#[derive(Clone, Copy)]
pub(super) struct Planar(pub Vector3<f64>, pub f64);

impl Planar {
    pub(super) fn row(self) -> Row6 {
        [self.0.x, self.0.y, self.0.z, 0.0, self.1, 0.0]
    }
}
