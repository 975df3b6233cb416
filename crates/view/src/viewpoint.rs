//! Where to look from: obliquely from before the robot's first stand, unless static bodies hide much of the motion there.
//!
//! Of some directions the one counts from which fewest of the sampled places of robot and objects lie behind boxes of static
//! bodies, those of objects also behind other objects, and which looks least along the way that they go. Directions off the
//! usual one must be better by a margin.

use crate::motion::{Carrier, Motion};
use nalgebra::{Matrix2, Vector2, Vector3};
use plan::Geometry;
use spatial::Pose;

/// Azimuth from the robot's heading at the start, and elevation [rad].
const USUAL: [f64; 2] = [-0.95, 0.34];

/// Azimuths and elevations that are tried [rad]; of equals the first counts.
const AZIMUTHS: [f64; 8] = [-0.95, 0.95, -0.5, 0.5, -1.5, 1.5, -2.1, 2.1];
const ELEVATIONS: [f64; 2] = [0.34, 0.6];

/// Hidden shares that a direction must save: off the usual one; for being steeper; per radian beyond the usual azimuth; and per
/// radian from behind, where the robot hides what it does.
const OFF: f64 = 0.05;
const STEEP: f64 = 0.04;
const ASIDE: f64 = 0.1;
const BEHIND: f64 = 0.3;

/// Hidden share that weighs as much as looking along the way of robot and objects, compared with across it.
const ALONG: f64 = 0.2;

/// Nodes at which it is asked what is hidden.
const LOOKS: usize = 24;

/// A body does not hide places within this distance: what touches it is seen beside it [m].
const NEAR: f64 = 0.03;

/// A direction of view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Viewpoint {
    /// About the world's z, from its x [rad].
    pub azimuth: f64,
    /// Above the horizon [rad].
    pub elevation: f64,
}

impl Viewpoint {
    /// The direction for a motion.
    pub fn of(motion: &Motion) -> Self {
        let facing = motion.world_from_frame(0, 0).rotate(Vector3::x());
        let heading = facing.y.atan2(facing.x);
        let sight = Sight::of(motion);
        let mut best = (f64::INFINITY, USUAL);
        for elevation in ELEVATIONS {
            for azimuth in AZIMUTHS {
                let view = Self::new(heading, [azimuth, elevation]);
                let score = sight.hidden(&view.away()) + drawback([azimuth, elevation]);
                if score < best.0 {
                    best = (score, [azimuth, elevation]);
                }
            }
        }
        Self::new(heading, best.1)
    }

    fn new(heading: f64, [azimuth, elevation]: [f64; 2]) -> Self {
        let azimuth = heading + azimuth;
        Self { azimuth, elevation }
    }

    /// Unit vector towards the viewer.
    pub fn away(&self) -> Vector3<f64> {
        let flat = self.elevation.cos();
        Vector3::new(
            self.azimuth.cos() * flat,
            self.azimuth.sin() * flat,
            self.elevation.sin(),
        )
    }
}

fn drawback([azimuth, elevation]: [f64; 2]) -> f64 {
    let steep = if elevation > USUAL[1] { STEEP } else { 0.0 };
    let off = if azimuth == USUAL[0] { 0.0 } else { OFF };
    let beyond = |from: f64| (azimuth.abs() - from).max(0.0);
    off + steep + ASIDE * beyond(USUAL[0].abs()) + BEHIND * beyond(1.5)
}

/// What there is to see, and what may be in the way, at some nodes.
struct Sight {
    fixed: Vec<Block>,
    looks: Vec<Look>,
    /// Horizontal spread of all places: its covariance over the sum of its variances.
    spread: Matrix2<f64>,
}

/// One node.
struct Look {
    /// Of links and interfaces.
    robot: Vec<Vector3<f64>>,
    /// Per object its boxes, and their middles and corners.
    objects: Vec<(Vec<Block>, Vec<Vector3<f64>>)>,
}

impl Sight {
    fn of(motion: &Motion) -> Self {
        let last = motion.n_nodes() - 1;
        let looks: Vec<_> = (0..=LOOKS)
            .map(|look| Look::of(motion, look * last / LOOKS))
            .collect();
        let fixed = motion.plan.environment.iter();
        Self {
            fixed: fixed
                .flat_map(|x| blocks(&x.geometry, &Pose::identity()))
                .collect(),
            spread: spread(looks.iter().flat_map(Look::places)),
            looks,
        }
    }

    /// Shares of the places of robot and of objects that are hidden, and what looking along their way weighs.
    fn hidden(&self, away: &Vector3<f64>) -> f64 {
        let (mut robot, mut objects) = (Share::default(), Share::default());
        for look in &self.looks {
            for place in &look.robot {
                robot.add(self.fixed.iter().any(|x| x.hides(place, away)));
            }
            for (i, (_, places)) in look.objects.iter().enumerate() {
                let others = look.objects.iter().enumerate().filter(|(j, _)| *j != i);
                let others: Vec<_> = others.flat_map(|(_, (blocks, _))| blocks).collect();
                for place in places {
                    let mut all = self.fixed.iter().chain(others.iter().copied());
                    objects.add(all.any(|x| x.hides(place, away)));
                }
            }
        }
        let flat = Vector2::new(away.x, away.y).normalize();
        robot.value() + objects.value() + ALONG * flat.dot(&(self.spread * flat))
    }
}

