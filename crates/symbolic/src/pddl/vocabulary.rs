//! What a domain may say about a scene: types, predicates that the scene gives, predicates that stand for contacts.
//!
//! Everything is optional: a domain gets those atoms whose predicate it declares with fitting types.

use super::problem::Problem;
use super::source::PddlError;
use super::syntax::{Atom, DomainFile, Formula, Literal, ObjectId, Term};
use crate::contact::{Contact, ContactState, InterfaceId};
use crate::domain::{Domain, Owner, Role};
use crate::goal::{Goal, GoalPair};
use std::collections::BTreeSet;

/// Predicates that never change unless the domain's actions change them, with their numbers of arguments.
const GIVEN: [(&str, usize); 7] = [
    ("part-of", 2),
    ("can-hold", 2),
    ("can-push", 2),
    ("can-rest", 2),
    ("can-stick", 2),
    ("opposite", 2),
    ("elsewhere", 1),
];

/// Predicates that stand for contacts, and those that follow from them at the start.
const STATE: [(&str, usize); 9] = [
    ("holds", 2),
    ("pushes", 2),
    ("rests", 2),
    ("sticks", 2),
    ("squeezes", 4),
    ("busy", 1),
    ("gripped", 1),
    ("down", 1),
    ("moved", 1),
];

/// What an object of a problem is in the scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ScenePart {
    /// An interface.
    Interface(InterfaceId),
    /// A movable object, by its index.
    Object(usize),
    /// A constant of the domain that the scene does not know.
    Constant,
}

/// The problem of a scene, and what its objects are.
#[derive(Debug)]
pub(crate) struct SceneProblem<'d> {
    file: &'d DomainFile,
    domain: &'d Domain,
    pub problem: Problem,
    pub parts: Vec<ScenePart>,
}

impl<'d> SceneProblem<'d> {
    /// Objects, start and goal of a scene in the words of a domain.
    ///
    /// # Errors
    /// [`PddlError`] if the domain declares a known predicate with another number of arguments, uses one that
    /// neither the scene nor an action makes true, or cannot move an object as the goal asks.
    pub fn new(
        file: &'d DomainFile,
        domain: &'d Domain,
        start: &ContactState,
        goal: &Goal,
        release_at_end: bool,
    ) -> Result<Self, PddlError> {
        check_predicates(file)?;
        let mut scene = Self {
            file,
            domain,
            problem: Problem {
                name: "scene".to_owned(),
                objects: file.constants.clone(),
                init: BTreeSet::new(),
                goal: Formula::And(vec![]),
            },
            parts: vec![ScenePart::Constant; file.constants.len()],
        };
        scene.name_parts();
        scene.tell_given(goal);
        scene.tell_start(start);
        scene.check_goal(start, goal)?;
        scene.problem.goal = scene.goal(goal, release_at_end);
        Ok(scene)
    }

    fn name_parts(&mut self) {
        let domain = self.domain;
        for id in domain.ids() {
            let interface = domain.interface(id);
            let kinds: &[&str] = match (interface.owner, interface.role) {
                (Owner::Robot, Role::Hand) => &["hand", "effector", "interface"],
                (Owner::Robot, Role::Foot) => &["foot", "effector", "interface"],
                (Owner::Robot, Role::Surface) => &["effector", "interface"],
                (Owner::Object(_), _) => &["surface", "interface"],
                (Owner::Static(_), _) => &["fixed", "surface", "interface"],
            };
            self.add_part(ScenePart::Interface(id), &interface.name, kinds);
        }
        for (n, name) in domain.objects().iter().enumerate() {
            self.add_part(ScenePart::Object(n), name, &["movable"]);
        }
    }

    fn add_part(&mut self, part: ScenePart, name: &str, kinds: &[&str]) {
        let name = pddl_name(name);
        let objects = &mut self.problem.objects;
        let constant = objects.iter().position(|(other, _)| *other == name);
        if let Some(n) = constant.filter(|&n| self.parts[n] == ScenePart::Constant) {
            self.parts[n] = part;
            return;
        }
        let names = std::iter::once(name.clone()).chain((2..).map(|n| format!("{name}-{n}")));
        let free = names
            .into_iter()
            .find(|name| objects.iter().all(|(other, _)| other != name));
        let types = &self.file.types;
        let untyped = (types.names.len() == 1).then_some(0);
        let Some(kind) = kinds.iter().find_map(|kind| types.find(kind)).or(untyped) else {
            return; // the domain does not speak of such parts
        };
        objects.push((free.unwrap_or(name), kind));
        self.parts.push(part);
    }

