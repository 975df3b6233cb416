//! Where objects are in a guess: on their supports, in the air between these.

use crate::collision::corners;
use crate::program::Phase;
use crate::settings::Arrangement;
use crate::turn::turn_onto;
use crate::ways::{base_height, ground};
use nalgebra::Vector3;
use scene::{Interface, Object, Owner, PlacedShape, Scene, Shape};
use spatial::Pose;
use std::ops::Range;
use symbolic::Contact;

/// Height by which an object in the air is lifted above its neighbours [m].
const LIFT: f64 = 0.06;
/// Height of what something is carried over at most, in that of the base of a robot that stands.
const OVER: f64 = 1.3;
/// Parts of a straight way that are looked at.
const WAY: usize = 8;
/// Room above what something is carried over [m].
const ABOVE: f64 = 0.05;
/// Room between two objects on the same support [m].
const ROOM: f64 = 0.03;
/// Grid of places on a support [m], and its extent each way.
const GRID: f64 = 0.05;
const MOST_STEPS: f64 = 10.0;

/// Angle between two faces up to which they lie on one another [rad].
const FLAT: f64 = 1e-4;

/// What a step towards where an object comes from counts for, in a step away from the middle of a support.
const TOWARDS: f64 = 0.1;

/// An object on a support.
struct Rest {
    object: usize,
    contact: Contact,
    phases: Range<usize>,
}

impl Rest {
    fn overlaps(&self, other: &Self) -> bool {
        self.phases.start < other.phases.end && other.phases.start < self.phases.end
    }

    /// True if another object is on the same support at the same time.
    fn shares_with(&self, other: &Self) -> bool {
        self.object != other.object && self.contact.b == other.contact.b && self.overlaps(other)
    }
}

/// Poses of all objects at the phase boundaries; those at the first boundaries may be `given`, by object. With
/// [`Arrangement::LaterBeside`] what is given makes room for what comes to stand beside it after them.
pub fn poses(
    scene: &Scene,
    phases: &[Phase],
    arrangement: Arrangement,
    given: &[Vec<Pose>],
) -> Vec<Vec<Pose>> {
    let start = |object: usize| scene.objects[object].world_from_start;
    let rests = rests(scene, phases);
    // What begins at the last of the given boundaries is not in the phases that led there.
    let before = given
        .first()
        .map_or(0, |poses| poses.len().saturating_sub(1));
    let makes_room = |rest: &Rest| {
        let comes = |r: &Rest| r.phases.start >= before && r.shares_with(rest);
        arrangement == Arrangement::LaterBeside && rests.iter().any(comes)
    };
    let known = |rest: &Rest| match rest.phases.start {
        0 => Some(start(rest.object)),
        k if k < before && !makes_room(rest) => Some(given[rest.object][k]),
        _ => None,
    };
    let mut at: Vec<Option<Pose>> = rests.iter().map(known).collect();
    let mut turns: Vec<usize> = (0..rests.len()).collect();
    if arrangement == Arrangement::EarlierBeside {
        turns.reverse();
    }
    for i in turns {
        if at[i].is_some() {
            continue;
        }
        let rest = &rests[i];
        let known = || {
            rests
                .iter()
                .zip(&at)
                .filter_map(|(r, at)| Some((r, (*at)?)))
        };
        let own = known().filter(|(r, _)| r.object == rest.object);
        let mut earlier = own.filter(|(r, _)| r.phases.end <= rest.phases.start);
        let from = earlier.next_back().map_or(start(rest.object), |(_, at)| at);
        let others = known().filter(|(r, _)| r.shares_with(rest));
        let others: Vec<_> = others.map(|(r, at)| (r.contact, at)).collect();
        let below = match scene.interfaces[rest.contact.b.0].owner {
            Owner::Object(o) => {
                let below = known().find(|(r, _)| r.object == o && r.overlaps(rest));
                below.map_or(start(o), |(_, at)| at)
            }
            _ => Pose::identity(),
        };
        at[i] = Some(resting_pose(scene, rest.contact, &below, &from, &others));
    }
    let mut known: Vec<Vec<Option<Pose>>> = (0..scene.objects.len())
        .map(|object| {
            let mut known = vec![None; phases.len() + 1];
            known[0] = Some(start(object));
            for (known, given) in known
                .iter_mut()
                .zip(given.get(object).into_iter().flatten())
            {
                *known = Some(*given);
            }
            known
        })
        .collect();
    for (rest, at) in rests.iter().zip(at) {
        known[rest.object][rest.phases.start..=rest.phases.end].fill(at);
    }
    (0..known.len())
        .map(|object| with_air(scene, object, &known))
        .collect()
}

