//! Explanations in words and as the types of the plan file.

use super::Case;
use super::knob::Knob;
use super::remedy::Found;
use crate::domain::UPWARD;
use crate::summary;
use nalgebra::Vector3;
use ocp::Pull;
use plan::{Explanation, FailedStage, Obstacle, Remedy};
use scene::{Owner, Scene};
use std::fmt::Write;
use symbolic::{Contact, InterfaceId};

/// Numbers tried in vain that the text lists.
const MOST_IN_VAIN: usize = 5;

/// Group of a constraint, as docs/explanation.md lists them.
pub(super) fn group(category: &str) -> &'static str {
    match category {
        "friction cone" | "torsional friction" => "friction",
        "torque limit" | "torque at speed" => "torque",
        "joint velocity" => "joint velocity",
        "joint range" => "joint range",
        "contact force" | "grasp strength" | "centre of pressure" => "contact force",
        "clearance" | "clearance between nodes" => "clearance",
        "goal region" | "goal orientation" => "goal",
        "phase duration" => "duration",
        "equations of motion" | "momentum" => "dynamics",
        _ => "geometry",
    }
}

/// A pull for the file.
pub(super) fn pull(case: &Case, pull: &Pull) -> plan::Pull {
    plan::Pull {
        phase: pull.phase + 1,
        constraint: pull.label.category.into(),
        subject: summary::subject(case.scene, pull.label.subject),
        share: pull.share,
    }
}

/// Names of surfaces, joints and bodies that have a number.
fn owners(scene: &Scene, knob: &Knob) -> Vec<String> {
    let interfaces = |of: &[usize]| {
        let names = of.iter().map(|&i| scene.interfaces[i].name.clone());
        names.collect()
    };
    let joints = |of: &[usize]| {
        let names = of.iter().map(|&j| scene.robot.model.joints[j].name.clone());
        names.collect()
    };
    match knob {
        Knob::Mass(o) | Knob::Object(o, _) | Knob::Width(o, _) => {
            vec![scene.objects[*o].name.clone()]
        }
        Knob::Friction(of) | Knob::Torsion(of) | Knob::Force(of) | Knob::Moment(of) => {
            interfaces(of)
        }
        Knob::Torque(of) | Knob::Velocity(of) => joints(of),
        Knob::Range(j, _) => joints(&[*j]),
        Knob::AllTorques => vec!["all joints".into()],
        Knob::Longest | Knob::Shortest => vec!["all phases".into()],
        Knob::Static(s, _) => vec![scene.statics[*s].name.clone()],
        Knob::Goal(r, ..) => vec![scene.goal_regions[*r].body.clone()],
    }
}

/// Quantity and key of a number.
fn quantity(scene: &Scene, knob: &Knob) -> (&'static str, String) {
    let axis = |i: usize| ["x", "y", "z"][i];
    let of_interfaces = |of: &[usize], key: &str| {
        let robot = |&i: &usize| matches!(scene.interfaces[i].owner, Owner::Robot { .. });
        let place = match (of.iter().any(robot), of.iter().all(robot)) {
            (true, true) => "robot file [[interface]]",
            (true, false) => "scene file [[object]] or [[static]], and robot file [[interface]]",
            _ => "scene file [[object]] or [[static]]",
        };
        format!("{place}: {key}")
    };
    let end = |upper: bool| if upper { "largest" } else { "smallest" };
    match knob {
        Knob::Mass(_) => ("mass", "scene file [[object]]: mass".into()),
        Knob::Friction(of) => ("friction", of_interfaces(of, "mu")),
        Knob::Torsion(of) => ("torsional friction", of_interfaces(of, "mu_r")),
        Knob::Torque(_) => ("torque limit", "URDF <limit>: effort".into()),
        Knob::AllTorques => ("torque limits", "URDF <limit>: effort, times".into()),
        Knob::Velocity(_) => ("velocity limit", "URDF <limit>: velocity".into()),
        Knob::Range(_, upper) => (
            "joint range",
            format!("URDF <limit>: {}", if *upper { "upper" } else { "lower" }),
        ),
        Knob::Force(of) => ("largest force", of_interfaces(of, "max_force")),
        Knob::Moment(of) => ("largest moment", of_interfaces(of, "max_moment")),
        Knob::Longest => (
            "longest phase",
            "scene file [optimiser]: max_duration".into(),
        ),
        Knob::Shortest => (
            "shortest phase",
            "scene file [optimiser]: min_duration".into(),
        ),
        Knob::Static(_, 2) => ("height", "scene file [[static]]: position z".into()),
        Knob::Static(_, i) => (
            "position",
            format!("scene file [[static]]: position {}", axis(*i)),
        ),
        Knob::Object(_, i) => (
            "position",
            format!("scene file [[object]]: position {} in the world", axis(*i)),
        ),
        Knob::Width(_, i) => (
            "width",
            format!(
                "scene file [[object]]: size {}, and what depends on it",
                axis(*i)
            ),
        ),
        Knob::Goal(_, i, upper) => (
            "goal",
            format!("[[goal.region]]: {} {}", end(*upper), axis(*i)),
        ),
    }
}

