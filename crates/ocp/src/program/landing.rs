//! Landing and lifting off: what lands comes down straight and slowly, what leaves goes up so.
//!
//! With v, ω the twist of `a` relative to `b` in axes of `a`, z its normal, at a node that is time τ ≤ τ_1 away from the
//! contact, and u the speed gained since τ_0, whose acceleration grows from 0 to a_0 in τ_2: u = a_0 σ²/(2 τ_2) up to
//! σ = max(0, τ − τ_0) = τ_2, a_0 (σ − τ_2/2) beyond. |v_z| ≤ v_0 + u, |v_x|, |v_y| ≤ v_0 + r u, |ω_i| ≤ (v_0 + r u)/l.
//! Distances demanded beside contacts grow with s ∫ u dτ meanwhile. Short phases have τ_0, τ_1 and a_0 of their own.
//!
//! Source: ours. A foot that comes in along the ground is stopped by it before its time where the robot hangs a little
//! lower than planned. One that is still braking when it touches is lifted off again by its controller, and falls back when the
//! controller counts on it; hence the slow way of τ_0. What this does to replays: benches/runs/2026-11-23-calm-landings.md.

use std::sync::Arc;

use super::label::label;
use super::{Builder, FINE_STEP, Grid, PARTS, Phase, Program, Subject};
use crate::settings::Preset;
use crate::terms::{PoseTerm, alignment::Tilted, height::Beyond};
use nalgebra::Vector3;
use scene::Role;
use symbolic::Contact;

/// Growth of the speed with the time from the contact, a_0 [m/s²], and the same times the square of a phase's duration
/// [m], whichever is more.
const GROWTH: f64 = 1.5;
const OF_SHORT: f64 = 1.5;
/// Shares of it along the surface, r, and for distances, s.
const ALONG: f64 = 0.4;
const RISE: f64 = 2.0 / 3.0;
/// Time from the contact with the least speed, τ_0 [s], and the same as a share of the phase.
const STILL: f64 = 0.2;
const STILL_SHARE: f64 = 0.125;
/// Time in which the acceleration grows, τ_2 [s].
const GENTLE: f64 = 0.1;
/// Longer steps than [`FINE_STEP`] are too few for that: they have this τ_0 [s], and τ_2 = 0.
const STILL_ON_LONG: f64 = 0.08;
/// Longest time from the contact, τ_1 [s], and the same as a share of the phase.
const BESIDE: f64 = 0.4;
const SHARE: f64 = 0.25;
/// Lever of the angular velocity, l [m].
const LEVER: f64 = 0.2;

/// Turn about any axis [rad] and distance along the surface [m] by which a hand or object may differ from its contact one interval of
/// a coarse grid away from it (benches/runs/2026-11-25-choices.md).
const TURNED: f64 = 0.2;
const BESIDE_PLACE: f64 = 0.05;

/// Longest duration of a phase of so many intervals [s].
fn duration(program: &Program, steps: usize) -> f64 {
    program.settings.max_step * steps as f64
}

/// Growth of the speed in a phase of such a duration [m/s²].
fn growth(duration: f64) -> f64 {
    GROWTH.max(OF_SHORT / duration.powi(2))
}

/// Speed gained, u [m/s], and the way made with it [m], at a time from the contact, in a phase of such a duration
/// in such steps.
fn gained(step: f64, duration: f64, time: f64) -> (f64, f64) {
    let (still, gentle) = if step > FINE_STEP {
        (STILL_ON_LONG, 0.0)
    } else {
        (STILL, GENTLE)
    };
    let sigma = (time - still.min(STILL_SHARE * duration)).max(0.0);
    let (speed, way) = if sigma < gentle {
        let speed = sigma.powi(2) / (2.0 * gentle);
        (speed, speed * sigma / 3.0)
    } else {
        let speed = sigma - 0.5 * gentle;
        (speed, 0.5 * speed.powi(2) + gentle.powi(2) / 24.0)
    };
    let growth = growth(duration);
    (growth * speed, growth * way)
}

