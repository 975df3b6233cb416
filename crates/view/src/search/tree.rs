//! The tree of all beginnings of contact sequences that a search looked at.

use super::journal::{Journal, States};
use crate::compact::rounded;
use serde::Serialize;
use std::collections::BTreeMap;

/// A contact state after those of its ancestors.
#[derive(Debug, Default, Serialize)]
pub(crate) struct NodeData {
    pub parent: Option<usize>,
    /// What changes on entering it, as the planner calls it.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub label: String,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub gained: Vec<String>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub lost: Vec<String>,
    /// Complete sequences through it.
    #[serde(skip_serializing_if = "is_zero")]
    pub sequences: usize,
    /// Greatest reward of them.
    pub best: f64,
    /// How often the search went through it, when the last sequence through it was told; none outside its tree.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub visits: Option<u32>,
    /// Mean reward of these visits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// How far the best of them, or the beginning itself, got: `open`, `refused` (its own keyframes), `keyframes` (of a
    /// complete sequence), `alike` (left out, since others failed at the same contacts), `optimised`, `feasible`.
    pub reached: &'static str,
    /// Why not further, in the planner's words: index into the reasons of the tree.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<usize>,
    /// Least cost below.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cost: Option<f64>,
    /// Time of all answers about it and what is below [s].
    pub seconds: f64,
}

/// A complete sequence.
#[derive(Debug, Serialize)]
pub(crate) struct SequenceData {
    pub number: usize,
    /// Node of its last state.
    pub node: usize,
    pub at: f64,
    pub reached: &'static str,
    pub reason: Option<String>,
    pub cost: Option<f64>,
    pub violation: Option<f64>,
    pub failed_phase: Option<usize>,
    pub iterations: usize,
    pub seconds: f64,
    pub reward: f64,
    /// Index of its motion in the page.
    pub plan: Option<usize>,
}

/// Contacts that are impossible together.
#[derive(Debug, Serialize)]
pub(crate) struct RefusedData {
    pub contacts: Vec<String>,
    pub reason: String,
}

/// Everything that the journal says, as the page shows it.
#[derive(Debug, Default)]
pub(crate) struct Tree {
    pub nodes: Vec<NodeData>,
    /// Every reason once.
    pub reasons: Vec<String>,
    pub sequences: Vec<SequenceData>,
    pub refused: Vec<RefusedData>,
    pub asked: [[usize; 2]; 2],
}

/// In order of what was got to.
const STAGES: [&str; 6] = [
    "open",
    "refused",
    "keyframes",
    "alike",
    "optimised",
    "feasible",
];

/// Builds the tree.
pub(crate) fn build(journal: &Journal) -> Tree {
    let mut tree = Tree::default();
    let (mut known, mut reasons) = (BTreeMap::new(), Reasons::default());
    for answer in &journal.prefixes {
        let path = enter(&mut tree, &mut known, &answer.states);
        add_time(&mut tree, &path, answer.seconds);
        if let (false, Some(node)) = (answer.possible, path.last()) {
            tree.nodes[*node].reason = reasons.index(answer.reason.as_ref());
            tree.nodes[*node].reached = "refused";
        }
    }
    for tried in &journal.sequences {
        let path = enter(&mut tree, &mut known, &tried.states);
        add_time(&mut tree, &path, tried.seconds);
        let (reached, reason) = (stage(&tried.reached), reasons.index(tried.reason.as_ref()));
        for (k, node) in path.iter().enumerate() {
            let node = &mut tree.nodes[*node];
            node.sequences += 1;
            node.best = node.best.max(tried.reward);
            if let (Some(visits), Some(value)) = (tried.visits.get(k), tried.values.get(k)) {
                (node.visits, node.value) = (Some(*visits), Some(rounded(*value, 4)));
            }
            node.cost = [node.cost, tried.cost.filter(|_| reached == "feasible")]
                .into_iter()
                .flatten()
                .reduce(f64::min);
            if rank(reached) >= rank(node.reached) {
                node.reached = reached;
                node.reason = reason;
            }
            if let Some(label) = tried.labels.get(k) {
                node.label = label.replace('_', " ");
            }
        }
        tree.sequences.push(SequenceData {
            number: tried.number,
            node: path.last().copied().unwrap_or(0),
            at: rounded(tried.at, 2),
            reached,
            reason: tried.reason.clone(),
            cost: tried.cost,
            violation: tried.violation,
            failed_phase: tried.failed_phase,
            iterations: tried.iterations,
            seconds: rounded(tried.seconds, 3),
            reward: tried.reward,
            plan: None,
        });
    }
    for answer in journal.states.iter().filter(|answer| !answer.possible) {
        tree.refused.push(RefusedData {
            contacts: answer.states.concat(),
            reason: answer.reason.clone().unwrap_or_default(),
        });
    }
    tree.asked = [&journal.states, &journal.prefixes].map(|answers| {
        let refused = answers.iter().filter(|answer| !answer.possible).count();
        [answers.len(), refused]
    });
    tree.reasons = reasons.texts;
    for node in &mut tree.nodes {
        node.seconds = rounded(node.seconds, 3);
    }
    tree
}

