//! How far a foot must reach from one surface to another, at least: what orders sequences before anything is computed of them.
//!
//! A stair or a stone that is left out makes a stride that a robot can hardly do slowly, and the symbols do not show it. Feet are
//! set on places of a grid, where a sole fits on its surface and nothing static stands.
//!
//! Source: ours. It orders, it forbids nothing.

use crate::domain::UPWARD;
use nalgebra::Vector3;
use scene::{Interface, Owner, Role, Scene, Shape};
use spatial::Pose;

/// Distance of places on a surface [m], and most of them in one direction: on larger surfaces they are farther apart.
const GRID: f64 = 0.05;
const MOST_STEPS: usize = 80;
/// How far an unbounded surface is looked at beyond everything else [m].
const AROUND: f64 = 0.5;
/// Stride and rise that are done without effort, in heights of the base over the feet.
const EASY_STRIDE: f64 = 0.45;
const EASY_RISE: f64 = 0.3;
/// What one height of the base more of stride or rise costs [phases]: a stair of 0.3 m that is left out as much as three swings.
const EFFORT: f64 = 20.0;

/// Least effort of a stride from any surface to any other.
pub(crate) struct Strides {
    efforts: Vec<Vec<f64>>,
}

impl Strides {
    /// Looks at the surfaces of a scene as they are at the start. Those of objects may be anywhere: only their height counts.
    pub fn new(scene: &Scene) -> Self {
        let sole = sole(scene);
        let surfaces: Vec<Option<Surface>> = scene
            .interfaces
            .iter()
            .map(|i| Surface::new(scene, i, sole))
            .collect();
        let height = ocp::base_height(scene);
        let effort = |a: usize, b: usize| match (&surfaces[a], &surfaces[b]) {
            (Some(from), Some(to)) if a != b => from.effort_to(to, height),
            _ => 0.0,
        };
        let all = 0..surfaces.len();
        let most_to = |b| all.clone().map(|a| effort(a, b)).fold(0.0, f64::max);
        let most: Vec<f64> = all.clone().map(most_to).collect();
        let from = |a: usize| {
            let to = |b| match surfaces[a] {
                Some(_) => effort(a, b),
                None => most[b],
            };
            all.clone().map(to).collect()
        };
        Self {
            efforts: all.clone().map(from).collect(),
        }
    }

    /// Cost of setting a foot on `to` while another one stands on `from` [phases]. From what does not face up, such as a wall, as much
    /// as from where it is farthest.
    pub fn effort(&self, from: usize, to: usize) -> f64 {
        self.efforts[from][to]
    }
}

/// An upward surface.
struct Surface {
    height: f64,
    /// Where a foot can be; `None`: anywhere.
    places: Option<Vec<[f64; 2]>>,
}

impl Surface {
    fn new(scene: &Scene, interface: &Interface, sole: f64) -> Option<Self> {
        let (pose, fixed) = match interface.owner {
            Owner::Robot { .. } => return None,
            Owner::Object(o) => {
                let start = scene.objects[o].world_from_start;
                (start * interface.body_from_interface, false)
            }
            Owner::Static(_) => (interface.body_from_interface, true),
        };
        (pose.rotate(Vector3::z()).z > UPWARD).then(|| Self {
            height: pose.origin().z,
            places: fixed.then(|| places(scene, &pose, interface.half_size, sole)),
        })
    }

    /// Effort of the shortest stride to a place of another surface.
    fn effort_to(&self, other: &Self, base_height: f64) -> f64 {
        let rise = (other.height - self.height).abs() - EASY_RISE * base_height;
        let apart = match (&self.places, &other.places) {
            (Some(a), Some(b)) if !a.is_empty() && !b.is_empty() => {
                let squared =
                    |p: &[f64; 2], q: &[f64; 2]| (p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2);
                let nearest = |p| {
                    b.iter()
                        .map(|q| squared(p, q))
                        .fold(f64::INFINITY, f64::min)
                };
                a.iter().map(nearest).fold(f64::INFINITY, f64::min).sqrt()
            }
            _ => 0.0,
        };
        let beyond = (apart - EASY_STRIDE * base_height).max(0.0) + rise.max(0.0);
        EFFORT * beyond / base_height
    }
}

/// Half the length of the longest sole [m].
fn sole(scene: &Scene) -> f64 {
    let feet = scene.interfaces.iter().filter(|i| i.role == Role::Foot);
    let lengths = feet.filter_map(|i| i.half_size.map(|[x, y]| x.max(y)));
    lengths.fold(0.0, f64::max)
}

/// Places of a grid on a surface where a sole fits in one direction at least and no static body is in its way.
fn places(scene: &Scene, pose: &Pose, half_size: Option<[f64; 2]>, sole: f64) -> Vec<[f64; 2]> {
    let blocks = blocks(scene);
    let points = half_size.map_or_else(
        || points_around(scene, &blocks, pose.origin().z),
        |half| points_on(pose, half, sole),
    );
    let free = |p: &&Vector3<f64>| !blocks.iter().any(|b| b.is_in_the_way(p, sole));
    points.iter().filter(free).map(|p| [p.x, p.y]).collect()
}

