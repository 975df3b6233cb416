//! From a scene to the symbolic domain, with the facts that geometry decides: opposite patches, and by [`weight`] which lifts are
//! none ([`crate::departures`] adds places to leave).

use crate::api::{Error, Impossible};
use crate::strides::Strides;
use crate::swings::{PHASES_PER_SWING, Swings};
use crate::weight;
use multibody::Kinematics;
use nalgebra::Vector3;
use scene::{Objective, Owner, Role, Scene};
use std::collections::BTreeMap;
use symbolic::pddl::{DomainFile, Problem};
use symbolic::search::{EndCost, ExtraCost, Step};
use symbolic::{
    Contact, ContactState, ContactType, Costs, Domain, Goal, GraphOptions, InterfaceId,
    Manipulation, SearchLimits, SkeletonGraph, SymbolicError,
};

/// Are the goal's objects let go at the end.
const RELEASE_AT_END: bool = true;
/// Cosine of the angle from which on two normals count as opposite.
const OPPOSITE: f64 = -0.98;
/// Share of the distance between two patches by which they may be offset sideways and still form a squeeze.
const SIDEWAYS: f64 = 0.35;

/// The symbolic domain of a scene.
///
/// # Errors
/// If interfaces and objects do not make a domain.
pub fn domain(scene: &Scene) -> Result<Domain, Error> {
    let interfaces = scene
        .interfaces
        .iter()
        .map(|i| symbolic::Interface {
            name: i.name.clone(),
            owner: match i.owner {
                Owner::Robot { .. } => symbolic::Owner::Robot,
                Owner::Object(o) => symbolic::Owner::Object(o),
                Owner::Static(s) => symbolic::Owner::Static(s),
            },
            role: match i.role {
                Role::Foot => symbolic::Role::Foot,
                Role::Hand => symbolic::Role::Hand,
                Role::Surface => symbolic::Role::Surface,
            },
            patch: i.patch,
            lands: i.lands,
            bears_feet: i.bears_feet,
            contact_types: i.contact_types.clone(),
        })
        .collect();
    let objects = scene.objects.iter().map(|o| o.name.clone()).collect();
    Ok(Domain::new(interfaces, objects, squeezes(scene))?)
}

/// Pairs of patches of one object that face away from one another and lie opposite: two hands can squeeze them.
fn squeezes(scene: &Scene) -> Vec<(InterfaceId, InterfaceId)> {
    let mut out = Vec::new();
    let graspable = |i: &scene::Interface| {
        i.patch && !i.lands && i.contact_types.iter().any(|t| t.is_unilateral())
    };
    for (i, a) in scene.interfaces.iter().enumerate() {
        for (j, b) in scene.interfaces.iter().enumerate().take(i) {
            let same = matches!((a.owner, b.owner), (Owner::Object(x), Owner::Object(y)) if x == y);
            if !same || !graspable(a) || !graspable(b) {
                continue;
            }
            let normal = |i: &scene::Interface| i.body_from_interface.rotate(Vector3::z());
            let between = b.body_from_interface.origin() - a.body_from_interface.origin();
            let depth = between.dot(&normal(b));
            let offset = (between - normal(b) * depth).norm();
            if normal(a).dot(&normal(b)) < OPPOSITE && depth > 0.0 && offset < SIDEWAYS * depth {
                out.push((InterfaceId(j), InterfaceId(i)));
            }
        }
    }
    out
}

/// The contact pairs of the scene's goal.
fn goal(scene: &Scene) -> Goal {
    Goal::of_pairs(scene.goal_contacts.iter().map(|g| (g.a, g.b)))
}

/// The PDDL domain of a scene, the built-in one if it names none, and the problem that the scene poses in it.
///
/// # Errors
/// If interfaces and objects do not make a domain, or the PDDL domain does not fit them.
pub fn pddl(scene: &Scene) -> Result<(DomainFile, Problem), Error> {
    let file = scene
        .search
        .domain
        .clone()
        .unwrap_or_else(DomainFile::builtin);
    let (domain, goal) = (domain(scene)?, goal(scene));
    let start = scene.start_state();
    let problem = Problem::of_scene(&file, &domain, &start, &goal, RELEASE_AT_END);
    let problem = problem.map_err(SymbolicError::from)?;
    Ok((file, problem.named(&scene.name)))
}

