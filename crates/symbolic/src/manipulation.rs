//! The built-in manipulation operators, grasp, lift, place and release, grounded on the interfaces of a domain.
//!
//! Source: paper, "Manipulation skeleton". A fact is a grasp (one hand that holds a handle, or two hands that squeeze
//! opposite patches) or an object's surface that rests on a support; its meaning is the set of contacts that it
//! imposes. A list of operators from elsewhere replaces this one by filling a [`Manipulation`].

use crate::contact::{Contact, ContactState, InterfaceId};
use crate::domain::{Domain, Role};
use crate::error::SymbolicError;
use crate::goal::{Goal, GoalPair};
use crate::task::{Condition, Fact, FactSet, Operator, Task};

/// A way to hold an object.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Grasp {
    /// Index of the object.
    pub object: usize,
    /// One bilateral contact, or two unilateral ones of different hands on opposite patches.
    pub contacts: Vec<Contact>,
}

impl Grasp {
    fn shares(&self, other: &Self, side: fn(&Contact) -> InterfaceId) -> bool {
        self.contacts
            .iter()
            .any(|one| other.contacts.iter().any(|two| side(one) == side(two)))
    }
}

/// A ground task together with the contacts that its facts stand for.
#[derive(Debug, Clone)]
pub struct Manipulation {
    /// Facts, operators, start and goal.
    pub task: Task,
    /// Per fact the contacts that hold while it is true; empty for a fact that is none about contacts.
    pub meaning: Vec<Vec<Contact>>,
}

impl Manipulation {
    /// The built-in operators for a start and a goal.
    ///
    /// The task's goal is the part of `goal` that facts decide: objects on supports and grasps. With
    /// `release_at_end` the objects of the goal are let go as well, except by grasps that the goal names.
    ///
    /// # Errors
    /// Never for a valid domain; the error is that of [`Task::new`].
    pub fn builtin(
        domain: &Domain,
        start: &ContactState,
        goal: &Goal,
        release_at_end: bool,
    ) -> Result<Self, SymbolicError> {
        let facts = Facts::of(domain);
        let meaning = facts.meaning();
        let holds = |contacts: &[Contact]| contacts.iter().all(|contact| start.contains(contact));
        let start = (0..meaning.len())
            .filter(|&n| holds(&meaning[n]))
            .map(Fact)
            .collect::<FactSet>();
        let operators = facts.operators();
        let names = (0..meaning.len()).map(|n| facts.name(n)).collect();
        let task = Task::new(names, operators, start, facts.goal(goal, release_at_end))?;
        Ok(Self { task, meaning })
    }

    /// The contacts that a state of the task imposes.
    pub fn imposed(&self, facts: &FactSet) -> ContactState {
        facts
            .iter()
            .flat_map(|fact| self.meaning[fact.0].iter().copied())
            .collect()
    }
}

/// Every way to hold an object that the domain allows, ordered: single hands first.
pub fn grasps(domain: &Domain) -> Vec<Grasp> {
    let of_hand = |c: &&Contact| domain.is_effector(c.a, Role::Hand);
    let hand_contacts: Vec<Contact> = domain.contacts().iter().filter(of_hand).copied().collect();
    let mut grasps: Vec<Grasp> = Vec::new();
    for contact in hand_contacts.iter().filter(|c| !c.kind.is_unilateral()) {
        if let Some(object) = domain.object_of(contact.b) {
            grasps.push(Grasp {
                object,
                contacts: vec![*contact],
            });
        }
    }
    for &(left, right) in domain.squeezes() {
        let Some(object) = domain.object_of(left) else {
            continue;
        };
        for one in hand_contacts
            .iter()
            .filter(|c| c.b == left && c.kind.is_unilateral())
        {
            for two in hand_contacts
                .iter()
                .filter(|c| c.b == right && c.kind == one.kind && c.a != one.a)
            {
                let mut contacts = vec![*one, *two];
                contacts.sort_unstable();
                grasps.push(Grasp { object, contacts });
            }
        }
    }
    let mut seen = std::collections::BTreeSet::new();
    grasps.retain(|grasp| seen.insert(grasp.clone()));
    grasps
}

