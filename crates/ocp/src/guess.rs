//! Initial guesses: keyframe configurations from the sequence alone, trajectories from keyframes.
//!
//! Source: formulation, section 5.

use crate::point::Point;
use crate::program::{Interval, Phase, Program};
use crate::resting;
use crate::settings::Arrangement;
use crate::system::System;
use multibody::Kinematics;
use nalgebra::Vector3;
use scene::{Owner, Role, Scene};
use spatial::Pose;
use std::collections::BTreeSet;
use symbolic::{Contact, InterfaceId};

/// First guess of a phase's duration at least [s], and of how fast the base moves [m/s] and turns, and joints turn [rad/s], in the
/// mean of a phase.
const DURATION: f64 = 0.7;
const BASE_SPEED: f64 = 0.4;
const JOINT_SPEED: f64 = 1.0;
/// The same of a phase without contacts of the robot, and of one between another phase and a flight: a push is short.
const FLIGHT: f64 = 0.35;

/// One configuration per phase boundary: the start posture, objects on their supports or between them, the base moved
/// along with what the robot handles once a foot may move.
pub fn keyframes(
    scene: &Scene,
    system: &System,
    phases: &[Phase],
    arrangement: Arrangement,
) -> Vec<Vec<f64>> {
    after(scene, system, phases, arrangement, &[])
}

/// The same with objects where the first of all configurations, `known`, have them.
pub fn after(
    scene: &Scene,
    system: &System,
    phases: &[Phase],
    arrangement: Arrangement,
    known: &[Vec<f64>],
) -> Vec<Vec<f64>> {
    let start = system.start(scene);
    let mut out = vec![start.clone(); phases.len() + 1];
    let pose = |o: usize, q: &[f64]| {
        let first = system.object_q(o);
        Pose::from_xyzquat(&std::array::from_fn(|i| q[first + i]))
    };
    let objects = 0..scene.objects.len();
    let given = objects.map(|o| known.iter().map(|q| pose(o, q)).collect());
    let given: Vec<Vec<Pose>> = given.collect();
    let poses = resting::poses(scene, phases, arrangement, &given);
    for (o, poses) in poses.iter().enumerate() {
        let first = system.object_q(o);
        for (q, pose) in out.iter_mut().zip(poses) {
            q[first..first + 7].copy_from_slice(&pose.to_xyzquat());
        }
    }
    let offsets = base_offsets(scene, system, phases, &out);
    for (q, offset) in out.iter_mut().zip(offsets) {
        for i in 0..3 {
            q[i] += offset[i];
        }
    }
    out
}

/// Horizontal and vertical offsets of the base per phase boundary.
fn base_offsets(
    scene: &Scene,
    system: &System,
    phases: &[Phase],
    nodes: &[Vec<f64>],
) -> Vec<Vector3<f64>> {
    let feet = |phase: &Phase| -> Vec<Contact> {
        phase
            .state
            .contacts
            .iter()
            .copied()
            .filter(|c| scene.interfaces[c.a.0].role == Role::Foot)
            .collect()
    };
    let mut known: Vec<Option<Vector3<f64>>> = vec![None; nodes.len()];
    known[0] = Some(Vector3::zeros());
    let start_feet = feet(&phases[0]);
    let mut moved = false;
    for (k, phase) in phases.iter().enumerate() {
        let now = feet(phase);
        let mut wish = None;
        for contact in &phase.state.contacts {
            let (a, b) = (
                &scene.interfaces[contact.a.0],
                &scene.interfaces[contact.b.0],
            );
            if let (Owner::Robot { .. }, Owner::Object(o)) = (a.owner, b.owner) {
                let first = system.object_q(o);
                let shift = |i: usize| nodes[k + 1][first + i] - nodes[0][first + i];
                wish = Some(Vector3::new(shift(0), shift(1), 0.0));
            }
        }
        if !moved {
            known[k] = Some(Vector3::zeros());
        }
        // A foot on another surface takes the base along.
        for contact in now.iter().filter(|c| !start_feet.contains(c)) {
            let b = &scene.interfaces[contact.b.0];
            let place = b.body_from_interface.origin();
            if b.half_size.is_some() && matches!(b.owner, Owner::Static(_)) {
                let weight = 1.0 / now.len().max(1) as f64;
                let to =
                    Vector3::new(place.x - nodes[0][0], place.y - nodes[0][1], place.z) * weight;
                wish = Some(wish.unwrap_or(to));
            }
        }
        moved |= now.len() < start_feet.len();
        if moved && (wish.is_some() && now.len() == start_feet.len()) {
            known[k + 1] = wish;
        }
    }
    (0..known.len())
        .map(|k| {
            let before = (0..=k).rev().find_map(|i| known[i].map(|p| (i, p)));
            let after = (k..known.len()).find_map(|i| known[i].map(|p| (i, p)));
            match (before, after) {
                (Some((i, from)), Some((j, to))) if j > i => {
                    from + (to - from) * ((k - i) as f64 / (j - i) as f64)
                }
                (Some((_, from)), _) => from,
                _ => Vector3::zeros(),
            }
        })
        .collect()
}

