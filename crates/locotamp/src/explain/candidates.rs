//! Which numbers might make a sequence feasible, the most promising first.

use super::knob::{ALONG, Knob, can_move, width};
use nalgebra::Vector3;
use ocp::{Phase, Pull, Subject};
use scene::{Owner, Role, Scene};
use std::collections::BTreeSet;
use symbolic::{Contact, ContactType};

/// Joints that are tried one by one for range or velocity.
const MOST_JOINTS: usize = 3;

/// The contacts of all phases.
fn contacts(phases: &[Phase]) -> BTreeSet<Contact> {
    let all = phases.iter().flat_map(|p| p.state.contacts.iter());
    all.copied().collect()
}

/// Numbers that only matter for forces and times, in groups: masses; friction; strength; torque; durations and velocities.
pub(super) fn of_motion(scene: &Scene, phases: &[Phase], pulls: &[Pull]) -> Vec<Vec<Knob>> {
    let contacts = contacts(phases);
    let robot = |i: usize| matches!(scene.interfaces[i].owner, Owner::Robot { .. });
    let handled = contacts.iter().filter(|c| robot(c.a.0));
    let objects: BTreeSet<usize> = handled
        .filter_map(|c| match scene.interfaces[c.b.0].owner {
            Owner::Object(o) => Some(o),
            _ => None,
        })
        .collect();
    let mut times = vec![Knob::Longest, Knob::Shortest];
    for j in joints_of(scene, pulls, "joint velocity") {
        let mut joints = mirrored(scene, j);
        joints.sort_unstable();
        let knob = Knob::Velocity(joints);
        if !times.contains(&knob) {
            times.push(knob);
        }
    }
    let torque = scene.optimiser.torque_limits.then_some(Knob::AllTorques);
    let groups = [
        objects.into_iter().map(Knob::Mass).collect(),
        frictions(scene, &contacts),
        strengths(scene, &contacts),
        torque.into_iter().collect(),
        times,
    ];
    groups.into_iter().filter(|g| !g.is_empty()).collect()
}

/// Numbers of geometry: goal regions, places of static bodies and objects, widths of objects between two hands, joint ranges.
pub(super) fn of_geometry(scene: &Scene, phases: &[Phase], pulls: &[Pull]) -> Vec<Knob> {
    let mut out = Vec::new();
    for (r, region) in scene.goal_regions.iter().enumerate() {
        for axis in 0..3 {
            for (upper, bound) in [(false, region.lower[axis]), (true, region.upper[axis])] {
                if bound.is_finite() {
                    out.push(Knob::Goal(r, axis, upper));
                }
            }
        }
    }
    let contacts = contacts(phases);
    let stands_on = |s: usize| {
        let mut start = scene.start_contacts.iter();
        start.any(|c| {
            let (a, b) = (scene.interfaces[c.a.0].owner, scene.interfaces[c.b.0].owner);
            matches!(a, Owner::Robot { .. }) && b == Owner::Static(s)
        })
    };
    let touched: BTreeSet<usize> = contacts
        .iter()
        .filter_map(|c| match scene.interfaces[c.b.0].owner {
            Owner::Static(s) => Some(s),
            _ => None,
        })
        .collect();
    for s in touched {
        if can_move(scene, s) && !stands_on(s) {
            out.extend([2, 0, 1].map(|axis| Knob::Static(s, axis)));
        }
    }
    out.extend(widths(scene, phases));
    for o in 0..scene.objects.len() {
        let touched = |c: &&Contact| scene.interfaces[c.b.0].owner == Owner::Object(o);
        if contacts.iter().any(|c| touched(&c)) {
            out.extend([0, 1].map(|axis| Knob::Object(o, axis)));
        }
    }
    let narrow = joints_of(scene, pulls, "joint range").collect::<Vec<_>>();
    for j in narrow {
        out.extend([Knob::Range(j, false), Knob::Range(j, true)]);
    }
    out
}

/// Widths of objects that are one box, along the horizontal axes on whose two sides the robot touches them in one phase.
pub(super) fn widths(scene: &Scene, phases: &[Phase]) -> Vec<Knob> {
    let mut out = Vec::new();
    let side = |c: &Contact| {
        let (robot, body) = (&scene.interfaces[c.a.0], &scene.interfaces[c.b.0]);
        match (robot.owner, body.owner) {
            (Owner::Robot { .. }, Owner::Object(o)) => {
                Some((o, body.body_from_interface.rotate(Vector3::z())))
            }
            _ => None,
        }
    };
    for phase in phases {
        let sides: Vec<(usize, Vector3<f64>)> =
            phase.state.contacts.iter().filter_map(side).collect();
        for (o, axis) in sides.iter().flat_map(|(o, _)| [(*o, 0), (*o, 1)]) {
            let on = |sign: f64| {
                let mut sides = sides.iter();
                sides.any(|(other, normal)| *other == o && sign * normal[axis] > ALONG)
            };
            let knob = Knob::Width(o, axis);
            if on(1.0) && on(-1.0) && width(scene, o, axis).is_some() && !out.contains(&knob) {
                out.push(knob);
            }
        }
    }
    out
}

