//! Two links of the robot, or some of their shapes, that keep out of one another.
//!
//! Balls that cover a box leave its edges out by up to 15 mm. Where links are that close at rest, points of fixed places along edges
//! are covered too, and edges that go through a face of the other link's boxes in a guide configuration by the very points that are deepest.

use std::sync::Arc;

use super::edges;
use super::links::{LinkShape, Postures};
use super::pairs::{BLUR, Said, Says, value};
use super::shared::Shared;
use super::{Ball, Part};
use crate::terms::PoseTerm;
use crate::terms::distance::{Distance, Obstacle, bounding_ball};
use multibody::Kinematics;
use nalgebra::Vector3;
use spatial::Pose;

/// Distance at rest from which on links are so close that less can be demanded than edges stick out of the balls that cover boxes [m].
const CLOSE: f64 = 0.015;
/// Distance from which on shapes of such links get a say in their row [m]: with the points along edges there are many.
const NEAR_CLOSE: f64 = 0.08;
/// Distance of neighbouring points on an edge [m].
const EDGE_STEP: f64 = 0.04;
/// Shapes of links three joints apart that are nearer than this at rest may overlap by [`PLAY`]: boxes around the meshes of a hip touch
/// however the leg moves [m].
const ALL_BUT_TOUCH: f64 = 0.005;
/// By how much they may [m].
pub(super) const PLAY: f64 = 0.0005;
/// By how much less than at rest is demanded of two links [m].
pub(super) const AT_REST: f64 = 0.0005;

/// Points with their distances from something [m].
type Nearest = Vec<(f64, Ball)>;

/// Shapes of two links that must not touch: balls of one and parts of the other.
#[derive(Debug, Clone)]
pub(super) struct SelfPair {
    pub a: usize,
    pub b: usize,
    pub balls: Vec<Ball>,
    pub parts: Vec<Part>,
    /// Boxes of the first link whose edges are looked at where they come near boxes of the other: of links that are close at rest.
    boxes: Vec<Part>,
    /// A ball around the balls.
    bound: Ball,
    /// Their distance in the home posture, and the least of that and at the start [m]; negative: a depth.
    pub at_home: f64,
    at_rest: f64,
    /// What their row says in the home posture or at the start, the less of both [m].
    row_at_rest: f64,
    /// Distance from which on they get a row [m].
    near: f64,
    /// Are the links three joints apart.
    beside: bool,
}

impl SelfPair {
    pub fn new(
        postures: &Postures,
        (a, own): (usize, LinkShape),
        (b, parts): (usize, Vec<Part>),
        (near, beside): (f64, bool),
    ) -> Self {
        let mut out = Self {
            a,
            b,
            bound: bounding_ball(&own.balls),
            balls: own.balls.clone(),
            parts,
            boxes: vec![],
            at_home: f64::NAN,
            at_rest: f64::NAN,
            row_at_rest: f64::NAN,
            near,
            beside,
        };
        out.rest(postures);
        let mut covered = out.clone();
        covered.cover_edges(&own.parts);
        covered.near = covered.near.min(NEAR_CLOSE);
        covered.rest(postures);
        if covered.at_rest < CLOSE {
            covered
        } else {
            out
        }
    }

    /// Finds distance and row at rest.
    fn rest(&mut self, postures: &Postures) {
        let [home, start, _] = &postures.0;
        self.at_home = self.distance(home);
        self.at_rest = self.at_home.min(self.distance(start));
        self.row_at_rest = self.row_says(home).min(self.row_says(start));
    }

    /// Covers edges of boxes too, which stick out of their balls by up to 15 mm.
    fn cover_edges(&mut self, own: &[Part]) {
        let is_box = |part: &&Part| matches!(part, Part::Box(..));
        self.boxes = own.iter().filter(is_box).cloned().collect();
        let of_b = edge_points(&self.parts);
        let points = of_b.map(|(centre, radius)| Part::Ball(centre, radius));
        let points: Vec<Part> = points.collect();
        self.parts.extend(points);
        self.balls.extend(edge_points(own));
        self.bound = bounding_ball(&self.balls);
    }

    /// True of shapes that do not overlap for sure, more than in the home posture or not.
    pub fn is_far(&self, kinematics: &Kinematics) -> bool {
        let (centre, radius) = self.bound;
        let p = from_link(kinematics, self.a, self.b).act(centre);
        let near = |part: &Part| part.rough_distance(&p) <= radius + super::FAR;
        !self.parts.iter().any(near)
    }

    /// Least distance of the shapes, or minus their depth [m].
    pub fn distance(&self, kinematics: &Kinematics) -> f64 {
        let b_from_a = from_link(kinematics, self.a, self.b);
        let mut least = f64::INFINITY;
        for (centre, radius) in &self.balls {
            let p = b_from_a.act(*centre);
            for part in &self.parts {
                least = least.min(part.rough_distance(&p) - radius);
            }
        }
        let [of_a, of_b] = self.edges(&b_from_a, least);
        let edges = of_a.iter().chain(&of_b).map(|(distance, _)| *distance);
        edges.fold(least, f64::min)
    }

    /// The points of edges of both links that are nearer to a box of the other one than so much, with their distances, in the frames
    /// of the links.
    fn edges(&self, b_from_a: &Pose, below: f64) -> [Nearest; 2] {
        let (mut of_a, mut of_b) = (vec![], vec![]);
        let add = |out: &mut Nearest, of: &Part, to: &Part, to_from_of: &Pose| {
            let (Part::Box(own_from_link, half), Part::Box(other_from_link, other)) = (of, to)
            else {
                return;
            };
            let there = *other_from_link * *to_from_of * own_from_link.inverse();
            let (own, other) = (Obstacle::Box(*half), Obstacle::Box(*other));
            let found = edges::nearest(&own, &other, &there, below).into_iter();
            let link_from_own = own_from_link.inverse();
            out.extend(found.map(|(d, (p, r))| (d, (link_from_own.act(p), r))));
        };
        let a_from_b = b_from_a.inverse();
        for own in &self.boxes {
            for other in &self.parts {
                add(&mut of_a, own, other, b_from_a);
                add(&mut of_b, other, own, &a_from_b);
            }
        }
        [of_a, of_b]
    }