/// Straight lines between keyframes, `steps` per phase.
pub fn straight(system: &System, keyframes: &[Vec<f64>], steps: usize) -> Vec<Vec<f64>> {
    let mut out = vec![keyframes[0].clone()];
    for pair in keyframes.windows(2) {
        let difference = system.model.difference(&pair[0], &pair[1]);
        for i in 1..=steps {
            let s = i as f64 / steps as f64;
            let increment: Vec<f64> = difference.iter().map(|d| d * s).collect();
            out.push(system.model.integrate(&pair[0], &increment));
        }
    }
    out
}

/// A cubic curve through configurations at given times, at rest at both ends, with given velocities there or those of Catmull
/// and Rom 1974. Where accelerations are held between the nodes, the given velocities make it that motion.
pub struct Curve<'a> {
    system: &'a System,
    times: &'a [f64],
    nodes: &'a [Vec<f64>],
    /// Empty, or one velocity per node.
    velocities: &'a [Vec<f64>],
    /// nodes[i+1] ⊖ nodes[i].
    differences: Vec<Vec<f64>>,
}

impl<'a> Curve<'a> {
    /// Through `nodes` at increasing `times`, one each; `velocities` there, or none.
    pub fn new(
        system: &'a System,
        times: &'a [f64],
        nodes: &'a [Vec<f64>],
        velocities: &'a [Vec<f64>],
    ) -> Self {
        let differences = nodes
            .windows(2)
            .map(|pair| system.model.difference(&pair[0], &pair[1]))
            .collect();
        Self {
            system,
            times,
            nodes,
            velocities,
            differences,
        }
    }

    /// Velocity component `k` at node `i`.
    fn tangent(&self, i: usize, k: usize) -> f64 {
        if i == 0 || i == self.differences.len() {
            return 0.0;
        }
        if let Some(velocity) = self.velocities.get(i) {
            return velocity[k];
        }
        let moved = self.differences[i - 1][k] + self.differences[i][k];
        moved / (self.times[i + 1] - self.times[i - 1])
    }

    /// Configuration and velocity at a time.
    pub fn at(&self, time: f64) -> (Vec<f64>, Vec<f64>) {
        let last = self.differences.len() - 1;
        let piece = self.times[1..=last].partition_point(|&t| t < time);
        let length = self.times[piece + 1] - self.times[piece];
        let s = ((time - self.times[piece]) / length).clamp(0.0, 1.0);
        let nv = self.system.model.nv;
        let (mut increment, mut velocity) = (vec![0.0; nv], vec![0.0; nv]);
        for k in 0..nv {
            let (m0, m1) = (self.tangent(piece, k), self.tangent(piece + 1, k));
            let d = self.differences[piece][k];
            increment[k] = length * (s * (1.0 - s) * (1.0 - s) * m0 + s * s * (s - 1.0) * m1)
                + s * s * (3.0 - 2.0 * s) * d;
            velocity[k] = (1.0 - s) * (1.0 - 3.0 * s) * m0
                + s * (3.0 * s - 2.0) * m1
                + 6.0 * s * (1.0 - s) * d / length;
        }
        let q = self.system.model.integrate(&self.nodes[piece], &increment);
        (q, velocity)
    }
}

