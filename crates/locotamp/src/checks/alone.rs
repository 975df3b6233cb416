//! Is there room for the objects at all? A beginning without the robot: where no configurations have what the objects rest on one after
//! the other, none of any beginning with the same has, whatever hands and feet do.

use super::Checks;
use ocp::Phase;
use symbolic::ContactState;

/// What the objects rest on one after the other, in a beginning that has no room for them.
pub(super) struct Crowded {
    history: Vec<ContactState>,
    reason: String,
}

impl Checks<'_> {
    /// Why there is no room for the objects of a beginning, if that is known.
    pub(super) fn crowded(&self, states: &[&ContactState]) -> Option<&str> {
        let history = self.history(states);
        let same = |known: &&Crowded| history.starts_with(&known.history);
        self.crowded
            .iter()
            .find(same)
            .map(|known| known.reason.as_str())
    }

    /// Takes note of a beginning that was refused for some reason, if the objects alone have no room in it.
    pub(super) fn note_refused(&mut self, states: &[&ContactState], reason: &str) {
        let history = self.history(states);
        if self.scene.objects.len() > 1 && !self.has_room(&history) {
            let reason = format!("{reason}, whatever the robot does");
            self.crowded.push(Crowded { history, reason });
        }
    }

    /// What the objects rest on one after the other.
    fn history(&self, states: &[&ContactState]) -> Vec<ContactState> {
        let all: Vec<usize> = (0..self.scene.objects.len()).collect();
        let mut history: Vec<ContactState> = states.iter().map(|s| self.resting(s, &all)).collect();
        history.dedup();
        history
    }

    /// Are there places for objects that rest on these one after the other?
    pub(super) fn has_room(&mut self, history: &[ContactState]) -> bool {
        let phase = |state: &ContactState| self.phase(state.clone());
        let phases: Vec<Phase> = history.iter().map(phase).collect();
        let answer = self.answered(&phases, |checks| {
            (checks.planner).keyframes_of_prefix(&phases, checks.settings)
        });
        answer.possible
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{fresh, state};
    use super::*;
    use ocp::{Planner, Preset, Settings};
    use scene::{Expectation, Perturbation, Scene, SequenceFile};
    use std::path::Path;
    use symbolic::{Oracle, Verdict};

    /// A box in the middle of a table, with 12 cm beside it, and one 13 cm wide on another table.
    const NO_ROOM: &str = r#"
        name = "no room"
        robot = "g1"
        static = [
            { name = "ground", plane = true },
            { name = "table", size = [0.15, 0.4, 0.03], position = [0.4, 0.3, 0.735] },
            { name = "other", size = [0.15, 0.4, 0.03], position = [0.4, -0.2, 0.735] },
        ]
        [[object]]
        name = "still"
        mass = 1.0
        size = [0.12, 0.16, 0.12]
        on = "table_top"
        [[object]]
        name = "red"
        mass = 1.0
        size = [0.13, 0.13, 0.15]
        on = "other_top"
        [[object.interface]]
        name = "red_side"
        side = "+y"
        half_size = [0.05, 0.06]
        contacts = ["unilateral_patch"]
        [goal]
        contacts = [["red_bottom", "table_top"]]
    "#;

    #[test]
    fn where_objects_have_no_room_nothing_that_the_robot_does_is_asked_about_again() {
        let scene = Scene::from_toml(NO_ROOM, "here", Path::new("")).expect("a scene");
        let planner = Planner::new(&scene).expect("a model");
        let settings = Settings::new(Preset::Default, &scene.optimiser);
        let mut checks = fresh(&planner, &settings);
        let feet = [("left_foot", "ground_top"), ("right_foot", "ground_top")];
        let hand = [("left_hand", "red_side")];
        let still = [("still_bottom", "table_top")];
        let with = |pairs: &[&[(&str, &str)]]| state(&scene, &pairs.concat());
        let before = with(&[&feet, &still, &[("red_bottom", "other_top")]]);
        let taken = with(&[&feet, &hand, &still]);
        let there = with(&[&feet, &hand, &still, &[("red_bottom", "table_top")]]);
        let states = [&before, &taken, &there];
        assert!(matches!(checks.prefix(&states), Verdict::Reject(_)));
        assert!(checks.crowded(&states[..2]).is_none());

        let work = checks.work;
        let one_foot = with(&[&feet[..1], &hand, &still]);
        for states in [
            &[&before, &taken, &one_foot, &there][..],
            &[&before, &taken, &one_foot, &taken, &there],
        ] {
            let Verdict::Reject(reason) = checks.prefix(states) else {
                panic!("there is no room");
            };
            assert!(reason.ends_with(", whatever the robot does"), "{reason}");
        }
        assert_eq!(checks.work, work, "nothing was solved");

        // Once the other box has been lifted there is.
        let lifted = with(&[&feet, &hand]);
        let history = checks.history(&[&before, &taken, &lifted, &there]);
        assert!(checks.has_room(&history));
    }

    #[test]
    fn objects_have_room_in_sequences_with_a_motion_and_in_their_variants() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/sequences");
        let paths = SequenceFile::find(Path::new(folder)).expect("sequences");
        let mut refused = vec![];
        for path in paths {
            let file = SequenceFile::load(&path).expect("a sequence file");
            let scene = file.load_scene().expect("its scene");
            let sequence = file.resolve(&scene).expect("a sequence of the scene");
            if sequence.expect != Some(Expectation::Feasible) || scene.objects.len() < 2 {
                continue;
            }
            let states: Vec<&ContactState> = sequence.phases.iter().map(|p| &p.state).collect();
            for variant in 0..=4 {
                let scene = match variant {
                    0 => scene.clone(),
                    n => scene.perturbed(&Perturbation::default(), n),
                };
                let planner = Planner::new(&scene).expect("a model");
                let settings = Settings::new(Preset::Default, &scene.optimiser);
                let mut checks = fresh(&planner, &settings);
                let history = checks.history(&states);
                for k in 2..=history.len() {
                    if !checks.has_room(&history[..k]) {
                        refused.push(format!("{} {variant} {k}", path.display()));
                    }
                }
            }
        }
        assert!(refused.is_empty(), "{refused:#?}");
    }
}
