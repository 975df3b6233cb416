//! `locotamp symbols`: text, JSON, graphs, PDDL files, and domains of the user's.

use crate::{hopper, locotamp, stderr, stdout};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Standard output of a run that must succeed.
fn symbols(folder: &Path, more: &[&str]) -> String {
    let output = locotamp(folder, &[&["symbols"], more].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    stdout(&output)
}

fn json(folder: &Path, more: &[&str]) -> Value {
    serde_json::from_str(&symbols(folder, more)).expect("one JSON object")
}

#[test]
fn interfaces_contacts_limits_rules_and_skeletons_are_shown() {
    let folder = tempfile::tempdir().unwrap();
    let text = symbols(folder.path(), &["pick-place"]);
    for part in [
        "9 interfaces",
        "red_box_handle  red_box  surface          patch  bilateral_patch",
        "21 possible contacts",
        "left_hand (bilateral_patch): red_box_handle",
        "object on object: none",
        "phases (K_max)                 13  from the scene",
        "skeleton actions (N_PDDL)       8  from the scene",
        "duration of a phase        0.25 to 2 s",
        "along skeletons from the start",
        "4 skeletons of at most 8 actions",
        "grasp red_box with left_hand, lift red_box, place red_box on table_b_top, release red_box",
    ] {
        assert!(text.contains(part), "{part:?} is missing in:\n{text}");
    }
}

#[test]
fn machines_get_the_same_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let shown = json(folder.path(), &["pick-place", "--json"]);
    assert_eq!(shown["interfaces"].as_array().unwrap().len(), 9);
    assert_eq!(shown["contacts"].as_array().unwrap().len(), 21);
    assert_eq!(shown["limits"]["max_phases"], 13);
    assert_eq!(
        shown["skeletons"]["by_length"],
        serde_json::json!([[4, 2], [8, 2]])
    );
    assert_eq!(shown["skeletons"]["complete"], true);
    let rules = shown["rules"].as_array().unwrap();
    assert_eq!(rules.last().unwrap()["states"]["exact"], 2100);
    let along = shown["along_skeletons"]["states"].as_u64().unwrap();
    assert!(along < 2100);
}

#[test]
fn graphs_are_written_and_say_if_nodes_are_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let output = locotamp(
        path,
        &[
            "symbols",
            "pick-place",
            "--dot",
            "s.dot",
            "--graph-json",
            "s.json",
        ],
    );
    assert!(
        stderr(&output).contains("s.dot: 11 nodes, 24 edges\n"),
        "{}",
        stderr(&output)
    );
    let dot = fs::read_to_string(path.join("s.dot")).unwrap();
    assert!(
        dot.contains("n0 -> n1 [label=\"grasp red_box with left_hand\"];"),
        "{dot}"
    );
    assert!(
        dot.contains("red_box_bottom on table_b_top\", peripheries=2];"),
        "{dot}"
    );
    let graph: Value =
        serde_json::from_str(&fs::read_to_string(path.join("s.json")).unwrap()).unwrap();
    assert_eq!(
        graph["nodes"][0]["contacts"],
        serde_json::json!(["red_box_bottom on table_a_top"])
    );
    assert_eq!(graph["edges"].as_array().unwrap().len(), 24);

    let contacts = |nodes: &str| -> Value {
        let arguments = [
            "pick-place",
            "--graph",
            "contacts",
            "--nodes",
            nodes,
            "--graph-json",
            "c.json",
        ];
        symbols(path, &arguments);
        serde_json::from_str(&fs::read_to_string(path.join("c.json")).unwrap()).unwrap()
    };
    let cut = contacts("50");
    assert_eq!(
        (&cut["complete"], cut["nodes"].as_array().unwrap().len()),
        (&Value::Bool(false), 50)
    );
    let whole = contacts("1000");
    assert_eq!(whole["complete"], true);
    let along = &json(path, &["pick-place", "--json"])["along_skeletons"];
    assert_eq!(along["states"], whole["nodes"].as_array().unwrap().len());
    assert_eq!(
        along["transitions"],
        whole["edges"].as_array().unwrap().len()
    );
}

#[test]
fn the_written_pddl_files_can_be_used_as_the_domain_of_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    symbols(path, &["pick-place", "--pddl", "pddl"]);
    let problem = fs::read_to_string(path.join("pddl/problem.pddl")).unwrap();
    assert!(
        problem.starts_with("(define (problem pick-place)\n  (:domain manipulation)"),
        "{problem}"
    );
    let scene = stdout(&locotamp(path, &["scenes", "pick-place"]));
    let scene = format!("{scene}\n[search]\ndomain = \"pddl/domain.pddl\"\nmax_skeleton = 4\n");
    fs::write(path.join("own.toml"), &scene).unwrap();
    let shown = json(path, &["own.toml", "--json"]);
    assert_eq!(shown["skeletons"]["by_length"], serde_json::json!([[4, 2]]));
    // without the rule that a held object must be released first, it stays in the hand
    let domain = fs::read_to_string(path.join("pddl/domain.pddl")).unwrap();
    let own = domain.replace("(:action release", "(:action drop");
    fs::write(path.join("pddl/domain.pddl"), own).unwrap();
    let shown = json(path, &["own.toml", "--json"]);
    let first = &shown["skeletons"]["first"][0];
    assert_eq!(first[0], "grasp left_hand red_box red_box_handle");
    assert_eq!(first[3], "drop left_hand red_box red_box_handle");

    let rest = "(can-rest ?s ?t - surface)";
    let faulty = domain.replace(rest, &format!("{rest} (can-fly ?s - surface)"));
    fs::write(path.join("pddl/domain.pddl"), faulty).unwrap();
    let output = locotamp(path, &["symbols", "own.toml", "--json"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        stderr(&output).contains("\"can-fly\" is never true"),
        "{}",
        stderr(&output)
    );
    assert!(
        stderr(&output).contains("domain.pddl:25:32"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn reaching_up_with_the_base_is_the_objective_base_height() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let source = hopper();
    fs::copy(
        source.with_file_name("hopper.urdf"),
        path.join("hopper.urdf"),
    )
    .unwrap();
    let text = fs::read_to_string(&source).unwrap();
    let plan = |name: &str, objective: &str| {
        let file = format!("{name}.toml");
        fs::write(
            path.join(&file),
            text.replace("kind = \"base_height\"", objective),
        )
        .unwrap();
        let output = locotamp(path, &["plan", &file, "--out", name, "-q"]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        plan::Plan::read(path.join(name).join("plan.json")).unwrap()
    };
    let height = plan("height", "kind = \"base_height\"");
    let reach = plan(
        "reach",
        "kind = \"reach\"\nbody = \"base\"\ndirection = [0, 0, 2]",
    );
    assert_eq!(height.q, reach.q);
    let goal = "kind = \"reach\"\nbody = \"base\"\ndirection = [0, 0, 1]\n\n[[goal.region]]\nbody = \"base\"\nyaw = [0.4, 0.6]\n\
                tilt = 0.05";
    let upright = plan("upright", goal);
    assert_eq!(
        (upright.goal_regions[0].yaw, upright.goal_regions[0].tilt),
        (Some([0.4, 0.6]), Some(0.05))
    );
    let output = locotamp(
        path,
        &[
            "check",
            "upright/plan.json",
            "--profile",
            "accept",
            "--json",
        ],
    );
    assert_eq!(output.status.code(), Some(0), "{}", stdout(&output));
    assert!(
        stdout(&output).contains("goal_orientation"),
        "{}",
        stdout(&output)
    );
}
