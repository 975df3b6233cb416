//! Texts that are no usable robot: each error once, with a message that names the culprit, and no panic on any text.

use multibody::{Model, ModelError, Root};
use spatial::Random;

const BODY: &str =
    r#"<inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial>"#;
const LIMIT: &str = r#"<limit lower="-1" upper="1" effort="10" velocity="5"/>"#;

/// A robot of links `a`, `b`, `c` with mass and whatever joints are given.
fn robot(joints: &str) -> String {
    let links: String = ["a", "b", "c"]
        .map(|name| format!("<link name=\"{name}\">{BODY}</link>\n"))
        .concat();
    format!("<robot name=\"test\">\n{links}{joints}\n</robot>")
}

fn joint(name: &str, kind: &str, parent: &str, child: &str, more: &str) -> String {
    format!(
        "<joint name=\"{name}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{child}\"/>\
         <axis xyz=\"0 0 1\"/>{more}</joint>\n"
    )
}

fn chain() -> String {
    robot(&(joint("j1", "revolute", "a", "b", LIMIT) + &joint("j2", "prismatic", "b", "c", LIMIT)))
}

#[track_caller]
fn refused(text: &str, expected: impl Fn(&ModelError) -> bool, words: &[&str]) {
    let error = Model::from_urdf(text, Root::Floating).expect_err("this text is no robot");
    assert!(expected(&error), "{error:?}");
    let message = error.to_string();
    for word in words {
        assert!(message.contains(word), "{message:?} does not say {word:?}");
    }
}

#[test]
fn a_good_chain_loads() {
    let model = Model::from_urdf(&chain(), Root::Floating).expect("a chain of three links");
    assert_eq!((model.nq, model.nv, model.frames.len()), (9, 8, 3));
    assert_eq!(model.joints[2].name, "j2");
    assert_eq!(model.total_mass(), 3.0);
    let fixed = Model::from_urdf(&chain(), Root::Fixed).expect("the same on the ground");
    assert_eq!((fixed.nq, fixed.nv), (2, 2));
    assert_eq!(fixed.frames[0].joint, None);
}

#[test]
fn children_come_in_the_order_of_the_file_depth_first() {
    let text =
        robot(&(joint("z", "continuous", "a", "b", "") + &joint("y", "continuous", "a", "c", "")));
    let model = Model::from_urdf(&text, Root::Fixed).expect("two branches");
    let names: Vec<&str> = model
        .joints
        .iter()
        .map(|joint| joint.name.as_str())
        .collect();
    assert_eq!(names, ["z", "y"]);
    assert!(model.joints[0].upper.is_infinite());
}

#[test]
fn broken_xml_is_refused_with_its_place() {
    let is = |error: &ModelError| matches!(error, ModelError::Xml { .. });
    refused("<robot><link name=\"a\"></robot>", is, &["1:"]);
    refused("", is, &["XML"]);
    refused(
        "<robot name=\"a\">\n<link name=\"x\"/>\n<link name=></robot>",
        is,
        &["3:"],
    );
    refused(
        "<html/>",
        |error| matches!(error, ModelError::NotARobot { .. }),
        &["html", "robot"],
    );
}

#[test]
fn missing_parts_are_named() {
    let is = |error: &ModelError| matches!(error, ModelError::Missing { .. });
    refused("<robot><link/></robot>", is, &["link", "name"]);
    refused(
        &robot("<joint name=\"j\" type=\"fixed\"><parent link=\"a\"/></joint>"),
        is,
        &["\"j\"", "child"],
    );
    refused(
        &robot("<joint name=\"j\"><parent link=\"a\"/><child link=\"b\"/></joint>"),
        is,
        &["\"j\"", "type"],
    );
    refused(
        "<robot><link name=\"a\"><inertial><mass/><inertia/></inertial></link></robot>",
        is,
        &["\"a\"", "value", "line 1"],
    );
    refused(
        "<robot name=\"empty\"/>",
        |error| matches!(error, ModelError::NoLinks { .. }),
        &["empty"],
    );
}

#[test]
fn numbers_that_are_none_are_shown() {
    let is = |error: &ModelError| matches!(error, ModelError::BadNumber { .. });
    refused(
        &chain().replace("ixx=\"0.1\"", "ixx=\"nan\""),
        is,
        &["\"a\"", "ixx", "nan", "line 2"],
    );
    refused(
        &chain().replace("mass value=\"1\"", "mass value=\"1kg\""),
        is,
        &["1kg"],
    );
    refused(
        &chain().replace("xyz=\"0 0 1\"", "xyz=\"0 0\""),
        is,
        &["\"j1\"", "three"],
    );
    refused(
        &chain().replace("upper=\"1\"", "upper=\"NaN\""),
        is,
        &["\"j1\"", "upper"],
    );
    refused(
        &chain().replace("xyz=\"0 0 1\"", "xyz=\"0 0 inf\""),
        is,
        &["finite"],
    );
}

