//! Where to look from: obliquely from before the robot's first stand, unless static bodies hide much of the motion there.
//!
//! Of some directions the one counts from which fewest of the sampled places of robot and objects lie behind boxes of static
//! bodies; directions off the usual one must be better by a margin.

use crate::motion::Motion;
use nalgebra::Vector3;
use spatial::Pose;

/// Azimuth from the robot's heading at the start, and elevation [rad].
const USUAL: [f64; 2] = [-0.95, 0.34];

/// Azimuths and elevations that are tried [rad]; of equals the first counts.
const AZIMUTHS: [f64; 9] = [-0.95, 0.95, -0.5, 0.5, -1.5, 1.5, -2.1, 2.1, 2.7];
const ELEVATIONS: [f64; 2] = [0.34, 0.6];

/// Hidden shares that a direction must save: off the usual one, for being steeper, and per radian that it is more from behind
/// than from the side.
const OFF: f64 = 0.08;
const STEEP: f64 = 0.04;
const BEHIND: f64 = 0.15;

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
        let boxes = boxes(motion);
        let places = [robot_places(motion), object_places(motion)];
        let mut best = (f64::INFINITY, USUAL);
        for elevation in ELEVATIONS {
            for azimuth in AZIMUTHS {
                let view = Self::new(heading, [azimuth, elevation]);
                let hidden = places.iter().map(|x| share_hidden(x, &boxes, &view.away()));
                let score = hidden.sum::<f64>() + drawback([azimuth, elevation]);
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
    let behind = (azimuth.abs() - 1.5).max(0.0);
    off + steep + BEHIND * behind
}

/// A box of a static body.
struct Block {
    box_from_world: Pose,
    half_size: Vector3<f64>,
}

impl Block {
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

fn boxes(motion: &Motion) -> Vec<Block> {
    let shapes = motion.plan.environment.iter().flat_map(|x| &x.geometry);
    let block = |shape: &plan::Geometry| {
        Some(Block {
            half_size: shape.half_size?.into(),
            box_from_world: Pose::from_xyzquat(&shape.pose).inverse(),
        })
    };
    shapes.filter_map(block).collect()
}

fn nodes(motion: &Motion) -> impl Iterator<Item = usize> {
    let last = motion.n_nodes() - 1;
    (0..=LOOKS).map(move |look| look * last / LOOKS)
}

/// Where the robot's links and interfaces are.
fn robot_places(motion: &Motion) -> Vec<Vector3<f64>> {
    let of_robot = |i: &usize| matches!(motion.carriers[*i], crate::motion::Carrier::Frame(_));
    let interfaces: Vec<_> = (0..motion.carriers.len()).filter(of_robot).collect();
    let links = 0..motion.model.frames.len();
    let at = |t: usize| {
        let interfaces = interfaces.iter();
        let links = links.clone().map(move |i| motion.world_from_frame(t, i));
        links.chain(interfaces.map(move |i| motion.world_from_interface(t, *i)))
    };
    nodes(motion).flat_map(at).map(|x| x.origin()).collect()
}

/// Where the middles and corners of the objects' boxes are.
fn object_places(motion: &Motion) -> Vec<Vector3<f64>> {
    let mut places = Vec::new();
    for (i, object) in motion.plan.objects.iter().enumerate() {
        for t in nodes(motion) {
            let world_from_object = motion.world_from_object(t, i);
            for shape in &object.geometry {
                let world_from_box = world_from_object * Pose::from_xyzquat(&shape.pose);
                let half_size = Vector3::from(shape.half_size.unwrap_or_default());
                places.push(world_from_box.origin());
                places.extend((0..8).map(|corner: usize| {
                    let side =
                        Vector3::from_fn(|k, _| if corner >> k & 1 == 0 { -1.0 } else { 1.0 });
                    world_from_box.act(half_size.component_mul(&side))
                }));
            }
        }
    }
    places
}

fn share_hidden(places: &[Vector3<f64>], boxes: &[Block], away: &Vector3<f64>) -> f64 {
    let hidden = |place: &&Vector3<f64>| boxes.iter().any(|x| x.hides(place, away));
    places.iter().filter(hidden).count() as f64 / places.len().max(1) as f64
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
        assert!(drawback([1.5, 0.6]) < drawback([2.7, 0.34]));
    }
}
