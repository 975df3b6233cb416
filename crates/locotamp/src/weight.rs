//! Lifts that are impossible whatever the motion: all that holds the object bears less than it weighs.
//!
//! An object that rests on a horizontal face is at rest. When it leaves it, contacts of the robot alone bear it and what stands
//! on it, d/dt (m ż) = Σ f − m g with ż = 0 at first: if all that these contacts can push upwards is less than the weight, it
//! sinks at once, into what it rested on. Its tilt is that of the rest meanwhile, so the direction of every face is known.
//! Moments are left out, and nothing is said of contacts later in the air or of flight: who throws an object lifts it first.
//!
//! Frames: `object`, whose axes are its body's; up is given in them.
//! Source: bounds of contact forces as in `ocp/src/program/forces.rs`.

use crate::api::{Impossible, Refusal};
use nalgebra::Vector3;
use scene::{Interface, Owner, Role, Scene};
use std::collections::{BTreeMap, BTreeSet};
use symbolic::{Contact, ContactState, ContactType, InterfaceId, SkeletonGraph, TaskState};

/// Cosine of the angle up to which a face counts as horizontal, up to rounding.
const HORIZONTAL: f64 = 1.0 - 1e-9;
/// Share of the weight by which contacts must fall short, so that rounding decides nothing.
const SHORT: f64 = 1e-9;

/// Skeleton actions that lift more than what holds it can bear, by the positions that they join, and why.
pub(crate) fn impossible_lifts(
    scene: &Scene,
    graph: &SkeletonGraph,
) -> (BTreeSet<(TaskState, TaskState)>, Vec<Impossible>) {
    let (mut between, mut reasons) = (BTreeSet::new(), BTreeMap::new());
    let skeletons = graph.skeletons();
    for from in (0..skeletons.n_states()).map(TaskState) {
        for edge in skeletons.edges(from) {
            let help: Vec<Contact> = graph.free_contacts(edge.to).collect();
            let (before, after) = (graph.imposed(from), graph.imposed(edge.to));
            if let Some(lift) = Lift::of(scene, before, after)
                && let Some(found) = lift.fault(&help)
            {
                between.insert((from, edge.to));
                let known = reasons.entry(found.reason.clone()).or_insert(found);
                known.refused += 1;
            }
        }
    }
    (between, reasons.into_values().collect())
}

/// Why an object cannot leave what it rests on from one state to the next, if it is to.
pub(crate) fn fault(scene: &Scene, from: &ContactState, to: &ContactState) -> Option<Impossible> {
    Lift::of(scene, from, to)?.fault(&[])
}

/// An object that leaves what it rests on, held by the robot alone.
struct Lift<'a> {
    scene: &'a Scene,
    /// Objects that go up together, the one that is lifted first, with up in their axes.
    up: BTreeMap<usize, Vector3<f64>>,
    object: usize,
    /// Contacts of the robot with them.
    held: Vec<Contact>,
    /// Surfaces that are face to face with others before.
    covered: BTreeSet<InterfaceId>,
}

/// The most that a contact pushes upwards.
struct Share<'a> {
    contact: Contact,
    /// What pushes, and on what.
    robot: &'a Interface,
    on: &'a Interface,
    /// [N].
    force: f64,
}

impl<'a> Lift<'a> {
    /// The lift between two states; `None` if there is none, or something that does not move bears the objects after it too.
    fn of(scene: &'a Scene, from: &ContactState, to: &ContactState) -> Option<Self> {
        let falls = scene.gravity.xy().norm() <= 0.0 && scene.gravity.z < 0.0;
        (0..scene.objects.len())
            .filter(|_| falls)
            .find_map(|object| {
                let group = group(scene, object, to);
                let up = |&o: &usize| Some((o, up_in(scene, o, from, scene.objects.len())?));
                let up: BTreeMap<_, _> = group.iter().map(up).collect::<Option<_>>()?;
                let joined = |c: &Contact| other_side(scene, c, &group);
                let others: Vec<(Contact, Owner)> =
                    to.iter().filter_map(|c| Some((c, joined(&c)?))).collect();
                let robot = |o: &Owner| matches!(o, Owner::Robot { .. });
                (!others.is_empty() && others.iter().all(|(_, o)| robot(o))).then(|| Self {
                    scene,
                    up,
                    object,
                    held: others.into_iter().map(|(c, _)| c).collect(),
                    covered: from.iter().map(|c| c.a).collect(),
                })
            })
    }