/// The facts of the built-in task: first the grasps, then the rests.
struct Facts<'d> {
    domain: &'d Domain,
    grasps: Vec<Grasp>,
    rests: Vec<Contact>,
}

impl<'d> Facts<'d> {
    fn of(domain: &'d Domain) -> Self {
        let rests = domain
            .contacts()
            .iter()
            .filter(|c| domain.object_of(c.a).is_some())
            .copied()
            .collect();
        Self {
            domain,
            grasps: grasps(domain),
            rests,
        }
    }

    fn meaning(&self) -> Vec<Vec<Contact>> {
        self.grasps
            .iter()
            .map(|g| g.contacts.clone())
            .chain(self.rests.iter().map(|&c| vec![c]))
            .collect()
    }

    fn name(&self, n: usize) -> String {
        match self.grasps.get(n) {
            Some(grasp) => {
                let contacts: Vec<String> = grasp
                    .contacts
                    .iter()
                    .map(|c| self.domain.contact_name(c))
                    .collect();
                contacts.join(" and ")
            }
            None => self.domain.contact_name(&self.rests[n - self.grasps.len()]),
        }
    }

    fn operators(&self) -> Vec<Operator> {
        let n_objects = self.domain.objects().len();
        let grasps = (0..self.grasps.len()).map(|n| self.grasp(n));
        let lifts = (0..n_objects).map(|object| self.lift(object));
        let places = self
            .rests
            .iter()
            .enumerate()
            .map(|(n, contact)| self.place(n, contact));
        let releases = (0..self.grasps.len()).map(|n| self.release(n));
        grasps.chain(lifts).chain(places).chain(releases).collect()
    }

    fn grasp_facts(&self, keep: impl Fn(&Grasp) -> bool) -> Vec<Fact> {
        (0..self.grasps.len())
            .filter(|&n| keep(&self.grasps[n]))
            .map(Fact)
            .collect()
    }

    fn rest_facts(&self, keep: impl Fn(&Contact) -> bool) -> Vec<Fact> {
        let offset = self.grasps.len();
        (0..self.rests.len())
            .filter(|&n| keep(&self.rests[n]))
            .map(|n| Fact(offset + n))
            .collect()
    }

    fn rests_of(&self, object: usize) -> Vec<Fact> {
        self.rest_facts(|contact| self.domain.object_of(contact.a) == Some(object))
    }

    /// Hands and surfaces must be free of other grasps; the surfaces must not lie on anything.
    fn grasp(&self, n: usize) -> Operator {
        let grasp = &self.grasps[n];
        let mut none_of =
            self.grasp_facts(|other| grasp.shares(other, |c| c.a) || grasp.shares(other, |c| c.b));
        none_of.extend(self.rest_facts(|rest| grasp.contacts.iter().any(|c| c.b == rest.a)));
        Operator {
            label: self.grasp_label(grasp),
            requires: Condition {
                any_of: Vec::new(),
                none_of,
            },
            deletes: Vec::new(),
            adds: vec![Fact(n)],
        }
    }

    /// A held object leaves all its supports; what lies on it comes along.
    fn lift(&self, object: usize) -> Operator {
        let held = self.grasp_facts(|grasp| grasp.object == object);
        let rests = self.rests_of(object);
        Operator {
            label: format!("lift {}", self.domain.objects()[object]),
            requires: Condition {
                any_of: vec![held, rests.clone()],
                none_of: Vec::new(),
            },
            deletes: rests,
            adds: Vec::new(),
        }
    }