/// What is changed, in words: "mass of box".
pub(super) fn name(scene: &Scene, knob: &Knob) -> String {
    let (quantity, key) = quantity(scene, knob);
    let of = owners(scene, knob).join(", ");
    match knob {
        Knob::Longest | Knob::Shortest => quantity.into(),
        Knob::Static(_, i) | Knob::Object(_, i) => {
            format!("{} of {of}", ["x", "y", "height"][*i])
        }
        Knob::Width(_, i) => format!("width of {of} along its {}", ["x", "y", "z"][*i]),
        Knob::Goal(..) => {
            let which = key.rsplit(": ").next().unwrap_or_default();
            format!("{which} of the goal of {of}")
        }
        Knob::Range(_, upper) => {
            let end = if *upper { "upper" } else { "lower" };
            format!("{end} end of the joint range of {of}")
        }
        _ => format!("{quantity} of {of}"),
    }
}

/// A number with at most three decimals.
fn number(value: f64) -> String {
    let text = format!("{value:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn with_unit(value: f64, unit: &str) -> String {
    format!("{} {unit}", number(value)).trim_end().to_owned()
}

/// A remedy for the file.
pub(super) fn remedy(scene: &Scene, found: &Found) -> Remedy {
    let Found { knob, from, to } = found;
    let (quantity, key) = quantity(scene, knob);
    let unit = knob.unit(scene);
    let verb = if to > from { "raise" } else { "lower" };
    let (now, then) = (with_unit(*from, unit), with_unit(*to, unit));
    let name = name(scene, knob);
    let text = match knob {
        Knob::AllTorques => format!("multiply all torque limits by {}", number(*to)),
        Knob::Static(s, 2) => {
            let tops = scene.interfaces.iter();
            let top = tops
                .filter(|i| i.owner == Owner::Static(*s))
                .filter(|i| i.body_from_interface.rotate(Vector3::z()).z > UPWARD)
                .map(|i| i.body_from_interface.origin().z)
                .fold(f64::NEG_INFINITY, f64::max);
            let at = if top.is_finite() {
                format!(
                    ", so that its top is at {}",
                    with_unit(top + to - from, "m")
                )
            } else {
                String::new()
            };
            let name = &scene.statics[*s].name;
            format!(
                "{verb} {name} by {}, from z = {now} to {then}{at}",
                with_unit((to - from).abs(), "m")
            )
        }
        Knob::Static(_, i) | Knob::Object(_, i) => {
            let axis = ["x", "y"][*i];
            let of = owners(scene, knob).join(", ");
            format!(
                "move {of} by {} in {axis}, from {now} to {then}",
                with_unit(to - from, "m")
            )
        }
        _ => format!("{verb} the {name} from {now} to {then}"),
    };
    Remedy {
        quantity: quantity.into(),
        of: owners(scene, knob),
        key,
        from: *from,
        to: *to,
        unit: unit.into(),
        text,
    }
}

/// The constraint that a remedy relieves, in the phase that fails.
pub(super) fn cause(case: &Case, phase: usize, found: &Found) -> Obstacle {
    let Found { knob, from, to } = found;
    let scene = case.scene;
    let contact = |test: &dyn Fn(&Contact) -> bool| {
        let here = case.phases[phase].state.contacts.iter();
        let all = case.phases.iter().flat_map(|p| p.state.contacts.iter());
        let name = |i: symbolic::InterfaceId| scene.interfaces[i.0].name.as_str();
        let first = here.chain(all).find(|c| test(c));
        first.map(|c| format!("{} on {}", name(c.a), name(c.b)))
    };
    let of = |of: &[usize]| {
        contact(&|c| of.contains(&c.b.0) && of.contains(&c.a.0))
            .or_else(|| contact(&|c| of.contains(&c.b.0) || of.contains(&c.a.0)))
    };
    let on_static = |s: usize| contact(&move |c| scene.interfaces[c.b.0].owner == Owner::Static(s));
    let (constraint, subject) = match knob {
        Knob::Mass(_) => ("equations of motion", None),
        Knob::Friction(i) => ("friction cone", of(i)),
        Knob::Torsion(i) => ("torsional friction", of(i)),
        Knob::Torque(_) | Knob::AllTorques => ("torque limit", None),
        Knob::Velocity(_) => ("joint velocity", None),
        Knob::Range(..) => ("joint range", None),
        Knob::Force(i) => ("contact force", of(i)),
        Knob::Moment(i) => ("grasp strength", of(i)),
        Knob::Longest | Knob::Shortest => ("phase duration", None),
        Knob::Static(s, _) => ("contact distance", on_static(*s)),
        Knob::Object(o, _) | Knob::Width(o, _) => {
            let o = Owner::Object(*o);
            let touched = contact(&move |c| scene.interfaces[c.b.0].owner == o);
            ("contact distance", touched)
        }
        Knob::Goal(..) => ("goal region", None),
    };
    let weight = scene.gravity.norm();
    let (group, amount, unit) = match knob {
        Knob::Mass(_) => ("weight", (from - to) * weight, "N"),
        _ => (group(constraint), (to - from).abs(), knob.unit(scene)),
    };
    Obstacle {
        phase: phase + 1,
        action: case.action(phase),
        group: group.into(),
        constraint: constraint.into(),
        subject: subject.unwrap_or_else(|| owners(scene, knob).join(", ")),
        amount,
        unit: unit.into(),
    }
}

/// All of an explanation in a few lines, each ending with a line break; `falls_short` if only the grid on which a motion must hold has none.
pub(super) fn text(e: &Explanation, falls_short: bool) -> String {
    let mut text = String::new();
    let what = match e.stage {
        FailedStage::Contradiction => "Bounds contradict each other",
        FailedStage::Keyframes => {
            "There is no configuration that meets contacts, joint ranges, clearances and goal"
        }
        FailedStage::Motion if falls_short => {
            "There are configurations for every phase, but no motion through them was found that holds between coarse nodes"
        }
        FailedStage::Motion => {
            "There are configurations for every phase, but no motion through them was found"
        }
    };
    let cause = &e.cause;
    let action = if cause.action.is_empty() {
        String::new()
    } else {
        format!(" ({})", cause.action)
    };
    let _ = writeln!(text, "{what}: phase {}{action} fails.", cause.phase);
    let _ = writeln!(
        text,
        "cause        {}: {} of {}, {} off",
        cause.group,
        cause.constraint,
        cause.subject,
        with_unit(cause.amount, &cause.unit)
    );
    for (i, v) in e.violated.iter().take(3).enumerate() {
        let head = if i == 0 { "violated" } else { "" };
        let amount = format!("{:.2e} {}", v.amount, v.unit);
        let _ = writeln!(
            text,
            "{head:12} {} of {}: {amount}, phase {}",
            v.constraint, v.subject, v.phase
        );
    }
    for (i, p) in e.pulls.iter().take(3).enumerate() {
        let head = if i == 0 { "pulls" } else { "" };
        let share = 100.0 * p.share;
        let _ = writeln!(
            text,
            "{head:12} {} of {}, phase {} ({share:.0} %)",
            p.constraint, p.subject, p.phase
        );
    }
    for (i, remedy) in e.remedies.iter().enumerate() {
        let head = if i == 0 { "would do" } else { "or" };
        let _ = writeln!(text, "{head:12} {} [{}]", remedy.text, remedy.key);
    }
    if e.remedies.is_empty() {
        let known = if e.complete {
            "no single number that was tried makes it feasible"
        } else {
            "not known: stopped before all numbers were tried"
        };
        let _ = writeln!(text, "{:12} {known}", "would do");
    }
    if !e.in_vain.is_empty() {
        let shown = e.in_vain.iter().take(MOST_IN_VAIN).cloned();
        let more = e.in_vain.len().saturating_sub(MOST_IN_VAIN);
        let more = (more > 0).then(|| format!("{more} more (--json lists all)"));
        let all: Vec<String> = shown.chain(more).collect();
        let _ = writeln!(text, "{:12} {}", "in vain", all.join("; "));
    }
    text
}

/// Which objects nothing touches in some phase, one to a line: a contact that was forgotten is the likely reason.
pub(super) fn falling(case: &Case) -> String {
    let mut text = String::new();
    for (o, object) in case.scene.objects.iter().enumerate() {
        let owner = |i: InterfaceId| case.scene.interfaces[i.0].owner;
        let touches = |c: Contact| [c.a, c.b].map(owner).contains(&Owner::Object(o));
        let falls = |&k: &usize| !case.phases[k].state.iter().any(touches);
        if let Some(k) = (0..case.phases.len()).find(falls) {
            let (phase, name) = (k + 1, &object.name);
            let _ = writeln!(
                text,
                "{:12} nothing touches {name} in phase {phase}: it falls there; is a contact of it missing?",
                "note"
            );
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn only_a_face_that_looks_up_is_a_top() {
        let text_with = |side: &str| {
            let text = format!(
                "name = \"s\"\nrobot = \"g1\"\n[[static]]\nname = \"ground\"\nplane = true\n[[static]]\nname = \"wall\"\n\
                 size = [0.1, 2.0, 2.0]\nposition = [0.9, 0.0, 1.0]\ntop = false\n[[static.interface]]\nname = \"face\"\n\
                 side = \"{side}\"\n[objective]\nkind = \"base_height\"\n"
            );
            let scene = Scene::from_toml(&text, "s.toml", Path::new(".")).expect("a scene");
            let (from, to) = (1.0, 1.5);
            let knob = Knob::Static(1, 2);
            remedy(&scene, &Found { knob, from, to }).text
        };
        assert_eq!(
            text_with("-x"),
            "raise wall by 0.5 m, from z = 1 m to 1.5 m"
        );
        let top = "raise wall by 0.5 m, from z = 1 m to 1.5 m, so that its top is at 2.5 m";
        assert_eq!(text_with("+z"), top);
    }
}