/// Interpolates a path with `path_steps` configurations per phase to `steps[k]` nodes in phase k.
pub fn interpolate(
    system: &System,
    steps: &[usize],
    path: &[Vec<f64>],
    path_steps: usize,
) -> Vec<Vec<f64>> {
    let times: Vec<f64> = (0..path.len())
        .map(|i| i as f64 / path_steps as f64)
        .collect();
    let curve = Curve::new(system, &times, path, &[]);
    let mut out = vec![path[0].clone()];
    // Explicit Euler from rest and to rest: the first two and the last two nodes coincide, so the first and the last phase
    // have an interval less to move in.
    for (phase, &count) in steps.iter().enumerate() {
        let late = f64::from(u8::from(phase == 0));
        let early = f64::from(u8::from(phase + 1 == steps.len()));
        let moving = (count as f64 - late - early).max(1.0);
        let along = |i: usize| phase as f64 + ((i as f64 - late) / moving).clamp(0.0, 1.0);
        out.extend((1..=count).map(|i| curve.at(along(i)).0));
    }
    let n = out.len() - 1;
    let (first, last) = (out[0].clone(), out[n].clone());
    out[1].copy_from_slice(&first);
    out[n - 1].copy_from_slice(&last);
    out
}

/// A point of a program from node configurations: wrenches carry weights, durations are alike but for flights, in which the
/// base rises and falls.
pub fn point(program: &Program, scene: &Scene, mut nodes: Vec<Vec<f64>>) -> Point {
    let system = &program.system;
    let mut kinematics = Kinematics::new(&system.model);
    let mut wrenches = Vec::with_capacity(program.intervals.len());
    for (interval, q) in program.intervals.iter().zip(&nodes) {
        kinematics.update(&system.model, q);
        wrenches.push(wrenches_at_rest(interval, scene, system, &kinematics));
    }
    let shortest = program.settings.min_duration.max(0.0);
    let longest = program.settings.max_duration.max(shortest);
    let durations = match program.grid {
        crate::Grid::Motion => {
            let is_flight = |k: usize| program.flies.get(k) == Some(&true);
            let push = |k: usize| k > 0 && (is_flight(k) || is_flight(k + 1));
            let unhurried = unhurried(program, &nodes);
            let durations =
                (0..program.flies.len()).map(|k| if push(k) { FLIGHT } else { unhurried[k] });
            let durations: Vec<f64> = durations.map(|d| d.clamp(shortest, longest)).collect();
            rise_in_flight(program, scene, &durations, &mut nodes);
            durations
        }
        _ => vec![1.0; program.steps.len()],
    };
    let velocities = if program.has_velocities() {
        vec![vec![0.0; program.system.model.nv]; nodes.len()]
    } else {
        vec![]
    };
    Point {
        nodes,
        wrenches,
        velocities,
        durations,
    }
}

/// Durations of the phases with which the base and the joints keep to moderate speeds in the mean [s].
fn unhurried(program: &Program, nodes: &[Vec<f64>]) -> Vec<f64> {
    let model = &program.system.model;
    let robot = program.system.robot_nv;
    let mut first = 0;
    let duration = |&steps: &usize| {
        let ways = nodes[first..=first + steps].windows(2);
        let mut way = vec![0.0; robot];
        for pair in ways {
            let moved = model.difference(&pair[0], &pair[1]);
            way.iter_mut().zip(&moved).for_each(|(w, m)| *w += m.abs());
        }
        first += steps;
        let speed = |i: usize| if i < 3 { BASE_SPEED } else { JOINT_SPEED };
        let times = way.iter().enumerate().map(|(i, w)| w / speed(i));
        times.fold(DURATION, f64::max)
    };
    program.steps.iter().map(duration).collect()
}