/// What the search over contact sequences works on.
#[derive(Debug)]
pub struct Skeletons {
    /// The skeleton-constrained graph, without lifts of what is too heavy.
    pub graph: SkeletonGraph,
    /// The bounds of its search.
    pub limits: SearchLimits,
    /// The lifts that were taken out.
    pub too_heavy: Vec<Impossible>,
}

/// The skeleton-constrained graph of a scene, and the bounds of its search. Lifts are taken out if the goal were within reach
/// with them, be it within reach without or not.
///
/// # Errors
/// If start, goal and domain do not fit together.
pub fn skeletons(scene: &Scene) -> Result<Skeletons, Error> {
    let start = scene.start_state();
    let goal = goal(scene);
    let options = GraphOptions {
        max_changes: scene.search.max_changes,
        support_hands: scene.search.support_hands,
        flights: scene.search.flights,
        max_actions: scene.search.max_skeleton,
        release_at_end: RELEASE_AT_END,
    };
    let domain = domain(scene)?;
    let mut graph = match &scene.search.domain {
        None => SkeletonGraph::new(domain, start, goal, options)?,
        Some(file) => {
            let actions = Manipulation::of(file, &domain, &start, &goal, options.release_at_end)?;
            SkeletonGraph::with_manipulation(domain, start, goal, options, actions)?
        }
    };
    let mut too_heavy = vec![];
    if graph.shortest_skeleton().is_some() {
        let (lifts, reasons) = weight::impossible_lifts(scene, &graph);
        graph.remove_actions(&lifts);
        too_heavy = reasons;
    }
    let swings = Swings::new(scene);
    let natural =
        || symbolic::search::default_phases(&graph) + PHASES_PER_SWING * swings.beyond_default();
    let limits = SearchLimits {
        max_phases: Some(scene.search.max_phases.unwrap_or_else(natural)),
        likely_phases: 1 + PHASES_PER_SWING * swings.fewest(),
        ending: ending(scene),
        ..SearchLimits::default()
    };
    Ok(Skeletons {
        graph,
        limits,
        too_heavy,
    })
}

/// Cosine of the slope up to which a surface counts as one to stand on.
pub(crate) const UPWARD: f64 = 0.98;
/// Extra cost of ending with a foot on the lowest surface rather than on the highest [phases], where the base is to get high:
/// more than any way to a higher one costs.
const LOW: f64 = 100.0;
/// Cost of a foot set on a wall or a slope: as much as four swings [phases].
const STEEP: f64 = 8.0;

/// Cost of ending with a foot in the air where the goal raises one [phases]: as much as the landing that it saves; and by how much
/// higher than at the start it must be for that [m].
const RAISED: f64 = 1.0;
const CLEARLY: f64 = 0.02;

/// Costs by which sequences are ordered. Where the base is to get high, new surfaces and manipulation are what may help; without torque
/// limits, jumps too.
pub(crate) fn costs(scene: &Scene) -> Costs {
    let mut costs = Costs::default();
    if scene.objective == Objective::BaseHeight {
        costs = Costs {
            new_surface: 0.0,
            detour: 0.0,
            turn: 0.0,
            ..costs
        };
    }
    if !scene.optimiser.torque_limits {
        costs.flight = costs.simultaneous;
    }
    if raises_a_foot(scene) {
        costs.end_in_swing = RAISED;
    }
    costs
}

/// True if a region of the goal wants a foot, by its interface or link, higher than it stands at the start.
fn raises_a_foot(scene: &Scene) -> bool {
    let model = &scene.robot.model;
    let mut kinematics = Kinematics::new(model);
    kinematics.update(model, &scene.start);
    let height = |body: &String| {
        let of_foot = |i: &scene::Interface| {
            let Owner::Robot { frame } = i.owner else {
                return None;
            };
            let link = kinematics.frame_pose(model, frame);
            let of_interface = || link * i.body_from_interface;
            let named = (i.name == *body).then(of_interface);
            named.or((model.frames[frame].name == *body).then_some(link))
        };
        let mut feet = scene.interfaces.iter().filter(|i| i.role == Role::Foot);
        feet.find_map(of_foot).map(|foot| foot.origin().z)
    };
    let mut regions = scene.goal_regions.iter();
    regions.any(|r| height(&r.body).is_some_and(|now| r.lower.z > now + CLEARLY))
}

