//! Wrench variables of the active contacts, their bounds and rows.

use std::sync::Arc;

use super::label::label;
use super::{Builder, Force, ForceRows, OnRobot, Phase, Subject};
use crate::relative::{Body, Carrier, RelativeFrame};
use crate::terms::{
    ForceTerm, friction::Friction, grasp::Grasp, point_friction::PointFriction, pressure::Pressure,
    support_pressure::SupportPressure, torsion::Torsion,
};
use scene::{Owner, Role};
use solver::BlockStructure;
use spatial::Pose;
use symbolic::{Contact, ContactState, ContactType, InterfaceId};

/// Share of the area for the centre of pressure that a foot has when its ramp begins.
const FIRST_AREA: f64 = 0.15;
/// A smaller friction coefficient counts as this, so that the cone has an inside.
const LEAST_FRICTION: f64 = 1e-4;

impl Builder<'_> {
    /// Wrenches of interval `t`.
    #[allow(clippy::too_many_lines)] // one expression or layout, written down in its own order
    pub(super) fn forces(&mut self, t: usize, phases: &[Phase]) {
        if !self.program.intervals[t].dynamics {
            return;
        }
        let phase = &phases[self.program.phase_of(t)];
        for &contact in &phase.state.contacts {
            let frame = self.contact_frame(contact);
            let (a, b) = (
                &self.scene.interfaces[contact.a.0],
                &self.scene.interfaces[contact.b.0],
            );
            let g = self.scene.gravity.norm();
            let max_force = a.max_force.min(b.max_force);
            let load = self.load(&phase.state, contact);
            let share = self.ramp(t, contact, phases);
            let force = match a.owner {
                Owner::Robot { .. } => a.max_force / 6.0,
                Owner::Object(_) => load.max(1.0),
                Owner::Static(_) => 10.0,
            };
            let force = if force.is_finite() {
                force
            } else {
                self.program.system.robot_mass * g / 3.0
            };
            let moment = 0.1 * force;
            let margins = &self.program.settings.margins;
            let (mu, mu_r) = (
                a.mu.min(b.mu) * margins.friction,
                a.mu_r.min(b.mu_r) * margins.friction,
            );
            // Without friction the cone has no inside: the tangential force is fixed at zero instead.
            let patch = contact.kind == ContactType::UnilateralPatch;
            let (frictionless, turns_freely) = (patch && mu <= 0.0, patch && mu_r <= 0.0);
            let mu = mu.max(LEAST_FRICTION);
            // Blunts the tip of the cone by as much of the normal force whatever μ is.
            let epsilon = 0.015 * mu * force;
            let pressure = match a.owner {
                Owner::Robot { .. } => margins.pressure,
                _ => margins.support,
            };
            let mut terms: Vec<Arc<dyn ForceTerm>> = Vec::new();
            match contact.kind {
                ContactType::UnilateralPatch => {
                    if !frictionless {
                        terms.push(Arc::new(Friction {
                            mu,
                            epsilon,
                            scale: force,
                        }));
                    }
                    if !turns_freely {
                        terms.push(Arc::new(Torsion::new(mu_r, moment)));
                    }
                    if let Some([x, y]) = a.half_size {
                        let half_size = [x * pressure, y * pressure];
                        let (center, half_size) = self.area(contact, half_size, share);
                        terms.push(Arc::new(Pressure::new(center, half_size, moment)));
                    }
                    if let (true, Some([x, y])) = (b.overhang, b.half_size) {
                        let half_size = [x * pressure, y * pressure];
                        terms.push(Arc::new(SupportPressure {
                            half_size,
                            scale: moment,
                        }));
                    }
                }
                ContactType::BilateralPatch => {
                    terms.push(Arc::new(Grasp {
                        max_force,
                        max_moment: Some(a.max_moment.min(b.max_moment)),
                    }));
                }
                ContactType::UnilateralPoint => terms.push(Arc::new(PointFriction {
                    mu,
                    epsilon,
                    scale: force,
                })),
                ContactType::BilateralPoint => terms.push(Arc::new(Grasp {
                    max_force,
                    max_moment: None,
                })),
            }
            let on_robot = self.on_robot(t, contact);
            let p = &mut self.program;
            let interval = &mut p.intervals[t];
            let (first, n) = (
                interval.n_wrench,
                if contact.kind.is_patch() { 6 } else { 3 },
            );
            interval.n_wrench += n;
            if first == 0 {
                interval.wrench_var = p.structure.n_vars;
            }
            p.structure.n_vars += n;
            let most = self.most_load(t, contact, share, phases).min(max_force);
            let least = self.least_load(contact, most);
            let p = &mut self.program;
            for i in 0..n {
                let normal = i == 2 && patch;
                let limit = if (frictionless && i < 2) || (turns_freely && i == 5) {
                    0.0
                } else if i < 3 && most.is_finite() {
                    most / force
                } else {
                    f64::INFINITY
                };
                p.structure.lower.push(-limit);
                p.structure
                    .upper
                    .push(if normal { -least / force } else { limit });
            }
            let interval = &mut p.intervals[t];
            let slot = p.nodes[t].slot(frame);
            let element = &mut p.structure.elements[t];
            let mut rows = Vec::new();
            for term in terms {
                let bounds = term.bounds();
                let (first_row, block, n_rows) =
                    (element.n_rows(), element.blocks.len(), bounds.len());
                for (l, u) in bounds {
                    element.row_lower.push(l);
                    element.row_upper.push(u);
                    let (scale, unit) = if term.name() == "friction cone" {
                        (force, "N")
                    } else {
                        (moment, "N m")
                    };
                    self.labels[t].push(label(term.name(), Subject::Contact(contact), scale, unit));
                }
                element.blocks.push(BlockStructure {
                    first_row,
                    n_rows,
                    cols: vec![],
                });
                rows.push(ForceRows {
                    term,
                    first_row,
                    n_rows,
                    block,
                });
            }
            let mut scale = [force; 6];
            scale[3..].fill(moment);
            let reference = [0.0, 0.0, -load / force, 0.0, 0.0, 0.0];
            interval.forces.push(Force {
                contact,
                slot,
                frame,
                first,
                n,
                scale,
                reference,
                on_robot,
                rows,
            });
        }
    }

    /// What a contact bears in a state in which nothing moves [N]: feet the robot, alike; what an object stands on, alike, the
    /// object and what stands on it.
    fn load(&self, state: &ContactState, contact: Contact) -> f64 {
        self.load_below(state, contact, self.scene.objects.len())
    }

    /// The same for at most so many objects one above the other.
    fn load_below(&self, state: &ContactState, contact: Contact, most: usize) -> f64 {
        let owner = |i: InterfaceId| self.scene.interfaces[i.0].owner;
        let share_of = |lands: &dyn Fn(&Contact) -> bool| {
            state.iter().filter(|c| lands(c)).count().max(1) as f64
        };
        match owner(contact.a) {
            Owner::Robot { .. } => {
                let is_foot = |c: &Contact| self.scene.interfaces[c.a.0].role == Role::Foot;
                if is_foot(&contact) {
                    self.robot_weight() / share_of(&is_foot)
                } else {
                    0.0
                }
            }
            Owner::Object(o) => {
                self.weight_with_load(state, o, most)
                    / share_of(&|c| owner(c.a) == Owner::Object(o))
            }
            Owner::Static(_) => 0.0,
        }
    }

    /// Weight of an object and of what stands on it [N].
    fn weight_with_load(&self, state: &ContactState, object: usize, most: usize) -> f64 {
        let weight = self.scene.objects[object].mass * self.scene.gravity.norm();
        let owner = |c: &Contact| self.scene.interfaces[c.b.0].owner;
        let on_it = state.iter().filter(|c| owner(c) == Owner::Object(object));
        let above = |c| {
            most.checked_sub(1)
                .map(|most| self.load_below(state, c, most))
        };
        weight + on_it.filter_map(above).sum::<f64>()
    }

    /// The most of that in any phase [N].
    pub(super) fn heaviest(&self, object: usize, phases: &[Phase]) -> f64 {
        let most = self.scene.objects.len();
        let weights = phases.iter();
        let weights = weights.map(|phase| self.weight_with_load(&phase.state, object, most));
        weights.fold(0.0, f64::max)
    }

    fn robot_weight(&self) -> f64 {
        self.program.system.robot_mass * self.scene.gravity.norm()
    }

    /// How far a contact that bears the robot or an object has got with taking up its load after it began, or with giving it
    /// away before it ends: 0 to 1. At the beginning and end of a flight no other contact takes the load over, so there it
    /// comes and goes at once.
    fn ramp(&self, t: usize, contact: Contact, phases: &[Phase]) -> f64 {
        let p = &self.program;
        if !self.bears_load(contact) {
            return 1.0;
        }
        let along = p.along();
        let here = 0.5 * (along[t] + along[t + 1]);
        let n = p.n_intervals();
        let active = |t: usize| phases[p.phase_of(t)].state.contains(&contact);
        let flies = |t: usize| {
            let mut contacts = phases[p.phase_of(t)].state.contacts.iter();
            let owner = |i: symbolic::InterfaceId| self.scene.interfaces[i.0].owner;
            let robot = |i| matches!(owner(i), Owner::Robot { .. });
            !contacts.any(|c| robot(c.a) || robot(c.b))
        };
        let came = (1..=t).rev().find(|&i| !active(i - 1));
        let came = came.filter(|&i| !flies(i - 1));
        let goes = (t + 1..n).find(|&i| !active(i));
        let goes = goes.filter(|&i| !flies(i));
        let apart = came
            .into_iter()
            .chain(goes)
            .map(|i| (along[i] - here).abs())
            .fold(f64::INFINITY, f64::min);
        let share = apart / p.settings.margins.ramp;
        if share < 1.0 { share } else { 1.0 }
    }

    /// Does a contact take up load gradually: of the robot or of an object that stands on something.
    fn bears_load(&self, contact: Contact) -> bool {
        let [a, b] = [contact.a, contact.b].map(|i| &self.scene.interfaces[i.0]);
        match (a.owner, b.owner) {
            (Owner::Robot { .. } | Owner::Object(_), Owner::Static(_)) => true,
            (Owner::Robot { .. }, _) => a.role == Role::Foot,
            _ => false,
        }
    }

    /// Largest force of a contact with so much of its ramp behind it [N].
    fn most_load(&self, t: usize, contact: Contact, share: f64, phases: &[Phase]) -> f64 {
        if share >= 1.0 {
            return f64::INFINITY;
        }
        let state = &phases[self.program.phase_of(t)].state;
        let bears = match self.scene.interfaces[contact.a.0].owner {
            Owner::Object(_) => self.load(state, contact),
            _ => self.robot_weight(),
        };
        bears * share
    }

    /// Centre and half extents of the area that the centre of pressure may use, with so much of the ramp behind the contact
    /// [m]. A foot begins and ends below its last joint: there a force that is not as planned does not turn it.
    fn area(&self, contact: Contact, [x, y]: [f64; 2], share: f64) -> ([f64; 2], [f64; 2]) {
        let a = &self.scene.interfaces[contact.a.0];
        if a.role != Role::Foot || share >= 1.0 {
            return ([0.0; 2], [x, y]);
        }
        let carrier = self.program.system.carrier(a.owner, &a.body_from_interface);
        let ankle = carrier.body_from_frame.inverse().origin();
        let share = share.max(FIRST_AREA);
        let around = |ankle: f64, half: f64| ankle.clamp(-half, half) * (1.0 - share);
        (
            [around(ankle.x, x), around(ankle.y, y)],
            [x * share, y * share],
        )
    }

    /// What a foot bears at least that may bear so much [N]. One that hardly touches rattles where a controller holds it fast.
    fn least_load(&self, contact: Contact, most: f64) -> f64 {
        if self.scene.interfaces[contact.a.0].role == Role::Foot {
            (self.program.settings.margins.load * self.robot_weight()).min(0.5 * most)
        } else {
            0.0
        }
    }

    /// The part of a contact in the robot's momentum; `None` if it acts on the robot not at all or at both ends.
    fn on_robot(&mut self, t: usize, contact: Contact) -> Option<OnRobot> {
        if !self.program.momentum {
            return None;
        }
        let carrier = |i: usize| {
            let interface = &self.scene.interfaces[i];
            self.program
                .system
                .carrier(interface.owner, &interface.body_from_interface)
        };
        let (a, b) = (carrier(contact.a.0), carrier(contact.b.0));
        let moves_robot = |carrier: &Carrier| match carrier.body {
            Body::Joint(j) => j < self.program.system.n_robot_joints,
            Body::World => false,
        };
        let sign = match (moves_robot(&a), moves_robot(&b)) {
            (true, false) => 1.0,
            (false, true) => -1.0,
            _ => return None,
        };
        let key = (contact.a.0, usize::MAX);
        let frame = self.keys.iter().position(|k| *k == key).unwrap_or_else(|| {
            let world = Carrier {
                body: Body::World,
                body_from_frame: Pose::identity(),
            };
            self.program
                .frames
                .push(RelativeFrame::new(&self.program.system.model, a, world));
            self.keys.push(key);
            self.keys.len() - 1
        });
        let slot = self.program.nodes[t].slot(frame);
        Some(OnRobot { frame, slot, sign })
    }
}
