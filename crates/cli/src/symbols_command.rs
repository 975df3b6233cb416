//! `locotamp symbols`: what a scene means symbolically, as text, JSON, graphs and PDDL.

use crate::arguments::{GraphName, SymbolsOptions};
use crate::failure::Failure;
use crate::plan_command::load;
use crate::symbols_graph::Graph;
use crate::{Exit, output, symbols_text};
use locotamp::{Impossible, with_places_to_leave};
use scene::Scene;
use serde_json::{Value, json};
use std::path::Path;
use symbolic::search::default_phases;
use symbolic::statistics::{Count, RuleCount, SkeletonCount, count_by_rule, count_skeleton_graph};
use symbolic::{Contact, Domain, Interface, Owner, Role, SkeletonGraph};

/// Most states along skeletons that are counted.
const MOST_STATES: usize = 100_000;
/// Most skeletons that are counted.
const MOST_SKELETONS: usize = 100_000;
/// Skeletons that are written out.
pub(crate) const SHOWN_SKELETONS: usize = 5;

/// Everything that is shown.
pub(crate) struct Symbols {
    pub scene: Scene,
    pub graph: SkeletonGraph,
    /// Largest number of phases K_max.
    pub max_phases: usize,
    pub rules: Vec<RuleCount>,
    /// What the skeletons leave; `None` if there are more than [`MOST_STATES`].
    pub along_skeletons: Option<SkeletonCount>,
    /// Per length the number of skeletons.
    pub lengths: Vec<(usize, usize)>,
    /// False if there are more than [`MOST_SKELETONS`].
    pub all_counted: bool,
    /// The first skeletons, as labels of their actions.
    pub first: Vec<Vec<String>>,
    /// Lifts of what is too heavy, which no skeleton has.
    pub too_heavy: Vec<Impossible>,
}

impl Symbols {
    fn of(scene: Scene) -> Result<Self, Failure> {
        let locotamp::Skeletons {
            mut graph,
            limits,
            too_heavy,
        } = locotamp::skeletons(&scene)?;
        let mut lengths: Vec<(usize, usize)> = Vec::new();
        let mut first = Vec::new();
        let label = |n: usize| graph.manipulation().task.operators()[n].label.clone();
        let mut plans = graph.skeletons().plans();
        for plan in plans.by_ref().take(MOST_SKELETONS) {
            match lengths.last_mut() {
                Some((length, count)) if *length == plan.len() => *count += 1,
                _ => lengths.push((plan.len(), 1)),
            }
            if first.len() < SHOWN_SKELETONS {
                first.push(plan.iter().map(|edge| label(edge.operator)).collect());
            }
        }
        let all_counted = plans.next().is_none();
        let max_phases = limits.max_phases.unwrap_or_else(|| default_phases(&graph));
        Ok(Self {
            max_phases,
            rules: count_by_rule(graph.domain()),
            along_skeletons: count_skeleton_graph(&mut graph, MOST_STATES),
            lengths,
            all_counted,
            first,
            too_heavy,
            scene,
            graph,
        })
    }

    pub fn domain(&self) -> &Domain {
        self.graph.domain()
    }
}

/// Prints the symbolic problem of a scene and writes its graphs and PDDL files, if asked for.
pub(crate) fn run(options: &SymbolsOptions) -> Result<Exit, Failure> {
    let scene = load(&options.scene)?;
    let scene = with_places_to_leave(&scene).unwrap_or(scene);
    if let Some(folder) = &options.pddl {
        write_pddl(&scene, folder)?;
    }
    let mut symbols = Symbols::of(scene)?;
    if options.dot.is_some() || options.graph_json.is_some() {
        let graph = match options.graph {
            GraphName::Skeletons => Graph::of_skeletons(&symbols.graph),
            GraphName::Contacts => Graph::of_contacts(&mut symbols.graph, options.nodes),
        };
        let files = [
            (&options.dot, graph.dot()),
            (&options.graph_json, graph.json()),
        ];
        for (path, text) in files {
            if let Some(path) = path {
                write(path, &text)?;
                output::error(&format!("{}: {}\n", path.display(), graph.size()));
            }
        }
    }
    if options.json {
        output::result(&format!("{}\n", in_json(&symbols)));
    } else {
        output::result(&symbols_text::write(&symbols));
    }
    Ok(Exit::Done)
}

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    std::fs::write(path, text).map_err(|error| Failure::path("write", path, &error))
}