/// Costs beside these: where the base is to get high, of ending low.
pub(crate) fn end_cost(scene: &Scene) -> Option<EndCost> {
    if scene.objective != Objective::BaseHeight {
        return None;
    }
    let low = lowness(scene);
    let feet: Vec<InterfaceId> = (0..scene.interfaces.len())
        .filter(|&n| scene.interfaces[n].role == Role::Foot)
        .map(InterfaceId)
        .collect();
    Some(Box::new(move |_: &SkeletonGraph, state: &ContactState| {
        // A foot in the air, or on a wall, is worth no more than one on the ground.
        let height = |&foot: &InterfaceId| {
            let under = state.iter().find(|c| c.a == foot)?;
            low.get(&(foot, under.b)).copied()
        };
        feet.iter().map(|foot| height(foot).unwrap_or(LOW)).sum()
    }))
}

/// A cost beside these: setting a foot on what does not face up at the start, or by a long stride from where others stand.
pub(crate) fn own_cost(scene: &Scene) -> ExtraCost {
    let faces_up = |i: &scene::Interface| match i.owner {
        Owner::Robot { .. } => false,
        Owner::Object(o) => {
            let pose = scene.objects[o].world_from_start * i.body_from_interface;
            pose.rotate(Vector3::z()).z > UPWARD
        }
        Owner::Static(_) => i.body_from_interface.rotate(Vector3::z()).z > UPWARD,
    };
    let strides = Strides::new(scene);
    let steep: Vec<bool> = scene.interfaces.iter().map(|i| !faces_up(i)).collect();
    Box::new(move |step: &Step<'_>| {
        let domain = step.graph.domain();
        let is_foot = |i| domain.is_effector(i, symbolic::Role::Foot);
        let after = step.graph.state(step.to.state);
        let effort = |from, to| strides.effort(from, to);
        let cost = |c: &Contact| {
            let least = |standing: &mut dyn Iterator<Item = Contact>| {
                let others = standing.filter(|o| is_foot(o.a) && o.a != c.a);
                let efforts = others.map(|o| effort(o.b.0, c.b.0));
                efforts.min_by(f64::total_cmp)
            };
            // Out of a flight as if from where the feet stand at the start.
            let start = step.graph.state(step.graph.root().state);
            let effort = least(&mut after.iter()).or_else(|| least(&mut start.iter()));
            effort.unwrap_or(0.0) + if steep[c.b.0] { STEEP } else { 0.0 }
        };
        let landings = step.action.makes.iter().filter(|c| is_foot(c.a));
        landings.map(cost).sum()
    })
}

/// True if where the feet end matters: the search then looks ahead.
pub(crate) fn looks_ahead(scene: &Scene) -> bool {
    let of_robot = |i: InterfaceId| matches!(scene.interfaces[i.0].owner, Owner::Robot { .. });
    let pairs = scene.goal_contacts.iter();
    scene.objective == Objective::BaseHeight
        || pairs
            .into_iter()
            .any(|pair| of_robot(pair.a) || of_robot(pair.b))
}

/// For every foot and upward surface how much lower it is, at the start, than the highest: 0 to [`LOW`].
fn lowness(scene: &Scene) -> BTreeMap<(InterfaceId, InterfaceId), f64> {
    let world_from = |i: &scene::Interface| match i.owner {
        Owner::Robot { .. } => None,
        Owner::Object(o) => Some(scene.objects[o].world_from_start * i.body_from_interface),
        Owner::Static(_) => Some(i.body_from_interface),
    };
    let poses: Vec<_> = scene.interfaces.iter().map(world_from).collect();
    let height = |n: usize| {
        let pose = poses[n].as_ref()?;
        let up = pose.rotate(Vector3::z()).z > UPWARD;
        let carries = scene.interfaces[n]
            .contact_types
            .contains(&ContactType::UnilateralPatch);
        (up && carries).then(|| pose.origin().z)
    };
    let heights: Vec<Option<f64>> = (0..poses.len()).map(height).collect();
    let known = || heights.iter().flatten().copied();
    let (most, least) = (
        known().fold(f64::MIN, f64::max),
        known().fold(f64::MAX, f64::min),
    );
    let feet = (0..scene.interfaces.len()).filter(|&n| scene.interfaces[n].role == Role::Foot);
    let mut low = BTreeMap::new();
    for foot in feet {
        for (surface, height) in heights.iter().enumerate() {
            if let Some(height) = height.filter(|_| most > least) {
                let share = (most - height) / (most - least);
                low.insert((InterfaceId(foot), InterfaceId(surface)), LOW * share);
            }
        }
    }
    low
}

