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

/// Poses of all objects at the phase boundaries.
pub fn poses(scene: &Scene, phases: &[Phase]) -> Vec<Vec<Pose>> {
    let mut out: Vec<Vec<Pose>> = Vec::new();
    for object in 0..scene.objects.len() {
        out.push(object_poses(scene, object, phases, &out));
    }
    out
}

/// The contact that supports an object in a phase: its landing surface on a static body or another object.
pub fn support(scene: &Scene, object: usize, phase: &Phase) -> Option<Contact> {
    phase.state.contacts.iter().copied().find(|c| {
        scene.interfaces[c.a.0].owner == Owner::Object(object)
            && !matches!(scene.interfaces[c.b.0].owner, Owner::Robot { .. })
    })
}

fn object_poses(
    scene: &Scene,
    object: usize,
    phases: &[Phase],
    earlier: &[Vec<Pose>],
) -> Vec<Pose> {
    let start = &scene.objects[object].world_from_start;
    let mut known: Vec<Option<Pose>> = vec![None; phases.len() + 1];
    known[0] = Some(*start);
    let mut current = (support(scene, object, &phases[0]), *start);
    for (k, phase) in phases.iter().enumerate() {
        let contact = support(scene, object, phase);
        if let Some(contact) = contact {
            if current.0 != Some(contact) {
                let others = neighbours(scene, contact, phases, k, earlier);
                current = (
                    Some(contact),
                    resting_pose(scene, contact, &current.1, &others),
                );
            }
            known[k] = Some(current.1);
            known[k + 1] = Some(current.1);
        } else {
            current.0 = None;
        }
    }
    // In the air: between the neighbours, a little higher.
    let mut out = Vec::with_capacity(known.len());
    for k in 0..known.len() {
        let before = (0..=k).rev().find_map(|i| known[i].map(|p| (i, p)));
        let after = (k..known.len()).find_map(|i| known[i].map(|p| (i, p)));
        out.push(match (known[k], before, after) {
            (Some(pose), _, _) => pose,
            (None, Some((i, from)), Some((j, to))) => {
                let s = (k - i) as f64 / (j - i) as f64;
                lifted(&from.plus(&(to.minus(&from) * s)))
            }
            (None, Some((_, from)), None) => lifted(&from),
            (None, None, _) => *start,
        });
    }
    out
}

fn lifted(pose: &Pose) -> Pose {
    Pose::from_parts(
        *pose.rotation(),
        pose.origin() + Vector3::new(0.0, 0.0, LIFT),
    )
}

/// Objects that stand on the same support at some time from phase `k` on: their surfaces and poses.
fn neighbours(
    scene: &Scene,
    contact: Contact,
    phases: &[Phase],
    k: usize,
    earlier: &[Vec<Pose>],
) -> Vec<(Contact, Pose)> {
    let mut out = Vec::new();
    for (o, poses) in earlier.iter().enumerate() {
        let there = (k..phases.len()).find_map(|i| {
            let other = support(scene, o, &phases[i]).filter(|c| c.b == contact.b)?;
            Some((other, poses[i]))
        });
        out.extend(there);
    }
    out
}

/// The object's pose with its surface on a support, turned as little as possible: in the middle, or as near to it as others
/// leave room.
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
    let origin = world_from_b.act(free_place(&wish, b.half_size, &taken));
    let body_origin = origin - now.rotate(a.body_from_interface.origin());
    Pose::from_parts(*now.rotation(), body_origin)
}

/// Half the side of a surface [m].
fn extent(surface: &Interface) -> f64 {
    surface.half_size.map_or(0.0, |[x, y]| x.max(y))
}

/// The place nearest to a wish that is apart from what is taken (places and distances along the nearer axis), within the
/// support's half sizes; the wish if there is none.
fn free_place(
    wish: &Vector3<f64>,
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
    let grid = (-nx..=nx).flat_map(|i| (-ny..=ny).map(move |j| (i, j)));
    grid.map(|(i, j)| wish + Vector3::new(f64::from(i), f64::from(j), 0.0) * GRID)
        .filter(is_free)
        .min_by(|p, q| (p - wish).norm().total_cmp(&(q - wish).norm()))
        .unwrap_or(*wish)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_that_is_taken_is_left_for_the_nearest_free_one() {
        let middle = Vector3::zeros();
        let half = Some([0.1, 0.4]);
        assert_eq!(free_place(&middle, half, &[]), middle);
        let beside = free_place(&middle, half, &[(middle, 0.2)]);
        assert!((beside.norm() - 0.2).abs() < 1e-9 && beside.x.abs() < 1e-9);
        assert_eq!(free_place(&middle, half, &[(middle, 1.0)]), middle, "full");
    }
}
