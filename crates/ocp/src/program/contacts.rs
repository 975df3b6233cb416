//! Rows of contacts: where the interfaces lie, and that they stick.

use std::sync::Arc;

use super::label::label;
use super::{Builder, Grid, Phase, Program, Slip, Stick, Subject};
use crate::relative::RelativeFrame;
use crate::settings::Sticking;
use crate::terms::{
    PoseTerm, alignment::Alignment, bounds::Bounds, half_space::HalfSpace, height::Height,
    place::Place, slip_velocity,
};
use solver::BlockStructure;
use symbolic::Contact;

/// Play of a contact that stands nearer to an edge at the start than its margin [m].
const PLAY: f64 = 5e-5;

/// True if `contact` binds the geometry of interval `t`: it is active there, or, with explicit Euler, was released at node t
/// (formulation 2.19: at rest at the release too; the other integrators imply that).
pub(super) fn binds(phases: &[Phase], program: &Program, contact: Contact, t: usize) -> bool {
    let active = |t: usize| {
        phases[program.phase_of(t)]
            .state
            .contacts
            .contains(&contact)
    };
    let released = program.grid == Grid::Motion && !program.has_velocities();
    active(t) || (released && t > 0 && active(t - 1))
}

impl Builder<'_> {
    /// Index of the relative frame of a contact's two interfaces.
    pub(super) fn contact_frame(&mut self, contact: Contact) -> usize {
        let key = (contact.a.0, contact.b.0);
        if let Some(i) = self.keys.iter().position(|k| *k == key) {
            return i;
        }
        let carrier = |i: usize| {
            let interface = &self.scene.interfaces[i];
            self.program
                .system
                .carrier(interface.owner, &interface.body_from_interface)
        };
        let frame = RelativeFrame::new(&self.program.system.model, carrier(key.0), carrier(key.1));
        self.keys.push(key);
        self.program.frames.push(frame);
        self.keys.len() - 1
    }

    /// Contact rows of node t and sticking rows of interval t.
    pub(super) fn contact_geometry(&mut self, t: usize, phases: &[Phase]) {
        let p = &self.program;
        let mut all: Vec<Contact> = Vec::new();
        for k in 0..phases.len() {
            all.extend(
                phases[k]
                    .state
                    .contacts
                    .iter()
                    .filter(|c| !all.contains(c))
                    .copied()
                    .collect::<Vec<_>>(),
            );
        }
        let n = p.n_intervals();
        let keyframes = p.grid.is_keyframes();
        for contact in all {
            let here = binds(phases, &self.program, contact, t);
            let before = t > 0 && binds(phases, &self.program, contact, t - 1);
            let frame = self.contact_frame(contact);
            // Where neither side has moved since the node before, its rows say it all.
            let known = t > 0
                && (before || (t > 1 && binds(phases, &self.program, contact, t - 2)))
                && self.is_settled(contact, t);
            if (here || before) && !known && self.program.nodes[t].var.is_some() {
                let told = self.told(phases, contact, t);
                self.contact_rows(t, t, contact, frame, told.place);
                if told.rest {
                    self.touch_rows(t, contact, frame);
                }
            }
            // The last keyframe has no element of its own; its rows sit in the last one.
            if keyframes && t + 1 == n && here {
                self.contact_rows(t, t + 1, contact, frame, true);
            }
            let by_velocity = !keyframes && self.program.settings.sticking == Sticking::Velocity;
            let is_new = here && !before && !self.is_at_rest(contact, t);
            let p = &self.program;
            if p.has_velocities() && is_new && p.nodes[t].velocity_var.is_some() {
                self.touch_rows(t, contact, frame);
            }
            let p = &self.program;
            if p.grid == Grid::State || self.is_settled(contact, t + 1) {
                continue;
            }
            let told = self.told(phases, contact, t + 1);
            if here && told.place && p.nodes[t + 1].var.is_some() && p.moves(t) {
                if by_velocity {
                    self.slip_rows(t, contact, frame);
                    continue;
                }
                self.place_rows(t, contact, frame, "contact slip", [0.0; 2]);
            }
        }
    }

    /// Between nodes t and t+1 the place of a contact moves by at most so much: along the surface [m], and about its normal [rad].
    pub(super) fn place_rows(
        &mut self,
        t: usize,
        contact: Contact,
        frame: usize,
        category: &'static str,
        [along, turn]: [f64; 2],
    ) {
        let p = &mut self.program;
        let slot_a = p.nodes[t].slot(frame);
        let slot_b = p.nodes[t + 1].slot(frame);
        let place = Arc::new(Place {
            yaw: contact.kind.is_patch(),
        });
        let element = &mut p.structure.elements[t];
        let (first_row, block) = (element.n_rows(), element.blocks.len());
        let rows = [(along, "m"), (along, "m"), (turn, "rad")];
        for (limit, unit) in rows.into_iter().take(place.n_rows()) {
            element.row_lower.push(-limit);
            element.row_upper.push(limit);
            self.labels[t].push(label(category, Subject::Contact(contact), 1.0, unit));
        }
        element.blocks.push(BlockStructure {
            first_row,
            n_rows: place.n_rows(),
            cols: vec![],
        });
        p.intervals[t].sticks.push(Stick {
            slot_a,
            slot_b,
            place,
            first_row,
            block,
        });
    }

    /// Tangential velocity and yaw rate at node t are zero.
    fn slip_rows(&mut self, t: usize, contact: Contact, frame: usize) {
        let p = &mut self.program;
        let slot = p.nodes[t].slot(frame);
        let yaw = contact.kind.is_patch();
        let n_rows = slip_velocity::n_rows(yaw);
        let element = &mut p.structure.elements[t];
        let (first_row, block) = (element.n_rows(), element.blocks.len());
        for r in 0..n_rows {
            element.row_lower.push(0.0);
            element.row_upper.push(0.0);
            let unit = if r < 2 { "m/s" } else { "rad/s" };
            self.labels[t].push(label("contact slip", Subject::Contact(contact), 1.0, unit));
        }
        element.blocks.push(BlockStructure {
            first_row,
            n_rows,
            cols: vec![],
        });
        p.intervals[t].slips.push(Slip {
            slot,
            yaw,
            first_row,
            block,
        });
    }

    /// Distances in x and y to the edges of the support where a contact of the start is now [m]; infinite for others.
    fn room_at_start(
        &self,
        contact: Contact,
        frame: usize,
        half_a: [f64; 2],
        half_b: [f64; 2],
    ) -> [f64; 2] {
        if !self.scene.start_contacts.contains(&contact) {
            return [f64::INFINITY; 2];
        }
        let frame = &self.program.frames[frame];
        let mut relative = frame.relative();
        frame.update(&self.start, &mut relative);
        let mut room = [0.0; 4];
        Bounds { half_a, half_b }.values(&relative.b_from_a, &mut room);
        // A bound that leaves no room at all is one that an interior point cannot meet.
        std::array::from_fn(|i| room[2 * i].min(room[2 * i + 1]) - PLAY)
    }

    /// Height and alignment, if they are to be told, or half space, and bounds of one contact at a node.
    fn contact_rows(
        &mut self,
        element: usize,
        node: usize,
        contact: Contact,
        frame: usize,
        told: bool,
    ) {
        let (a, b) = (
            &self.scene.interfaces[contact.a.0],
            &self.scene.interfaces[contact.b.0],
        );
        let mut terms: Vec<Arc<dyn PoseTerm>> = vec![];
        if told {
            terms.push(Arc::new(Height));
        }
        if !contact.kind.is_patch() {
            terms.push(Arc::new(HalfSpace { limb: a.limb }));
        } else if told {
            terms.push(Arc::new(Alignment));
        }
        if let Some(half_b) = b.half_size {
            let margin = self.program.settings.margins.bounds;
            let half_a = if b.overhang || !contact.kind.is_patch() {
                [0.0; 2]
            } else {
                a.half_size.unwrap_or([0.0; 2])
            };
            // What stands nearer to the edge at the start may stay there.
            let room = self.room_at_start(contact, frame, half_a, half_b);
            let margin =
                |i: usize| (margin.min(0.5 * (half_b[i] - half_a[i]).max(0.0))).min(room[i]);
            terms.push(Arc::new(Bounds {
                half_a,
                half_b: [half_b[0] - margin(0), half_b[1] - margin(1)],
            }));
        }
        for term in terms {
            let category = term.name();
            let unit = term.unit();
            self.node_term(
                element,
                node,
                frame,
                term,
                label(category, Subject::Contact(contact), 1.0, unit),
            );
        }
    }
}
