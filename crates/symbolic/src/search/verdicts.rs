//! What the oracle has said: remembered verdicts and the reasons of rejections.

use std::collections::{BTreeMap, BTreeSet};

use crate::contact::{Contact, ContactState};
use crate::graph::{Node, SkeletonGraph, StateId};
use crate::search::oracle::{Oracle, Verdict};
use crate::task_graph::TaskState;

/// What was rejected.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rejected {
    /// A contact state, wherever it occurs.
    State(ContactState),
    /// Every contact state that contains these contacts.
    Contacts(ContactState),
    /// Every contact state that contains these contacts while none of these objects has been moved.
    Unmoved(ContactState, Vec<usize>),
    /// A transition, wherever it occurs.
    Transition(ContactState, ContactState),
    /// Every sequence that begins with these states, or is equal to them.
    Prefix(Vec<ContactState>),
}

/// A rejection with its reason.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rejection {
    /// What was rejected.
    pub what: Rejected,
    /// Why, in words.
    pub reason: String,
}

/// Counts of a search.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Beginnings of sequences that were created.
    pub created: usize,
    /// Beginnings that were judged.
    pub judged: usize,
    /// Beginnings dropped because of their last state.
    pub dropped_by_state: usize,
    /// Beginnings dropped because of their last transition.
    pub dropped_by_transition: usize,
    /// Beginnings dropped as a whole.
    pub dropped_by_prefix: usize,
    /// Sequences returned.
    pub returned: usize,
}

/// Verdicts by content.
#[derive(Debug, Clone, Default)]
pub(crate) struct Verdicts {
    states: BTreeMap<StateId, bool>,
    rejected_contacts: Vec<ContactState>,
    /// Per state and objects that have not been moved.
    unmoved: BTreeMap<(StateId, Vec<usize>), bool>,
    /// Contacts that exclude one another while these objects have not been moved.
    rejected_unmoved: Vec<(ContactState, Vec<usize>)>,
    transitions: BTreeMap<(StateId, StateId), bool>,
    rejected_prefixes: BTreeSet<Vec<StateId>>,
    accepted_prefixes: Option<BTreeSet<Vec<StateId>>>,
    rejections: Vec<Rejection>,
    /// For so many rejected sets of contacts: is a skeleton left.
    skeletons: Option<(usize, bool)>,
    /// Grows when a rejection concerns what may have been accepted before.
    pub(crate) revision: u32,
    pub(crate) counts: Counts,
}

impl Verdicts {
    /// Verdicts that also remember accepted prefixes, for searches that come across the same one again.
    pub(crate) fn remembering_accepted() -> Self {
        Self {
            accepted_prefixes: Some(BTreeSet::new()),
            ..Self::default()
        }
    }

    pub(crate) fn rejections(&self) -> &[Rejection] {
        &self.rejections
    }

    /// Judges the last state, the last transition and the whole of a path from the start whose beginning is accepted.
    pub(crate) fn accepts(
        &mut self,
        graph: &SkeletonGraph,
        path: &[StateId],
        oracle: &mut dyn Oracle,
    ) -> bool {
        let Some(&last) = path.last() else {
            return true;
        };
        self.counts.judged += 1;
        if !self.accepts_state(graph, last, oracle)
            || !self.accepts_unmoved(graph, last, &unmoved(graph, path), oracle)
        {
            self.counts.dropped_by_state += 1;
            return false;
        }
        if let [.., before, last] = path
            && !self.accepts_transition(graph, *before, *last, oracle)
        {
            self.counts.dropped_by_transition += 1;
            return false;
        }
        let accepted = self.accepts_prefix(graph, path, oracle);
        self.counts.dropped_by_prefix += usize::from(!accepted);
        accepted
    }

    pub(crate) fn accepts_state(
        &mut self,
        graph: &SkeletonGraph,
        id: StateId,
        oracle: &mut dyn Oracle,
    ) -> bool {
        if let Some(&known) = self.states.get(&id) {
            return known;
        }
        let state = graph.state(id);
        let known_reason = self
            .rejected_contacts
            .iter()
            .any(|contacts| contacts.is_subset(state));
        let accepted = !known_reason
            && self.note(graph, oracle.state(state), || {
                Rejected::State(state.clone())
            });
        self.states.insert(id, accepted);
        accepted
    }

