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
use symbolic::{Contact, ContactType};

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
                        let spare = self.spare_load(contact, share);
                        let term = Pressure::new(center, half_size, moment, spare);
                        terms.push(Arc::new(term));
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
            let weights = self.wrench_weights(t, contact, (force, moment), phases);
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
            let known = match a.owner {
                Owner::Object(o) if self.program.intervals[t].idle.contains(&o) => {
                    Some(self.weight(o, contact))
                }
                _ => None,
            };
            let p = &mut self.program;
            for i in 0..n {
                if let Some(wrench) = known {
                    let known = wrench[i] / if i < 3 { force } else { moment };
                    p.structure.lower.push(known);
                    p.structure.upper.push(known);
                    continue;
                }
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
            for term in terms.into_iter().filter(|_| known.is_none()) {
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
                weights,
                known: known.is_some(),
                on_robot,
                rows,
            });
        }
    }

    /// Weights of the squares of what a scaled wrench differs from its reference: alike, and where velocities are unknowns those
    /// of a foot's moments about its middle with what they are on its edge. On fine grids those of its load and of its tangential
    /// force too, and larger ones of its moments while another foot is about to land, which comes down as the ground under this one
    /// lets the robot tilt.
    fn wrench_weights(
        &self,
        t: usize,
        contact: Contact,
        (force, moment): (f64, f64),
        phases: &[Phase],
    ) -> [f64; 6] {
        let settings = &self.program.settings.weights;
        let mut weights = [settings.force; 6];
        let a = &self.scene.interfaces[contact.a.0];
        let sole = a
            .half_size
            .filter(|_| a.role == Role::Foot && self.program.has_velocities());
        if let (ContactType::UnilateralPatch, Some([x, y])) = (contact.kind, sole) {
            let weight = self.robot_weight();
            let fine = self.program.is_fine();
            let pressure = if fine && self.before_landing(t, phases) {
                settings.landing_pressure
            } else {
                settings.pressure
            };
            if fine && weight > 0.0 {
                let unit = (force / weight).powi(2);
                weights[2] += self.sharing(t, phases) * unit;
                for tangential in &mut weights[..2] {
                    *tangential += settings.shear * unit;
                }
            }
            for (i, half) in [(3, y), (4, x)] {
                let edge = weight * half;
                if edge > 0.0 {
                    weights[i] += pressure * (moment / edge).powi(2);
                }
            }
        }
        weights
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