impl Look {
    fn of(motion: &Motion, t: usize) -> Self {
        let links = (0..motion.model.frames.len()).map(|i| motion.world_from_frame(t, i));
        let on_robot = |i: &usize| matches!(motion.carriers[*i], Carrier::Frame(_));
        let interfaces = (0..motion.carriers.len()).filter(on_robot);
        let interfaces = interfaces.map(|i| motion.world_from_interface(t, i));
        let object = |(i, object): (usize, &plan::Object)| {
            let blocks = blocks(&object.geometry, &motion.world_from_object(t, i));
            let places = blocks.iter().flat_map(Block::places).collect();
            (blocks, places)
        };
        Self {
            robot: links.chain(interfaces).map(|x| x.origin()).collect(),
            objects: motion.plan.objects.iter().enumerate().map(object).collect(),
        }
    }

    fn places(&self) -> impl Iterator<Item = &Vector3<f64>> {
        let objects = self.objects.iter().flat_map(|(_, places)| places);
        self.robot.iter().chain(objects)
    }
}

/// How many of all.
#[derive(Default)]
struct Share {
    counted: usize,
    all: usize,
}

impl Share {
    fn add(&mut self, counts: bool) {
        self.counted += usize::from(counts);
        self.all += 1;
    }

    fn value(&self) -> f64 {
        self.counted as f64 / self.all.max(1) as f64
    }
}

fn spread<'p>(places: impl Iterator<Item = &'p Vector3<f64>>) -> Matrix2<f64> {
    let flat: Vec<_> = places.map(|x| Vector2::new(x.x, x.y)).collect();
    let mean = flat.iter().sum::<Vector2<f64>>() / flat.len().max(1) as f64;
    let squares = flat.iter().map(|x| (x - mean) * (x - mean).transpose());
    let sum: Matrix2<f64> = squares.sum();
    sum / sum.trace().max(f64::MIN_POSITIVE)
}

/// A box that may hide what is behind it.
struct Block {
    box_from_world: Pose,
    half_size: Vector3<f64>,
}

impl Block {
    /// Middle and corners in the world.
    fn places(&self) -> impl Iterator<Item = Vector3<f64>> {
        let world_from_box = self.box_from_world.inverse();
        let corners = (0..8).map(|corner: usize| {
            Vector3::from_fn(|k, _| if corner >> k & 1 == 0 { -1.0 } else { 1.0 })
        });
        let all = corners.chain([Vector3::zeros()]);
        all.map(move |side| world_from_box.act(self.half_size.component_mul(&side)))
    }

    /// True if the ray from `place` along `away` meets the box, further than [`NEAR`].
    fn hides(&self, place: &Vector3<f64>, away: &Vector3<f64>) -> bool {
        let start = self.box_from_world.act(place + away * NEAR);
        let along = self.box_from_world.rotate(*away);
        let (mut enter, mut leave) = (0.0, f64::INFINITY);
        for k in 0..3 {
            // Along a face, one end is +∞ and one −∞, or both have the same sign: outside.
            let ends = [-1.0, 1.0].map(|side| (side * self.half_size[k] - start[k]) / along[k]);
            enter = ends[0].min(ends[1]).max(enter);
            leave = ends[0].max(ends[1]).min(leave);
        }
        enter < leave
    }
}

fn blocks(shapes: &[Geometry], world_from_body: &Pose) -> Vec<Block> {
    let block = |shape: &Geometry| {
        Some(Block {
            half_size: shape.half_size?.into(),
            box_from_world: (*world_from_body * Pose::from_xyzquat(&shape.pose)).inverse(),
        })
    };
    shapes.iter().filter_map(block).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wall_hides_what_is_behind_it_and_nothing_else() {
        let wall = Block {
            box_from_world: Pose::from_translation(2.0, 0.0, 0.5).inverse(),
            half_size: Vector3::new(0.05, 1.0, 0.5),
        };
        let hides = |place: [f64; 3], away: Vector3<f64>| wall.hides(&place.into(), &away);
        assert!(hides([0.0, 0.0, 0.5], Vector3::x()));
        assert!(
            !hides([0.0, 0.0, 0.5], -Vector3::x()),
            "seen from the other side"
        );
        assert!(!hides([0.0, 0.0, 1.2], Vector3::x()), "over it");
        assert!(!hides([0.0, 1.5, 0.5], Vector3::x()), "beside it");
        assert!(!hides([2.0, 0.0, 1.0], Vector3::z()), "on it");
        let steep = Vector3::new(1.0, 0.0, 0.6).normalize();
        assert!(!hides([0.0, 0.0, 0.5], steep), "from above");
    }

    #[test]
    fn the_usual_direction_has_no_drawback_and_those_from_behind_most() {
        assert_eq!(drawback(USUAL), 0.0);
        assert!(drawback([0.95, 0.34]) < drawback([0.95, 0.6]));
        assert!(drawback([1.5, 0.6]) < drawback([2.1, 0.34]));
    }
}
