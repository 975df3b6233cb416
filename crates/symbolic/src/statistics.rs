//! How many states and transitions each pruning rule leaves (paper, "Symbolic search pruning").

use std::collections::{BTreeSet, VecDeque};
use std::fmt;

use crate::contact::{Contact, ContactState, InterfaceId};
use crate::contact_rules::{RULES, all_triples};
use crate::domain::Domain;
use crate::graph::{Node, SkeletonGraph};
use crate::state_rules::{both_sides, two_partners};
use crate::transition_rules::{partner_change, side_swap};

/// Most combinations of objects' contacts whose pairs are visited one by one.
const LAYOUT_LIMIT: usize = 3000;

/// A number that may be too large to write down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Count {
    /// The number, if it has at most 38 digits.
    pub exact: Option<u128>,
    /// Its decimal logarithm; −∞ for zero.
    pub log10: f64,
}

impl Count {
    fn of(number: u128) -> Self {
        Self {
            exact: Some(number),
            log10: (number as f64).log10(),
        }
    }

    fn product(factors: impl Iterator<Item = usize>) -> Self {
        factors.fold(Self::of(1), |product, factor| {
            product.times(Self::of(factor as u128))
        })
    }

    fn times(self, other: Self) -> Self {
        let exact = self
            .exact
            .zip(other.exact)
            .and_then(|(a, b)| a.checked_mul(b));
        Self {
            exact,
            log10: self.log10 + other.log10,
        }
    }

    /// n (n − 1): pairs of different states.
    fn ordered_pairs(self) -> Self {
        match self.exact {
            Some(n) => n
                .checked_mul(n.saturating_sub(1))
                .map_or(self.times(self), Self::of),
            None => self.times(self),
        }
    }
}

impl fmt::Display for Count {
    /// The number itself up to twelve digits, otherwise a power of ten.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.exact {
            Some(n) if n < 1_000_000_000_000 => write!(f, "{n}"),
            _ => write!(f, "10^{:.1}", self.log10),
        }
    }
}

/// What one rule leaves.
#[derive(Debug, Clone, PartialEq)]
pub struct RuleCount {
    /// The rule in words.
    pub rule: &'static str,
    /// Triples (i, j, θ) that can still occur.
    pub contacts: usize,
    /// States that are left; `None` if they are too many to count.
    pub states: Option<Count>,
    /// Pairs of states that may follow each other; `None` if they are too many to count.
    pub transitions: Option<Count>,
}

/// Applies the rules one after another and counts what is left; the first entry is before any rule.
pub fn count_by_rule(domain: &Domain) -> Vec<RuleCount> {
    let interfaces = domain.interfaces();
    let mut triples: Vec<Contact> = all_triples(interfaces.len()).collect();
    let states = count_pair_choices(&triples);
    let mut counts = vec![entry(
        "all sets of (i, j, θ), all pairs of them",
        &triples,
        states,
        states.times(states),
    )];
    for (name, rule) in RULES {
        triples.retain(|contact| !rule(interfaces, contact));
        let states = count_pair_choices(&triples);
        counts.push(entry(name, &triples, states, states.times(states)));
    }
    let states = Count::product(domain.ids().map(|a| 1 + domain.landings(a).len()));
    counts.push(entry(
        "a landing side has one partner and one type",
        &triples,
        states,
        states.times(states),
    ));

    let layouts = object_layouts(domain);
    let states = layouts
        .as_ref()
        .map(|layouts| count_states(domain, layouts));
    let legal = layouts
        .as_ref()
        .filter(|layouts| layouts.len() <= LAYOUT_LIMIT);
    let transitions = legal.map(|layouts| count_transitions(domain, layouts));
    let rest = [
        (
            "a surface lies on something or is touched, not both",
            states.map(|s| s.times(s)),
        ),
        (
            "an action changes the state",
            states.map(Count::ordered_pairs),
        ),
        (
            "a landing side changes partner, type or side only through a free state",
            transitions,
        ),
    ];
    let contacts = triples.len();
    counts.extend(rest.map(|(rule, transitions)| RuleCount {
        rule,
        contacts,
        states,
        transitions,
    }));
    counts
}

fn entry(rule: &'static str, triples: &[Contact], states: Count, transitions: Count) -> RuleCount {
    RuleCount {
        rule,
        contacts: triples.len(),
        states: Some(states),
        transitions: Some(transitions),
    }
}

/// Every ordered pair has one of its types or none. The triples are ordered by pair.
fn count_pair_choices(triples: &[Contact]) -> Count {
    Count::product(
        triples
            .chunk_by(|x, y| (x.a, x.b) == (y.a, y.b))
            .map(|types| 1 + types.len()),
    )
}