/// `domain.pddl` and `problem.pddl`, for other planners.
fn write_pddl(scene: &Scene, folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|error| Failure::path("create", folder, &error))?;
    let (domain, problem) = locotamp::pddl(scene)?;
    write(&folder.join("domain.pddl"), domain.text())?;
    write(&folder.join("problem.pddl"), &problem.text(&domain))
}

/// A length or time without the last digits of its arithmetic, to a micrometre or microsecond.
pub(crate) fn rounded(value: f64) -> f64 {
    (1e6 * value).round() / 1e6
}

/// What carries an interface: "robot", the name of an object, or of a static body.
pub(crate) fn owner(scene: &Scene, interface: &Interface) -> String {
    match interface.owner {
        Owner::Robot => "robot".to_owned(),
        Owner::Object(n) => scene.objects[n].name.clone(),
        Owner::Static(n) => scene.statics[n].name.clone(),
    }
}

/// What an interface is used for.
pub(crate) fn role(interface: &Interface) -> &'static str {
    match (interface.role, interface.lands) {
        (Role::Foot, _) => "foot",
        (Role::Hand, _) => "hand",
        (Role::Surface, true) => "landing surface",
        (Role::Surface, false) => "surface",
    }
}

/// The bodies that a contact joins.
pub(crate) fn bodies(domain: &Domain, contact: &Contact) -> &'static str {
    let owner = |id| domain.interface(id).owner;
    match (owner(contact.a), owner(contact.b)) {
        (Owner::Robot, Owner::Object(_)) => "robot on object",
        (Owner::Robot, _) => "robot on environment",
        (_, Owner::Object(_)) => "object on object",
        _ => "object on environment",
    }
}

/// The kinds of [`bodies`] in the order in which they are shown.
pub(crate) const BODIES: [&str; 4] = [
    "robot on environment",
    "robot on object",
    "object on environment",
    "object on object",
];

fn in_json(symbols: &Symbols) -> Value {
    let (domain, scene) = (symbols.domain(), &symbols.scene);
    let interface = |i: &Interface| {
        let types: Vec<&str> = i.contact_types.iter().map(|kind| kind.name()).collect();
        json!({
            "name": i.name, "owner": owner(scene, i), "role": role(i),
            "kind": if i.patch { "patch" } else { "point" }, "contact_types": types,
        })
    };
    let contact = |c: &Contact| {
        json!({
            "a": domain.interface(c.a).name, "b": domain.interface(c.b).name, "type": c.kind.name(),
            "bodies": bodies(domain, c),
        })
    };
    let number = |count: Option<Count>| {
        count.map(
            |count| match count.exact.and_then(|n| u64::try_from(n).ok()) {
                Some(n) => json!({ "exact": n }),
                None => json!({ "log10": count.log10 }),
            },
        )
    };
    let rule = |row: &RuleCount| {
        json!({
            "after": row.rule, "contacts": row.contacts,
            "states": number(row.states), "transitions": number(row.transitions),
        })
    };
    let lengths = symbols.lengths.iter();
    json!({
        "scene": scene.name,
        "interfaces": domain.interfaces().iter().map(interface).collect::<Vec<_>>(),
        "contacts": domain.contacts().iter().map(contact).collect::<Vec<_>>(),
        "limits": {
            "max_phases": symbols.max_phases,
            "max_skeleton": symbols.graph.skeletons().max_actions(),
            "max_changes": scene.search.max_changes,
            "support_hands": scene.search.support_hands,
            "flights": scene.search.flights,
            "min_duration": rounded(scene.optimiser.min_duration),
            "max_duration": rounded(scene.optimiser.max_duration),
        },
        "rules": symbols.rules.iter().map(rule).collect::<Vec<_>>(),
        "along_skeletons": symbols.along_skeletons.map(|count| json!({
            "positions": count.positions, "states": count.states, "transitions": count.transitions,
        })),
        "skeletons": {
            "shortest": symbols.graph.shortest_skeleton(),
            "by_length": lengths.map(|(length, count)| json!([length, count])).collect::<Vec<_>>(),
            "complete": symbols.all_counted,
            "first": symbols.first,
            "too_heavy": symbols.too_heavy.iter().map(|lift| &lift.reason).collect::<Vec<_>>(),
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_digits_of_arithmetic_are_not_shown() {
        assert_eq!(rounded(6.0 * 0.05).to_string(), "0.3");
        assert_eq!(rounded(0.123_456_7).to_string(), "0.123457");
    }
}