/// Who rests where and when; what begins first comes first.
fn rests(scene: &Scene, phases: &[Phase]) -> Vec<Rest> {
    let mut rests: Vec<Rest> = Vec::new();
    for (k, phase) in phases.iter().enumerate() {
        for object in 0..scene.objects.len() {
            let Some(contact) = support(scene, object, phase) else {
                continue;
            };
            let same = |r: &&mut Rest| r.contact == contact && r.phases.end == k;
            match rests.iter_mut().find(same) {
                Some(rest) => rest.phases.end = k + 1,
                None => rests.push(Rest {
                    object,
                    contact,
                    phases: k..k + 1,
                }),
            }
        }
    }
    rests
}

/// The contact that supports an object in a phase: its landing surface on a static body or another object.
pub fn support(scene: &Scene, object: usize, phase: &Phase) -> Option<Contact> {
    phase.state.contacts.iter().copied().find(|c| {
        scene.interfaces[c.a.0].owner == Owner::Object(object)
            && !matches!(scene.interfaces[c.b.0].owner, Owner::Robot { .. })
    })
}

/// Poses of an object at all boundaries; in the air between the neighbours, a little higher, and above what stands there. Where
/// objects rest, and where the first of all boundaries has them, is known.
fn with_air(scene: &Scene, object: usize, known: &[Vec<Option<Pose>>]) -> Vec<Pose> {
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
fn bounds(shapes: &[PlacedShape], pose: &Pose) -> [Vector3<f64>; 2] {
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

/// The object's pose with its surface on a support, turned as little as possible: in the middle, or as near to it as others
/// leave room, of places as near on the side that it comes from: it need not pass the others.
fn resting_pose(
    scene: &Scene,
    contact: Contact,
    world_from_below: &Pose,
    now: &Pose,
    others: &[(Contact, Pose)],
) -> Pose {
    let (a, b) = (
        &scene.interfaces[contact.a.0],
        &scene.interfaces[contact.b.0],
    );
    let world_from_b = *world_from_below * b.body_from_interface;
    let kept = world_from_b
        .inverse()
        .act((*now * a.body_from_interface).origin());
    let wish = if b.half_size.is_none() {
        Vector3::new(kept.x, kept.y, 0.0)
    } else {
        Vector3::zeros()
    };
    let taken: Vec<(Vector3<f64>, f64)> = others
        .iter()
        .map(|(other, pose)| {
            let surface = &scene.interfaces[other.a.0];
            let place = *pose * surface.body_from_interface;
            let there = world_from_b.inverse().act(place.origin());
            (there, extent(surface) + extent(a) + ROOM)
        })
        .collect();
    let origin = world_from_b.act(free_place(&wish, &kept, b.half_size, &taken));
    let up = world_from_b.rotate(Vector3::z());
    let out = (*now * a.body_from_interface).rotate(Vector3::z());
    let turned = if out.angle(&-up) < FLAT {
        *now.rotation()
    } else {
        turn_onto(&out, &-up) * now.rotation()
    };
    let body_origin = origin - turned * a.body_from_interface.origin();
    Pose::from_parts(turned, body_origin)
}

/// Half the side of a surface [m].
fn extent(surface: &Interface) -> f64 {
    surface.half_size.map_or(0.0, |[x, y]| x.max(y))
}

/// The place nearest to a wish, and a little to where the object comes from, that is apart from what is taken (places and distances
/// along the nearer axis), within the support's half sizes; the wish if there is none.
fn free_place(
    wish: &Vector3<f64>,
    from: &Vector3<f64>,
    half: Option<[f64; 2]>,
    taken: &[(Vector3<f64>, f64)],
) -> Vector3<f64> {
    let is_free = |p: &Vector3<f64>| {
        taken
            .iter()
            .all(|(q, apart)| (p.x - q.x).abs().max((p.y - q.y).abs()) >= *apart)
    };
    let steps = |half: f64| (half / GRID).floor().min(MOST_STEPS) as i32;
    let [nx, ny] = half.map_or([MOST_STEPS as i32; 2], |[x, y]| [steps(x), steps(y)]);
    let way = |p: &Vector3<f64>| (p - wish).norm() + TOWARDS * (p - from).xy().norm();
    let grid = (-nx..=nx).flat_map(|i| (-ny..=ny).map(move |j| (i, j)));
    grid.map(|(i, j)| wish + Vector3::new(f64::from(i), f64::from(j), 0.0) * GRID)
        .filter(is_free)
        .min_by(|p, q| way(p).total_cmp(&way(q)))
        .unwrap_or(*wish)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;
    use symbolic::ContactType;

    #[test]
    fn what_is_put_down_later_need_not_pass_what_stands_there() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/two-box.toml");
        let scene = Scene::load(&path).unwrap();
        let on = |bottom: &str, table: &str| Contact {
            a: scene.interface_id(bottom).unwrap(),
            b: scene.interface_id(table).unwrap(),
            kind: ContactType::UnilateralPatch,
        };
        let phase = |contacts: &[Contact]| Phase {
            state: contacts.iter().copied().collect(),
            steps: 1,
        };
        let start = scene.start_contacts.iter().copied();
        let of_object = |c: &Contact| matches!(scene.interfaces[c.a.0].owner, Owner::Object(_));
        let start: Vec<Contact> = start.filter(of_object).collect();
        // Both come from the right (−y), whichever is the first.
        for (first, second) in [("red_box", "green_box"), ("green_box", "red_box")] {
            let bottom = |name: &str| format!("{name}_bottom");
            let waits = *start
                .iter()
                .find(|c| scene.interfaces[c.a.0].name == bottom(second))
                .unwrap();
            let there = on(&bottom(first), "table_c_top");
            let phases = [
                phase(&start),
                phase(&[waits]),
                phase(&[waits, there]),
                phase(&[there]),
                phase(&[there, on(&bottom(second), "table_c_top")]),
            ];
            let index = |name: &str| {
                let is_it = |object: &Object| object.name == name;
                scene.objects.iter().position(is_it).unwrap()
            };
            let ends = |arrangement: Arrangement, given: &[Vec<Pose>]| {
                let poses = poses(&scene, &phases, arrangement, given);
                [first, second].map(|name| poses[index(name)][phases.len()].origin().y)
            };
            let [there, beside] = ends(Arrangement::LaterBeside, &[]);
            assert!(there - beside > 0.1, "{second} comes last");
            let [beside, there] = ends(Arrangement::EarlierBeside, &[]);
            assert!(there - beside > 0.1, "{second} comes last");
            // Put down at the near end when nothing else was to come.
            let mut given = poses(&scene, &phases[..4], Arrangement::default(), &[]);
            let near = Pose::from_parts(
                *Pose::identity().rotation(),
                given[index(first)][4].origin() - Vector3::new(0.0, 0.2, 0.0),
            );
            given[index(first)][2..].fill(near);
            let [there, beside] = ends(Arrangement::LaterBeside, &given);
            assert!(there - beside > 0.1, "{first} makes room");
            let [kept, beyond] = ends(Arrangement::EarlierBeside, &given);
            assert!(beyond > kept && (kept - near.origin().y).abs() < 1e-12);
        }
    }

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

    #[test]
    fn a_place_that_is_taken_is_left_for_the_nearest_free_one() {
        let middle = Vector3::zeros();
        let half = Some([0.1, 0.4]);
        let taken = [(middle, 0.2)];
        assert_eq!(free_place(&middle, &middle, half, &[]), middle);
        let beside = free_place(&middle, &middle, half, &taken);
        assert!((beside.norm() - 0.2).abs() < 1e-9 && beside.x.abs() < 1e-9);
        let full = [(middle, 1.0)];
        assert_eq!(free_place(&middle, &middle, half, &full), middle, "full");
        for side in [-1.0, 1.0] {
            let from = Vector3::new(0.0, 1.5 * side, 0.0);
            let place = free_place(&middle, &from, half, &taken);
            assert!((place.y - 0.2 * side).abs() < 1e-9, "{place}");
        }
    }

    #[test]
    fn any_side_of_an_object_lies_flat_on_what_it_is_put_on() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/two-box.toml");
        let scene = Scene::load(path).expect("a scene");
        let id = |name: &str| scene.interface_id(name).expect("an interface");
        let b = id("table_c_top");
        let start = scene.objects[1].world_from_start;
        let below = scene.interfaces[b.0].body_from_interface;
        let mut sides = 0;
        for a in (0..scene.interfaces.len()).map(symbolic::InterfaceId) {
            let side = &scene.interfaces[a.0];
            if side.owner != Owner::Object(1) {
                continue;
            }
            let kind = ContactType::UnilateralPatch;
            let contact = Contact { a, b, kind };
            let pose = resting_pose(&scene, contact, &Pose::identity(), &start, &[]);
            let placed = pose * side.body_from_interface;
            let normals = placed.rotate(Vector3::z()) + below.rotate(Vector3::z());
            assert!(normals.norm() < 1e-9, "{}", side.name);
            let gap = below.inverse().act(placed.origin()).z;
            assert!(gap.abs() < 1e-9, "{}", side.name);
            sides += 1;
        }
        assert!(sides >= 3);
    }
}