/// All legal combinations of contacts between objects and supports; `None` if they exceed a million.
fn object_layouts(domain: &Domain) -> Option<Vec<ContactState>> {
    let mut layouts = vec![ContactState::default()];
    for side in domain.ids().filter(|&i| domain.object_of(i).is_some()) {
        let with = |layout: &ContactState, contact: &Contact| {
            let mut layout = layout.clone();
            layout.contacts.insert(*contact);
            layout
        };
        let more: Vec<ContactState> = layouts
            .iter()
            .flat_map(|layout| {
                domain
                    .landings(side)
                    .iter()
                    .map(|contact| with(layout, contact))
            })
            .collect();
        layouts.extend(more);
        if layouts.len() > 1_000_000 {
            return None;
        }
    }
    layouts.retain(|layout| two_partners(layout).is_none() && both_sides(layout).is_none());
    Some(layouts)
}

/// Surfaces that rest on something, so that the robot cannot touch them.
fn covered(layout: &ContactState) -> BTreeSet<InterfaceId> {
    layout.iter().map(|contact| contact.a).collect()
}

/// Given what the objects do, every robot interface is free or touches one surface that is not covered.
fn count_states(domain: &Domain, layouts: &[ContactState]) -> Count {
    let of_layout = |layout: &ContactState| {
        let covered = covered(layout);
        let choices = |i| {
            domain
                .landings(i)
                .iter()
                .filter(|c| !covered.contains(&c.b))
                .count()
        };
        Count::product(domain.effectors().map(|i| 1 + choices(i)))
    };
    sum(layouts.iter().map(of_layout))
}

/// Pairs of states that pass every rule: a robot interface stays as it is, breaks or makes contact.
fn count_transitions(domain: &Domain, layouts: &[ContactState]) -> Count {
    let covers: Vec<BTreeSet<InterfaceId>> = layouts.iter().map(covered).collect();
    let of_pair = |from: usize, to: usize| {
        let choices = |i| {
            let open = |n: usize, c: &Contact| usize::from(!covers[n].contains(&c.b));
            domain
                .landings(i)
                .iter()
                .map(|c| open(from, c) + open(to, c) + open(from, c) * open(to, c))
                .sum::<usize>()
        };
        Count::product(domain.effectors().map(|i| 1 + choices(i)))
    };
    let pairs = (0..layouts.len()).flat_map(|from| (0..layouts.len()).map(move |to| (from, to)));
    let legal = |&(from, to): &(usize, usize)| {
        partner_change(&layouts[from], &layouts[to]).is_none()
            && side_swap(&layouts[from], &layouts[to]).is_none()
    };
    let all = sum(pairs.filter(legal).map(|(from, to)| of_pair(from, to)));
    let unchanged = count_states(domain, layouts).exact;
    match all.exact.zip(unchanged) {
        Some((all, unchanged)) => Count::of(all - unchanged),
        None => all,
    }
}

fn sum(counts: impl Iterator<Item = Count>) -> Count {
    counts.fold(Count::of(0), |sum, count| {
        if let Some(exact) = sum
            .exact
            .zip(count.exact)
            .and_then(|(a, b)| a.checked_add(b))
        {
            return Count::of(exact);
        }
        let (low, high) = (sum.log10.min(count.log10), sum.log10.max(count.log10));
        Count {
            exact: None,
            log10: high + 10_f64.powf(low - high).ln_1p() / std::f64::consts::LN_10,
        }
    })
}

/// What the skeletons leave.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SkeletonCount {
    /// Manipulation states on some way to the goal within N actions.
    pub positions: usize,
    /// Contact states that are within reach along skeletons.
    pub states: usize,
    /// Actions between them.
    pub transitions: usize,
}

/// Counts what is within reach from the start along skeletons, up to `limit` states; `None` if there are more.
///
/// Which positions a particular skeleton has visited before is not looked at, nor the number of phases.
pub fn count_skeleton_graph(graph: &mut SkeletonGraph, limit: usize) -> Option<SkeletonCount> {
    let useful = |graph: &SkeletonGraph, node: Node| {
        graph
            .skeletons()
            .may_reach_goal(node.position, graph.skeletons().depth(node.position))
    };
    let mut count = SkeletonCount {
        positions: 0,
        states: 0,
        transitions: 0,
    };
    let mut seen = BTreeSet::from([graph.root()]);
    let mut queue: VecDeque<Node> = seen
        .iter()
        .copied()
        .filter(|&node| useful(graph, node))
        .collect();
    let mut positions = BTreeSet::new();
    while let Some(node) = queue.pop_front() {
        count.states += 1;
        positions.insert(node.position);
        for edge in graph.successors(node) {
            if !useful(graph, edge.node) {
                continue;
            }
            count.transitions += 1;
            if seen.insert(edge.node) {
                queue.push_back(edge.node);
            }
        }
        if seen.len() > limit {
            return None;
        }
    }
    count.positions = positions.len();
    Some(count)
}