#[test]
fn names_must_be_unique_and_known() {
    let duplicate = chain().replace("name=\"c\"", "name=\"b\"");
    refused(
        &duplicate,
        |error| matches!(error, ModelError::Duplicate { .. }),
        &["link", "\"b\"", "line 4"],
    );
    let joints = joint("j", "revolute", "a", "b", LIMIT) + &joint("j", "revolute", "b", "c", LIMIT);
    refused(
        &robot(&joints),
        |error| matches!(error, ModelError::Duplicate { .. }),
        &["joint", "\"j\""],
    );
    let unknown = chain().replace("child link=\"c\"", "child link=\"cc\"");
    refused(
        &unknown,
        |error| matches!(error, ModelError::UnknownLink { .. }),
        &["\"j2\"", "\"cc\"", "mean \"c\""],
    );
}

#[test]
fn only_trees_are_accepted() {
    let two = joint("j1", "fixed", "a", "b", "")
        + &joint("j2", "fixed", "a", "c", "")
        + &joint("j3", "fixed", "b", "c", "");
    refused(
        &robot(&two),
        |error| matches!(error, ModelError::TwoParents { .. }),
        &["\"c\"", "\"j2\"", "\"j3\""],
    );
    let ring = joint("j1", "fixed", "a", "b", "")
        + &joint("j2", "fixed", "b", "c", "")
        + &joint("j3", "fixed", "c", "a", "");
    refused(
        &robot(&ring),
        |error| matches!(error, ModelError::Loop { .. }),
        &["ancestor"],
    );
    let apart = joint("j1", "fixed", "b", "c", "") + &joint("j2", "fixed", "c", "b", "");
    refused(
        &robot(&apart),
        |error| matches!(error, ModelError::Loop { .. }),
        &["ancestor"],
    );
    let loose = joint("j1", "fixed", "a", "b", "");
    refused(
        &robot(&loose),
        |error| matches!(error, ModelError::SeveralRoots { .. }),
        &["\"a\"", "\"c\""],
    );
}

#[test]
fn joints_must_be_of_a_known_kind_with_axis_and_limits() {
    for kind in ["planar", "floating", "spherical"] {
        let text = chain().replace("type=\"prismatic\"", &format!("type=\"{kind}\""));
        refused(
            &text,
            |error| matches!(error, ModelError::UnsupportedJoint { .. }),
            &["\"j2\"", kind],
        );
    }
    let flat = chain().replace("xyz=\"0 0 1\"", "xyz=\"0 0 0\"");
    refused(
        &flat,
        |error| matches!(error, ModelError::BadAxis { .. }),
        &["\"j1\""],
    );
    let free = chain().replace(LIMIT, "");
    refused(
        &free,
        |error| matches!(error, ModelError::MissingLimits { .. }),
        &["\"j1\"", "revolute", "continuous"],
    );
    let turned = chain().replace("lower=\"-1\"", "lower=\"2\"");
    refused(
        &turned,
        |error| matches!(error, ModelError::BadLimits { .. }),
        &["\"j1\"", "[2, 1]"],
    );
}

#[test]
fn masses_and_inertias_must_be_possible() {
    let negative = chain().replacen("mass value=\"1\"", "mass value=\"-1\"", 1);
    refused(
        &negative,
        |error| matches!(error, ModelError::BadMass { .. }),
        &["\"a\"", "-1 kg"],
    );
    let impossible = chain().replace("izz=\"0.1\"", "izz=\"-0.1\"");
    refused(
        &impossible,
        |error| matches!(error, ModelError::BadInertia { .. }),
        &["j2", "-1.0e-1"],
    );
    let massless = chain().replace(&format!("<link name=\"c\">{BODY}"), "<link name=\"c\">");
    refused(
        &massless,
        |error| matches!(error, ModelError::MissingInertia { .. }),
        &["\"j2\"", "\"c\"", "inertial"],
    );
    let nothing = "<robot><link name=\"only\"/></robot>";
    refused(
        nothing,
        |error| matches!(error, ModelError::MissingInertia { .. }),
        &["\"only\""],
    );
}

#[test]
fn too_many_joints_are_refused() {
    let link = |i: usize| format!("<link name=\"l{i}\">{BODY}</link>");
    let links = (0..700).map(link).collect::<Vec<_>>().concat();
    let joint = |i: usize| {
        joint(
            &format!("j{i}"),
            "continuous",
            &format!("l{}", i - 1),
            &format!("l{i}"),
            "",
        )
    };
    let joints: String = (1..700).map(joint).collect();
    let text = format!("<robot>{links}{joints}</robot>");
    refused(
        &text,
        |error| matches!(error, ModelError::TooManyJoints { .. }),
        &["512"],
    );
}