    /// Judges a state in which objects are still where they are at the start.
    fn accepts_unmoved(
        &mut self,
        graph: &SkeletonGraph,
        id: StateId,
        objects: &[usize],
        oracle: &mut dyn Oracle,
    ) -> bool {
        if objects.is_empty() {
            return true;
        }
        let key = (id, objects.to_vec());
        if let Some(&known) = self.unmoved.get(&key) {
            return known;
        }
        let state = graph.state(id);
        let accepted = !self.is_rejected_unmoved(state, objects)
            && match oracle.unmoved(state, objects) {
                Verdict::Accept => true,
                Verdict::Reject(reason) => {
                    self.reject_unmoved(state.clone(), objects, reason);
                    false
                }
                Verdict::RejectContacts(contacts, reason) => {
                    self.reject_unmoved(contacts, objects, reason);
                    false
                }
            };
        self.unmoved.insert(key, accepted);
        accepted
    }

    fn is_rejected_unmoved(&self, state: &ContactState, objects: &[usize]) -> bool {
        self.rejected_unmoved.iter().any(|(contacts, unmoved)| {
            contacts.is_subset(state) && unmoved.iter().all(|o| objects.contains(o))
        })
    }

    fn reject_unmoved(&mut self, contacts: ContactState, objects: &[usize], reason: String) {
        self.rejections.push(Rejection {
            what: Rejected::Unmoved(contacts.clone(), objects.to_vec()),
            reason,
        });
        self.rejected_unmoved.push((contacts, objects.to_vec()));
    }

    /// Judges two nodes, the first of which is accepted, and the transition between them.
    pub(crate) fn accepts_step(
        &mut self,
        graph: &SkeletonGraph,
        from: Node,
        to: Node,
        oracle: &mut dyn Oracle,
    ) -> bool {
        self.accepts_state(graph, to.state, oracle)
            && self.accepts_unmoved(graph, to.state, graph.unmoved(to.position), oracle)
            && self.accepts_transition(graph, from.state, to.state, oracle)
    }

    /// True if nothing is known against a node.
    pub(crate) fn is_open(&self, graph: &SkeletonGraph, node: Node) -> bool {
        let state = graph.state(node.state);
        self.states.get(&node.state) != Some(&false)
            && !self.rejected_contacts.iter().any(|c| c.is_subset(state))
            && !self.is_rejected_unmoved(state, graph.unmoved(node.position))
    }

    /// True if some skeleton needs no contacts that were rejected wherever they occur.
    pub(crate) fn leaves_a_skeleton(&mut self, graph: &SkeletonGraph) -> bool {
        let known = self.rejected_contacts.len() + self.rejected_unmoved.len();
        if known == 0 {
            return true;
        }
        if let Some((_, left)) = self.skeletons.filter(|skeletons| skeletons.0 == known) {
            return left;
        }
        let open = |position: TaskState| {
            let imposed = graph.imposed(position);
            let rejected = |contacts: &ContactState| contacts.is_subset(imposed);
            !self.rejected_contacts.iter().any(rejected)
                && !self.is_rejected_unmoved(imposed, graph.unmoved(position))
        };
        let tasks = graph.skeletons();
        let (mut seen, mut left) = (BTreeSet::from([TaskState(0)]), vec![TaskState(0)]);
        let mut found = false;
        while let Some(position) = left.pop() {
            found |= tasks.distance(position) == Some(0);
            for edge in tasks.edges(position) {
                if open(edge.to) && seen.insert(edge.to) {
                    left.push(edge.to);
                }
            }
        }
        self.skeletons = Some((known, found));
        found
    }

    /// True if a transition was rejected.
    pub(crate) fn is_barred(&self, from: StateId, to: StateId) -> bool {
        self.transitions.get(&(from, to)) == Some(&false)
    }

    /// True if a beginning was rejected as a whole.
    pub(crate) fn is_rejected_as_beginning(&self, path: &[StateId]) -> bool {
        self.rejected_prefixes.contains(path)
    }

    pub(crate) fn accepts_transition(
        &mut self,
        graph: &SkeletonGraph,
        from: StateId,
        to: StateId,
        oracle: &mut dyn Oracle,
    ) -> bool {
        if let Some(&known) = self.transitions.get(&(from, to)) {
            return known;
        }
        let (one, two) = (graph.state(from), graph.state(to));
        let accepted = self.note(graph, oracle.transition(one, two), || {
            Rejected::Transition(one.clone(), two.clone())
        });
        self.transitions.insert((from, to), accepted);
        accepted
    }