    /// A held object in the air comes to rest on a static surface, or on an object that rests itself.
    fn place(&self, n: usize, contact: &Contact) -> Operator {
        let (surface, support) = (contact.a, contact.b);
        let object = self.domain.object_of(surface);
        let mut any_of = vec![self.grasp_facts(|grasp| Some(grasp.object) == object)];
        if let Some(under) = self.domain.object_of(support) {
            let rests = |rest: &Contact| {
                self.domain.object_of(rest.a) == Some(under)
                    && self.domain.object_of(rest.b) != object
            };
            any_of.push(self.rest_facts(rests));
        }
        let blocks = |rest: &Contact| {
            self.domain.object_of(rest.a) == object || rest.b == surface || rest.a == support
        };
        let mut none_of = self.rest_facts(blocks);
        none_of.extend(self.grasp_facts(|grasp| grasp.contacts.iter().any(|c| c.b == surface)));
        Operator {
            label: self.place_label(contact),
            requires: Condition { any_of, none_of },
            deletes: Vec::new(),
            adds: vec![Fact(self.grasps.len() + n)],
        }
    }

    /// A held object is let go if it rests on something or another grasp holds it.
    fn release(&self, n: usize) -> Operator {
        let object = self.grasps[n].object;
        let mut others = self.rests_of(object);
        others.extend(
            self.grasp_facts(|grasp| grasp.object == object)
                .into_iter()
                .filter(|&fact| fact != Fact(n)),
        );
        Operator {
            label: format!("release {}", self.domain.objects()[object]),
            requires: Condition {
                any_of: vec![vec![Fact(n)], others],
                none_of: Vec::new(),
            },
            deletes: vec![Fact(n)],
            adds: Vec::new(),
        }
    }

    fn grasp_label(&self, grasp: &Grasp) -> String {
        let names = |side: fn(&Contact) -> InterfaceId| {
            let names: Vec<&str> = grasp
                .contacts
                .iter()
                .map(|c| self.domain.interface(side(c)).name.as_str())
                .collect();
            names.join(" and ")
        };
        let same_hands = |other: &&Grasp| {
            other.object == grasp.object
                && other.contacts.len() == grasp.contacts.len()
                && other
                    .contacts
                    .iter()
                    .zip(&grasp.contacts)
                    .all(|(one, two)| one.a == two.a)
        };
        let mut label = format!(
            "grasp {} with {}",
            self.domain.objects()[grasp.object],
            names(|c| c.a)
        );
        if self.grasps.iter().filter(same_hands).count() > 1 {
            label = format!("{label} at {}", names(|c| c.b));
        }
        label
    }

    fn place_label(&self, contact: &Contact) -> String {
        let object = self
            .domain
            .object_of(contact.a)
            .map_or("", |o| &self.domain.objects()[o]);
        let mut label = format!(
            "place {object} on {}",
            self.domain.interface(contact.b).name
        );
        let same = |rest: &&Contact| {
            rest.b == contact.b && self.domain.object_of(rest.a) == self.domain.object_of(contact.a)
        };
        if self.rests.iter().filter(same).count() > 1 {
            label = format!("{label} by {}", self.domain.interface(contact.a).name);
        }
        label
    }

    fn goal(&self, goal: &Goal, release_at_end: bool) -> Condition {
        let decides = |pair: &GoalPair| {
            let rests = self.rest_facts(|rest| pair.matches(rest));
            let holds = self
                .grasp_facts(|grasp| grasp.contacts.len() == 1 && pair.matches(&grasp.contacts[0]));
            [rests, holds].concat()
        };
        let clauses = goal
            .pairs
            .iter()
            .map(decides)
            .filter(|clause| !clause.is_empty());
        let named = |object: usize| {
            let ids = goal.pairs.iter().flat_map(|pair| [pair.a, pair.b]);
            release_at_end
                && ids
                    .into_iter()
                    .any(|id| self.domain.object_of(id) == Some(object))
        };
        let wanted = |grasp: &Grasp| {
            goal.pairs
                .iter()
                .any(|pair| grasp.contacts.iter().any(|contact| pair.matches(contact)))
        };
        let none_of = self.grasp_facts(|grasp| named(grasp.object) && !wanted(grasp));
        Condition {
            any_of: clauses.collect(),
            none_of,
        }
    }
}