    fn object(&self, part: ScenePart) -> Option<ObjectId> {
        self.parts.iter().position(|&other| other == part)
    }

    /// The atom, if the domain declares the predicate and the parts are of its types.
    fn atom(&self, name: &str, parts: &[ScenePart]) -> Option<Atom> {
        let predicate = self.file.predicate(name)?;
        let parameters = &self.file.predicates[predicate].parameters;
        let arguments: Option<Vec<ObjectId>> = parts.iter().map(|&p| self.object(p)).collect();
        let fits = |(&n, &kind): (&ObjectId, &usize)| {
            self.file.types.is_a(self.problem.objects[n].1, kind)
        };
        arguments
            .filter(|arguments| arguments.iter().zip(parameters).all(fits))
            .map(|arguments| (predicate, arguments))
    }

    fn tell(&mut self, name: &str, parts: &[ScenePart]) {
        let atom = self.atom(name, parts);
        self.problem.init.extend(atom);
    }

    fn tell_interfaces<const N: usize>(&mut self, name: &str, interfaces: [InterfaceId; N]) {
        self.tell(name, &interfaces.map(ScenePart::Interface));
    }

    fn tell_given(&mut self, goal: &Goal) {
        for id in self.domain.ids() {
            if let Some(object) = self.domain.object_of(id) {
                let parts = [ScenePart::Interface(id), ScenePart::Object(object)];
                self.tell("part-of", &parts);
            }
        }
        for contact in self.domain.contacts() {
            if let Some((_, able)) = verb(self.domain, contact) {
                self.tell_interfaces(able, [contact.a, contact.b]);
            }
        }
        for (one, other) in opposite_pairs(self.domain) {
            self.tell_interfaces("opposite", [one, other]);
        }
        for object in 0..self.domain.objects().len() {
            if !self.is_named(goal, object) {
                self.tell("elsewhere", &[ScenePart::Object(object)]);
            }
        }
    }

    /// True if the goal speaks of the object.
    fn is_named(&self, goal: &Goal, object: usize) -> bool {
        let mut ids = goal.pairs.iter().flat_map(|pair| [pair.a, pair.b]);
        ids.any(|id| self.domain.object_of(id) == Some(object))
    }

    /// The atom that says that an object has left its place, if the domain has such a predicate.
    pub fn moved(&self, object: usize) -> Option<Atom> {
        self.atom("moved", &[ScenePart::Object(object)])
    }

    fn tell_start(&mut self, start: &ContactState) {
        for contact in start.iter() {
            let Some((verb, _)) = verb(self.domain, &contact) else {
                continue;
            };
            self.tell_interfaces(verb, [contact.a, contact.b]);
            if self.domain.object_of(contact.a).is_some() {
                self.tell_interfaces("down", [contact.a]);
            }
        }
        for grasp in grasps(self.domain) {
            if grasp.iter().all(|contact| start.contains(contact)) {
                if let [one, two] = grasp[..] {
                    self.tell_interfaces("squeezes", [one.a, two.a, one.b, two.b]);
                }
                for contact in grasp {
                    self.tell_interfaces("busy", [contact.a]);
                    self.tell_interfaces("gripped", [contact.b]);
                }
            }
        }
    }

    /// The atoms that change and stand for a contact of a goal pair.
    fn deciding(&self, pair: &GoalPair) -> Vec<Atom> {
        let contacts = self.domain.contacts().iter().filter(|c| pair.matches(c));
        let atoms = contacts.filter_map(|c| {
            let (verb, _) = verb(self.domain, c)?;
            self.atom(verb, &[c.a, c.b].map(ScenePart::Interface))
        });
        atoms.filter(|atom| self.file.is_fluent(atom.0)).collect()
    }

