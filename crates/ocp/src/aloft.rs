//! Where objects are in the air in a guess: between the places where they rest, above what is there.

use crate::collision::corners;
use crate::resting::ROOM;
use crate::ways::{base_height, ground};
use nalgebra::Vector3;
use scene::{Object, PlacedShape, Scene, Shape};
use spatial::Pose;

/// Height by which an object in the air is lifted above its neighbours [m].
const LIFT: f64 = 0.06;
/// Height of what something is carried over at most, in that of the base of a robot that stands.
const OVER: f64 = 1.3;
/// Parts of a straight way that are looked at.
const WAY: usize = 8;
/// Room above what something is carried over [m].
const ABOVE: f64 = 0.05;

/// Poses of an object at all boundaries; in the air between the neighbours, a little higher, and above what stands there. Where
/// objects rest, and where the first of all boundaries has them, is known.
pub fn with_air(scene: &Scene, object: usize, known: &[Vec<Option<Pose>>]) -> Vec<Pose> {
    let mine = &known[object];
    let obstacles = obstacles(scene);
    let body = &scene.objects[object];
    let in_air = |k: usize| {
        let before = (0..=k).rev().find_map(|i| mine[i].map(|p| (i, p)));
        let after = (k..mine.len()).find_map(|i| mine[i].map(|p| (i, p)));
        let (i, from) = before.expect("an object's start is known");
        let between = after.map_or(from, |(j, to)| {
            from.plus(&(to.minus(&from) * ((k - i) as f64 / (j - i) as f64)))
        });
        let between = match after {
            Some((_, to)) => over(body, between, [from, to], &obstacles),
            None => between,
        };
        let others = known.iter().enumerate().filter(|(o, _)| *o != object);
        let standing =
            others.filter_map(|(o, poses)| Some(bounds(&scene.objects[o].shapes, &poses[k]?)));
        above(body, lifted(LIFT, &between), standing)
    };
    (0..mine.len())
        .map(|k| mine[k].unwrap_or_else(|| in_air(k)))
        .collect()
}

/// The pose as high as what it would be in demands.
fn above(object: &Object, pose: Pose, standing: impl Iterator<Item = [Vector3<f64>; 2]>) -> Pose {
    let [least, most] = bounds(&object.shapes, &pose);
    let meets = |[low, high]: &[Vector3<f64>; 2]| {
        (0..3).all(|i| low[i] < most[i] + ROOM && least[i] < high[i] + ROOM)
    };
    let higher = standing
        .filter(meets)
        .map(|[_, high]| high.z + ROOM - least.z);
    lifted(higher.fold(0.0, f64::max), &pose)
}

/// What is static, and not too high for something to be carried over it: the least and the greatest coordinates of its shapes [m].
fn obstacles(scene: &Scene) -> Vec<[Vector3<f64>; 2]> {
    let most = ground(scene) + OVER * base_height(scene);
    let shapes = scene.statics.iter().flat_map(|body| &body.shapes);
    let solid = shapes.filter(|placed| !matches!(placed.shape, Shape::HalfSpace));
    let world = Pose::identity();
    let all = solid.map(|placed| bounds(std::slice::from_ref(placed), &world));
    all.filter(|[_, high]| high.z <= most).collect()
}

/// A pose of an object that is carried straight from one place to another, as high as what is static in the way demands.
fn over(
    object: &Object,
    pose: Pose,
    [from, to]: [Pose; 2],
    obstacles: &[[Vector3<f64>; 2]],
) -> Pose {
    let bounds_at = |i: usize| {
        let share = i as f64 / WAY as f64;
        bounds(&object.shapes, &from.plus(&(to.minus(&from) * share)))
    };
    let way: Vec<_> = (0..=WAY).map(bounds_at).collect();
    let swept = way.windows(2).map(|ends| {
        let [[low_a, high_a], [low_b, high_b]] = [ends[0], ends[1]];
        [low_a.inf(&low_b), high_a.sup(&high_b)]
    });
    let swept: Vec<_> = swept.collect();
    // What is lifted over one thing may meet another.
    let mut height = f64::NEG_INFINITY;
    loop {
        let is_in_the_way = |[least, most]: &&[Vector3<f64>; 2]| {
            let meets = |[low, high]: &[Vector3<f64>; 2]| {
                let high = high + Vector3::z() * (height - low.z).max(0.0);
                (0..3).all(|i| low[i] < most[i] && least[i] < high[i])
            };
            swept.iter().any(meets)
        };
        let tops = obstacles.iter().filter(is_in_the_way);
        let demanded = tops.map(|[_, most]| most.z + ABOVE);
        let demanded = demanded.fold(f64::NEG_INFINITY, f64::max);
        if demanded <= height {
            break;
        }
        height = demanded;
    }
    let [low, _] = bounds(&object.shapes, &pose);
    lifted((height - low.z).max(0.0), &pose)
}

/// The least and the greatest coordinates of a body in the world [m].
pub fn bounds(shapes: &[PlacedShape], pose: &Pose) -> [Vector3<f64>; 2] {
    let mut balls = Vec::new();
    for shape in shapes {
        corners(shape, &mut balls);
    }
    let none = [f64::INFINITY, f64::NEG_INFINITY].map(Vector3::repeat);
    balls.iter().fold(none, |[low, high], (center, radius)| {
        let center = pose.act(*center);
        let reach = Vector3::repeat(*radius);
        [low.inf(&(center - reach)), high.sup(&(center + reach))]
    })
}

fn lifted(by: f64, pose: &Pose) -> Pose {
    Pose::from_parts(*pose.rotation(), pose.origin() + Vector3::new(0.0, 0.0, by))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn what_is_carried_over_something_is_lifted_above_it() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/two-box.toml");
        let scene = Scene::load(&path).unwrap();
        let object = |name: &str| scene.objects.iter().find(|o| o.name == name).unwrap();
        let (carried, stands) = (object("green_box"), object("red_box"));
        let standing = || std::iter::once(bounds(&stands.shapes, &stands.world_from_start));
        let at = |by: Vector3<f64>| {
            let start = stands.world_from_start;
            Pose::from_parts(*start.rotation(), start.origin() + by)
        };
        let into = at(Vector3::new(0.1, 0.0, 0.05));
        let height = above(carried, into, standing()).origin().z;
        // Half the heights of both, and some room.
        let top = stands.world_from_start.origin().z + 0.075 + 0.1;
        assert!((top..top + 0.05).contains(&height), "{height} m");
        let aside = at(Vector3::new(0.0, -0.3, 0.05));
        assert_eq!(above(carried, aside, standing()), aside);
    }

    #[test]
    fn what_is_carried_past_a_higher_table_is_lifted_above_it() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/past-higher.toml");
        let scene = Scene::load(&path).unwrap();
        let green = scene
            .objects
            .iter()
            .find(|o| o.name == "green_box")
            .unwrap();
        let (start, obstacles) = (green.world_from_start, obstacles(&scene));
        let at = |y: f64| {
            let to = Vector3::new(start.origin().x, y, start.origin().z);
            Pose::from_parts(*start.rotation(), to)
        };
        let bottom =
            |ends: [Pose; 2]| bounds(&green.shapes, &over(green, ends[0], ends, &obstacles))[0].z;
        // The table beside is at 0.9 m.
        let [here, past] = [at(start.origin().y), at(1.0)];
        assert!((bottom([here, past]) - 0.9 - ABOVE).abs() < 1e-3);
        let low = bounds(&green.shapes, &here)[0].z;
        assert!((0.0..=ABOVE).contains(&(bottom([here, at(-1.0)]) - low)));
    }
}
