//! Why a search found not even a motion that misses something: what would make refused contacts possible, and an explanation of a simple
//! sequence.
//!
//! Searches refuse contacts and beginnings before there is a whole sequence, each with a reason of its own. What resists is plainer in one
//! sequence from start to goal: of the cheapest ones for the symbolic search, whatever was refused, the first one
//! whose keyframes miss about the least.

use super::Run;
use super::workers::Shop;
use crate::api::{Event, Explained, Possible, Request};
use crate::explain::{Case, Failed, explain, remedy_of_contacts};
use crate::{domain, weight};
use ocp::Keyframes;
use scene::{Owner, Scene};
use std::time::Instant;
use symbolic::{BestFirst, ContactState, InterfaceId, Oracle, Policy, Sequence, Verdict};

/// Time that the explanation may take, in that of the search, and the least and most of it [s].
const SHARE: f64 = 0.25;
const LEAST: f64 = 5.0;
const MOST: f64 = 30.0;
/// Part of it for finding the sequence.
const CHOOSING: f64 = 0.3;
/// Sequences to choose from.
const CHOICE: usize = 30;
/// Share of the violation of a cheaper sequence that a dearer one must come below.
const MUCH_LESS: f64 = 0.8;

impl Run<'_> {
    /// Why there is no plan, if that is asked for and nobody has ended it: beside refused contacts a simple sequence, unless there is a
    /// motion that misses something.
    pub fn why(&mut self, ended: bool, has_motion: bool) -> (Vec<Possible>, Option<Explained>) {
        if ended || !self.request.explain {
            return (vec![], None);
        }
        let possible = self.possible();
        let explained = if has_motion { None } else { self.explain() };
        (possible, explained)
    }

    /// What would make contacts possible that exclude one another, where one number can say it; of several contacts that need the same
    /// number changed, those that need it least. What is not asked within [`LEAST`] is left out.
    fn possible(&self) -> Vec<Possible> {
        let Shop {
            planner, settings, ..
        } = self.shop;
        let begin = Instant::now();
        let in_time = |_: &&ContactState| {
            begin.elapsed().as_secs_f64() < LEAST && !self.request.stop.is_set()
        };
        let cores = self.checks.cores().take_while(in_time);
        let remedied = cores.filter_map(|contacts| {
            let remedy = remedy_of_contacts(planner.scene, settings, contacts)?;
            let contacts = self.checks.names(contacts);
            Some(Possible { contacts, remedy })
        });
        let mut told: Vec<Possible> = vec![];
        for found in remedied {
            let change = |p: &Possible| (p.remedy.to - p.remedy.from).abs();
            let of = |p: &Possible| (p.remedy.of.clone(), p.remedy.key.clone());
            match told.iter_mut().find(|known| of(known) == of(&found)) {
                Some(known) if change(&found) < change(known) => *known = found,
                Some(_) => {}
                None => told.push(found),
            }
        }
        told
    }

    /// Explains a simple sequence, if there is one that lifts what the goal speaks of.
    fn explain(&mut self) -> Option<Explained> {
        let begin = Instant::now();
        let seconds = self.shop.begin.elapsed().as_secs_f64();
        let request = Request {
            time_limit: (SHARE * seconds).clamp(LEAST, MOST),
            ..self.request.clone()
        };
        let (sequence, keyframes) = self.nearest_sequence(begin, CHOOSING * request.time_limit)?;
        let phases = self.phases(&sequence);
        let case = Case {
            scene: self.shop.planner.scene,
            phases: &phases,
            labels: &sequence.labels,
            request: &request,
            is_quick: true,
            falls_short: false,
            failed: Failed::Keyframes(&keyframes),
        };
        let stop = &self.request.stop;
        let observe = &mut self.observe;
        let mut observe = |event: &Event| observe(event) && !stop.is_set();
        let explanation = explain(&case, begin, &mut observe);
        Some(Explained {
            labels: sequence.labels,
            explanation,
        })
    }

    /// The sequence whose keyframes miss least among those that cost least, after at most so many seconds.
    fn nearest_sequence(&self, begin: Instant, seconds: f64) -> Option<(Sequence, Keyframes)> {
        let Shop {
            planner, settings, ..
        } = self.shop;
        let scene = planner.scene;
        let domain::Skeletons { graph, limits, .. } = domain::skeletons(scene).ok()?;
        let mut policy = BestFirst::new(graph, &limits, domain::costs(scene));
        let is_late = || begin.elapsed().as_secs_f64() > seconds || self.request.stop.is_set();
        let mut oracle = Statics {
            scene,
            is_late: &is_late,
        };
        let drawn = std::iter::from_fn(|| policy.next(&mut oracle));
        let lifting = drawn.filter(|sequence| lifts(scene, sequence)).take(CHOICE);
        let mut nearest: Option<(Sequence, Keyframes)> = None;
        for sequence in lifting {
            let found = planner.keyframes(&self.phases(&sequence), settings);
            let less = |known: &(Sequence, Keyframes)| {
                found.report.violation < MUCH_LESS * known.1.report.violation
            };
            if !found.possible && nearest.as_ref().is_none_or(less) {
                nearest = Some((sequence, found));
            }
            if is_late() {
                break;
            }
        }
        nearest
    }
}

/// Refuses lifts by contacts that bear less than the object weighs, and nothing else.
struct Statics<'a> {
    scene: &'a Scene,
    is_late: &'a dyn Fn() -> bool,
}

impl Oracle for Statics<'_> {
    fn transition(&mut self, from: &ContactState, to: &ContactState) -> Verdict {
        match weight::fault(self.scene, from, to) {
            Some(found) => Verdict::Reject(found.reason),
            None => Verdict::Accept,
        }
    }

    fn stop(&mut self) -> bool {
        (self.is_late)()
    }
}

/// True if every object of the goal stands on nothing in some phase.
fn lifts(scene: &Scene, sequence: &Sequence) -> bool {
    let owner = |i: InterfaceId| scene.interfaces[i.0].owner;
    let is_meant = |o: &usize| {
        let name = &scene.objects[*o].name;
        let mut goals = scene.goal_contacts.iter();
        let mut regions = scene.goal_regions.iter();
        goals.any(|goal| owner(goal.a) == Owner::Object(*o)) || regions.any(|r| r.body == *name)
    };
    let is_lifted = |o: usize| {
        let mut states = sequence.states.iter();
        states.any(|state| {
            state
                .contacts
                .iter()
                .all(|c| owner(c.a) != Owner::Object(o))
        })
    };
    let mut meant = (0..scene.objects.len()).filter(is_meant);
    meant.all(is_lifted)
}

#[cfg(test)]
mod tests {
    use super::*;
    use symbolic::Contact;

    #[test]
    fn what_the_goal_speaks_of_is_lifted_where_it_stands_on_nothing() {
        let scene = Scene::builtin("lift-box").expect("a scene");
        let start: ContactState = scene.start_contacts.iter().copied().collect();
        let of_robot = |c: &&Contact| !matches!(scene.interfaces[c.a.0].owner, Owner::Object(_));
        let standing = scene.start_contacts.iter().filter(of_robot);
        let lifted: ContactState = standing.copied().collect();
        let sequence = |states: &[&ContactState]| Sequence {
            states: states.iter().map(|&state| state.clone()).collect(),
            labels: vec![],
            skeleton: vec![],
            cost: 0.0,
        };
        assert!(!lifts(&scene, &sequence(&[&start, &start])));
        assert!(lifts(&scene, &sequence(&[&start, &lifted, &start])));
    }
}
