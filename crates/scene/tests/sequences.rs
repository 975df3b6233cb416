//! Sequence files: what is read, every error once, the schema, and all files of the repository.

use crate::fixtures;
use scene::{Expectation, Scene, SceneError, Sequence, SequenceFile};
use std::path::{Path, PathBuf};
use symbolic::ContactType;

const VALID: &str = r#"name = "grasp"
description = "the crate is grasped"
scene = "pick-place"
steps = 5
expect = "infeasible"
why = "the handle is too far"

[goal]
contacts = [["table_top", "crate_bottom"]]

[[phase]]
contacts = [
    ["left_foot", "ground_top"],
    ["right_foot", "ground_top"],
    ["crate_bottom", "table_top"],
    ["cup_foot", "crate_lid"],
]

[[phase]]
label = "grasp"
steps = 7
contacts = [
    ["left_foot", "ground_top", "unilateral_patch"],
    ["right_foot", "ground_top"],
    ["crate_handle", "left_hand"],
    ["crate_bottom", "table_top"],
    ["cup_foot", "crate_lid"],
]
"#;

/// A scene with a crate on a table and a cup on the crate.
fn scene() -> Scene {
    fixtures::read(fixtures::VALID).unwrap_or_else(|e| panic!("{}", e.render()))
}

fn file(text: &str) -> Result<SequenceFile, SceneError> {
    SequenceFile::from_toml(text, "test.toml", Path::new("folder"))
}

fn read(text: &str) -> Result<Sequence, SceneError> {
    file(text)?.resolve(&scene())
}

#[test]
fn a_sequence_is_read() {
    let sequence = read(VALID).unwrap_or_else(|e| panic!("{}", e.render()));
    assert_eq!(sequence.name, "grasp");
    assert_eq!(sequence.phases[0].state, scene().start_state());
    let steps: Vec<usize> = sequence.phases.iter().map(|p| p.steps).collect();
    assert_eq!(steps, [5, 7]);
    assert_eq!(sequence.phases[1].label.as_deref(), Some("grasp"));
    let grasp = sequence.phases[1]
        .state
        .iter()
        .find(|c| c.kind == ContactType::BilateralPatch)
        .expect("the only type of the handle is taken, in either order of the names");
    assert_eq!(scene().interfaces[grasp.a.0].name, "left_hand");
    assert_eq!(sequence.goal.unwrap().contacts.len(), 1);
    let why = "the handle is too far".to_owned();
    assert_eq!(sequence.expect, Some(Expectation::Infeasible { why }));
}

#[test]
fn what_is_left_out_has_defaults() {
    let text = VALID
        .replace("name = \"grasp\"\n", "")
        .replacen("steps = 5\n", "", 1)
        .replace(
            "expect = \"infeasible\"\nwhy = \"the handle is too far\"\n",
            "",
        );
    let sequence = read(&text).unwrap_or_else(|e| panic!("{}", e.render()));
    assert_eq!(sequence.name, "test");
    assert_eq!(sequence.phases[0].steps, scene().optimiser.steps);
    assert_eq!(sequence.expect, None);
}

/// The message for [`VALID`] with one piece replaced, and the line it points at.
fn refused(piece: &str, replacement: &str) -> (String, usize) {
    assert!(VALID.contains(piece), "no {piece:?} in the valid sequence");
    let text = VALID.replacen(piece, replacement, 1);
    let error = read(&text).expect_err(replacement);
    assert!(error.render().contains("test.toml:"), "{}", error.render());
    let line = error.place().expect("a place").line();
    (error.to_string(), line)
}

/// Piece of [`VALID`], what replaces it, the line of the fault, what its message says.
type Case = (&'static str, &'static str, usize, &'static [&'static str]);

