//! Where objects are in a guess: on their supports; in the air between these ([`crate::aloft`]).

use crate::aloft::{bounds, with_air};
use crate::packing::{self, Item};
use crate::program::Phase;
use crate::settings::Arrangement;
use crate::turn::turn_onto;
use nalgebra::{Vector2, Vector3};
use scene::{Interface, Owner, Scene};
use spatial::Pose;
use std::collections::BTreeSet;
use std::ops::Range;
use symbolic::{Contact, InterfaceId};

/// Room between two objects on the same support [m].
pub const ROOM: f64 = 0.03;
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
    for &i in &turns {
        if at[i].is_some() {
            continue;
        }
        let rest = &rests[i];
        let placed = || {
            rests
                .iter()
                .zip(&at)
                .filter_map(|(r, at)| Some((r, (*at)?)))
        };
        let own = placed().filter(|(r, _)| r.object == rest.object);
        let mut earlier = own.filter(|(r, _)| r.phases.end <= rest.phases.start);
        let from = earlier.next_back().map_or(start(rest.object), |(_, at)| at);
        let others = placed().filter(|(r, _)| r.shares_with(rest));
        let others: Vec<_> = others.map(|(r, at)| (r.contact, at)).collect();
        let below = match scene.interfaces[rest.contact.b.0].owner {
            Owner::Object(o) => {
                let below = placed().find(|(r, _)| r.object == o && r.overlaps(rest));
                below.map_or(start(o), |(_, at)| at)
            }
            _ => Pose::identity(),
        };
        at[i] = Some(resting_pose(scene, rest.contact, &below, &from, &others));
    }
    let stays: Vec<bool> = rests.iter().map(|rest| known(rest).is_some()).collect();
    make_room(scene, (&rests, &stays), &turns, &mut at);
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

/// Moves what does not stay to where there is room for all on the surface of a static body, if that is found: one by one, the first may
/// stand where it leaves no room for the next.
fn make_room(
    scene: &Scene,
    (rests, stays): (&[Rest], &[bool]),
    turns: &[usize],
    at: &mut [Option<Pose>],
) {
    let supports: BTreeSet<InterfaceId> = rests.iter().map(|rest| rest.contact.b).collect();
    for support in supports {
        let surface = &scene.interfaces[support.0];
        let (Owner::Static(_), Some(half)) = (surface.owner, surface.half_size) else {
            continue;
        };
        let on_it = turns
            .iter()
            .copied()
            .filter(|&i| rests[i].contact.b == support);
        let on_it: Vec<usize> = on_it.collect();
        let support_from_world = surface.body_from_interface.inverse();
        let item = |&i: &usize| {
            let rest = &rests[i];
            let body = &scene.objects[rest.object];
            let own = &scene.interfaces[rest.contact.a.0];
            let support_from_body = support_from_world * at[i].expect("all are placed");
            let placed = support_from_body * own.body_from_interface;
            let [low, high] = bounds(&body.shapes, &support_from_body);
            let place = placed.origin().xy();
            let axes = placed.rotation().fixed_view::<2, 2>(0, 0).abs();
            Item {
                shape: [low.xy() - place, high.xy() - place],
                surface: axes * Vector2::from(own.half_size.unwrap_or_default()),
                from: support_from_world.act(body.world_from_start.origin()).xy(),
                place,
                stays: stays[i],
            }
        };
        let mut items: Vec<Item> = on_it.iter().map(item).collect();
        let meet = |i: usize, j: usize| rests[on_it[i]].shares_with(&rests[on_it[j]]);
        let half = Vector2::from(half);
        if packing::fit(&items, half, &meet) {
            continue;
        }
        let before: Vec<_> = items.iter().map(|item| item.place).collect();
        if packing::pack(&mut items, half, &meet) {
            for ((&i, item), before) in on_it.iter().zip(&items).zip(before) {
                let by = surface
                    .body_from_interface
                    .rotate((item.place - before).push(0.0));
                at[i] = at[i].map(|pose| Pose::from_parts(*pose.rotation(), pose.origin() + by));
            }
        }
    }
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
    use scene::Object;
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