#[test]
fn what_cannot_move_on_its_own_is_locked_and_said() {
    let mimic = chain().replace(
        LIMIT,
        &format!("{LIMIT}<mimic joint=\"other\" offset=\"0.5\"/>"),
    );
    let model = Model::from_urdf(&mimic, Root::Floating).expect("mimicking joints are locked");
    assert_eq!(model.nv, 6);
    assert!(
        model.notes[0].contains("\"j1\"") && model.notes[0].contains("0.5"),
        "{:?}",
        model.notes
    );
    let still = chain().replace("lower=\"-1\" upper=\"1\"", "lower=\"0.2\" upper=\"0.2\"");
    let model = Model::from_urdf(&still, Root::Floating).expect("joints of zero range are locked");
    assert_eq!((model.nv, model.notes.len()), (6, 1));
    for joint in ["\"j1\" at 0.2", "\"j2\" at 0.2"] {
        assert!(model.notes[0].contains(joint), "{:?}", model.notes);
    }
    let names: Vec<&str> = model.locked.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["j1", "j2"]);
}

#[test]
fn damping_and_friction_of_joints_are_said_to_be_left_out_with_their_largest_values() {
    let resisted = |text: &str| {
        let text = chain().replace(LIMIT, &format!("{LIMIT}{text}"));
        Model::from_urdf(&text, Root::Floating).unwrap().notes
    };
    let notes = resisted("<dynamics damping=\"0.5\" friction=\"2.25\"/>");
    assert_eq!(notes.len(), 1, "{notes:?}");
    for words in [
        "of 2 joints",
        "damping up to 0.5 N·m·s/rad",
        "friction up to 2.25 N·m",
    ] {
        assert!(notes[0].contains(words), "{words}: {notes:?}");
    }
    for silent in ["<dynamics/>", "<dynamics damping=\"0\" friction=\"\"/>"] {
        assert_eq!(resisted(silent), Vec::<String>::new());
    }
}

#[test]
fn an_effort_limit_of_zero_is_none_and_said_and_one_below_is_refused() {
    let with = |effort: &str| chain().replace("effort=\"10\"", &format!("effort=\"{effort}\""));
    assert_ne!(with("0"), chain());
    let model = Model::from_urdf(&with("0"), Root::Floating).expect("unlimited joints");
    assert!(
        model
            .joints
            .last()
            .is_some_and(|j| j.torque_limit.is_infinite())
    );
    let said = |part: &str| model.notes.iter().any(|note| note.contains(part));
    assert!(said("no limit on the effort of j1"), "{:?}", model.notes);
    refused(
        &with("-7"),
        |error| matches!(error, ModelError::BadEffort { .. }),
        &["\"j1\"", "-7"],
    );
}

#[test]
fn a_velocity_limit_of_zero_is_none_and_said() {
    let still = chain().replace("velocity=\"5\"", "velocity=\"0\"");
    assert_ne!(still, chain());
    let model = Model::from_urdf(&still, Root::Floating).expect("unlimited joints");
    let last = model.joints.last().expect("a joint");
    assert!(last.velocity_limit.is_infinite());
    let said = |part: &str| model.notes.iter().any(|note| note.contains(part));
    assert!(said("no limit on the velocity of j1"), "{:?}", model.notes);
}

#[test]
fn no_mutation_of_a_robot_makes_it_panic() {
    let originals = [chain(), include_str!("../oracle/panda.urdf").to_owned()];
    let pieces = [
        "<", ">", "\"", "/", "-", "1e308", "nan", "inf", "<link", "</robot>", "&#0;", "é", " ",
        "mimic", "0",
    ];
    let mut random = Random::new(7);
    let mut loaded = 0;
    for round in 0..4000 {
        let mut text: Vec<char> = originals[round % 2].chars().collect();
        for _ in 0..=random.index(4) {
            let at = random.index(text.len());
            let until = (at + random.index(40)).min(text.len());
            match random.index(4) {
                0 => drop(text.drain(at..until)),
                1 => text
                    .splice(at..at, pieces[random.index(pieces.len())].chars())
                    .for_each(drop),
                2 => {
                    let copied = text[at..until].to_vec();
                    let to = random.index(text.len());
                    text.splice(to..to, copied).for_each(drop);
                }
                _ => text[at] = char::from(random.index(128) as u8),
            }
        }
        let text: String = text.into_iter().collect();
        for root in [Root::Floating, Root::Fixed] {
            match Model::from_urdf(&text, root) {
                Ok(model) => {
                    loaded += 1;
                    assert!(model.neutral().len() == model.nq);
                }
                Err(error) => assert!(!error.to_string().is_empty()),
            }
        }
    }
    assert!(
        loaded > 100,
        "mutations should leave some robots intact, {loaded} did"
    );
}

#[test]
fn deep_nesting_is_no_way_to_overflow_the_stack() {
    let text = format!(
        "<robot>{}{}</robot>",
        "<link name=\"a\">".repeat(50_000),
        "</link>".repeat(50_000)
    );
    assert!(Model::from_urdf(&text, Root::Floating).is_err());
}