const CASES: &[Case] = &[
    (
        "name = \"grasp\"",
        "nam = \"grasp\"",
        1,
        &["unknown key \"nam\"", "did you mean \"name\"?"],
    ),
    (
        "steps = 5",
        "steps = 0",
        4,
        &["steps is 0", "from 1 to 200"],
    ),
    ("steps = 7", "steps = 201", 21, &["steps is 201"]),
    (
        "\"infeasible\"",
        "\"impossible\"",
        5,
        &["unknown value `impossible`"],
    ),
    (
        "why = \"the handle is too far\"\n",
        "",
        5,
        &["needs the reason", "why ="],
    ),
    (
        "\"infeasible\"",
        "\"feasible\"",
        6,
        &["why", "goes with expect = \"infeasible\" only"],
    ),
    (
        "\"crate_handle\"",
        "\"crate_handel\"",
        25,
        &["crate_handel", "did you mean \"crate_handle\"?"],
    ),
    (
        "\"unilateral_patch\"",
        "\"sticky\"",
        23,
        &["no contact type is called \"sticky\"", "unilateral_patch"],
    ),
    (
        "\"unilateral_patch\"",
        "\"bilateral_patch\"",
        23,
        &["cannot touch", "no contact type in common"],
    ),
    (
        "[\"crate_handle\", \"left_hand\"]",
        "[\"crate_handle\"]",
        25,
        &["expected [interface, interface]"],
    ),
    (
        "[\"crate_handle\", \"left_hand\"]",
        "[\"crate_handle\", \"crate_lid\"]",
        25,
        &["cannot touch"],
    ),
    (
        "[\"crate_handle\", \"left_hand\"]",
        "[\"left_foot\", \"ground_top\"]",
        25,
        &["left_foot on ground_top", "listed twice"],
    ),
    (
        "[\"crate_handle\", \"left_hand\"]",
        "[\"left_foot\", \"table_top\"]",
        25,
        &["left_foot", "touch \"ground_top\" as well"],
    ),
    (
        "[\"crate_handle\", \"left_hand\"]",
        "[\"left_hand\", \"crate_bottom\"]",
        26,
        &["rest and be touched at once"],
    ),
    (
        "    [\"right_foot\", \"ground_top\"],\n",
        "",
        12,
        &[
            "first phase",
            "right_foot on ground_top (unilateral_patch) missing",
        ],
    ),
    (
        "    [\"cup_foot\", \"crate_lid\"],\n]",
        "    [\"cup_foot\", \"crate_lid\"], [\"left_hand\", \"crate_handle\"]\n]",
        12,
        &["left_hand on crate_handle (bilateral_patch) not there"],
    ),
    (
        "[\"table_top\", \"crate_bottom\"]",
        "[\"shelf_top\", \"crate_bottom\"]",
        22,
        &["cannot touch"],
    ),
    (
        "[\"table_top\", \"crate_bottom\"]",
        "[\"ground_top\", \"crate_bottom\"]",
        22,
        &[
            "last phase",
            "crate_bottom on ground_top",
            "[goal] of its own",
        ],
    ),
];

#[test]
fn every_fault_is_named_with_its_line() {
    for &(piece, replacement, line, parts) in CASES {
        let (message, at) = refused(piece, replacement);
        for part in parts {
            assert!(
                message.contains(part),
                "{replacement}: {part:?} is missing in {message:?}"
            );
        }
        if !parts.contains(&"cannot touch") {
            assert_eq!(at, line, "{replacement}: {message}");
        }
    }
}

#[test]
fn an_ambiguous_contact_asks_for_its_type() {
    let mut scene = scene();
    let handle = scene.interface_id("crate_handle").unwrap().0;
    scene.interfaces[handle]
        .contact_types
        .push(ContactType::UnilateralPatch);
    let error = file(VALID).unwrap().resolve(&scene).unwrap_err();
    let message = error.to_string();
    assert!(
        message.contains("unilateral_patch or bilateral_patch") && message.contains("third entry"),
        "{message}"
    );
}

#[test]
fn a_file_without_phases_is_refused() {
    let head = VALID.split("[[phase]]").next().unwrap();
    let message = file(head).unwrap_err().to_string();
    assert!(message.contains("missing key `phase`"), "{message}");
    let message = read(&format!("phase = []\n{head}"))
        .unwrap_err()
        .to_string();
    assert!(message.contains("at least one [[phase]]"), "{message}");
}

