//! What nodes say of a contact that lasts, where accelerations are held over short intervals.
//!
//! With q⁺ = q ⊕ dt/2 (v + v⁺), rows that say at every node where a contact is leave v⁺ = −v along them. No damping: the
//! multipliers of these rows alternate from node to node, with an amplitude of 2 g / dt² all the way back from where g, the price of
//! the acceleration along them, changes abruptly, as before a flight; and the curvature of the rows alternates with them. So
//! every so many intervals begin anew: the node after the last of them says both where the contact is and that it is at rest there, the
//! node after the first says neither and is off by what one interval's curvature makes of it. As many rows as before, one fewer at the
//! end of a motion, where rest is known. Only in sequences with a flight: others take as many iterations either way.
//!
//! Source: ours; benches/runs/2026-12-01-lasting-contacts.md.

use super::{Builder, Phase};
use crate::settings::Integrator;
use symbolic::Contact;

/// Intervals that begin anew together.
const TOGETHER: usize = 4;
/// Longest steps on which one interval's curvature stays below what the checker allows, in a jump [s].
const SHORT_STEP: f64 = 0.025;

/// What a node says of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Told {
    /// Where it is, or that it is where it was at the node before.
    pub place: bool,
    /// That it is at rest, where that is not known.
    pub rest: bool,
}

impl Builder<'_> {
    /// What node `t` says of a contact of the interval before it or after it.
    pub(super) fn told(&self, phases: &[Phase], contact: Contact, t: usize) -> Told {
        let p = &self.program;
        let always = Told {
            place: true,
            rest: false,
        };
        let held = p.has_velocities() && p.settings.integrator == Integrator::ConstantAcceleration;
        let short = p.settings.max_step <= SHORT_STEP && p.flies.contains(&true);
        if !held || !short || t == 0 {
            return always;
        }
        let active = |k: &usize| phases[*k].state.contains(&contact);
        let here = p.phase_of(t - 1);
        if !active(&here) {
            return always;
        }
        let first = (0..=here).rev().take_while(active).last().unwrap_or(here);
        let last = (here..phases.len()).take_while(active).last();
        let begin: usize = p.steps[..first].iter().sum();
        let end: usize = p.steps[..=last.unwrap_or(here)].iter().sum();
        // What follows the last unknown configuration is at rest.
        let unknown = |node: &usize| p.nodes[*node].var.is_some();
        let end = (t..=end).rev().find(unknown).unwrap_or(t);
        let left = (end - t) % TOGETHER;
        Told {
            place: t > begin + 1 && left + 1 < TOGETHER,
            rest: left == 0 && p.nodes[t].velocity_var.is_some(),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::Refinement;
    use crate::collision::samples::Sequence;
    use crate::collision::{Clearances, Watched};
    use crate::motion::Planner;
    use crate::program::{Grid, Subject};
    use crate::settings::{Preset, Settings};

    /// Rows of a category for one foot, per element, of a sequence on a grid with so long steps.
    fn rows(sequence: &str, category: &str, max_step: f64) -> Vec<usize> {
        let Sequence { scene, phases } = Sequence::with_steps(sequence, 10);
        let planner = Planner::new(&scene).unwrap();
        let coarse = Settings::new(Preset::Default, &scene.optimiser);
        let refinement = Refinement {
            max_step,
            ..Refinement::default()
        };
        let settings = refinement.settings(&coarse);
        let nothing = Watched::new();
        let clearances = Clearances::Watched(&nothing);
        let program = planner.program(&phases, &settings, Grid::Motion, clearances);
        let foot = phases[0].state.iter().next().expect("a foot");
        let mut labels = program.labels.iter();
        let elements = program.structure.elements.iter();
        let count = elements.map(|element| {
            let own = labels.by_ref().take(element.n_rows());
            own.filter(|l| l.category == category && l.subject == Subject::Contact(foot))
                .count()
        });
        count.collect()
    }

    #[test]
    fn in_a_jump_a_contact_is_at_rest_at_every_few_nodes_and_another_does_not_say_where_it_is() {
        // The contacts of the first phase begin at node 0 and end at node 10.
        let distance = rows("flat/jump.toml", "contact distance", 0.02);
        assert_eq!(distance[..=10], [0, 0, 1, 0, 1, 1, 1, 0, 1, 1, 1]);
        let velocity = rows("flat/jump.toml", "contact velocity", 0.02);
        assert_eq!(velocity[..=10], [0, 0, 6, 0, 0, 0, 6, 0, 0, 0, 6]);
        // Those of the last one begin at node 20; nodes 29 and 30 are known to be at rest.
        assert_eq!(distance[20..], [1, 0, 1, 0, 1, 1, 1, 0, 1, 1]);
        assert_eq!(velocity[20..], [6, 0, 6, 0, 0, 0, 6, 0, 0, 0]);
    }

    #[test]
    fn every_node_of_a_longer_grid_and_of_a_step_says_where_a_contact_is() {
        for (sequence, max_step) in [("flat/jump.toml", 0.06), ("flat/forward_2.toml", 0.02)] {
            let distance = rows(sequence, "contact distance", max_step);
            assert_eq!(distance[1..=10], [1; 10], "{sequence}");
            let velocity = rows(sequence, "contact velocity", max_step);
            assert_eq!(velocity[1..=10], [0; 10], "{sequence}");
        }
    }
}
