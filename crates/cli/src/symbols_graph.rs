//! The graph of manipulation states, or of contact states, as DOT and JSON.

use serde_json::json;
use std::collections::{BTreeMap, VecDeque};
use std::fmt::Write;
use symbolic::{Node, SkeletonGraph, TaskState};

/// A node of a graph that is written.
struct Vertex {
    contacts: Vec<String>,
    goal: bool,
    /// The manipulation state that it belongs to.
    position: usize,
}

/// An edge: from, to, what is done.
type Edge = (usize, usize, String);

/// Nodes and edges; the start is node 0.
pub(crate) struct Graph {
    name: &'static str,
    vertices: Vec<Vertex>,
    edges: Vec<Edge>,
    /// False if nodes were left out.
    complete: bool,
}

impl Graph {
    /// Manipulation states from which the goal is within N actions, and the actions between them.
    pub fn of_skeletons(graph: &SkeletonGraph) -> Self {
        let skeletons = graph.skeletons();
        let kept: Vec<TaskState> = (0..skeletons.n_states())
            .map(TaskState)
            .filter(|&n| n.0 == 0 || skeletons.may_reach_goal(n, skeletons.depth(n)))
            .collect();
        let vertices = kept.iter().map(|&n| Vertex {
            contacts: contacts(graph, graph.imposed(n)),
            goal: skeletons.distance(n) == Some(0),
            position: n.0,
        });
        let index = |n: TaskState| kept.binary_search(&n).ok();
        let label = |n: usize| graph.manipulation().task.operators()[n].label.clone();
        let edges = kept.iter().enumerate().flat_map(|(from, &n)| {
            let edges = skeletons.edges(n).iter();
            edges.filter_map(move |edge| Some((from, index(edge.to)?, label(edge.operator))))
        });
        Self {
            name: "skeletons",
            edges: edges.collect(),
            vertices: vertices.collect(),
            complete: true,
        }
    }

    /// Contact states along skeletons, breadth first from the start, up to `limit` nodes, and the actions between them.
    pub fn of_contacts(graph: &mut SkeletonGraph, limit: usize) -> Self {
        let root = graph.root();
        let mut index: BTreeMap<Node, usize> = BTreeMap::from([(root, 0)]);
        let mut queue = VecDeque::from([root]);
        let mut found = Self {
            name: "contacts",
            vertices: vec![vertex(graph, root)],
            edges: Vec::new(),
            complete: true,
        };
        while let Some(node) = queue.pop_front() {
            for edge in graph.successors(node) {
                let skeletons = graph.skeletons();
                let position = edge.node.position;
                if !skeletons.may_reach_goal(position, skeletons.depth(position)) {
                    continue;
                }
                if !index.contains_key(&edge.node) {
                    if index.len() == limit {
                        found.complete = false;
                        continue;
                    }
                    index.insert(edge.node, index.len());
                    found.vertices.push(vertex(graph, edge.node));
                    queue.push_back(edge.node);
                }
                let label = graph.label(node, &edge);
                found.edges.push((index[&node], index[&edge.node], label));
            }
        }
        found
    }

    /// How large it is, for people.
    pub fn size(&self) -> String {
        let cut = if self.complete {
            ""
        } else {
            ", the first of more (--nodes takes more)"
        };
        format!(
            "{} nodes, {} edges{cut}",
            self.vertices.len(),
            self.edges.len()
        )
    }

    /// Text for Graphviz.
    pub fn dot(&self) -> String {
        let quoted = |text: &str| text.replace('\\', "\\\\").replace('"', "\\\"");
        let mut text = format!(
            "digraph {} {{\n  rankdir=LR; node [shape=box];\n",
            self.name
        );
        if !self.complete {
            let _ = writeln!(text, "  label=\"the first {} nodes\";", self.vertices.len());
        }
        for (n, vertex) in self.vertices.iter().enumerate() {
            let lines: Vec<String> = vertex.contacts.iter().map(|c| quoted(c)).collect();
            let shape = match (n, vertex.goal) {
                (_, true) => ", peripheries=2",
                (0, _) => ", style=bold",
                _ => "",
            };
            let _ = writeln!(text, "  n{n} [label=\"{}\"{shape}];", lines.join("\\n"));
        }
        for (from, to, label) in &self.edges {
            let _ = writeln!(text, "  n{from} -> n{to} [label=\"{}\"];", quoted(label));
        }
        text.push_str("}\n");
        text
    }

    /// One JSON object.
    pub fn json(&self) -> String {
        let vertex =
            |v: &Vertex| json!({ "contacts": v.contacts, "goal": v.goal, "position": v.position });
        let edge = |(from, to, label): &Edge| json!({ "from": from, "to": to, "action": label });
        let graph = json!({
            "graph": self.name,
            "complete": self.complete,
            "nodes": self.vertices.iter().map(vertex).collect::<Vec<_>>(),
            "edges": self.edges.iter().map(edge).collect::<Vec<_>>(),
        });
        format!("{graph}\n")
    }
}

fn vertex(graph: &SkeletonGraph, node: Node) -> Vertex {
    Vertex {
        contacts: contacts(graph, graph.state(node.state)),
        goal: graph.is_goal(node),
        position: node.position.0,
    }
}

fn contacts(graph: &SkeletonGraph, state: &symbolic::ContactState) -> Vec<String> {
    if state.is_empty() {
        return vec!["no contact".to_owned()];
    }
    state
        .iter()
        .map(|contact| graph.domain().contact_name(&contact))
        .collect()
}
