//! Costs at the nodes: posture, tilt of the base, the objective at the end.

use std::sync::Arc;

use super::goal::{BASE, goal_body};
use super::loads::BALANCED;
use super::{Builder, NodeCost};
use crate::balance::Balance;
use crate::objective::CostTerm;
use crate::relative::{Body, Carrier, RelativeFrame};
use crate::resting;
use crate::settings::Preset;
use crate::terms::{PoseTerm, approach::Approach, height::Height, tilt::Tilt};
use crate::turn::turn_onto;
use multibody::{Kinematics, WeightedPoint};
use nalgebra::Vector3;
use scene::{Objective, Role};
use spatial::Pose;
use std::ops::Range;
use symbolic::{Contact, InterfaceId};

use super::{Grid, Phase};

/// Distance from its next or last contact that a hand has a step away from it, and anything else between [m].
const HAND_APPROACH: f64 = 0.08;
const LIFT: f64 = 0.05;
/// The same of feet and objects in a phase in which something is in the way [m].
const HIGH: f64 = 0.3;
/// Weight of the approach [1/m²].
const APPROACH: f64 = 200.0;
/// Weights of the place of a carried object [1/m²] and of its tilt, beside a posture weight of 0.05 per rad².
const CARRY: f64 = 20.0;
/// What draws the centre of mass over the feet at the end of keyframes where a body is to reach far [1/m²]: the reward draws the robot as
/// far over as its legs allow, from where no motion comes back to what can be borne. 5 cm are as strong as the reward; reaching up draws nowhere.
const REACHING_BALANCE: f64 = 1000.0;
const CARRY_UPRIGHT: f64 = 1.0;
/// Cosine of the angle up to which the sides on which an object stands before and after it is carried are the same.
const SAME_SIDE: f64 = 0.9;

