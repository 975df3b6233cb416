//! Flights: phases in which nothing bears the robot, and how finely they and their neighbours are divided.
//!
//! A push takes a quarter of a second, and so does a landing. With longer intervals a motion jumps as no robot can, and no finer
//! grid has a motion near it.
//!
//! Source: ours; benches/runs/2026-12-01-pushes.md.

use super::{Builder, Phase};
use scene::{Owner, Role, Scene};
use symbolic::Contact;

impl Builder<'_> {
    /// Tells flights from other phases, and how long the intervals let each phase last: those of a flight and of the phases beside it
    /// are shorter.
    pub(super) fn flights(&mut self, phases: &[Phase]) {
        let p = &mut self.program;
        p.flies = flies(self.scene, phases);
        let hurried = beside(&p.flies);
        let step = |k: usize| {
            let push = if hurried[k] {
                p.settings.push_step
            } else {
                f64::INFINITY
            };
            p.settings.max_step.min(push)
        };
        let steps = p.steps.iter().enumerate();
        p.longest = steps.map(|(k, &n)| n as f64 * step(k)).collect();
    }
}

/// Does a contact bear the robot: a foot on anything, or another end-effector on something fixed.
fn bears(scene: &Scene, contact: Contact) -> bool {
    let [a, b] = [contact.a, contact.b].map(|i| &scene.interfaces[i.0]);
    let robot = matches!(a.owner, Owner::Robot { .. });
    robot && (a.role == Role::Foot || matches!(b.owner, Owner::Static(_)))
}

/// In which phases nothing bears the robot, whatever it carries.
pub(crate) fn flies(scene: &Scene, phases: &[Phase]) -> Vec<bool> {
    let borne = |phase: &Phase| phase.state.iter().any(|c| bears(scene, c));
    phases.iter().map(|phase| !borne(phase)).collect()
}

/// Which phases are flights or beside one.
pub(crate) fn beside(flies: &[bool]) -> Vec<bool> {
    let last = flies.len() - 1;
    let near = |k: usize| flies[k.saturating_sub(1)..=(k + 1).min(last)].contains(&true);
    (0..=last).map(near).collect()
}

#[cfg(test)]
mod tests {
    use crate::collision::samples::Sequence;
    use crate::collision::{Clearances, Watched};
    use crate::motion::Planner;
    use crate::program::{Grid, Program};
    use crate::settings::{Preset, Settings};

    /// The program of a coarse motion.
    fn coarse(sequence: &str) -> Program {
        let Sequence { scene, phases } = Sequence::with_steps(sequence, 16);
        let planner = Planner::new(&scene).unwrap();
        let settings = Settings::new(Preset::Default, &scene.optimiser);
        let nothing = Watched::new();
        let clearances = Clearances::Watched(&nothing);
        planner.program(&phases, &settings, Grid::Motion, clearances)
    }

    #[test]
    fn flights_and_the_phases_beside_them_have_short_intervals() {
        let jump = coarse("flat/jump.toml");
        assert_eq!(jump.flies, [false, true, false]);
        assert_eq!(jump.longest, [16.0 * jump.settings.push_step; 3]);
        let walk = coarse("flat/forward_2.toml");
        let longest = 16.0 * walk.settings.max_step;
        assert!(walk.longest.iter().all(|&l| l == longest));
    }
}