/// Texts that occur often, each once.
#[derive(Default)]
struct Reasons {
    texts: Vec<String>,
    known: BTreeMap<String, usize>,
}

impl Reasons {
    fn index(&mut self, text: Option<&String>) -> Option<usize> {
        let text = text?;
        let index = *self.known.entry(text.clone()).or_insert(self.texts.len());
        if index == self.texts.len() {
            self.texts.push(text.clone());
        }
        Some(index)
    }
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde asks with a reference"
)]
fn is_zero(n: &usize) -> bool {
    *n == 0
}

fn stage(reached: &str) -> &'static str {
    STAGES
        .into_iter()
        .find(|stage| *stage == reached)
        .unwrap_or("open")
}

fn rank(stage: &str) -> usize {
    STAGES.iter().position(|x| *x == stage).unwrap_or(0)
}

fn add_time(tree: &mut Tree, path: &[usize], seconds: f64) {
    for node in path {
        tree.nodes[*node].seconds += seconds;
    }
}

type Known = BTreeMap<(Option<usize>, Vec<String>), usize>;

/// The nodes of all states of a sequence, new ones where it leaves what is known.
fn enter(tree: &mut Tree, known: &mut Known, states: &States) -> Vec<usize> {
    let mut path: Vec<usize> = Vec::new();
    for (k, state) in states.iter().enumerate() {
        let parent = path.last().copied();
        let mut content = state.clone();
        content.sort();
        let next = tree.nodes.len();
        let node = *known.entry((parent, content)).or_insert(next);
        if node == next {
            let before: &[String] = if k > 0 { &states[k - 1] } else { &[] };
            let missing = |from: &[String], those: &[String]| {
                let left = from.iter().filter(|x| !those.contains(x));
                left.map(|x| x.replace('_', " ")).collect::<Vec<_>>()
            };
            tree.nodes.push(NodeData {
                parent,
                gained: missing(state, before),
                lost: missing(before, state),
                reached: "open",
                ..NodeData::default()
            });
        }
        path.push(node);
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sequences_with_the_same_beginning_share_its_nodes_and_the_best_counts() {
        let text = r#"{"kind":"state","states":[["x on y","z on y"]],"possible":false,"reason":"too far","seconds":0.1}
{"kind":"prefix","states":[["a on b"],["c on d"]],"possible":false,"reason":"no configuration","seconds":1}
{"kind":"sequence","number":1,"at":2,"labels":["start","grasp"],"states":[["a on b"],["a on b","h on i"]],"reached":"optimised","reason":"friction","cost":9,"seconds":2,"reward":0.4,"visits":[1],"values":[0.4]}
{"kind":"sequence","number":2,"at":5,"labels":["start","grasp","lift"],"states":[["a on b"],["h on i","a on b"],["h on i"]],"reached":"feasible","cost":7,"seconds":3,"reward":0.9,"visits":[3,1],"values":[0.45,0.9]}
"#;
        let tree = build(&Journal::parse(text).unwrap());
        assert_eq!(tree.nodes.len(), 4);
        let [root, refused, grasp, lift] = [0, 1, 2, 3].map(|i| &tree.nodes[i]);
        assert_eq!(
            (root.sequences, root.reached, root.cost),
            (2, "feasible", Some(7.0))
        );
        assert_eq!(
            (
                refused.reached,
                refused.reason.map(|i| tree.reasons[i].as_str())
            ),
            ("refused", Some("no configuration"))
        );
        assert_eq!(
            (
                grasp.gained.concat(),
                grasp.lost.len(),
                grasp.label.as_str()
            ),
            ("h on i".into(), 0, "grasp")
        );
        assert_eq!(
            (lift.parent, lift.lost.concat(), lift.best),
            (Some(2), "a on b".into(), 0.9)
        );
        let known = [root, refused, grasp, lift].map(|node| node.visits.zip(node.value));
        assert_eq!(known, [Some((3, 0.45)), None, Some((1, 0.9)), None]);
        assert!((root.seconds - 6.0).abs() < 1e-9);
        assert_eq!(
            (tree.sequences[1].node, tree.refused[0].reason.as_str()),
            (3, "too far")
        );
        assert_eq!(tree.asked, [[1, 1], [1, 1]]);
    }
}