/// Scaled wrenches with which nothing moves: contacts bear weights along their normals, and what objects stand on takes the
/// moments of what stands on them about its middle.
fn wrenches_at_rest(
    interval: &Interval,
    scene: &Scene,
    system: &System,
    kinematics: &Kinematics,
) -> Vec<f64> {
    let mut wrenches = vec![0.0; interval.n_wrench];
    let place = |i: InterfaceId| system.world_from_interface(&scene.interfaces[i.0], kinematics);
    let owner = |i: InterfaceId| scene.interfaces[i.0].owner;
    for force in &interval.forces {
        wrenches[force.first..force.first + force.n].copy_from_slice(&force.reference[..force.n]);
        let (Owner::Object(o), 6) = (owner(force.contact.a), force.n) else {
            continue;
        };
        let below = place(force.contact.a);
        let object = &kinematics.world_from_joint[system.object_joint(o)];
        let weight = scene.objects[o].mass * scene.gravity;
        let mut moment = (object.origin() - below.origin()).cross(&weight);
        for on_it in interval
            .forces
            .iter()
            .filter(|f| owner(f.contact.b) == Owner::Object(o))
        {
            let above = place(on_it.contact.a);
            let load = -above.rotate(on_it.scale[2] * on_it.reference[2] * Vector3::z());
            moment += (above.origin() - below.origin()).cross(&load);
        }
        let moment = below.rotate_inverse(-moment);
        for i in 0..2 {
            wrenches[force.first + 3 + i] = moment[i] / force.scale[3 + i];
        }
    }
    wrenches
}

