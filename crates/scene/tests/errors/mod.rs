//! Every message of a bad scene once: file and line, what is wrong, what was expected, the remedy.

mod meanings;
mod texts;

use crate::fixtures::{read, spoiled};
use scene::Scene;

/// A piece of the valid scene, its replacement, and the message: how it begins, then after each " … " what it also says.
type Case = (&'static str, &'static str, &'static str);

fn assert_messages(cases: &[Case]) {
    let mut wrong = Vec::new();
    for (piece, replacement, message) in cases {
        let text = spoiled(piece, replacement);
        let Err(error) = read(&text) else {
            panic!("{replacement:?} passes");
        };
        let shown = error.to_string();
        let (start, rest) = message.split_once(" … ").unwrap_or((message, ""));
        if !(shown.starts_with(start) && rest.split(" … ").all(|part| shown.contains(part))) {
            wrong.push(format!("{shown}\nexpected: {message}"));
        }
        let place = error.place().expect("the fault stands in the file");
        let rendered = error.render();
        let line = text.lines().nth(place.line() - 1).unwrap_or_default();
        assert!(rendered.contains(line.trim_end()), "{rendered}");
        assert!(rendered.contains(&error.fault().to_string()), "{rendered}");
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

#[test]
fn syntax_keys_and_types() {
    assert_messages(texts::SYNTAX);
}

#[test]
fn numbers() {
    assert_messages(texts::NUMBERS);
}

#[test]
fn names() {
    assert_messages(texts::NAMES);
}

#[test]
fn keys_that_do_not_go_together() {
    assert_messages(meanings::KEYS);
}

#[test]
fn contacts_that_cannot_be() {
    assert_messages(meanings::CONTACTS);
}

#[test]
fn starts_that_do_not_hold() {
    assert_messages(meanings::STARTS);
}

#[test]
fn objects_that_stand_on_each_other_in_a_ring() {
    let text = spoiled("on = \"table_top\"", "on = \"cup_top\"")
        .replace(
            "position = [0.6, 0.1, 0.95]",
            "on = \"crate_lid\"\nwith = \"cup_foot\"\ninterface = [{ name = \"cup_top\", side = \"+z\", position = [0, 0, 0], half_size = [1, 1] }, \
             { name = \"cup_foot\", side = \"-z\", position = [0, 0, 0], half_size = [0.02, 0.02], lands = true }]",
        );
    let end = text
        .find("[[object.interface]]\nname = \"cup_foot\"")
        .unwrap();
    let goal = text.find("[goal]").unwrap();
    let error = read(&format!("{}{}", &text[..end], &text[goal..])).unwrap_err();
    let message = error.to_string();
    let expected = "test.toml:26: objects \"crate\", \"cup\" stand on each other in a ring; give one of them a position";
    assert!(message.starts_with(expected), "{message}");
}

#[test]
fn a_support_that_can_only_be_the_upper_one() {
    let text = spoiled(
        "on = \"table_top\"\nposition = [0.0, 0.0]",
        "on = \"cup_foot\"\nwith = \"crate_lid\"",
    );
    let message = read(&text).unwrap_err().to_string();
    let expected = "test.toml:26: object \"crate\": \"crate_lid\" cannot stand on \"cup_foot\"; the other way round it can";
    assert!(message.starts_with(expected), "{message}");
}

#[test]
fn goals_that_ask_for_nothing() {
    let without_goal = |goal: &str| {
        let text = spoiled(
            "[goal]\ncontacts = [[\"crate_bottom\", \"ground_top\"]]\n",
            goal,
        );
        text.replace("[[goal.region]]\nbody = \"base\"\nx = [-0.5, 0.5]\n", "")
    };
    let cases = [
        (
            "",
            "test.toml:1: the scene asks for nothing: it has neither [goal] nor [objective]; add contacts",
        ),
        (
            "[goal]\n",
            "test.toml:54: the scene asks for nothing: [goal] names neither a contact nor a region",
        ),
        (
            "[goal]\ncontacts = []\n",
            "test.toml:54: the scene asks for nothing: [goal] names neither",
        ),
        (
            "[objective]\nkind = \"time\"\n",
            "test.toml:55: the scene asks for nothing: least time without a goal is reached by doing nothing",
        ),
    ];
    for (goal, expected) in cases {
        let message = read(&without_goal(goal)).unwrap_err().to_string();
        assert!(
            message.starts_with(expected),
            "{message}\nexpected: {expected}"
        );
    }
    assert!(read(&without_goal("[objective]\nkind = \"base_height\"\n")).is_ok());
}

#[test]
fn faults_of_a_pddl_domain_are_shown_in_its_own_file() {
    let folder = tempfile::tempdir().unwrap();
    let text = spoiled("max_changes = 2", "max_changes = 2\ndomain = \"own.pddl\"");
    let load = || {
        Scene::from_toml(&text, "test.toml", folder.path()).map_err(|e| (e.to_string(), e.render()))
    };
    let (message, _) = load().unwrap_err();
    assert!(
        message.starts_with("test.toml:63: cannot read "),
        "{message}"
    );
    std::fs::write(
        folder.path().join("own.pddl"),
        "(define (domain own)\n  (:axiom))\n",
    )
    .unwrap();
    let (message, rendered) = load().unwrap_err();
    let expected = "own.pddl:2:3: the section \":axiom\" is not supported; expected :requirements";
    assert!(message.contains(expected), "{message}");
    assert!(rendered.contains("2 │   (:axiom))"), "{rendered}");
    let builtin = symbolic::pddl::DomainFile::builtin();
    std::fs::write(folder.path().join("own.pddl"), builtin.text()).unwrap();
    let scene = load().unwrap();
    assert!(
        scene
            .search
            .domain
            .is_some_and(|domain| domain.is_builtin())
    );
}

#[test]
fn a_rendered_error_shows_the_line_and_the_remedy() {
    let error = read(&spoiled("on = \"table_top\"", "on = \"tabel_top\"")).unwrap_err();
    let rendered = error.render();
    for part in [
        "Error: object \"crate\": no interface is called \"tabel_top\"",
        "test.toml:26:6",
        "26 │ on = \"tabel_top\"",
        "Help: did you mean \"table_top\"?",
    ] {
        assert!(rendered.contains(part), "{rendered}");
    }
    assert!(!rendered.contains('\u{1b}'), "no colours");
}

#[test]
fn an_empty_text_lacks_its_name() {
    let error = Scene::from_toml("", "empty.toml", std::path::Path::new("")).unwrap_err();
    assert!(
        error
            .to_string()
            .starts_with("empty.toml:1: missing key `name`"),
        "{error}"
    );
    assert!(!error.render().is_empty());
}