/// Sequences end in the first goal state; in any where contacts do not say all of the goal, since more steps may be needed to get
/// to a region, or further.
fn ending(scene: &Scene) -> Option<symbolic::Ending> {
    let further = scene.goal_contacts.is_empty() && scene.objective != Objective::Time;
    let anywhere = further || !scene.goal_regions.is_empty();
    anywhere.then_some(symbolic::Ending::Every)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn feet_that_stand_as_the_goal_says_may_walk_to_its_region() {
        let skeletons_with = |contacts: &str| {
            let text = format!(
                "name = \"s\"\nrobot = \"g1\"\n[[static]]\nname = \"ground\"\nplane = true\n[goal]\n{contacts}\n\
                 [[goal.region]]\nbody = \"base\"\nx = [0.3, 0.4]\n"
            );
            let scene = Scene::from_toml(&text, "s.toml", Path::new(".")).expect("a scene");
            skeletons(&scene).expect("skeletons").limits
        };
        let both = skeletons_with(
            "contacts = [[\"left_foot\", \"ground_top\"], [\"right_foot\", \"ground_top\"]]",
        );
        assert_eq!(both, skeletons_with(""));
        assert_eq!(both.ending, Some(symbolic::Ending::Every));
        assert_eq!(both.max_phases, Some(9));
    }

    #[test]
    fn ending_with_a_foot_in_the_air_costs_little_where_the_goal_raises_one() {
        let end_in_swing = |region: &str| {
            let text = format!(
                "name = \"s\"\nrobot = \"g1\"\n[[static]]\nname = \"ground\"\nplane = true\n[[goal.region]]\n{region}\n"
            );
            let scene = Scene::from_toml(&text, "s.toml", Path::new(".")).expect("a scene");
            costs(&scene).end_in_swing
        };
        let usual = Costs::default().end_in_swing;
        let interface = end_in_swing("body = \"right_foot\"\nz = [0.3, 0.4]");
        assert!(interface < usual);
        let link = end_in_swing("body = \"right_ankle_roll_link\"\nz = [0.3, 0.4]");
        assert_eq!(link, interface);
        for region in [
            "body = \"right_foot\"\nx = [0.3, 0.4]",
            "body = \"right_foot\"\nz = [0.0, 0.1]",
            "body = \"right_ankle_roll_link\"\nz = [0.03, 0.1]",
            "body = \"base\"\nz = [0.5, 0.6]",
        ] {
            assert_eq!(end_in_swing(region), usual);
        }
    }

    #[test]
    fn two_opposite_patches_can_be_squeezed_by_points_too() {
        let squeezes_of = |kind: &str| {
            let text = format!(
                "name = \"s\"\nrobot = \"g1\"\n[[static]]\nname = \"ground\"\nplane = true\n[[object]]\nname = \"box\"\nmass = 1\n\
                 size = [0.2, 0.2, 0.2]\non = \"ground_top\"\nposition = [0.6, 0]\n[[object.interface]]\nname = \"l\"\nside = \"+y\"\n\
                 contacts = [\"{kind}\"]\n[[object.interface]]\nname = \"r\"\nside = \"-y\"\ncontacts = [\"{kind}\"]\n[objective]\n\
                 kind = \"base_height\"\n"
            );
            let scene = Scene::from_toml(&text, "s.toml", Path::new(".")).expect("a scene");
            squeezes(&scene).len()
        };
        assert_eq!(squeezes_of("unilateral_patch"), 1);
        assert_eq!(squeezes_of("unilateral_point"), 1);
        assert_eq!(squeezes_of("bilateral_patch"), 0);
    }
}