/// Distance that may be demanded at a node, so many sixteenths of a phase away from a contact [m]; `None` where nothing
/// bounds the speed there.
pub(crate) fn rise(program: &Program, node: usize, parts: f64) -> Option<f64> {
    if !program.has_velocities() || program.settings.margins.landing.is_infinite() {
        return None;
    }
    let interval = node.min(program.n_intervals() - 1);
    let steps = program.steps[program.phase_of(interval)];
    let duration = duration(program, steps);
    Some(
        RISE * gained(
            program.settings.max_step,
            duration,
            duration * parts / PARTS,
        )
        .1,
    )
}

impl Builder<'_> {
    /// Speeds beside the contacts that begin or end with a phase, where velocities are unknowns. Not while nothing of the
    /// robot touches anything: in flight its feet move as it does.
    pub(super) fn landings(&mut self, phases: &[Phase]) {
        let speed = self.program.settings.margins.landing;
        if !self.program.has_velocities() || speed.is_infinite() {
            return;
        }
        let dt = self.program.settings.max_step;
        let mut first = 0;
        for (k, phase) in phases.iter().enumerate() {
            let end = first + phase.steps;
            let duration = duration(&self.program, phase.steps);
            let share = (SHARE * phase.steps as f64).ceil() as usize;
            let within = ((BESIDE / dt) as usize).min(share).min(phase.steps - 1);
            let stands = !self.program.flies[k];
            let neighbours = [
                (k.checked_sub(1), false),
                ((k + 1 < phases.len()).then_some(k + 1), true),
            ];
            for (neighbour, lands) in neighbours {
                let Some(neighbour) = neighbour.filter(|_| stands) else {
                    continue;
                };
                let apart = phases[neighbour].state.contacts.iter();
                for &contact in apart.filter(|c| !phase.state.contains(c)) {
                    let frame = self.contact_frame(contact);
                    for nodes in 1..=within {
                        let t = if lands { end - nodes } else { first + nodes };
                        if self.program.nodes[t].velocity_var.is_none() {
                            continue;
                        }
                        let (more, _) = gained(dt, duration, dt * nodes as f64);
                        let along = speed + ALONG * more;
                        let limits = [along, speed + more, along / LEVER];
                        self.velocity_rows(t, contact, frame, "landing speed", limits);
                    }
                }
            }
            first = end;
        }
    }

    /// Where configurations alone are unknowns: feet that land or leave are beyond the plane of the contact at the node next to it,
    /// since an interval may be long enough to come through the edge of what they land on.
    pub(super) fn soles_outside(&mut self, phases: &[Phase]) {
        for (contact, node, _) in self.beside_contacts(phases, 4) {
            if !self.is_foot(contact) {
                continue;
            }
            let frame = self.contact_frame(contact);
            let term = Beyond {
                points: self.corners(contact),
            };
            let category = label(term.name(), Subject::Contact(contact), 1.0, term.unit());
            self.node_term(node, node, frame, Arc::new(term), category);
        }
    }

    /// On a coarse grid that a finer one follows, where collisions between nodes are nobody's business: what is no foot is turned as
    /// in its contact, and beside its place, at the node next to it, since an interval may be long enough to turn a hand around what
    /// it would collide with.
    pub(super) fn hands_turned(&mut self, phases: &[Phase]) {
        if self.program.settings.between {
            return;
        }
        for (contact, node, interval) in self.beside_contacts(phases, 6) {
            let nodes = &self.program.nodes[interval..=interval + 1];
            if self.is_foot(contact) || nodes.iter().any(|n| n.var.is_none()) {
                continue;
            }
            let frame = self.contact_frame(contact);
            if contact.kind.is_patch() {
                let term = Tilted(TURNED);
                let category = label(term.name(), Subject::Contact(contact), 1.0, term.unit());
                self.node_term(node, node, frame, Arc::new(term), category);
            }
            let limits = [BESIDE_PLACE, TURNED];
            self.place_rows(interval, contact, frame, "contact approach", limits);
        }
    }

    /// Contacts that begin or end with a phase of at least so many intervals in which they are open, each with the node next to it
    /// and the interval between; none but on grids of the default preset on which configurations alone are unknowns.
    fn beside_contacts(
        &self,
        phases: &[Phase],
        least_steps: usize,
    ) -> Vec<(Contact, usize, usize)> {
        let p = &self.program;
        let coarse = p.grid == Grid::Motion && !p.has_velocities();
        let mut out = vec![];
        if !coarse || p.settings.preset == Preset::Paper {
            return out;
        }
        let mut first = 0;
        for (k, phase) in phases.iter().enumerate() {
            let end = first + phase.steps;
            // With explicit Euler what leaves is still at rest at its release, two nodes later.
            let beside = [
                (k.checked_sub(1), first + 2, first + 1),
                (Some(k + 1).filter(|&k| k < phases.len()), end - 1, end - 1),
            ];
            for (neighbour, node, interval) in beside {
                let Some(neighbour) = neighbour.filter(|_| phase.steps >= least_steps) else {
                    continue;
                };
                let apart = phases[neighbour].state.iter();
                let open = apart.filter(|c| !phase.state.contains(c));
                out.extend(open.map(|contact| (contact, node, interval)));
            }
            first = end;
        }
        out
    }

    fn is_foot(&self, contact: Contact) -> bool {
        self.scene.interfaces[contact.a.0].role == Role::Foot
    }

    /// Corners of the interface that touches the other; its origin where it has none.
    fn corners(&self, contact: Contact) -> Vec<Vector3<f64>> {
        let half = self.scene.interfaces[contact.a.0].half_size;
        let Some([x, y]) = half.filter(|_| contact.kind.is_patch()) else {
            return vec![Vector3::zeros()];
        };
        let signs = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
        let corner = |(i, j)| Vector3::new(i * x, j * y, 0.0);
        signs.map(corner).to_vec()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::samples::Sequence;
    use crate::collision::{Clearances, Watched};
    use crate::motion::Planner;
    use crate::settings::Settings;

    #[test]
    fn a_hand_is_turned_as_in_its_grasp_one_interval_before_it_where_a_finer_grid_follows() {
        let Sequence { scene, phases } = Sequence::with_steps("boxes/pick_place.toml", 8);
        let planner = Planner::new(&scene).unwrap();
        let nothing = Watched::new();
        let elements_of_hands = |between| {
            let settings = Settings {
                between,
                ..Settings::new(Preset::Default, &scene.optimiser)
            };
            let clearances = Clearances::Watched(&nothing);
            let program = planner.program(&phases, &settings, Grid::Motion, clearances);
            let of_hand = |label: &super::super::RowLabel| match label.subject {
                Subject::Contact(c) => scene.interfaces[c.a.0].role == Role::Hand,
                _ => false,
            };
            let mut labels = program.labels.iter();
            let elements = program.structure.elements.iter().enumerate();
            elements
                .filter_map(|(t, element)| {
                    let mut own = labels.by_ref().take(element.n_rows()).collect::<Vec<_>>();
                    own.retain(|l| l.category == "contact approach" && of_hand(l));
                    (!own.is_empty()).then_some(t)
                })
                .collect::<Vec<usize>>()
        };
        assert!(elements_of_hands(true).is_empty());
        let hand = |c: &Contact| scene.interfaces[c.a.0].role == Role::Hand;
        let holds = |phase: &Phase| phase.state.iter().any(|c| hand(&c));
        let grasp = phases.iter().position(holds).expect("a grasp");
        assert!(elements_of_hands(false).contains(&(8 * grasp - 1)));
    }
}
