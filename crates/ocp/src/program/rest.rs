//! Where objects stay where they are: on something that stands still, by a patch that sticks.
//!
//! In a motion such a pose is no unknown of its own at every node: at the start it is given, later it is one for all nodes. Rows that
//! would say no more than that are left out, so that what is only there costs little. Keyframes and paths are cheap, and begin where
//! their rows do not hold yet: there every node has its own, which leads them to solutions more often (benches/runs).

use super::contacts::binds;
use super::{Builder, Grid, Phase};
use scene::Owner;
use symbolic::Contact;

/// First node of the stretch of nodes over which an object stays where it is, per object and node; `None` where it may move.
#[derive(Debug, Clone, Default)]
pub struct Rests(Vec<Vec<Option<usize>>>);

impl Rests {
    /// First node of the stretch at rest that a node belongs to.
    pub fn since(&self, object: usize, node: usize) -> Option<usize> {
        self.0[object][node]
    }

    /// True if an object stays where it is from the node before to this one.
    pub fn stays(&self, object: usize, node: usize) -> bool {
        self.since(object, node).is_some_and(|first| first < node)
    }
}

impl Builder<'_> {
    /// Finds where objects are at rest in a motion.
    pub(super) fn rests(&mut self, phases: &[Phase]) {
        let p = &self.program;
        let (n, n_objects) = (p.n_intervals(), self.scene.objects.len());
        let mut rests = vec![vec![None; n + 1]; n_objects];
        let motion = p.grid == Grid::Motion;
        for t in (0..n).filter(|_| motion) {
            let contacts = || {
                let all = phases.iter().flat_map(|phase| &phase.state.contacts);
                all.filter(|c| c.kind.is_patch() && binds(phases, p, **c, t))
            };
            let mut still = vec![false; n_objects];
            let stands =
                |interface: usize, still: &[bool]| match self.scene.interfaces[interface].owner {
                    Owner::Static(_) => true,
                    Owner::Object(o) => still[o],
                    Owner::Robot { .. } => false,
                };
            // What stands on an object that is at rest is so too.
            for _ in 0..n_objects {
                for contact in contacts() {
                    if let Owner::Object(o) = self.scene.interfaces[contact.a.0].owner {
                        still[o] |= stands(contact.b.0, &still);
                    }
                }
            }
            for (rest, _) in rests.iter_mut().zip(still).filter(|(_, still)| *still) {
                let first = *rest[t].get_or_insert(t);
                rest[t + 1] = Some(first);
            }
        }
        self.program.rests = Rests(rests);
    }

    /// True if neither side of a contact moves from the node before to this one.
    pub(super) fn is_settled(&self, contact: Contact, node: usize) -> bool {
        self.both(contact, |o| self.program.rests.stays(o, node))
    }

    /// True if neither side of a contact moves at a node.
    pub(super) fn is_at_rest(&self, contact: Contact, node: usize) -> bool {
        self.both(contact, |o| self.program.rests.since(o, node).is_some())
    }

    /// True if both sides of a contact are static or objects of which something holds.
    fn both(&self, contact: Contact, holds: impl Fn(usize) -> bool) -> bool {
        [contact.a, contact.b]
            .into_iter()
            .all(|i| match self.scene.interfaces[i.0].owner {
                Owner::Static(_) => true,
                Owner::Object(o) => holds(o),
                Owner::Robot { .. } => false,
            })
    }
}
