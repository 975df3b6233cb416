//! Where objects are in a guess: on their supports, in the air between these.

use crate::program::Phase;
use nalgebra::Vector3;
use scene::{Interface, Owner, Scene};
use spatial::Pose;
use symbolic::Contact;

/// Height by which an object in the air is lifted above its neighbours [m].
const LIFT: f64 = 0.06;
/// Room between two objects on the same support [m].
const ROOM: f64 = 0.03;
/// Grid of places on a support [m], and its extent each way.
const GRID: f64 = 0.05;
const MOST_STEPS: f64 = 10.0;

/// What a step towards where an object comes from counts for, in a step away from the middle of a support.
const TOWARDS: f64 = 0.1;

/// Poses of all objects at the phase boundaries. What is put down finds its place among what stands there by then.
pub fn poses(scene: &Scene, phases: &[Phase]) -> Vec<Vec<Pose>> {
    let mut stands: Vec<Stands> = (0..scene.objects.len())
        .map(|object| Stands {
            on: support(scene, object, &phases[0]),
            at: scene.objects[object].world_from_start,
        })
        .collect();
    let at_start = |stands: &Stands| vec![Some(stands.at)];
    let mut known: Vec<Vec<Option<Pose>>> = stands.iter().map(at_start).collect();
    for (k, phase) in phases.iter().enumerate() {
        for (object, known) in known.iter_mut().enumerate() {
            let on = support(scene, object, phase);
            if let Some(contact) = on.filter(|_| stands[object].on != on) {
                let others = stands.iter().filter_map(|other| {
                    let there = other.on.filter(|on| on.b == contact.b)?;
                    Some((there, other.at))
                });
                let others: Vec<_> = others.collect();
                stands[object].at = resting_pose(scene, contact, &stands[object].at, &others);
            }
            stands[object].on = on;
            let rests = on.map(|_| stands[object].at);
            known[k] = rests.or(known[k]);
            known.push(rests);
        }
    }
    known.iter().map(|known| with_air(known)).collect()
}

/// Where an object rests, or rested last.
struct Stands {
    on: Option<Contact>,
    at: Pose,
}

/// The contact that supports an object in a phase: its landing surface on a static body or another object.
pub fn support(scene: &Scene, object: usize, phase: &Phase) -> Option<Contact> {
    phase.state.contacts.iter().copied().find(|c| {
        scene.interfaces[c.a.0].owner == Owner::Object(object)
            && !matches!(scene.interfaces[c.b.0].owner, Owner::Robot { .. })
    })
}

/// Poses at all boundaries; in the air between the neighbours, a little higher. The first one is known.
fn with_air(known: &[Option<Pose>]) -> Vec<Pose> {
    let at = |k: usize| {
        let before = (0..=k).rev().find_map(|i| known[i].map(|p| (i, p)));
        let after = (k..known.len()).find_map(|i| known[i].map(|p| (i, p)));
        match (known[k], before, after) {
            (Some(pose), _, _) => pose,
            (None, Some((i, from)), Some((j, to))) => {
                let s = (k - i) as f64 / (j - i) as f64;
                lifted(&from.plus(&(to.minus(&from) * s)))
            }
            (None, Some((_, from)), None) => lifted(&from),
            (None, None, _) => unreachable!("an object's start is known"),
        }
    };
    (0..known.len()).map(at).collect()
}

fn lifted(pose: &Pose) -> Pose {
    Pose::from_parts(
        *pose.rotation(),
        pose.origin() + Vector3::new(0.0, 0.0, LIFT),
    )
}

/// The object's pose with its surface on a support, turned as little as possible: in the middle, or as near to it as others
/// leave room, of places as near on the side that it comes from: it need not pass the others.
fn resting_pose(scene: &Scene, contact: Contact, now: &Pose, others: &[(Contact, Pose)]) -> Pose {
    let (a, b) = (
        &scene.interfaces[contact.a.0],
        &scene.interfaces[contact.b.0],
    );
    let world_from_b = match b.owner {
        Owner::Object(o) => scene.objects[o].world_from_start * b.body_from_interface,
        _ => b.body_from_interface,
    };
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
    let body_origin = origin - now.rotate(a.body_from_interface.origin());
    Pose::from_parts(*now.rotation(), body_origin)
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
            let poses = poses(&scene, &phases);
            let at_end = |name: &str| {
                let is_it = |object: &scene::Object| object.name == name;
                let o = scene.objects.iter().position(is_it).unwrap();
                poses[o][phases.len()].origin().y
            };
            assert!(at_end(second) < at_end(first) - 0.1, "{second} comes last");
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
}
