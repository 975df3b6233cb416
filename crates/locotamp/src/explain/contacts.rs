//! Which number makes contacts possible that exclude one another wherever robot and objects are.

use super::candidates::widths;
use super::knob::{Knob, can_move};
use super::remedy::Found;
use super::words;
use ocp::{Phase, Planner, Settings};
use plan::Remedy;
use scene::{Owner, Scene};
use symbolic::ContactState;

/// The least change with which there is a configuration: of the width of a box that two hands cannot hold, or of the height of what the
/// goal has something stand on. `None` if none of them gives one.
pub(crate) fn remedy(
    scene: &Scene,
    settings: &Settings,
    contacts: &ContactState,
) -> Option<Remedy> {
    let phase = Phase {
        state: contacts.clone(),
        steps: 1,
    };
    let possible = |scene: &Scene| {
        let planner = Planner::new(scene);
        planner.is_ok_and(|planner| planner.state(contacts, settings).possible)
    };
    let knobs = widths(scene, &[phase]).into_iter();
    let found = knobs
        .chain(heights(scene, contacts))
        .find_map(|knob| least(scene, knob, &possible));
    found.map(|found| words::remedy(scene, &found))
}

/// Heights of the bounded surfaces on which contacts of the goal are.
fn heights(scene: &Scene, contacts: &ContactState) -> impl Iterator<Item = Knob> {
    let is_goal = |c: &symbolic::Contact| {
        let mut goals = scene.goal_contacts.iter();
        goals.any(|goal| (goal.a, goal.b) == (c.a, c.b))
    };
    let mut out: Vec<Knob> = vec![];
    for contact in contacts.iter().filter(is_goal) {
        if let Owner::Static(s) = scene.interfaces[contact.b.0].owner
            && can_move(scene, s)
            && !out.contains(&Knob::Static(s, 2))
        {
            out.push(Knob::Static(s, 2));
        }
    }
    out.into_iter()
}

/// The least change of a number that makes something possible, bisected.
fn least(scene: &Scene, knob: Knob, possible: &dyn Fn(&Scene) -> bool) -> Option<Found> {
    let from = knob.value(scene);
    let works = |to: f64| possible(&knob.with(scene, to));
    let found = knob.directions().iter().find_map(|&direction| {
        let ladder = knob.ladder(scene, direction);
        let steps = ladder.iter().map(|step| knob.rounded(*step, direction));
        let mut refused = from;
        for step in steps {
            if works(step) {
                return Some((refused, step));
            }
            refused = step;
        }
        None
    });
    let (mut refused, mut to) = found?;
    while let Some(middle) = knob.between(refused, to) {
        if works(middle) {
            to = middle;
        } else {
            refused = middle;
        }
    }
    Some(Found { knob, from, to })
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocp::Preset;
    use std::path::Path;
    use symbolic::{Contact, ContactType};

    #[test]
    fn a_table_of_the_goal_that_is_out_of_reach_is_told_its_height() {
        let text = Scene::builtin_text("pick-place").expect("a scene");
        let remedy = |z: &str| {
            let at = |z: &str| format!("position = [0.45, 1.20, {z}]");
            assert!(text.contains(&at("0.735")));
            let text = text.replace(&at("0.735"), &at(z));
            let scene = Scene::from_toml(&text, "scene.toml", Path::new(".")).expect("a scene");
            let id = |name: &str| scene.interface_id(name).expect("an interface");
            let contact = |a: &str, b: &str, kind| Contact {
                a: id(a),
                b: id(b),
                kind,
            };
            let contacts = [
                contact("right_foot", "ground_top", ContactType::UnilateralPatch),
                contact("right_hand", "red_box_handle", ContactType::BilateralPatch),
                contact(
                    "red_box_bottom",
                    "table_b_top",
                    ContactType::UnilateralPatch,
                ),
            ];
            let settings = Settings::new(Preset::Default, &scene.optimiser);
            super::remedy(&scene, &settings, &contacts.into_iter().collect())
        };
        let found = remedy("1.9").expect("a height");
        assert_eq!(found.of, ["table_b"]);
        assert!((1.0..1.9).contains(&found.to), "{found:?}");
        // From nearer by it comes to about the same height.
        let again = remedy(&format!("{:.3}", found.to + 0.1)).expect("a height");
        assert!(
            (again.to - found.to).abs() < 0.05,
            "{again:?} after {found:?}"
        );
    }
}
