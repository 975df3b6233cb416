//! `locotamp solve` and `locotamp bench` from outside.

use crate::{hopper, locotamp, stderr, stdout};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Two phases on the block.
const STAND: &str = "steps = 4\n[[phase]]\ncontacts = [[\"foot\", \"block_top\"]]\n[[phase]]\nlabel = \"rise\"\n\
                     contacts = [[\"foot\", \"block_top\"]]\n";

/// The goal "the trunk 2 m above the block".
const TOO_HIGH: &str = "[goal]\nregion = [{ body = \"base\", z = [2.2, 2.3] }]\n";

/// Solves a text on the scene of the hopper; the exit code and both outputs.
fn solve(folder: &Path, sequence: &str, more: &[&str]) -> (Option<i32>, String, String) {
    fs::write(folder.join("sequence.toml"), sequence).unwrap();
    let scene = hopper();
    let mut arguments = vec!["solve", scene.to_str().unwrap()];
    arguments.extend(["--sequence", "sequence.toml", "--out", "out"]);
    arguments.extend(more);
    let output = locotamp(folder, &arguments);
    (output.status.code(), stdout(&output), stderr(&output))
}

fn repository(path: &str) -> String {
    format!("{}/../../scenes/{path}", env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn a_sequence_becomes_a_plan_and_a_report() {
    let folder = tempfile::tempdir().unwrap();
    let goal = "[goal]\nregion = [{ body = \"base\", z = [0.3, 1.0] }]\n";
    let sequence = STAND.replacen("[[phase]]", &format!("{goal}[[phase]]"), 1);
    let (code, text, errors) = solve(folder.path(), &sequence, &[]);
    assert_eq!(code, Some(0), "{text}{errors}");
    for part in [
        "hopper, sequence: a feasible plan, 2 phases, ",
        "from 8 intervals",
        "rise",
        "derivatives",
        "report.json",
        "accepted",
    ] {
        assert!(text.contains(part), "{part:?} is missing in:\n{text}");
    }
    let report = fs::read_to_string(folder.path().join("out/report.json")).unwrap();
    let report: Value = serde_json::from_str(&report).unwrap();
    assert_eq!(report["status"], "feasible");
    assert_eq!(report["keyframes"]["possible"], true);
    let status = &report["optimiser"]["status"];
    assert!(status == "solved" || status == "good enough", "{status}");
    let seconds = &report["optimiser"]["seconds"];
    let parts = [
        "derivatives",
        "assembly_and_factorisation",
        "substitution",
        "line_search",
    ];
    let sum: f64 = parts
        .iter()
        .map(|part| seconds[part].as_f64().unwrap())
        .sum();
    assert!(sum > 0.0 && sum <= seconds["total"].as_f64().unwrap());
    let plan = plan::Plan::read(folder.path().join("out/plan.json")).unwrap();
    assert_eq!(plan.phases.len(), 2);
    assert_eq!(plan.phases[1].action, "rise");
    assert_eq!(plan.goal_regions[0].body, "trunk", "the base by its link");
}

#[test]
fn the_sequence_of_a_plan_file_is_solved_again() {
    let folder = tempfile::tempdir().unwrap();
    let (code, text, errors) = solve(folder.path(), STAND, &["--no-refine"]);
    assert_eq!(code, Some(0), "{text}{errors}");
    let scene = hopper();
    let arguments = [
        "solve",
        scene.to_str().unwrap(),
        "--sequence",
        "out/plan.json",
        "--out",
        "again",
    ];
    let output = locotamp(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let read = |path: &str| plan::Plan::read(folder.path().join(path)).unwrap();
    let contacts = |plan: &plan::Plan| -> Vec<_> {
        let of_phase = |p: &plan::Phase| {
            let pairs = p
                .contacts
                .iter()
                .map(|c| (c.a.clone(), c.b.clone(), c.kind));
            (p.action.clone(), pairs.collect::<Vec<_>>())
        };
        plan.phases.iter().map(of_phase).collect()
    };
    let (first, again) = (read("out/plan.json"), read("again/plan.json"));
    assert_eq!(contacts(&first), contacts(&again));
    // A plan for other names is no plan for this scene.
    let text = fs::read_to_string(folder.path().join("out/plan.json")).unwrap();
    fs::write(
        folder.path().join("other.json"),
        text.replace("block_top", "slab_top"),
    )
    .unwrap();
    let arguments = ["solve", scene.to_str().unwrap(), "--sequence", "other.json"];
    let output = locotamp(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(2));
    for part in ["slab_top", "sequence of other.json"] {
        assert!(stderr(&output).contains(part), "{}", stderr(&output));
    }
}

#[test]
fn the_written_motion_has_fine_steps_unless_the_coarse_one_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let one_leg = repository("sequences/flat/one_leg.toml");
    let flat = repository("flat.toml");
    let run = |more: &[&str]| -> (Value, plan::Plan) {
        let arguments = [
            &["solve", &flat, "--sequence", &one_leg, "--json", "-q"],
            more,
        ]
        .concat();
        let output = locotamp(folder.path(), &[&arguments[..], &["--out", "out"]].concat());
        assert_eq!(output.status.code(), Some(0), "{}", stdout(&output));
        let plan = plan::Plan::read(folder.path().join("out/plan.json")).unwrap();
        (serde_json::from_str(&stdout(&output)).unwrap(), plan)
    };
    let longest = |plan: &plan::Plan| {
        let steps = plan.time.windows(2).map(|pair| pair[1] - pair[0]);
        steps.fold(0.0, f64::max)
    };
    let (coarse, plan) = run(&["--no-refine"]);
    assert_eq!(plan.integrator, plan::Integrator::Euler);
    assert!(coarse["refinement"].is_null());
    assert!(longest(&plan) > 0.02);
    let missing = |report: &Value| {
        report["quality"]["between_nodes"]["base_force"]
            .as_f64()
            .unwrap()
    };
    let (fine, plan) = run(&[]);
    assert_eq!(plan.integrator, plan::Integrator::ConstantAcceleration);
    assert_eq!(fine["refinement"]["done"], true);
    assert!(longest(&plan) <= 0.02 + 1e-9);
    assert!(missing(&fine) < missing(&coarse).min(1.0), "{fine}");
    assert!(plan.extra.contains_key("quality"));
    let (semi, plan) = run(&["--no-refine", "--integrator", "semi-implicit-euler"]);
    assert_eq!(plan.integrator, plan::Integrator::SemiImplicitEuler);
    assert_eq!(semi["check"]["ok"], true);
}

#[test]
fn the_paper_and_sticking_by_velocity_have_one_integrator() {
    let folder = tempfile::tempdir().unwrap();
    let more = ["--preset", "paper", "--integrator", "constant-acceleration"];
    let (code, _, errors) = solve(folder.path(), STAND, &more);
    assert_eq!(code, Some(2), "{errors}");
    assert!(errors.contains("explicit Euler only"), "{errors}");
    let more = [
        "--sticking",
        "velocity",
        "--integrator",
        "constant-acceleration",
    ];
    let (code, _, errors) = solve(folder.path(), STAND, &more);
    assert_eq!(code, Some(2), "{errors}");
    assert!(errors.contains("stick by displacement"), "{errors}");
}

#[test]
fn without_keyframes_there_is_a_reason_and_no_plan() {
    let folder = tempfile::tempdir().unwrap();
    let (code, text, _) = solve(
        folder.path(),
        &format!("{TOO_HIGH}{}", &STAND[10..]),
        &["-q"],
    );
    assert_eq!(code, Some(1), "{text}");
    assert!(text.contains("no keyframes: "), "{text}");
    assert!(text.contains(" m off, in phase "), "{text}");
    assert!(!folder.path().join("out/plan.json").exists());
    let report = fs::read_to_string(folder.path().join("out/report.json")).unwrap();
    let report: Value = serde_json::from_str(&report).unwrap();
    assert_eq!(report["status"], "none");
    assert_eq!(report["keyframes"]["possible"], false);
}

#[test]
fn without_a_motion_the_joint_is_named_in_si_units() {
    let folder = tempfile::tempdir().unwrap();
    let scene = repository("weak-leg.toml");
    let sequence = repository("sequences/weak_leg/stand.toml");
    let arguments = ["solve", &scene, "--sequence", &sequence, "--json", "-q"];
    let output = locotamp(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let result: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(result["status"], "infeasible");
    let reason = result["reason"].as_str().unwrap();
    assert!(
        reason.contains("torque limit of slide") && reason.contains("in phase 1"),
        "{reason}"
    );
    let without = [&arguments[..], &["--no-torque-limits"]].concat();
    let output = locotamp(folder.path(), &without);
    assert_eq!(output.status.code(), Some(0), "{}", stdout(&output));
}

#[test]
fn the_same_sequence_gives_the_same_file() {
    let folder = tempfile::tempdir().unwrap();
    let mut texts = Vec::new();
    for _ in 0..2 {
        solve(folder.path(), STAND, &["-q"]);
        texts.push(fs::read(folder.path().join("out/plan.json")).unwrap());
    }
    assert!(texts[0] == texts[1]);
}

#[test]
fn flight_and_single_intervals_are_no_reason_to_panic() {
    let folder = tempfile::tempdir().unwrap();
    let flight = format!("{STAND}[[phase]]\ncontacts = []\n{}", &STAND[10..]);
    for text in [flight, STAND.replace("steps = 4", "steps = 1")] {
        let (code, text, errors) = solve(folder.path(), &text, &["-q"]);
        assert!(matches!(code, Some(0 | 1)), "{text}{errors}");
    }
}

#[test]
fn a_faulty_sequence_shows_its_line_and_ends_with_two() {
    let folder = tempfile::tempdir().unwrap();
    let wrong = STAND.replacen("block_top", "blok_top", 1);
    let (code, _, errors) = solve(folder.path(), &wrong, &[]);
    assert_eq!(code, Some(2), "{errors}");
    for part in ["sequence.toml:3", "blok_top", "did you mean \"block_top\"?"] {
        assert!(errors.contains(part), "{part:?} is missing in:\n{errors}");
    }
    assert!(!folder.path().join("out").exists());
}

#[test]
fn the_bench_compares_with_what_is_expected() {
    let folder = tempfile::tempdir().unwrap();
    let set = folder.path().join("set");
    fs::create_dir(&set).unwrap();
    let scene = hopper();
    let head = format!("scene = {:?}\n", scene.to_str().unwrap());
    let stand = format!("{head}expect = \"feasible\"\n{STAND}");
    let high = format!(
        "{head}expect = \"infeasible\"\nwhy = \"out of reach\"\n{TOO_HIGH}{}",
        &STAND[10..]
    );
    fs::write(set.join("stand.toml"), stand).unwrap();
    fs::write(set.join("high.toml"), high).unwrap();
    let output = locotamp(folder.path(), &["bench", "set", "-q"]);
    let text = stdout(&output);
    assert_eq!(output.status.code(), Some(0), "{text}{}", stderr(&output));
    for part in [
        "high",
        "no keyframes",
        "accepted",
        "1 of 1 feasible ones solved and accepted, 1 of 1 infeasible ones without a plan",
    ] {
        assert!(text.contains(part), "{part:?} is missing in:\n{text}");
    }
    let output = locotamp(
        folder.path(),
        &["bench", "set", "--filter", "stand", "--json", "-q"],
    );
    let rows: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(rows.as_array().unwrap().len(), 1);
    assert_eq!(rows[0]["as_expected"], true);
    assert_eq!(rows[0]["report"]["optimiser"]["status"], "solved");
    let wrong = format!("{head}expect = \"infeasible\"\nwhy = \"none\"\n{STAND}");
    fs::write(set.join("stand.toml"), wrong).unwrap();
    let output = locotamp(folder.path(), &["bench", "set", "--filter", "stand", "-q"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(stdout(&output).contains("! stand"), "{}", stdout(&output));
}

#[test]
fn a_bench_without_files_ends_with_two() {
    let folder = tempfile::tempdir().unwrap();
    let output = locotamp(folder.path(), &["bench", "."]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        stderr(&output).contains("no sequence file"),
        "{}",
        stderr(&output)
    );
    let output = locotamp(folder.path(), &["bench", "no-such-folder"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        stderr(&output).contains("cannot read no-such-folder"),
        "{}",
        stderr(&output)
    );
}
