//! Objects on the way from one keyframe to the next: where they would turn against what holds them, they follow it.
//!
//! The straight line of a floating body turns it the shorter way round. Where a robot turns by about half a turn with what it carries,
//! the shorter ways of its base, its waist and the object may be opposite ones, and no path leads from there to one on which the hand
//! keeps its hold. Joints know which way they turn, and with them the link that holds.
//!
//! Source: ours.

use crate::program::Phase;
use crate::system::System;
use multibody::Kinematics;
use scene::{Owner, Scene};
use spatial::Pose;

/// Angle by which an object turns against what holds it from which on it follows that [rad].
const AGAINST: f64 = 1.0;

/// Moves the objects of `nodes`, straight lines with `steps` per phase, along with the links that hold them, in phases in which they turn
/// against these.
pub fn follow(scene: &Scene, system: &System, phases: &[Phase], nodes: &mut [Vec<f64>]) {
    let steps = (nodes.len() - 1) / phases.len();
    let mut kinematics = Kinematics::new(&system.model);
    for (k, phase) in phases.iter().enumerate() {
        let way = &mut nodes[k * steps..=(k + 1) * steps];
        for object in 0..scene.objects.len() {
            if let Some(frame) = holder(scene, phase, object) {
                follow_link(system, (object, frame), way, &mut kinematics);
            }
        }
    }
}

/// Moves an object along with a link if it turns against that.
fn follow_link(
    system: &System,
    (object, frame): (usize, usize),
    way: &mut [Vec<f64>],
    kinematics: &mut Kinematics,
) {
    let first = system.object_q(object);
    let rests = way[0][first..first + 7] == way[way.len() - 1][first..first + 7];
    let mut held = |q: &Vec<f64>| {
        kinematics.update(&system.model, q);
        let link = kinematics.frame_pose(&system.model, frame);
        let object = kinematics.world_from_joint[system.object_joint(object)];
        (link, link.inverse() * object)
    };
    let now: Vec<(Pose, Pose)> = way.iter().map(&mut held).collect();
    let last = now.len() - 1;
    let (from, shift) = (now[0].1, now[last].1.minus(&now[0].1));
    let wanted: Vec<Pose> = (0..=last)
        .map(|i| from.plus(&(shift * (i as f64 / last as f64))))
        .collect();
    let angle =
        |(now, wanted): (&(Pose, Pose), &Pose)| now.1.minus(wanted).fixed_rows::<3>(3).norm();
    if rests || now.iter().zip(&wanted).map(angle).all(|a| a < AGAINST) {
        return;
    }
    for i in 1..last {
        let pose = now[i].0 * wanted[i];
        way[i][first..first + 7].copy_from_slice(&pose.to_xyzquat());
    }
}

/// A link that holds an object in a phase: a frame of the model.
fn holder(scene: &Scene, phase: &Phase, object: usize) -> Option<usize> {
    let mut contacts = phase.state.contacts.iter();
    contacts.find_map(|contact| {
        let [a, b] = [contact.a, contact.b].map(|i| scene.interfaces[i.0].owner);
        match a {
            Owner::Robot { frame } if b == Owner::Object(object) => Some(frame),
            _ => None,
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::samples::Sequence;
    use crate::guess;
    use crate::motion::Planner;

    /// Largest angle between an object and the link that holds it, against where it is held at first.
    fn most_turned(planner: &Planner<'_>, frame: usize, nodes: &[Vec<f64>]) -> f64 {
        let system = &planner.system;
        let mut kinematics = Kinematics::new(&system.model);
        let mut held = |q: &Vec<f64>| {
            kinematics.update(&system.model, q);
            let link = kinematics.frame_pose(&system.model, frame);
            link.inverse() * kinematics.world_from_joint[system.object_joint(0)]
        };
        let first = held(&nodes[0]);
        let angle = |q| held(q).minus(&first).fixed_rows::<3>(3).norm();
        nodes.iter().map(angle).fold(0.0, f64::max)
    }

    #[test]
    fn what_is_carried_turns_with_the_hand_where_that_turns_by_more_than_half() {
        let Sequence { scene, phases } = Sequence::with_steps("boxes/pick_place.toml", 4);
        let planner = Planner::new(&scene).unwrap();
        let system = &planner.system;
        let holds = |phase: &&Phase| holder(&scene, phase, 0).is_some();
        let phase = phases.iter().find(holds).unwrap().clone();
        let frame = holder(&scene, &phase, 0).unwrap();
        let waist = system
            .model
            .joints
            .iter()
            .find(|j| j.name.contains("waist_yaw"));
        let waist = waist.unwrap().idx_v;
        // The base and the waist turn by less than half a turn each, by more together.
        for (turn, follows) in [(0.3, false), (1.8, true)] {
            let from = system.start(&scene);
            let mut by = vec![0.0; system.model.nv];
            (by[5], by[waist]) = (turn, turn);
            let mut to = system.model.integrate(&from, &by);
            let mut kinematics = Kinematics::new(&system.model);
            let mut link = |q: &[f64]| {
                kinematics.update(&system.model, q);
                kinematics.frame_pose(&system.model, frame)
            };
            let first = system.object_q(0);
            let object = Pose::from_xyzquat(&std::array::from_fn(|i| from[first + i]));
            let held = link(&from).inverse() * object;
            let taken_along = link(&to) * held;
            to[first..first + 7].copy_from_slice(&taken_along.to_xyzquat());
            let straight = guess::straight(system, &[from, to], 4);
            let mut nodes = straight.clone();
            follow(&scene, system, std::slice::from_ref(&phase), &mut nodes);
            assert_eq!(nodes != straight, follows);
            assert_eq!(most_turned(&planner, frame, &straight) > 2.0, follows);
            if follows {
                assert!(most_turned(&planner, frame, &nodes) < 1e-6);
            }
            let last = nodes.len() - 1;
            assert_eq!((&nodes[0], &nodes[last]), (&straight[0], &straight[last]));
        }
    }
}