impl Builder<'_> {
    /// Posture and tilt costs of every free node, and the objective.
    pub(super) fn costs(&mut self) {
        let p = &mut self.program;
        let w = p.settings.weights.clone();
        let world = Carrier {
            body: Body::World,
            body_from_frame: Pose::identity(),
        };
        let base = Carrier {
            body: Body::Joint(0),
            body_from_frame: p.system.base_from_upright(self.scene),
        };
        p.frames
            .push(RelativeFrame::new(&p.system.model, base, world));
        self.keys.push((usize::MAX, usize::MAX));
        let last = p
            .nodes
            .iter()
            .rposition(|n| n.var.is_some())
            .map(|t| p.master_node(t));
        let ends = !matches!(p.grid, Grid::OpenKeyframes | Grid::State);
        for t in 0..p.nodes.len() {
            if p.nodes[t].var.is_none() || p.master_node(t) != t {
                continue;
            }
            let is_last = ends && last == Some(t);
            let share = p.share[p.intervals[t.min(p.intervals.len() - 1)].phase];
            (p.nodes[t].posture, p.nodes[t].posture_kind) = if is_last {
                (w.final_posture, CostTerm::FinalPosture)
            } else {
                (w.posture * share, CostTerm::Posture)
            };
            let slot = p.nodes[t].slot(0);
            p.nodes[t].costs.push(NodeCost {
                slot,
                term: Arc::new(Tilt),
                weights: vec![w.tilt * share],
                kind: CostTerm::Tilt,
            });
        }
        if let Some(t) = last.filter(|_| ends) {
            self.objective(t, -w.height);
        }
    }

    /// Where velocities are unknowns, objects in the air stay as upright as they stood: robots would carry them tilted by up to 70 degrees
    /// to spare their wrists (benches/runs/2026-11-29-upright.md). What is to stand on another side next turns on the way.
    pub(super) fn carried_upright(&mut self, phases: &[Phase]) {
        let settings = &self.program.settings;
        let up = (-self.scene.gravity).try_normalize(0.0);
        let Some(up) = up.filter(|_| self.program.has_velocities()) else {
            return;
        };
        if settings.preset == Preset::Paper {
            return;
        }
        let all = resting::poses(self.scene, phases, settings.arrangement, &[]);
        for (o, poses) in all.iter().enumerate() {
            let rests = |k: usize| resting::support(self.scene, o, &phases[k]).is_some();
            let up_in_object = |k: usize| poses[k].rotation().transpose() * up;
            let mut k = 0;
            while k < phases.len() {
                let end = (k..phases.len())
                    .find(|&k| rests(k))
                    .unwrap_or(phases.len());
                let same_side =
                    end == phases.len() || up_in_object(k).dot(&up_in_object(end)) > SAME_SIDE;
                if k < end && same_side {
                    self.upright(o, up_in_object(k), up, k..end);
                }
                k = end + 1;
            }
        }
    }

    /// An object's axis is drawn to the vertical at all nodes within some phases.
    fn upright(
        &mut self,
        object: usize,
        axis: Vector3<f64>,
        up: Vector3<f64>,
        phases: Range<usize>,
    ) {
        let weight = self.program.settings.weights.carried_tilt;
        let body = Carrier {
            body: Body::Joint(self.program.system.object_joint(object)),
            body_from_frame: with_z_along(&axis),
        };
        let frame = self.frame_in(body, with_z_along(&up));
        let p = &mut self.program;
        for t in 1..p.nodes.len() {
            let before = p.intervals[t - 1].phase;
            let after = p.intervals[t.min(p.intervals.len() - 1)].phase;
            let within = phases.contains(&before) && phases.contains(&after);
            if within && p.nodes[t].var.is_some() && p.master_node(t) == t {
                let slot = p.nodes[t].slot(frame);
                p.nodes[t].costs.push(NodeCost {
                    slot,
                    term: Arc::new(Tilt),
                    weights: vec![weight * p.share[after]],
                    kind: CostTerm::Tilt,
                });
            }
        }
    }

    /// The reward at the last node `t`: how far the body of the objective is along its direction.
    fn objective(&mut self, t: usize, weight: f64) {
        let (body, direction) = match &self.scene.objective {
            Objective::Time => return,
            Objective::BaseHeight => (BASE, Vector3::z()),
            Objective::Reach { body, direction } => (body.as_str(), *direction),
        };
        let Some(body) = goal_body(self.scene, &self.program.system, body) else {
            return;
        };
        let frame = self.frame_in(body, with_z_along(&direction));
        let slot = self.program.nodes[t].slot(frame);
        self.program.nodes[t].costs.push(NodeCost {
            slot,
            term: Arc::new(Height),
            weights: vec![weight],
            kind: CostTerm::Goal,
        });
    }

    /// In keyframes, objects in the air stay near their guess and upright: the posture alone would let them sink until they
    /// touch something, which is a bad place to start a motion from. Where the sequence ends with them in the air, only their height
    /// does.
    pub(super) fn carried(&mut self, phases: &[Phase]) {
        let keyframes = matches!(self.program.grid, Grid::Keyframes | Grid::OpenKeyframes);
        if !keyframes || self.program.settings.preset == Preset::Paper {
            return;
        }
        let world = |pose: Pose| Carrier {
            body: Body::World,
            body_from_frame: pose,
        };
        for (o, poses) in resting::poses(self.scene, phases, self.program.settings.arrangement, &[])
            .iter()
            .enumerate()
        {
            let rests = |k: usize| resting::support(self.scene, o, &phases[k]).is_some();
            let p = &mut self.program;
            let object = Carrier {
                body: Body::Joint(p.system.object_joint(o)),
                body_from_frame: Pose::identity(),
            };
            // What does not come to rest again comes along to where the goal wants the robot; in beginnings it waits.
            let comes_along = p.grid == Grid::Keyframes;
            let settles = (0..phases.len()).rfind(|&k| rests(k)).unwrap_or(0);
            for (t, pose) in poses.iter().enumerate().skip(1) {
                if rests(t - 1) || t < phases.len() && rests(t) {
                    continue;
                }
                let place = Pose::from_parts(*Pose::identity().rotation(), pose.origin());
                let frame = p.frames.len();
                let model = &p.system.model;
                p.frames
                    .push(RelativeFrame::new(model, object, world(place)));
                self.keys.push((usize::MAX, frame));
                let slot = p.nodes[t].slot(frame);
                let approach = Approach {
                    distance: 0.0,
                    above: (t < settles || !comes_along).then_some([0.0; 2]),
                };
                let terms: [(Arc<dyn PoseTerm>, f64); 2] =
                    [(Arc::new(approach), CARRY), (Arc::new(Tilt), CARRY_UPRIGHT)];
                for (term, weight) in terms {
                    p.nodes[t].costs.push(NodeCost {
                        slot,
                        term,
                        weights: vec![weight],
                        kind: CostTerm::Guide,
                    });
                }
            }
        }
    }

    /// In keyframes, robot and what it carries stand over the feet that stay where they are; on fine grids just before another foot
    /// lands.
    pub(super) fn balanced(&mut self, phases: &[Phase]) {
        if matches!(self.program.grid, Grid::Keyframes | Grid::OpenKeyframes) {
            let weight = self.program.settings.weights.balance;
            for t in 1..=phases.len() {
                let at_the_end = match &self.scene.objective {
                    Objective::Reach { direction, .. } if t == phases.len() => {
                        let up = -self.scene.gravity.normalize();
                        REACHING_BALANCE * (1.0 - direction.dot(&up).powi(2)).max(0.0)
                    }
                    _ => 0.0,
                };
                let weight = weight + at_the_end;
                self.balance(t, weight, &phases[t - 1..phases.len().min(t + 1)]);
            }
        } else if self.program.is_fine() {
            let weight = self.program.settings.weights.landing_balance;
            for t in 0..self.program.intervals.len() {
                let k = self.program.phase_of(t);
                if self.lands_within(BALANCED, t, phases) {
                    self.balance(t, weight * self.program.share[k], &phases[k..k + 2]);
                }
            }
        }
    }

    /// At a node, robot and what it carries stand over the feet that have contact in all of some phases.
    fn balance(&mut self, t: usize, weight: f64, phases: &[Phase]) {
        let up = (-self.scene.gravity).try_normalize(0.0);
        let (Some(up), true, true) = (up, weight > 0.0, self.program.nodes[t].var.is_some()) else {
            return;
        };
        let points = self.imbalance(phases);
        if !points.is_empty() {
            self.program.nodes[t].balance = Some(Balance { weight, up, points });
        }
    }

    /// Centre of mass of the robot and of the objects in the air, less the middle of the feet that have contact in all of some
    /// phases; empty if none has.
    fn imbalance(&self, phases: &[Phase]) -> Vec<WeightedPoint> {
        let (scene, system) = (self.scene, &self.program.system);
        let (first, rest) = (&phases[0], &phases[1..]);
        let stays = |c: &Contact| {
            let foot = scene.interfaces[c.a.0].role == Role::Foot;
            foot && rest.iter().all(|phase| phase.state.contains(c))
        };
        let feet: Vec<Contact> = first.state.iter().filter(stays).collect();
        let rests = |o: usize| {
            phases
                .iter()
                .any(|p| resting::support(scene, o, p).is_some())
        };
        let carried = (0..scene.objects.len()).filter(|&o| !rests(o));
        let carried = carried.map(|o| system.object_joint(o));
        let joints: Vec<usize> = (0..system.n_robot_joints).chain(carried).collect();
        let inertia = |joint: usize| &system.model.joints[joint].inertia;
        let mass: f64 = joints.iter().map(|&joint| inertia(joint).mass).sum();
        let mut points: Vec<WeightedPoint> = vec![];
        for contact in &feet {
            let interface = &scene.interfaces[contact.a.0];
            let carrier = system.carrier(interface.owner, &interface.body_from_interface);
            let Body::Joint(joint) = carrier.body else {
                continue;
            };
            points.push(WeightedPoint {
                joint,
                in_joint: carrier.body_from_frame.origin(),
                weight: -1.0 / feet.len() as f64,
            });
        }
        if points.is_empty() {
            return points;
        }
        points.extend(joints.iter().map(|&joint| WeightedPoint {
            joint,
            in_joint: inertia(joint).com,
            weight: inertia(joint).mass / mass,
        }));
        points
    }

    /// In a path, what makes or breaks contact with the next or last phase keeps off along the contact's normal.
    pub(super) fn approaches(&mut self, phases: &[Phase]) {
        if self.program.grid != Grid::Path {
            return;
        }
        let mut first = 0;
        for (k, phase) in phases.iter().enumerate() {
            let end = first + phase.steps;
            let neighbours = [
                (k.checked_sub(1), first + 1, 0),
                ((k + 1 < phases.len()).then_some(k + 1), end - 1, 1),
            ];
            for (neighbour, next_to_it, side) in neighbours {
                let Some(neighbour) = neighbour else { continue };
                let apart = phases[neighbour].state.contacts.iter();
                for &contact in apart.filter(|c| !phase.state.contains(c)) {
                    let hand = self.scene.interfaces[contact.a.0].role == Role::Hand;
                    let lifts = self.program.settings.lifts.get(&k).filter(|_| !hand);
                    let distance = match lifts {
                        _ if hand => HAND_APPROACH,
                        Some(_) => HIGH,
                        None => LIFT,
                    };
                    let place = lifts.map(|ends| self.place_of(contact, &ends[side]));
                    let place = place.or(hand.then_some([0.0; 2]));
                    let frame = self.contact_frame(contact);
                    for t in first + 1..end {
                        let is_next = t == next_to_it;
                        if hand && !is_next {
                            continue;
                        }
                        let slot = self.program.nodes[t].slot(frame);
                        self.program.nodes[t].costs.push(NodeCost {
                            slot,
                            term: Arc::new(Approach {
                                distance,
                                above: place.filter(|_| is_next),
                            }),
                            weights: vec![APPROACH],
                            kind: CostTerm::Guide,
                        });
                    }
                }
            }
            first = end;
        }
    }

    /// Where on its surface b the origin of a contact's interface a is at a configuration [m].
    fn place_of(&self, contact: Contact, q: &[f64]) -> [f64; 2] {
        let system = &self.program.system;
        let mut kinematics = Kinematics::new(&system.model);
        kinematics.update(&system.model, q);
        let world_from = |i: InterfaceId| {
            let interface = &self.scene.interfaces[i.0];
            let carrier = system.carrier(interface.owner, &interface.body_from_interface);
            carrier.world_from_frame(&kinematics)
        };
        let place = (world_from(contact.b).inverse() * world_from(contact.a)).origin();
        [place.x, place.y]
    }
}

/// A pose at the origin whose z axis is this direction.
fn with_z_along(direction: &Vector3<f64>) -> Pose {
    Pose::from_parts(turn_onto(&Vector3::z(), direction), Vector3::zeros())
}