    pub(crate) fn accepts_prefix(
        &mut self,
        graph: &SkeletonGraph,
        path: &[StateId],
        oracle: &mut dyn Oracle,
    ) -> bool {
        if self.rejected_prefixes.contains(path) {
            return false;
        }
        if self
            .accepted_prefixes
            .as_ref()
            .is_some_and(|known| known.contains(path))
        {
            return true;
        }
        let states: Vec<&ContactState> = path.iter().map(|&id| graph.state(id)).collect();
        let verdict = oracle.prefix(&states);
        let accepted = self.note(graph, verdict, || {
            Rejected::Prefix(states.iter().map(|&state| state.clone()).collect())
        });
        if !accepted {
            self.rejected_prefixes.insert(path.to_vec());
        } else if let Some(known) = &mut self.accepted_prefixes {
            known.insert(path.to_vec());
        }
        accepted
    }

    /// Remembers a rejection; `what` is the thing in question.
    fn note(
        &mut self,
        graph: &SkeletonGraph,
        verdict: Verdict,
        what: impl FnOnce() -> Rejected,
    ) -> bool {
        let (what, reason) = match verdict {
            Verdict::Accept => return true,
            Verdict::Reject(reason) => (what(), reason),
            Verdict::RejectContacts(contacts, reason) => {
                self.reject_contacts(graph, &contacts);
                (Rejected::Contacts(contacts), reason)
            }
        };
        self.rejections.push(Rejection { what, reason });
        false
    }

    fn reject_contacts(&mut self, graph: &SkeletonGraph, contacts: &ContactState) {
        for (id, accepted) in &mut self.states {
            *accepted = *accepted && !contacts.is_subset(graph.state(*id));
        }
        self.rejected_contacts.push(contacts.clone());
        self.revision += 1;
    }

    /// Takes a rejection from outside the oracle.
    pub(crate) fn reject(&mut self, graph: &mut SkeletonGraph, rejection: Rejection) {
        match &rejection.what {
            Rejected::State(state) => {
                self.states.insert(graph.intern(state), false);
            }
            Rejected::Contacts(contacts) => self.reject_contacts(graph, contacts),
            Rejected::Unmoved(contacts, objects) => {
                let all = (contacts.clone(), objects.clone());
                self.rejected_unmoved.push(all);
            }
            Rejected::Transition(from, to) => {
                self.transitions
                    .insert((graph.intern(from), graph.intern(to)), false);
            }
            Rejected::Prefix(states) => {
                let path = states.iter().map(|state| graph.intern(state)).collect();
                self.rejected_prefixes.insert(path);
            }
        }
        self.revision += 1;
        self.rejections.push(rejection);
    }

    /// True if nothing on the path has been rejected meanwhile.
    pub(crate) fn is_alive(&self, path: &[StateId]) -> bool {
        let transition =
            |pair: &[StateId]| self.transitions.get(&(pair[0], pair[1])) != Some(&false);
        path.iter().all(|id| self.states.get(id) != Some(&false))
            && path.windows(2).all(transition)
            && (1..=path.len()).all(|n| !self.rejected_prefixes.contains(&path[..n]))
    }
}

/// Objects that rest, all along a path, on what they rest on at first, which has not been moved either.
fn unmoved(graph: &SkeletonGraph, path: &[StateId]) -> Vec<usize> {
    let domain = graph.domain();
    let Some(&first) = path.first() else {
        return vec![];
    };
    let rests = |state: &ContactState, object: usize| -> Vec<Contact> {
        let of_object = |c: &Contact| domain.object_of(c.a) == Some(object);
        state.iter().filter(of_object).collect()
    };
    let objects = 0..domain.objects().len();
    let stays = |&object: &usize| {
        let at_first = rests(graph.state(first), object);
        let same = |&id: &StateId| rests(graph.state(id), object) == at_first;
        !at_first.is_empty() && path.iter().all(same)
    };
    let mut unmoved: Vec<usize> = objects.filter(stays).collect();
    loop {
        let on_others = |&object: &usize| {
            let below = rests(graph.state(first), object);
            let mut below = below.iter().filter_map(|c| domain.object_of(c.b));
            below.all(|object| unmoved.contains(&object))
        };
        let left: Vec<usize> = unmoved.iter().copied().filter(on_others).collect();
        if left.len() == unmoved.len() {
            return left;
        }
        unmoved = left;
    }
}