#[test]
fn the_scene_of_a_file_is_found_or_asked_for() {
    assert_eq!(
        file(VALID).unwrap().load_scene().unwrap().name,
        "pick-place"
    );
    let wrong = file(&VALID.replace("\"pick-place\"", "\"pick-plac\"")).unwrap();
    let message = wrong.load_scene().unwrap_err().to_string();
    assert!(
        message.contains("test.toml:3") && message.contains("did you mean \"pick-place\"?"),
        "{message}"
    );
    let absent = file(&VALID.replace("\"pick-place\"", "\"../no.toml\"")).unwrap();
    let message = absent.load_scene().unwrap_err().to_string();
    assert!(
        message.contains("test.toml:3") && message.contains("cannot read"),
        "{message}"
    );
    let none = file(&VALID.replace("scene = \"pick-place\"\n", "")).unwrap();
    let message = none.load_scene().unwrap_err().to_string();
    assert!(
        message.contains("expected the path of a scene file"),
        "{message}"
    );
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let message = SequenceFile::load("no/such.toml").unwrap_err().to_string();
    assert!(message.contains("cannot read no/such.toml"), "{message}");
}

/// All sequence files of the repository.
fn repository_files() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/sequences");
    let mut files = Vec::new();
    for folder in std::fs::read_dir(root).unwrap() {
        for path in std::fs::read_dir(folder.unwrap().path()).unwrap() {
            files.push(path.unwrap().path());
        }
    }
    files.sort();
    files
}

#[test]
fn the_files_of_the_repository_are_valid() {
    let files = repository_files();
    assert!(files.len() >= 40);
    let validator = jsonschema::validator_for(&scene::sequence_json_schema()).unwrap();
    let mut infeasible = 0;
    for path in &files {
        let file = SequenceFile::load(path).unwrap_or_else(|e| panic!("{}", e.render()));
        let scene = file
            .load_scene()
            .unwrap_or_else(|e| panic!("{}", e.render()));
        let sequence = file
            .resolve(&scene)
            .unwrap_or_else(|e| panic!("{}", e.render()));
        infeasible += usize::from(matches!(
            sequence.expect,
            Some(Expectation::Infeasible { .. })
        ));
        let json = as_json(&std::fs::read_to_string(path).unwrap());
        assert!(validator.is_valid(&json), "{}", path.display());
    }
    assert!(infeasible >= 8);
}

fn as_json(text: &str) -> serde_json::Value {
    let table: toml::Table = toml::from_str(&text.replace("inf]", "1e9]")).unwrap();
    serde_json::to_value(table).unwrap()
}

#[test]
fn the_committed_schema_is_that_of_the_types() {
    crate::schema::assert_committed("sequence.schema.json", &scene::sequence_json_schema());
}

#[test]
fn the_schema_rejects_spoiled_sequences() {
    let validator = jsonschema::validator_for(&scene::sequence_json_schema()).unwrap();
    assert!(validator.is_valid(&as_json(VALID)));
    for (piece, replacement) in [
        ("steps = 5", "steps = \"5\""),
        ("\"infeasible\"", "\"impossible\""),
        ("[\"crate_handle\", \"left_hand\"]", "[\"crate_handle\"]"),
        ("label = \"grasp\"", "labl = \"grasp\""),
    ] {
        let text = VALID.replacen(piece, replacement, 1);
        assert!(!validator.is_valid(&as_json(&text)), "{replacement}");
    }
}

const DOCUMENT: &str = include_str!("../../../docs/sequence-format.md");

#[test]
fn the_document_names_every_key_and_its_example_is_valid() {
    crate::schema::assert_keys_named(&scene::sequence_json_schema(), DOCUMENT);
    let example = DOCUMENT.split("```toml").nth(1).unwrap();
    let text = example.split("```").next().unwrap();
    let file = file(text).unwrap_or_else(|e| panic!("{}", e.render()));
    let scene = file.load_scene().unwrap();
    let sequence = file.resolve(&scene);
    let sequence = sequence.unwrap_or_else(|e| panic!("{}", e.render()));
    assert_eq!(sequence.phases.len(), 3);
}
