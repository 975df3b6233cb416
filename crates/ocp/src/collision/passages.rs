//! Bodies that are deeper in one another on the way between two nodes than at them, and rows that keep them apart there.

use std::collections::{BTreeMap, BTreeSet};

use super::pairs::{BLUR, Pair, Place, Says};
use super::shared::Shared;
use super::{CollisionModel, Other, Touch};
use crate::program::{Phase, Program};
use multibody::Kinematics;
use scene::Scene;
use solver::threads;

/// Shares of the way between two nodes at which bodies are looked at.
const SHARES: [f64; 3] = [0.25, 0.5, 0.75];
/// The one of them for a short way.
const HALF_WAY: [f64; 1] = [0.5];
/// Longest way of a joint that counts as short [rad]: a hand moves by some centimetres.
const SHORT: f64 = 0.1;
/// By how much deeper than at the nodes bodies may be in one another [m].
const TOLERANCE: f64 = 0.002;
/// Clearance that is demanded on the way, if rows say as much at both nodes [m].
const CLEARANCE: f64 = 0.002;

/// Two bodies that are in one another on the way between two nodes.
#[derive(Debug, Clone, Copy)]
pub struct Crossing {
    /// Share of the way.
    pub share: f64,
    /// How deep they are in one another at the nodes, at most [m].
    pub at_nodes: f64,
    /// By how much deeper on the way [m].
    pub depth: f64,
}

/// Interval, joint of the first body, and the second one.
pub type Way = (usize, usize, Other);

/// What rounds of solving have found so far, so that rows that mend it stay.
#[derive(Debug, Default)]
pub struct Crossings {
    /// Crossings by interval, joint of the first body, and the second one.
    pub ways: BTreeMap<Way, Vec<Crossing>>,
    /// Configurations per node of earlier rounds. An edge that goes through a face in one of them may do so again if nothing
    /// keeps it out.
    pub earlier: Vec<Vec<Vec<f64>>>,
}

impl Crossings {
    /// None.
    pub fn new() -> Self {
        Self::default()
    }
}

impl CollisionModel {
    /// Adds to `known` where bodies are deeper in one another, by more than 2 mm, on the way between neighbouring nodes than
    /// at them; true if there is such a place. Bodies that touch at one of the nodes alone, where they part or meet, are no
    /// exception: what lands comes from outside.
    pub fn find_crossings(
        &self,
        program: &Program,
        scene: &Scene,
        phases: &[Phase],
        nodes: &[Vec<f64>],
        known: &mut Crossings,
    ) -> bool {
        let intervals: Vec<_> = (0..program.n_intervals())
            .filter(|&t| program.moves(t))
            .collect();
        let size = intervals.len().div_ceil(program.settings.threads.max(1));
        let chunks = intervals.chunks(size.max(1));
        let mut found: Vec<_> = chunks.map(|part| (part, vec![])).collect();
        threads::each(found.iter_mut(), |(part, found)| {
            let mut kinematics = Kinematics::new(&program.system.model);
            for &t in *part {
                let touching = |t: usize| Self::touching(scene, program, phases, t);
                let both = &touching(t) & &touching(t + 1);
                found.extend(self.deepest_on_way(program, (t, nodes), &both, &mut kinematics));
            }
        });
        let mut any = false;
        for (pair, crossing) in found.into_iter().flat_map(|(_, found)| found) {
            any = true;
            let known = known.ways.entry(pair).or_default();
            if known.iter().all(|c| c.share != crossing.share) {
                known.push(crossing);
            }
        }
        any
    }

    /// The deepest crossing of each pair, of those that touch at both nodes none, on the way from node `t` to the next one.
    fn deepest_on_way(
        &self,
        program: &Program,
        (t, nodes): (usize, &[Vec<f64>]),
        touching: &BTreeSet<Touch>,
        kinematics: &mut Kinematics,
    ) -> impl Iterator<Item = (Way, Crossing)> + use<> {
        let model = &program.system.model;
        let mut overlaps = |q: &[f64]| {
            kinematics.update(model, q);
            let mut found = BTreeMap::new();
            self.overlaps(
                kinematics,
                &|a, b| touching.contains(&(a, b)),
                &mut |depth, a, other| {
                    let deepest = found.entry((a, other)).or_insert(f64::NEG_INFINITY);
                    *deepest = depth.max(*deepest);
                },
            );
            found
        };
        let way = model.difference(&nodes[t], &nodes[t + 1]);
        let mut joints = program.system.actuated();
        let short = joints.all(|joint| way[joint.idx_v].abs() < SHORT);
        let mut ends = None;
        let mut deepest = BTreeMap::new();
        for &share in if short { &HALF_WAY[..] } else { &SHARES } {
            let part: Vec<f64> = way.iter().map(|d| share * d).collect();
            let here = overlaps(&model.integrate(&nodes[t], &part));
            for (&(a, other), &depth) in here.iter().filter(|(_, depth)| **depth > TOLERANCE) {
                let ends = ends.get_or_insert_with(|| [t, t + 1].map(|i| overlaps(&nodes[i])));
                // At the nodes rows say how deep bodies that just touched may be in one another.
                let at_ends = ends.iter().filter_map(|end| end.get(&(a, other)));
                let at_nodes = at_ends.fold(0.0, |most: f64, &end| most.max(end));
                let crossing = Crossing {
                    share,
                    at_nodes,
                    depth: depth - at_nodes,
                };
                let most = deepest.entry((t, a, other)).or_insert(crossing);
                if crossing.depth > most.depth {
                    *most = crossing;
                }
            }
        }
        deepest.into_iter().filter(|(_, c)| c.depth > TOLERANCE)
    }

    /// Rows where bodies cross on the way between nodes.
    pub(super) fn crossing_pairs(
        &self,
        program: &Program,
        (nodes, kinematics): (&[Vec<f64>], &[Kinematics]),
        crossings: &Crossings,
        shared: &mut Shared,
        out: &mut Vec<Pair>,
    ) {
        let model = &program.system.model;
        let mut here = Kinematics::new(model);
        for (&(t, a, other), crossings) in &crossings.ways {
            let way = model.difference(&nodes[t], &nodes[t + 1]);
            for crossing in crossings {
                let share = crossing.share;
                let part: Vec<f64> = way.iter().map(|d| share * d).collect();
                here.update(model, &model.integrate(&nodes[t], &part));
                // What a row says may be less than the distance, but not by more than at a place where few balls are near.
                let demanded = |says: Says<'_>| {
                    let ends = kinematics[t..=t + 1].iter().map(|end| says(end).row);
                    ends.fold(CLEARANCE, f64::min)
                        .max(-crossing.at_nodes - says(&here).less.min(BLUR))
                };
                let place = Place::Way { interval: t, share };
                let window = [&here];
                for index in 0..self.primitives.len() {
                    if self.primitives[index].is_of(other) {
                        let rows = (a, index, &window[..], &window[..]);
                        let boxes = self.own(a).chain(&self.link_boxes[a]);
                        self.obstacle_rows(rows, boxes, &demanded, shared, &mut |b, term| {
                            out.push(Pair { place, a, b, term });
                        });
                    }
                }
                let links = self.self_pairs.iter().enumerate();
                for (index, pair) in links.filter(|(_, p)| p.a == a && Ok(p.b) == other) {
                    let row = pair.row(index, &window, &demanded, shared);
                    out.extend(row.map(|term| Pair {
                        place,
                        a,
                        b: Some(pair.b),
                        term,
                    }));
                }
            }
        }
    }
}