    /// Refuses goals that ask for a contact of an object which no action can make.
    fn check_goal(&self, start: &ContactState, goal: &Goal) -> Result<(), PddlError> {
        let domain = self.domain;
        let of_object = |c: &Contact| domain.object_of(c.a).is_some();
        let unreachable = |pair: &&GoalPair| {
            let mut contacts = domain.contacts().iter().filter(|c| pair.matches(c));
            contacts.any(of_object) && !pair.holds(start) && self.deciding(pair).is_empty()
        };
        goal.pairs.iter().find(unreachable).map_or(Ok(()), |pair| {
            let name = |id| &domain.interface(id).name;
            let problem = format!(
                "the goal asks for {:?} on {:?}, but no action brings that about",
                name(pair.a),
                name(pair.b)
            );
            let remedy = "add an action whose effect is (rests ?s ?t) or (sticks ?s ?t)";
            Err(self.file.source.error(0..0, problem, remedy))
        })
    }

    /// The part of the goal that facts decide: contacts of objects, grasps, and that the goal's objects are released.
    fn goal(&self, goal: &Goal, release_at_end: bool) -> Formula {
        let literal = |(predicate, arguments): Atom| {
            Formula::Atom(Literal {
                predicate,
                arguments: arguments.into_iter().map(Term::Object).collect(),
                span: 0..0,
            })
        };
        let decides = |pair: &GoalPair| -> Vec<Formula> {
            self.deciding(pair).into_iter().map(literal).collect()
        };
        let mut parts: Vec<Formula> = Vec::new();
        for mut clause in goal.pairs.iter().map(decides) {
            match clause.len() {
                0 => {}
                1 => parts.append(&mut clause),
                _ => parts.push(Formula::Or(clause)),
            }
        }
        let matches = |contact: &Contact| goal.pairs.iter().any(|pair| pair.matches(contact));
        for grasp in grasps(self.domain) {
            let object = self.domain.object_of(grasp[0].b);
            let named = object.is_some_and(|object| self.is_named(goal, object));
            if !release_at_end || !named || grasp.iter().any(matches) {
                continue;
            }
            let atom = match grasp[..] {
                [one, two] => {
                    let interfaces = [one.a, two.a, one.b, two.b];
                    self.atom("squeezes", &interfaces.map(ScenePart::Interface))
                }
                _ => self.atom("holds", &[grasp[0].a, grasp[0].b].map(ScenePart::Interface)),
            };
            let atom = atom.filter(|atom| self.file.is_fluent(atom.0)).map(literal);
            parts.extend(atom.map(|atom| Formula::Not(Box::new(atom))));
        }
        Formula::And(parts)
    }

    /// The contacts that an atom stands for; empty for one that is none about contacts.
    ///
    /// # Errors
    /// [`PddlError`] at the effect that makes it true, if such a contact is impossible in this scene.
    pub fn meaning(&self, atom: &Atom) -> Result<Vec<Contact>, PddlError> {
        let (predicate, arguments) = atom;
        let name = self.file.predicates[*predicate].name.as_str();
        let (pairs, unilateral) = match (name, arguments.as_slice()) {
            ("pushes" | "rests", &[a, b]) => (vec![(a, b)], true),
            ("holds" | "sticks", &[a, b]) => (vec![(a, b)], false),
            ("squeezes", &[a, c, b, d]) => (vec![(a, b), (c, d)], true),
            _ => return Ok(vec![]),
        };
        let contact = |(a, b): (ObjectId, ObjectId)| {
            let (ScenePart::Interface(a), ScenePart::Interface(b)) = (self.parts[a], self.parts[b])
            else {
                return None;
            };
            let fits = |c: &&Contact| c.b == b && c.kind.is_unilateral() == unilateral;
            self.domain.landings(a).iter().find(fits).copied()
        };
        let contacts: Option<Vec<Contact>> = pairs.iter().map(|&pair| contact(pair)).collect();
        contacts.ok_or_else(|| {
            let names = arguments.iter().map(|&n| self.problem.objects[n].0.as_str());
            let words: Vec<&str> = std::iter::once(name).chain(names).collect();
            let adds = |e: &&super::syntax::Effect| e.adds && e.atom.predicate == *predicate;
            let effect = self.file.effects().find(adds);
            let span = effect.map_or(0..0, |effect| effect.atom.span.clone());
            let problem = format!(
                "({}) can become true, but no such contact is possible in the scene",
                words.join(" ")
            );
            let remedy = "name what is possible in the precondition: can-hold for holds, can-push for pushes and \
                          squeezes, can-rest for rests, can-stick for sticks";
            self.file.source.error(span, problem, remedy)
        })
    }
}