/// Friction of what the contacts of every body leave to choose: of the body where that decides, of both sides.
fn frictions(scene: &Scene, contacts: &BTreeSet<Contact>) -> Vec<Knob> {
    let slips = |kind: ContactType| {
        matches!(
            kind,
            ContactType::UnilateralPatch | ContactType::UnilateralPoint
        )
    };
    let mut out = Vec::new();
    let mut by_body: Vec<(Owner, BTreeSet<usize>, BTreeSet<usize>)> = Vec::new();
    for contact in contacts.iter().filter(|c| slips(c.kind)) {
        let (a, b) = (contact.a.0, contact.b.0);
        if !matches!(scene.interfaces[a].owner, Owner::Robot { .. }) {
            continue;
        }
        let body = scene.interfaces[b].owner;
        match by_body.iter_mut().find(|(owner, ..)| *owner == body) {
            Some((_, ends, surfaces)) => {
                ends.insert(a);
                surfaces.insert(b);
            }
            None => by_body.push((body, BTreeSet::from([a]), BTreeSet::from([b]))),
        }
    }
    for (_, ends, surfaces) in by_body {
        let both: Vec<usize> = surfaces.iter().chain(&ends).copied().collect();
        let least = |of: &BTreeSet<usize>| {
            let mu = of.iter().map(|&i| scene.interfaces[i].mu);
            mu.fold(f64::INFINITY, f64::min)
        };
        if least(&surfaces) < least(&ends) {
            out.push(Knob::Friction(surfaces.into_iter().collect()));
        } else if least(&ends) < least(&surfaces) {
            out.push(Knob::Friction(ends.into_iter().collect()));
        }
        out.push(Knob::Friction(both.clone()));
        out.push(Knob::Torsion(both));
    }
    out
}

/// Largest forces and moments of hands, feet and surfaces, those of a kind together.
fn strengths(scene: &Scene, contacts: &BTreeSet<Contact>) -> Vec<Knob> {
    let mut out = Vec::new();
    for role in [Role::Hand, Role::Foot, Role::Surface] {
        let ends = contacts.iter().flat_map(|c| [(c.a.0, c), (c.b.0, c)]);
        let ours: Vec<_> = ends
            .filter(|(i, _)| scene.interfaces[*i].role == role)
            .collect();
        let of = |limit: fn(&scene::Interface) -> f64, kinds: &[ContactType]| -> Vec<usize> {
            let ours = ours.iter().filter(|(_, c)| kinds.contains(&c.kind));
            let limited: BTreeSet<usize> = ours.map(|(i, _)| *i).collect();
            let limited = limited.into_iter();
            limited
                .filter(|&i| limit(&scene.interfaces[i]).is_finite())
                .collect()
        };
        let any = [
            ContactType::UnilateralPatch,
            ContactType::UnilateralPoint,
            ContactType::BilateralPatch,
            ContactType::BilateralPoint,
        ];
        let forces = of(|i| i.max_force, &any);
        let moments = of(|i| i.max_moment, &[ContactType::BilateralPatch]);
        out.extend((!forces.is_empty()).then_some(Knob::Force(forces)));
        out.extend((!moments.is_empty()).then_some(Knob::Moment(moments)));
    }
    out
}

/// Joints of the robot whose constraint of a category pulls, the hardest first.
fn joints_of<'a>(
    scene: &'a Scene,
    pulls: &'a [Pull],
    category: &'static str,
) -> impl Iterator<Item = usize> + 'a {
    let mut seen = BTreeSet::new();
    let joints = pulls
        .iter()
        .filter_map(move |pull| match pull.label.subject {
            Subject::Coordinate(v) if pull.label.category == category => joint(scene, v),
            _ => None,
        });
    joints.filter(move |j| seen.insert(*j)).take(MOST_JOINTS)
}

/// The robot's joint with this velocity index.
pub(super) fn joint(scene: &Scene, v: usize) -> Option<usize> {
    let joints = &scene.robot.model.joints;
    joints.iter().position(|j| j.idx_v == v && j.kind.nv() == 1)
}

/// A joint and its counterpart on the other side, by name, if that has the same limits.
pub(super) fn mirrored(scene: &Scene, joint: usize) -> Vec<usize> {
    let joints = &scene.robot.model.joints;
    let name = &joints[joint].name;
    let other = if name.contains("left") {
        name.replace("left", "right")
    } else {
        name.replace("right", "left")
    };
    let same = |j: &usize| {
        let (one, two) = (&joints[*j], &joints[joint]);
        one.name == other && one.torque_limit == two.torque_limit
    };
    let counterpart = (0..joints.len()).find(same).filter(|&j| j != joint);
    std::iter::once(joint).chain(counterpart).collect()
}