/// Points of a patch at which a sole of this half length stays within it, at least its middle.
fn points_on(pose: &Pose, half_size: [f64; 2], sole: f64) -> Vec<Vector3<f64>> {
    let [x, y] = half_size.map(|half| line((half - sole).max(0.0)));
    let grid = x
        .iter()
        .flat_map(|&x| y.iter().map(move |&y| Vector3::new(x, y, 0.0)));
    grid.map(|point| pose.act(point)).collect()
}

/// Points at this height around the robot and all blocks.
fn points_around(scene: &Scene, blocks: &[Block], height: f64) -> Vec<Vector3<f64>> {
    let base = |i: usize| scene.start.get(i).copied().unwrap_or(0.0);
    let start = [base(0), base(1)];
    let (mut low, mut high) = (start, start);
    for corner in blocks.iter().flat_map(Block::corners) {
        for axis in 0..2 {
            low[axis] = low[axis].min(corner[axis]);
            high[axis] = high[axis].max(corner[axis]);
        }
    }
    let across = |axis: usize| {
        let middle = 0.5 * (low[axis] + high[axis]);
        let offsets = line(0.5 * (high[axis] - low[axis]) + AROUND);
        offsets.into_iter().map(move |offset| middle + offset)
    };
    let y: Vec<f64> = across(1).collect();
    let grid = across(0).flat_map(|x| y.iter().map(move |&y| Vector3::new(x, y, height)));
    grid.collect()
}

/// From −`half` to `half` in steps of at most [`GRID`], or [`MOST_STEPS`] longer ones.
fn line(half: f64) -> Vec<f64> {
    let steps = ((2.0 * half / GRID).ceil() as usize).min(MOST_STEPS);
    let at = |i: usize| -half + 2.0 * half * i as f64 / steps.max(1) as f64;
    (0..=steps).map(at).collect()
}

/// A static cuboid.
struct Block {
    world_from_box: Pose,
    half_size: Vector3<f64>,
}

impl Block {
    /// Corners as seen from above, each twice.
    fn corners(&self) -> impl Iterator<Item = [f64; 2]> {
        let h = self.half_size;
        let signs = [-1.0, 1.0];
        let all = signs.into_iter().flat_map(move |x| {
            signs
                .into_iter()
                .flat_map(move |y| signs.into_iter().map(move |z| [x, y, z]))
        });
        all.map(move |[x, y, z]| {
            let corner = self
                .world_from_box
                .act(Vector3::new(x * h.x, y * h.y, z * h.z));
            [corner.x, corner.y]
        })
    }

    /// True if a foot of this half length that stands at a point would be in the block: at twice its length above the ground, the
    /// height of an ankle.
    fn is_in_the_way(&self, point: &Vector3<f64>, sole: f64) -> bool {
        let above = point + Vector3::new(0.0, 0.0, sole);
        let inside = self.world_from_box.inverse().act(above);
        let near = |axis: usize| inside[axis].abs() < self.half_size[axis] + sole - 1e-9;
        (0..3).all(near)
    }
}

fn blocks(scene: &Scene) -> Vec<Block> {
    let shapes = scene.statics.iter().flat_map(|s| &s.shapes);
    let block = |placed: &scene::PlacedShape| match placed.shape {
        Shape::Box { half_size } => Some(Block {
            world_from_box: placed.body_from_shape,
            half_size,
        }),
        _ => None,
    };
    shapes.filter_map(block).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn strides(name: &str) -> impl Fn(&str, &str) -> f64 {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
        let scene = Scene::load(path.join(name)).expect("a scene");
        let strides = Strides::new(&scene);
        let names: Vec<String> = scene.interfaces.iter().map(|i| i.name.clone()).collect();
        let index = move |name: &str| names.iter().position(|n| n == name).expect("a surface");
        move |from, to| strides.effort(index(from), index(to))
    }

    #[test]
    fn stairs_and_stones_that_are_left_out_cost_more_than_those_that_are_not() {
        let stairs = strides("stairs.toml");
        for (a, b) in [(1, 2), (2, 3)] {
            let [a, b] = [a, b].map(|n| format!("stair_{n}_top"));
            assert_eq!((stairs(&a, &b), stairs(&b, &a)), (0.0, 0.0), "{a}, {b}");
        }
        assert_eq!(stairs("ground_top", "ground_top"), 0.0);
        let both = stairs("ground_top", "stair_3_top");
        assert!(both > 1.0, "0.3 m high: {both}");

        let stones = strides("stepping-stones.toml");
        let next = stones("bank_a_top", "stone_1_top");
        let (second, across) = (
            stones("bank_a_top", "stone_2_top"),
            stones("bank_a_top", "bank_b_top"),
        );
        assert_eq!(next, 0.0);
        assert!(second > 2.0 && across > second + 8.0, "{second}, {across}");
    }

    #[test]
    fn a_platform_is_nearer_from_a_box_wherever_that_stands() {
        let effort = strides("climb.toml");
        let (direct, first, second) = (
            effort("ground_top", "platform_top"),
            effort("ground_top", "box_top"),
            effort("box_top", "platform_top"),
        );
        assert!(first > 0.0 && second > 0.0);
        assert!(first + second < direct, "{first} + {second} < {direct}");
        let by_a_wall = effort("box_left", "platform_top");
        assert_eq!(
            by_a_wall, direct,
            "a foot on the wall of the box saves nothing"
        );
    }
}