    /// The most that a contact of the robot with one of the objects pushes upwards; `None` if it joins others.
    ///
    /// Each component of the force is bounded, tangential ones by friction μ f too: a face whose outward normal is at an
    /// angle θ from down gets f (cos θ + μ sin θ) at most.
    fn share(&self, contact: Contact) -> Option<Share<'a>> {
        let (a, b) = (
            &self.scene.interfaces[contact.a.0],
            &self.scene.interfaces[contact.b.0],
        );
        let (robot, on) = match (a.owner, b.owner) {
            (Owner::Robot { .. }, Owner::Object(_)) => (a, b),
            (Owner::Object(_), Owner::Robot { .. }) => (b, a),
            _ => return None,
        };
        let Owner::Object(object) = on.owner else {
            return None;
        };
        let up = self.up.get(&object)?;
        let most = a.max_force.min(b.max_force);
        let part = match contact.kind {
            ContactType::BilateralPatch | ContactType::BilateralPoint => 1.0,
            ContactType::UnilateralPoint => 3f64.sqrt(), // bounded along each axis
            ContactType::UnilateralPatch => {
                let cos = -on.body_from_interface.rotate(Vector3::z()).dot(up);
                let sin = (1.0 - cos * cos).max(0.0).sqrt();
                (cos + a.mu.min(b.mu) * sin).max(0.0)
            }
        };
        let force = if part > 0.0 { part * most } else { 0.0 };
        Some(Share {
            contact,
            robot,
            on,
            force,
        })
    }

    /// What holds the objects, and of `help` the best contact of every hand. Feet count where they hold, not as help: the robot
    /// stands on them.
    fn shares(&self, help: &[Contact]) -> Vec<Share<'a>> {
        let mut shares: Vec<Share<'a>> = self.held.iter().filter_map(|&c| self.share(c)).collect();
        let mut best: BTreeMap<&str, Share<'a>> = BTreeMap::new();
        for share in help.iter().filter_map(|&c| self.share(c)) {
            let touches = |i: &InterfaceId| self.covered.contains(i);
            let covered = touches(&share.contact.b) || share.robot.role != Role::Hand;
            let known = best.get(share.robot.name.as_str());
            if !covered && known.is_none_or(|known| known.force < share.force) {
                best.insert(&share.robot.name, share);
            }
        }
        shares.extend(best.into_values().filter(|share| share.force > 0.0));
        shares
    }

    /// Why what holds the objects, with the help that free hands may give, cannot lift them.
    fn fault(&self, help: &[Contact]) -> Option<Impossible> {
        let shares = self.shares(help);
        let bears: f64 = shares.iter().map(|share| share.force).sum();
        let mass: f64 = self.up.keys().map(|&o| self.scene.objects[o].mass).sum();
        let g = self.scene.gravity.norm();
        (bears < mass * g * (1.0 - SHORT)).then(|| Impossible {
            what: Refusal::Lift,
            contacts: shares.iter().map(Share::words).collect(),
            reason: self.reason(&shares, (mass, bears, g)),
            refused: 0,
        })
    }

    /// The fault in words: weight, what bears how much of it, and which mass or forces would do.
    fn reason(&self, shares: &[Share<'_>], (mass, bears, g): (f64, f64, f64)) -> String {
        let name = |o: usize| self.scene.objects[o].name.as_str();
        let others: Vec<&str> = self
            .up
            .keys()
            .filter(|&&o| o != self.object)
            .map(|&o| name(o))
            .collect();
        let with = if others.is_empty() {
            String::new()
        } else {
            format!(" with {} on it", others.join(" and "))
        };
        let held: Vec<String> = shares.iter().map(Share::words).collect();
        let parts: Vec<String> = shares.iter().map(|s| format!("{:.1} N", s.force)).collect();
        let bear = if let [_] = parts.as_slice() {
            format!("bears at most {} of it", parts[0])
        } else {
            format!("bear at most {} = {bears:.1} N of it", parts.join(" + "))
        };
        let own = self.scene.objects[self.object].mass;
        let most = ((bears / g - (mass - own)) * 100.0).floor() / 100.0;
        let lighter = if most > 0.0 {
            format!("a mass of {} of at most {most} kg", name(self.object))
        } else {
            "a lower mass".to_owned()
        };
        let enough = |s: &Share<'_>| {
            let (robot, on) = (s.robot.max_force, s.on.max_force);
            let needed = (robot.min(on) * mass * g / bears).ceil();
            let both = if on < needed {
                format!(" and {}", s.on.name)
            } else {
                String::new()
            };
            format!("{needed} N for {}{both}", s.robot.name)
        };
        let stronger = if bears > 0.0 {
            let forces: Vec<String> = shares.iter().map(enough).collect();
            format!(", or a max_force of at least {}", forces.join(" and "))
        } else {
            ", or a hold from below or by a handle".to_owned()
        };
        format!(
            "{}{with} weighs {:.1} N ({mass} kg), {} {bear}: it takes {lighter}{stronger}",
            name(self.object),
            mass * g,
            held.join(" with "),
        )
    }
}

