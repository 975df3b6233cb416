//! Feet set anew where they stand wrong: would a beginning be possible then, and in which state.

use super::Checks;
use super::beginnings::Refused;
use nalgebra::Vector2;
use ocp::{Arrangement, Keyframes, Phase, Ways};
use scene::Role;
use symbolic::{Anew, Contact, ContactState};

/// Way of the base that one swing allows at most [m], and what turning by 1 rad counts for [m].
const STRIDE: f64 = 0.5;
const TURN: f64 = 0.3;
/// States that are tried alone, those with the longest ways first.
const TRIES: usize = 3;

/// A beginning that would be possible if the feet were set anew in one state.
pub(super) struct FeetAnew {
    states: Vec<ContactState>,
    at: usize,
    /// Keyframes of the beginning with two more phases after that state: in the air, and the state again.
    nodes: Vec<Vec<f64>>,
}

impl Checks<'_> {
    /// If the phases are the beginning for which feet were set anew last, with swings in place of that: the way there in as many
    /// parts.
    pub(super) fn guess_of_swings(&self, phases: &[Phase]) -> Option<Vec<Vec<f64>>> {
        let FeetAnew { states, at, nodes } = self.anew.as_ref()?;
        let more = phases.len().checked_sub(states.len()).filter(|&n| n > 0)?;
        let same = |(phase, state): (&Phase, &ContactState)| phase.state == *state;
        let (before, after) = (&states[..=*at], &states[at + 1..]);
        if !phases.iter().zip(before).all(same)
            || !phases[at + 1 + more..].iter().zip(after).all(same)
        {
            return None;
        }
        let (from, to) = (&nodes[at + 1], &nodes[at + 3]);
        let part = |n: usize| self.on_the_way(from, to, n as f64 / more as f64);
        let mut way: Vec<Vec<f64>> = (0..=more).map(part).collect();
        self.planner.ways_of(phases).bend(&mut way, 0);
        let (first, rest) = (&nodes[..=*at], &nodes[at + 4..]);
        Some([first, &way, rest].concat())
    }

    /// Is a beginning possible if the feet are set anew in one of these states; with how many swings at least? `None` if it
    /// is if that is done in several.
    pub(super) fn feet_anew(
        &mut self,
        states: &[&ContactState],
        stances: &[usize],
    ) -> Option<Anew> {
        if self.crowded(states).is_some() {
            return Some(Anew::Far);
        }
        let phases: Vec<Phase> = states.iter().map(|&s| self.phase(s.clone())).collect();
        let (guess, all) = match self.anew_in_all(&phases, stances) {
            Ok(found) => found,
            Err(miss) => return Some(miss),
        };
        let ways = self.planner.ways_of(&phases);
        let mut longest: Vec<(usize, f64)> = (0..stances.len())
            .map(|n| (n, self.way(&ways, &all.nodes, stances[n] + 2 * n)))
            .collect();
        longest.sort_by(|a, b| b.1.total_cmp(&a.1).then(b.0.cmp(&a.0)));
        for &(n, _) in longest.iter().take(TRIES) {
            let at = stances[n];
            let nodes = anew_in_one(&guess, &all.nodes, stances, n);
            let found = self.solve_with(&phases, &[at], &nodes);
            if found.possible {
                let way = self.way(&ways, &found.nodes, at);
                self.anew = Some(FeetAnew {
                    states: states.iter().map(|&s| s.clone()).collect(),
                    at,
                    nodes: found.nodes,
                });
                let swings = ((way / STRIDE).ceil() as usize).max(1);
                return Some(Anew::Possible { at, swings });
            }
        }
        None
    }

    /// Keyframes with feet set anew in all these states, and the guess from which they were found.
    fn anew_in_all(
        &mut self,
        phases: &[Phase],
        stances: &[usize],
    ) -> Result<(Vec<Vec<f64>>, Keyframes), Anew> {
        let near = self.nearest_miss(phases);
        let missed = near.is_some();
        if let Some(guess) = near {
            let found = self.solve_anew(phases, stances, &guess);
            if found.possible {
                return Ok((guess, found));
            }
        }
        let guess = self.guess_of_rest(phases);
        let found = self.solve_anew(phases, stances, &guess);
        if found.possible {
            return Ok((guess, found));
        }
        let far = found.is_hopeless() && !missed;
        Err(if far { Anew::Far } else { Anew::Near })
    }

    /// How far the base goes between the boundary after phase `at` and the second one from there, feet in the air between [m].
    fn way(&self, ways: &Ways, nodes: &[Vec<f64>], at: usize) -> f64 {
        let model = &self.planner.system.model;
        let (from, to) = (&nodes[at + 1], &nodes[at + 3]);
        let turn = model.difference(from, to)[5].abs();
        let place = |q: &[f64]| Vector2::new(q[0], q[1]);
        ways.length(place(from), place(to)) + TURN * turn
    }

    /// What came nearest to keyframes of a beginning that was refused by little.
    fn nearest_miss(&mut self, phases: &[Phase]) -> Option<Vec<Vec<f64>>> {
        let same = |refused: &Refused| refused.states.iter().eq(phases.iter().map(|p| &p.state));
        if !self.refused.as_ref().is_some_and(same) {
            self.solve_beginning(phases); // the verdict is from the run that is continued
        }
        let refused = self.refused.as_ref().filter(|refused| same(refused));
        refused.and_then(|refused| refused.nearest.clone())
    }

    /// From the keyframes of what was possible before the last step, the rest as a first guess has it.
    fn guess_of_rest(&mut self, phases: &[Phase]) -> Vec<Vec<f64>> {
        let telling = |k: &usize| self.is_telling(&phases[k - 1].state, &phases[*k].state);
        let known = (2..phases.len()).rev().find(|k| telling(&(k - 1)));
        let known = known.and_then(|k| self.nodes(&phases[..k]));
        let known = known.as_deref().unwrap_or_default();
        self.planner
            .guess_after(known, phases, Arrangement::default())
    }

    /// Keyframes with feet set anew in some states, each of which becomes three phases: itself, without feet, and itself again.
    fn solve_anew(&self, phases: &[Phase], at: &[usize], guess: &[Vec<f64>]) -> Keyframes {
        let mut nodes = vec![guess[0].clone()];
        for k in 0..phases.len() {
            let times = if at.contains(&k) { 3 } else { 1 };
            nodes.extend(vec![guess[k + 1].clone(); times]);
        }
        self.solve_with(phases, at, &nodes)
    }

    /// The same from a guess with the nodes of the added phases.
    fn solve_with(&self, phases: &[Phase], at: &[usize], guess: &[Vec<f64>]) -> Keyframes {
        let is_foot = |c: &Contact| self.scene.interfaces[c.a.0].role == Role::Foot;
        let mut longer = vec![];
        for (k, phase) in phases.iter().enumerate() {
            longer.push(phase.clone());
            if at.contains(&k) {
                // Geometry does not ask what holds the robot meanwhile.
                let without = phase.state.iter().filter(|c| !is_foot(c)).collect();
                longer.extend([self.phase(without), phase.clone()]);
            }
        }
        self.planner
            .keyframes_near(guess, &longer, self.settings, true)
    }
}

/// A guess with feet set anew in the n-th of some states only, from keyframes with that in `all` of them: before it as in `guess`,
/// which has none, after it as if nothing happened in the others.
fn anew_in_one(guess: &[Vec<f64>], all: &[Vec<f64>], stances: &[usize], n: usize) -> Vec<Vec<f64>> {
    let at = stances[n];
    let before = guess[..=at].iter();
    let around = all[at + 1 + 2 * n..at + 4 + 2 * n].iter();
    let after = (at + 2..guess.len()).map(|k| {
        let earlier = stances.iter().filter(|&&s| s < k).count();
        &all[k + 2 * earlier]
    });
    before.chain(around).chain(after).cloned().collect()
}