/// The predicate of a contact and of its possibility; `None` for what a domain does not speak of.
fn verb(domain: &Domain, contact: &Contact) -> Option<(&'static str, &'static str)> {
    let of_robot = domain.interface(contact.a).owner == Owner::Robot;
    match (of_robot, contact.kind.is_unilateral()) {
        (true, true) => Some(("pushes", "can-push")),
        (true, false) => domain.object_of(contact.b).map(|_| ("holds", "can-hold")),
        (false, true) => Some(("rests", "can-rest")),
        (false, false) => Some(("sticks", "can-stick")),
    }
}

/// Opposite patches, each pair once.
fn opposite_pairs(domain: &Domain) -> Vec<(InterfaceId, InterfaceId)> {
    let mut pairs: Vec<(InterfaceId, InterfaceId)> = Vec::new();
    for &(one, other) in domain.squeezes() {
        if !pairs.contains(&(one, other)) && !pairs.contains(&(other, one)) {
            pairs.push((one, other));
        }
    }
    pairs
}

/// Every way to hold an object: one bilateral contact of a hand, or unilateral ones of two hands on opposite patches.
fn grasps(domain: &Domain) -> Vec<Vec<Contact>> {
    let of_hand = |c: &&Contact| domain.is_effector(c.a, Role::Hand);
    let hands: Vec<Contact> = domain.contacts().iter().filter(of_hand).copied().collect();
    let bilateral = |c: &&Contact| !c.kind.is_unilateral() && domain.object_of(c.b).is_some();
    let mut grasps: Vec<Vec<Contact>> = hands.iter().filter(bilateral).map(|&c| vec![c]).collect();
    for (left, right) in opposite_pairs(domain) {
        let on = |patch| {
            let pushes = move |c: &&Contact| c.b == patch && c.kind.is_unilateral();
            hands.iter().filter(pushes)
        };
        for &one in on(left) {
            let others = on(right).filter(|two| two.a != one.a);
            grasps.extend(others.map(|&two| vec![one, two]));
        }
    }
    grasps
}

/// Letters, digits, - and _, beginning with a letter, in small letters.
pub(super) fn pddl_name(name: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    let letters = name.chars().map(|c| {
        if plain(c) {
            c.to_ascii_lowercase()
        } else {
            '_'
        }
    });
    let name: String = letters.collect();
    if name.starts_with(|c: char| c.is_ascii_lowercase()) {
        name
    } else {
        format!("x{name}")
    }
}

fn check_predicates(file: &DomainFile) -> Result<(), PddlError> {
    for (n, predicate) in file.predicates.iter().enumerate() {
        let known = GIVEN
            .iter()
            .chain(&STATE)
            .find(|(name, _)| *name == predicate.name);
        let found = predicate.parameters.len();
        if let Some((name, expected)) = known.filter(|(_, expected)| *expected != found) {
            let problem = format!("{name:?} has {found} arguments, expected {expected}");
            let remedy = "a scene gives it a meaning; take another name for what is meant here";
            return Err(file.source.error(predicate.span.clone(), problem, remedy));
        }
        let given = GIVEN.iter().any(|(name, _)| *name == predicate.name);
        if !given && !file.is_fluent(n) {
            let given: Vec<&str> = GIVEN.iter().map(|(name, _)| *name).collect();
            let name = &predicate.name;
            let problem =
                format!("{name:?} is never true: no action changes it, no scene tells it");
            let remedy = format!("remove it, or use what a scene tells: {}", given.join(", "));
            return Err(file.source.error(predicate.span.clone(), problem, remedy));
        }
    }
    Ok(())
}
