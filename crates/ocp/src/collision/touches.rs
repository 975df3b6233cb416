//! When pairs of bodies touch.

use super::Touch;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// The nearest contact of a pair in time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Since {
    /// Sixteenths of a phase between it and the node.
    pub parts: f64,
    /// Node of the contact.
    pub node: usize,
}

/// The nodes at which each pair touches, in their order.
pub(super) struct Touches {
    own: BTreeMap<Touch, Vec<usize>>,
    /// The same of pairs whose first one touches an object that touches the other.
    through: BTreeMap<Touch, Vec<usize>>,
    /// Sixteenths of a phase from the start to each node.
    along: Vec<f64>,
}

impl Touches {
    /// Of those at each node; `objects` are the joints that carry objects.
    pub fn new(at_nodes: &[BTreeSet<Touch>], along: Vec<f64>, objects: &Range<usize>) -> Self {
        let mut own = BTreeMap::<_, Vec<usize>>::new();
        let mut through = BTreeMap::<_, Vec<usize>>::new();
        for (node, touching) in at_nodes.iter().enumerate() {
            let mut here = BTreeSet::new();
            for &(a, other) in touching {
                own.entry((a, other)).or_default().push(node);
                if let Some(object) = other.ok().filter(|o| objects.contains(o)) {
                    let of_object = touching.iter().filter(|touch| touch.0 == object);
                    here.extend(of_object.map(|&(_, other)| (a, other)));
                }
            }
            for touch in here {
                through.entry(touch).or_default().push(node);
            }
        }
        Self {
            own,
            through,
            along,
        }
    }

    /// The nearest one of a pair from a node.
    pub fn since(&self, touch: Touch, node: usize) -> Option<Since> {
        self.nearest(self.own.get(&touch)?, node)
    }

    /// The same where the first one touches an object that touches the other.
    pub fn since_through(&self, touch: Touch, node: usize) -> Option<Since> {
        self.nearest(self.through.get(&touch)?, node)
    }

    /// Of two that are as near the earlier one.
    fn nearest(&self, nodes: &[usize], node: usize) -> Option<Since> {
        let after = nodes.partition_point(|&n| n < node);
        let around = &nodes[after.saturating_sub(1)..nodes.len().min(after + 1)];
        let since = |&there: &usize| Since {
            parts: (self.along[there] - self.along[node]).abs(),
            node: there,
        };
        let sooner = |x: &Since, y: &Since| x.parts.total_cmp(&y.parts);
        around.iter().map(since).min_by(sooner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_contact_is_before_after_or_at_the_node_or_through_an_object() {
        let (hand, object, other) = (3, Ok(7), Err(1));
        let mut at_nodes = vec![BTreeSet::new(); 6];
        at_nodes[1].insert((hand, object));
        at_nodes[2].extend([(hand, object), (7, other)]);
        at_nodes[5].insert((hand, object));
        let along = vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.5];
        let touches = Touches::new(&at_nodes, along, &(7..8));
        let since = |node| touches.since((hand, object), node);
        let at = |node, parts| Some(Since { parts, node });
        assert_eq!([0, 2, 3].map(since), [at(1, 1.0), at(2, 0.0), at(2, 1.0)]);
        assert_eq!([4, 5].map(since), [at(5, 1.5), at(5, 0.0)]);
        assert_eq!(touches.since((hand, other), 3), None);
        assert_eq!(touches.since_through((hand, other), 4), at(2, 2.0));
        assert_eq!(touches.since_through((7, other), 4), None);
    }
}