    /// By how much the shapes are apart, or less deep in one another than they may be [m].
    pub fn beyond_home(&self, kinematics: &Kinematics) -> f64 {
        self.distance(kinematics) - self.at_home.min(0.0)
    }

    /// What the row of the pair says in a configuration [m]: up to a few centimetres less than the distance where flat faces lie
    /// opposite, since there many balls are equally near; infinite far away.
    pub fn row_says(&self, kinematics: &Kinematics) -> f64 {
        let (balls, parts) = self.near(&[kinematics]);
        if balls.is_empty() {
            return f64::INFINITY;
        }
        let row = Distance::new(balls, Obstacle::Parts(parts), Pose::identity(), 0.0);
        value(&row, &from_link(kinematics, self.a, self.b))
    }

    /// The same, and by how much it is less than the distance.
    fn says(&self, kinematics: &Kinematics) -> Said {
        let row = self.row_says(kinematics);
        let less = (self.distance(kinematics) - row).max(0.0);
        Said { row, less }
    }

    /// Distance that can be demanded of the shapes, `wish` if it leaves the robot room: half of that in the home posture, no more
    /// than at rest.
    fn distance_demanded(&self, wish: f64) -> f64 {
        if self.beside && self.at_rest < ALL_BUT_TOUCH {
            return wish.min(-PLAY).min(self.at_rest - AT_REST);
        }
        let half = 0.5 * (self.at_home - BLUR).max(0.0);
        wish.min(half).min(self.at_rest - AT_REST)
    }

    /// What can be demanded of the row in any configuration, where it may say less than the distance.
    pub fn clearance(&self, wish: f64) -> f64 {
        self.distance_demanded(wish).min(self.row_at_rest - AT_REST)
    }

    /// What can be demanded of the row near a configuration: where it says less than the distance at rest, at least that the shapes
    /// keep out of one another.
    pub fn clearance_near(&self, wish: f64, here: &Kinematics) -> f64 {
        let (apart, anywhere) = (self.distance_demanded(wish.min(0.0)), self.clearance(wish));
        if anywhere >= apart {
            return anywhere;
        }
        anywhere.max(apart - self.says(here).less)
    }

    /// Balls and parts that come near one another in any of the configurations.
    fn near(&self, window: &[&Kinematics]) -> (Vec<Ball>, Vec<Part>) {
        let poses: Vec<Pose> = (window.iter())
            .map(|k| from_link(k, self.a, self.b))
            .collect();
        let near = |(centre, radius): &Ball, part: &Part| {
            let mut points = poses.iter().map(|x| x.act(*centre));
            points.any(|p| part.rough_distance(&p) - radius < self.near)
        };
        let parts = self.parts.iter();
        let parts: Vec<Part> = parts
            .filter(|part| near(&self.bound, part))
            .cloned()
            .collect();
        let balls = self.balls.iter();
        let balls = balls.filter(|ball| parts.iter().any(|part| near(ball, part)));
        let (mut balls, mut parts): (Vec<Ball>, _) = (balls.copied().collect(), parts);
        // points of edges that are inside stand for those of fixed places around them: more of them would make the row say less
        for pose in &poses {
            let [of_a, of_b] = self.edges(pose, 0.0);
            for (_, point) in of_a {
                balls.retain(|ball| !is_around(&point, ball));
                balls.push(point);
            }
            for (_, point) in of_b {
                let around =
                    |part: &Part| matches!(part, Part::Ball(p, r) if is_around(&point, &(*p, *r)));
                parts.retain(|part| !around(part));
                parts.push(Part::Ball(point.0, point.1));
            }
        }
        (balls, parts)
    }

    /// The row of the shapes, if they come near one another in any of the configurations.
    pub fn row(
        &self,
        index: usize,
        window: &[&Kinematics],
        demanded: &dyn Fn(Says<'_>) -> f64,
        shared: &mut Shared,
    ) -> Option<Arc<dyn PoseTerm>> {
        let (balls, parts) = self.near(window);
        if balls.is_empty() {
            return None;
        }
        let clearance = demanded(&|k| self.says(k));
        let shapes = (balls, Obstacle::Parts(parts));
        let row = shared.row((index, None), shapes, Pose::identity(), clearance);
        Some(Arc::new(row))
    }
}

/// Points on the edges of boxes, in the frame of their link.
fn edge_points(parts: &[Part]) -> impl Iterator<Item = Ball> + '_ {
    parts.iter().flat_map(|part| {
        let Part::Box(box_from_link, half) = part else {
            return vec![];
        };
        let link_from_box = box_from_link.inverse();
        let points = edges::along_edges(half, EDGE_STEP, (Vector3::zeros(), f64::INFINITY));
        let ball = |p: Vector3<f64>| (link_from_box.act(p), edges::POINT);
        points.into_iter().map(ball).collect()
    })
}

/// Is a ball a point on an edge near another one.
fn is_around((p, _): &Ball, (q, radius): &Ball) -> bool {
    *radius == edges::POINT && (p - q).norm() < 0.5 * EDGE_STEP
}

/// Pose of one link in the frame of another.
pub(super) fn from_link(kinematics: &Kinematics, a: usize, b: usize) -> Pose {
    kinematics.world_from_joint[b].inverse() * kinematics.world_from_joint[a]
}