impl Share<'_> {
    fn words(&self) -> String {
        let verb = if self.contact.kind.is_unilateral() {
            "on"
        } else {
            "holding"
        };
        format!("{} {verb} {}", self.robot.name, self.on.name)
    }
}

/// Objects that touch one another, directly or not, from one of them on.
fn group(scene: &Scene, object: usize, state: &ContactState) -> BTreeSet<usize> {
    let owner = |i: InterfaceId| scene.interfaces[i.0].owner;
    let mut group = BTreeSet::from([object]);
    loop {
        let more: Vec<usize> = state
            .iter()
            .filter_map(|c| match (owner(c.a), owner(c.b)) {
                (Owner::Object(x), Owner::Object(y)) if group.contains(&x) => Some(y),
                (Owner::Object(x), Owner::Object(y)) if group.contains(&y) => Some(x),
                _ => None,
            })
            .filter(|o| !group.contains(o))
            .collect();
        if more.is_empty() {
            return group;
        }
        group.extend(more);
    }
}

/// What else than objects of the group a contact joins them with; `None` if it does not.
fn other_side(scene: &Scene, contact: &Contact, group: &BTreeSet<usize>) -> Option<Owner> {
    let owners = [contact.a, contact.b].map(|i| scene.interfaces[i.0].owner);
    let inside = |o: &Owner| matches!(o, Owner::Object(o) if group.contains(o));
    match owners {
        [x, y] if inside(&x) && !inside(&y) => Some(y),
        [x, y] if inside(&y) && !inside(&x) => Some(x),
        _ => None,
    }
}