/// Lets the base and what the robot holds fly along a parabola, above where they would be otherwise: ½ g s (T − s) at time s of a
/// flight of duration T.
fn rise_in_flight(program: &Program, scene: &Scene, durations: &[f64], nodes: &mut [Vec<f64>]) {
    for (t, interval) in program.intervals.iter().enumerate() {
        let k = interval.phase;
        let (first, steps) = (
            t - program.steps[..k].iter().sum::<usize>(),
            program.steps[k],
        );
        if !program.flies[k] || first == 0 {
            continue;
        }
        let s = durations[k] * first as f64 / steps as f64;
        let up = scene.gravity * (-0.5 * s * (durations[k] - s));
        let contacts = interval.forces.iter().map(|f| f.contact);
        let owners = contacts.map(|c| [c.a, c.b].map(|i| scene.interfaces[i.0].owner));
        let held = owners.filter_map(|owners| match owners {
            [Owner::Robot { .. }, Owner::Object(o)] => Some(program.system.object_q(o)),
            _ => None,
        });
        let moved: BTreeSet<usize> = std::iter::once(0).chain(held).collect();
        for (first, i) in moved
            .iter()
            .flat_map(|first| (0..3).map(move |i| (first, i)))
        {
            nodes[t][first + i] += up[i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::Crossings;
    use crate::collision::samples::Sequence;
    use crate::motion::{Planner, near};
    use crate::program::Grid;
    use crate::settings::{Preset, Settings};
    use std::path::Path;
    use symbolic::{ContactState, ContactType};

    #[test]
    fn known_velocities_give_the_motion_of_held_accelerations() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/pick-place.toml");
        let scene = Scene::load(&path).unwrap();
        let system = System::new(&scene).unwrap();
        let (start, nv) = (system.start(&scene), system.model.nv);
        // Every coordinate speeds up by 1 per second for 0.4 s, then slows down by 0.5 for 0.8 s.
        let moved = |way: f64| system.model.integrate(&start, &vec![way; nv]);
        let nodes = [moved(0.0), moved(0.08), moved(0.24)];
        let velocities = [vec![0.0; nv], vec![0.4; nv], vec![0.0; nv]];
        let curve = Curve::new(&system, &[0.0, 0.4, 1.2], &nodes, &velocities);
        for (time, way, speed) in [(0.1, 0.005, 0.1), (0.3, 0.045, 0.3), (0.8, 0.2, 0.2)] {
            let (q, v) = curve.at(time);
            // Of the joints: bodies turn about axes that turn with them.
            assert!((q[7] - start[7] - way).abs() < 1e-12, "{time} s: {}", q[7]);
            assert!((v[6] - speed).abs() < 1e-12, "{time} s: {}", v[6]);
        }
    }

    #[test]
    fn what_an_object_stands_on_bears_the_robot_on_it_too() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/climb.toml");
        let scene = Scene::load(&path).unwrap();
        let interface = |name: &str| scene.interface_id(name).unwrap();
        let contact = |a: &str, b: &str| Contact {
            a: interface(a),
            b: interface(b),
            kind: ContactType::UnilateralPatch,
        };
        let beside: Vec<Contact> = vec![
            contact("left_foot", "ground_top"),
            contact("right_foot", "ground_top"),
            contact("box_bottom", "ground_top"),
        ];
        let mut on_it = beside.clone();
        on_it[1] = contact("right_foot", "box_top");
        let phase = |contacts: Vec<Contact>| Phase {
            state: contacts.into_iter().collect::<ContactState>(),
            steps: 2,
        };
        let planner = Planner::new(&scene).unwrap();
        let nodes = vec![planner.system.start(&scene); 5];
        let settings = Settings::new(Preset::Default, &scene.optimiser);
        let none = Crossings::new();
        let phases = [phase(beside), phase(on_it)];
        let program = planner.program(&phases, &settings, Grid::Motion, near(&nodes, &none));
        let point = point(&program, &scene, nodes);
        // Force of the ground on the box along its normal [N].
        let borne = |t: usize| {
            let bottom = interface("box_bottom");
            let of_box = |f: &&crate::program::Force| f.contact.a == bottom;
            let force = program.intervals[t].forces.iter().find(of_box).unwrap();
            point.wrenches[t][force.first + 2].abs() * force.scale[2]
        };
        let robot = scene.robot.model.total_mass() * scene.gravity.norm();
        let weight = scene.objects[0].mass * scene.gravity.norm();
        assert!((borne(0) - weight).abs() < 1e-9, "{} N", borne(0));
        let loaded = borne(3) - weight - 0.5 * robot;
        assert!(loaded.abs() < 1e-9, "{} N", borne(3));
    }

    #[test]
    fn what_a_robot_holds_flies_with_it() {
        let mut sequence = Sequence::with_steps("boxes/squeeze_carry.toml", 4);
        let phases = &mut sequence.phases;
        phases.truncate(5);
        // Both feet leave the ground while the hands hold the box.
        let is_foot = |c: &Contact| sequence.scene.interfaces[c.a.0].role == Role::Foot;
        let hands = phases[3].state.iter().filter(|c| !is_foot(c));
        phases[3].state = hands.collect();
        let planner = Planner::new(&sequence.scene).unwrap();
        let system = &planner.system;
        let nodes = vec![system.start(&sequence.scene); 21];
        let settings = Settings::new(Preset::Default, &sequence.scene.optimiser);
        let none = Crossings::new();
        let program = planner.program(phases, &settings, Grid::Motion, near(&nodes, &none));
        let point = point(&program, &sequence.scene, nodes.clone());
        let object = system.object_q(0);
        let up = |t: usize, i: usize| point.nodes[t][i] - nodes[t][i];
        // Half-way through the flight, ⅛ g T².
        let highest = 9.81 * FLIGHT.powi(2) / 8.0;
        assert!((up(14, 2) - highest).abs() < 1e-9, "{} m", up(14, 2));
        assert!((up(14, object + 2) - highest).abs() < 1e-9);
        assert_eq!((up(12, object + 2), up(16, object + 2)), (0.0, 0.0));
    }
}