/// Up in the axes of an object that rests on a horizontal face of what does not move, or of an object that does so; `depth` is
/// the most objects on one another.
fn up_in(scene: &Scene, object: usize, state: &ContactState, depth: usize) -> Option<Vector3<f64>> {
    let interface = |i: InterfaceId| &scene.interfaces[i.0];
    let normal = |i: &Interface| i.body_from_interface.rotate(Vector3::z());
    let rests = |c: &Contact| interface(c.a).owner == Owner::Object(object) && c.kind.is_patch();
    state.iter().filter(rests).find_map(|c| {
        let under = interface(c.b);
        let up = match under.owner {
            Owner::Static(_) => Vector3::z(),
            Owner::Object(below) if depth > 0 => up_in(scene, below, state, depth - 1)?,
            _ => return None,
        };
        (normal(under).dot(&up) > HORIZONTAL).then(|| -normal(interface(c.a)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Request, domain};
    use std::path::Path;

    /// A box with handles on two sides that is to be brought to another table, for the G1, whose hands bear 60 N each.
    fn boxed(mass: f64, sides: &[&str]) -> Scene {
        let handle = |side: &&str| {
            let sign = if side.starts_with('-') { -1.0 } else { 1.0 };
            let y = 0.1 * sign;
            format!(
                "{{ name = \"handle{side}\", side = \"{side}\", position = [0, {y}, 0], half_size = [0.03, 0.03], \
                 contacts = [\"bilateral_patch\"] }}"
            )
        };
        let handles: Vec<String> = sides.iter().map(handle).collect();
        let text = format!(
            "name = \"s\"\nrobot = \"g1\"\n[[static]]\nname = \"ground\"\nplane = true\n\
             [[static]]\nname = \"table\"\nsize = [0.34, 0.44, 0.03]\nposition = [0.45, -0.12, 0.735]\n\
             [[static]]\nname = \"shelf\"\nsize = [0.34, 0.44, 0.03]\nposition = [0.4, 0.5, 0.735]\n\
             [[object]]\nname = \"box\"\nmass = {mass}\nsize = [0.2, 0.2, 0.2]\non = \"table_top\"\n\
             position = [-0.05, 0.1]\ninterface = [{}]\n[goal]\ncontacts = [[\"box_bottom\", \"shelf_top\"]]\n",
            handles.join(", ")
        );
        Scene::from_toml(&text, "s.toml", Path::new(".")).expect("a scene")
    }

    /// Actions of the skeletons that are left.
    fn skeletons(scene: &Scene) -> (Vec<Vec<String>>, Vec<Impossible>) {
        let found = domain::skeletons(scene).expect("a graph");
        let operators = found.graph.manipulation().task.operators();
        let plans = found.graph.skeletons().plans();
        let labels = plans.map(|plan| {
            let label = |edge: &symbolic::TaskEdge| operators[edge.operator].label.clone();
            plan.iter().map(label).collect()
        });
        (labels.collect(), found.too_heavy)
    }

    #[test]
    fn what_one_hand_cannot_bear_two_lift() {
        let scene = boxed(8.0, &["+y", "-y"]);
        let (left, reasons) = skeletons(&scene);
        assert!(!left.is_empty());
        for labels in left {
            let lift = labels.iter().position(|l| l.starts_with("lift"));
            let before = &labels[..lift.expect("a lift")];
            let grasps = before.iter().filter(|l| l.starts_with("grasp")).count();
            assert_eq!(grasps, 2, "{labels:?}");
        }
        let one = &reasons[0];
        assert_eq!((one.what, one.contacts.len()), (Refusal::Lift, 1));
        assert!(
            one.reason.contains(
                "box weighs 78.5 N (8 kg), left_hand holding handle+y bears at most 60.0 N of it"
            ),
            "{}",
            one.reason
        );
    }

    #[test]
    fn what_no_hands_can_bear_ends_the_search_with_the_reason_and_without_a_motion() {
        let scene = boxed(60.0, &["+y", "-y"]);
        let outcome = crate::plan(&scene, &Request::default(), &mut |_| true).expect("an outcome");
        assert!(
            outcome.ended.contains("contacts that are impossible"),
            "{}",
            outcome.ended
        );
        assert!(outcome.attempts.is_empty() && outcome.best.is_none());
        let both = outcome.impossible.iter().find(|x| x.contacts.len() == 2);
        let reason = &both.expect("two hands are refused too").reason;
        for part in [
            "588.6 N (60 kg)",
            "60.0 N + 60.0 N = 120.0 N",
            "at most 12.23 kg",
            "at least 295 N for left_hand and",
        ] {
            assert!(reason.contains(part), "{part:?} is missing in {reason}");
        }
    }

    #[test]
    fn what_every_hand_can_bear_loses_no_skeleton() {
        let (light, none) = skeletons(&boxed(1.0, &["+y", "-y"]));
        let (just, still_none) = skeletons(&boxed(6.11, &["+y", "-y"]));
        assert_eq!(
            (light.len(), none, still_none),
            (just.len(), vec![], vec![])
        );
        for name in Scene::builtin_names() {
            let scene = Scene::builtin(name).expect("a built-in scene");
            let found = domain::skeletons(&scene).expect("a graph");
            assert_eq!(found.too_heavy, [], "{name}");
        }
    }

    #[test]
    fn palms_on_upright_faces_lift_by_friction_alone() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/heavy-box.toml");
        let scene = Scene::load(path).expect("a scene of the repository");
        let (_, reasons) = skeletons(&scene);
        // 0.7 · 60 N on each side, 117.7 N of weight.
        assert!(
            reasons[0].reason.contains("42.0 N + 42.0 N = 84.0 N"),
            "{reasons:?}"
        );
    }
}
