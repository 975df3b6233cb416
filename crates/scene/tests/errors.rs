//! Every message of a bad scene once: file and line, what is wrong, what was expected, the remedy.

use crate::fixtures::{read, spoiled};
use scene::Scene;

/// A replacement in the valid scene, and how the message then begins and what it also says.
struct Case {
    piece: &'static str,
    replacement: &'static str,
    message: &'static str,
    also: &'static str,
}

const fn case(
    piece: &'static str,
    replacement: &'static str,
    message: &'static str,
    also: &'static str,
) -> Case {
    Case {
        piece,
        replacement,
        message,
        also,
    }
}

fn assert_messages(cases: &[Case]) {
    let mut wrong = Vec::new();
    for Case {
        piece,
        replacement,
        message,
        also,
    } in cases
    {
        let text = spoiled(piece, replacement);
        let Err(error) = read(&text) else {
            panic!("{replacement:?} passes");
        };
        let shown = error.to_string();
        if !(shown.starts_with(message) && shown.contains(also)) {
            wrong.push(format!(
                "{shown}
expected: {message} … {also}"
            ));
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
    assert_messages(&[
        case("[start]", "[start", "test.toml:4: malformed TOML: ", ""),
        case(
            "robot = \"g1\"",
            "robot = g1",
            "test.toml:2: malformed TOML: ",
            "",
        ),
        case(
            "mass = 2.0",
            "mas = 2.0",
            "test.toml:24: unknown key \"mas\"; did you mean \"mass\"? known: name, mass",
            "position",
        ),
        case(
            "max_changes = 2",
            "qqqqqqqqqqqq = 2",
            "test.toml:62: unknown key \"qqqqqqqqqqqq\"; known: max_phases",
            "",
        ),
        case(
            "mass = 2.0",
            "mass = \"2 kg\"",
            "test.toml:24: invalid type: string \"2 kg\", expected a number",
            "",
        ),
        case("mass = 2.0\n", "", "test.toml:22: missing key `mass`", ""),
        case(
            "size = [0.4, 0.6, 0.04]",
            "size = [0.4, 0.6]",
            "test.toml:14: invalid length 2, expected an array of length 3",
            "",
        ),
        case(
            "side = \"+y\"",
            "side = \"left\"",
            "test.toml:31: unknown value `left`, expected one of `+x`, `-x`",
            "",
        ),
        case(
            "[\"bilateral_patch\"]",
            "[\"sticky\"]",
            "test.toml:34: unknown value `sticky`, expected one of `unilateral_point`",
            "",
        ),
        case(
            "max_changes = 2",
            "max_changes = 1.5",
            "test.toml:62: invalid type: number `1.5`, expected a whole number",
            "",
        ),
    ]);
}

#[test]
fn numbers() {
    assert_messages(&[
        case(
            "mass = 2.0",
            "mass = -1",
            "test.toml:24: mass of object \"crate\" is -1 kg, expected a positive number",
            "",
        ),
        case(
            "mass = 2.0",
            "mass = nan",
            "test.toml:24: mass of object \"crate\" is NaN kg",
            "",
        ),
        case(
            "mass = 2.0",
            "mass = inf",
            "test.toml:24: mass of object \"crate\" is inf kg",
            "",
        ),
        case(
            "mass = 2.0",
            "mass = 1e9",
            "test.toml:24: object \"crate\": a mass of 1000000000 kg, expected at most 100000 kg",
            "",
        ),
        case(
            "size = [0.2, 0.3, 0.2]",
            "size = [0.2, -0.3, 0.2]",
            "test.toml:25: size of object \"crate\" is [0.2, -0.3, 0.2] m, expected 3 positive numbers",
            "",
        ),
        case(
            "position = [0.6, 0.0, 0.73]",
            "position = [0.6, nan, 0.73]",
            "test.toml:15: position of static body \"table\" is [0.6, NaN, 0.73], expected finite numbers",
            "",
        ),
        case(
            "position = [0.6, 0.0, 0.73]",
            "position = [0.6, 0.0, 0.73]\nquaternion = [0, 0, 0, 2]",
            "test.toml:16: quaternion [x, y, z, w] of static body \"table\" is [0.0, 0.0, 0.0, 2.0] of length 2.0000, \
             expected length 1; [0, 0, 0, 1] means no rotation",
            "",
        ),
        case(
            "position = [0.6, 0.0, 0.73]",
            "position = [0.6, 0.0, 0.73]\nyaw = inf",
            "test.toml:16: yaw of static body \"table\" is inf, expected a finite number",
            "",
        ),
        case(
            "radius = 0.03",
            "radius = 0",
            "test.toml:43: capsule radius of \"cup\" is 0 m, expected a positive number",
            "",
        ),
        case(
            "length = 0.1",
            "length = -0.1",
            "test.toml:43: capsule length of \"cup\" is -0.1 m, expected a finite number that is not negative",
            "",
        ),
        case(
            "half_size = [0.03, 0.03]",
            "half_size = [0.03, 0]",
            "test.toml:33: half_size of interface \"crate_handle\" is [0.03, 0.0] m",
            "",
        ),
        case(
            "inertia = [1e-4, 1e-4, 1e-4,",
            "inertia = [1e-4, 1e-4, 3e-4,",
            "test.toml:45: object \"cup\": inertia [0.0001, 0.0001, 0.0003, 0.0, 0.0, 0.0] kg·m² is that of no body",
            "none larger than the sum of the other two",
        ),
        case(
            "side = \"+z\"",
            "side = \"+z\"\nmu = -0.1",
            "test.toml:39: mu of interface \"crate_lid\" is -0.1, expected a finite number that is not negative",
            "",
        ),
        case(
            "side = \"+z\"",
            "side = \"+z\"\nmax_force = 0",
            "test.toml:39: max_force of interface \"crate_lid\" is 0 N, expected a positive number",
            "",
        ),
        case(
            "robot = \"g1\"",
            "robot = \"g1\"\ngravity = [0, 0, nan]",
            "test.toml:3: gravity is [0.0, 0.0, NaN], expected finite numbers",
            "",
        ),
        case(
            "steps = 8",
            "steps = 0",
            "test.toml:65: steps is 0, expected a whole number from 1 to 200",
            "",
        ),
        case(
            "min_duration = 0.3",
            "min_duration = 0.3\nmax_duration = 0.2",
            "test.toml:67: max_duration: 0.2 s is less than min_duration, 0.3 s; raise it",
            "",
        ),
        case(
            "x = [-0.5, 0.5]",
            "x = [0.5, -0.5]",
            "test.toml:59: goal region of \"base\" is [0.5, -0.5], expected [smallest, largest]",
            "",
        ),
        case(
            "joints = { waist_yaw_joint = 0.1 }",
            "joints = { waist_yaw_joint = 9.5 }",
            "test.toml:6: joint \"waist_yaw_joint\" starts at 9.5, expected a value within its limits [-2.618, 2.618]; \
             set it in [start.joints]",
            "",
        ),
        case(
            "joints = { waist_yaw_joint = 0.1 }",
            "joints = { waist_yaw_joint = nan }",
            "test.toml:6: position of joint \"waist_yaw_joint\" is NaN, expected a finite number",
            "",
        ),
    ]);
}

#[test]
fn names() {
    assert_messages(&[
        case(
            "on = \"table_top\"",
            "on = \"tabel_top\"",
            "test.toml:26: object \"crate\": no interface is called \"tabel_top\"; did you mean \"table_top\"? known: ",
            "left_foot",
        ),
        case(
            "[\"crate_bottom\", \"ground_top\"]",
            "[\"crate_bottom\", \"table_c_top\"]",
            "test.toml:55: goal contact: no interface is called \"table_c_top\"; did you mean \"table_top\"?",
            "",
        ),
        case(
            "body = \"base\"",
            "body = \"bass\"",
            "test.toml:58: goal region: no object, robot link or interface that can move is called \"bass\"; did you \
             mean \"base\"?",
            "",
        ),
        case(
            "body = \"base\"",
            "body = \"table\"",
            "test.toml:58: goal region: no object, robot link or interface that can move is called \"table\"",
            "",
        ),
        case(
            "waist_yaw_joint",
            "waist_jaw_joint",
            "test.toml:6: robot: no moving joint is called \"waist_jaw_joint\"; did you mean \"waist_yaw_joint\"?",
            "",
        ),
        case(
            "robot = \"g1\"",
            "robot = \"g2\"",
            "test.toml:2: robot: no built-in robot is called \"g2\"; did you mean \"g1\"? known: g1, or a path",
            "",
        ),
        case(
            "robot = \"g1\"",
            "robot = \"no/such/robot.toml\"",
            "test.toml:2: cannot read no/such/robot.toml: ",
            "check the path",
        ),
        case(
            "name = \"shelf\"",
            "name = \"table\"",
            "test.toml:18: the body \"table\" exists already; give it another name",
            "",
        ),
        case(
            "name = \"cup\"",
            "name = \"pelvis\"",
            "test.toml:41: the body \"pelvis\" exists already",
            "",
        ),
        case(
            "name = \"crate_lid\"",
            "name = \"left_hand\"",
            "test.toml:37: the interface \"left_hand\" exists already",
            "",
        ),
        case(
            "name = \"shelf\"",
            "name = \" \"",
            "test.toml:18: name: it is empty",
            "",
        ),
        case(
            "joints = {",
            "contacts = [[\"left_foot\", \"ground_top\", \"glue\"]]\njoints = {",
            "test.toml:6: start contact: no contact type is called \"glue\"; known: unilateral_point",
            "",
        ),
    ]);
}

#[test]
fn keys_that_do_not_go_together() {
    assert_messages(&[
        case(
            "side = \"+z\"",
            "",
            "test.toml:37: interface \"crate_lid\": expected exactly one of side and quaternion",
            "",
        ),
        case(
            "side = \"-z\"\nposition = [0.0, 0.0, 0.0]",
            "side = \"-z\"",
            "test.toml:48: interface \"cup_foot\": expected a position",
            "",
        ),
        case(
            "half_size = [0.02, 0.02]",
            "",
            "test.toml:48: interface \"cup_foot\": expected half_size = [x, y]",
            "",
        ),
        case(
            "half_size = [0.02, 0.02]",
            "kind = \"point\"\nhalf_size = [0.02, 0.02]",
            "test.toml:52: interface \"cup_foot\": a point has no half_size",
            "",
        ),
        case(
            "[\"bilateral_patch\"]",
            "[]",
            "test.toml:34: interface \"crate_handle\": contacts is empty",
            "",
        ),
        case(
            "size = [0.1, 0.1, 0.04]",
            "size = [0.1, 0.1, 0.04]\nplane = true",
            "test.toml:20: static body \"shelf\": a plane has no size and no shape",
            "",
        ),
        case(
            "size = [0.1, 0.1, 0.04]",
            "",
            "test.toml:18: static body \"shelf\": expected size = [x, y, z], plane = true or a [[static.shape]]",
            "",
        ),
        case(
            "size = [0.2, 0.3, 0.2]",
            "bottom = false",
            "test.toml:23: object \"crate\": expected size = [x, y, z] or an [[object.shape]]",
            "",
        ),
        case(
            "capsule = { radius = 0.03, length = 0.1 }, ",
            "",
            "test.toml:43: shape of \"cup\": expected exactly one of box, sphere, capsule",
            "",
        ),
        case(
            "capsule = { radius = 0.03, length = 0.1 }, ",
            "box = [1e-160, 1e-160, 1e-160], ",
            "test.toml:41: object \"cup\": the shapes are too small or too large",
            "",
        ),
        case(
            "on = \"table_top\"\nposition = [0.0, 0.0]",
            "",
            "test.toml:23: object \"crate\": expected position = [x, y, z] or on = \"<interface>\"",
            "",
        ),
        case(
            "on = \"table_top\"\n",
            "",
            "test.toml:26: object \"crate\": expected position = [x, y, z], or two numbers together with on",
            "",
        ),
        case(
            "on = \"table_top\"\nposition = [0.0, 0.0]",
            "on = \"table_top\"\nposition = [0.0, 0.0, 0.0]",
            "test.toml:27: object \"crate\": expected position = [x, y] in the plane",
            "",
        ),
        case(
            "on = \"table_top\"",
            "on = \"table_top\"\nquaternion = [0, 0, 0, 1]",
            "test.toml:27: object \"crate\": a quaternion cannot be given together with on",
            "",
        ),
        case(
            "on = \"table_top\"",
            "on = \"table_top\"\nwith = \"table_top\"",
            "test.toml:27: object \"crate\": `with` names an interface of something else",
            "",
        ),
        case(
            "inertia = [1e-4",
            "with = \"cup_foot\"\ninertia = [1e-4",
            "test.toml:45: object \"cup\": `with` names what stands on `on`, which is missing",
            "",
        ),
        case(
            "position = [0.6, 0.1, 0.95]",
            "on = \"crate_lid\"",
            "test.toml:44: object \"cup\": it has no interface \"cup_bottom\" to stand on; name one with = \"…\"",
            "",
        ),
        case(
            "position = [0.6, 0.0, 0.73]",
            "yaw = 0\nquaternion = [0, 0, 0, 1]",
            "test.toml:16: static body \"table\": both yaw and quaternion are given",
            "",
        ),
        case(
            "position = [0.0, 0.0]\njoints",
            "position = [0.0]\njoints",
            "test.toml:5: position of the start: expected [x, y] or [x, y, z]",
            "",
        ),
        case(
            "joints = {",
            "contacts = [[\"left_foot\"]]\njoints = {",
            "test.toml:6: start contact: expected [interface, interface] or",
            "",
        ),
        case(
            "[\"crate_bottom\", \"ground_top\"]",
            "[\"crate_bottom\"]",
            "test.toml:55: goal contact: expected a pair [interface, interface]",
            "",
        ),
        case(
            "x = [-0.5, 0.5]",
            "",
            "test.toml:57: goal region of \"base\": expected at least one of x, y, z",
            "",
        ),
        case(
            "size = [0.1, 0.1, 0.04]",
            "size = [0.1, 0.1, 0.04]\ninterface = [{ name = \"s\", side = \"+x\", lands = true }]",
            "test.toml:20: interface \"s\": a surface of a static body cannot land on anything",
            "",
        ),
    ]);
}

#[test]
fn contacts_that_cannot_be() {
    assert_messages(&[
        case(
            "[\"crate_bottom\", \"ground_top\"]",
            "[\"table_top\", \"ground_top\"]",
            "test.toml:55: \"table_top\" cannot touch \"ground_top\": both belong to static bodies; name an interface",
            "",
        ),
        case(
            "[\"crate_bottom\", \"ground_top\"]",
            "[\"crate_lid\", \"ground_top\"]",
            "test.toml:55: \"crate_lid\" cannot touch \"ground_top\": neither is made to land on the other; set lands",
            "",
        ),
        case(
            "[\"crate_bottom\", \"ground_top\"]",
            "[\"crate_bottom\", \"crate_lid\"]",
            "test.toml:55: \"crate_bottom\" cannot touch \"crate_lid\": both belong to the same object",
            "",
        ),
        case(
            "[\"crate_bottom\", \"ground_top\"]",
            "[\"left_hand\", \"right_hand\"]",
            "test.toml:55: ",
            "nothing lands on the robot",
        ),
        case(
            "[\"crate_bottom\", \"ground_top\"]",
            "[\"left_foot\", \"crate_handle\"]",
            "test.toml:55: \"left_foot\" cannot touch \"crate_handle\": no contact type in common: one takes \
             unilateral_patch, the other bilateral_patch; add a common type",
            "",
        ),
        case(
            "joints = {",
            "contacts = [[\"left_foot\", \"ground_top\", \"bilateral_patch\"]]\njoints = {",
            "test.toml:6: \"left_foot\" cannot touch \"ground_top\": no contact type in common",
            "(bilateral_patch asked for)",
        ),
        case(
            "half_size = [0.02, 0.02]\nlands = true",
            "half_size = [0.02, 0.02]\nlands = true\n[[object.interface]]\nname = \"tip\"\nside = \"+z\"\nkind = \
             \"point\"\nposition = [0, 0, 0.1]\nlands = true\ncontacts = [\"unilateral_patch\"]\n[[goal.region]]\n\
             body = \"tip\"\nx = [0, 1]\n[[object]]\nname = \"thing\"\nmass = 1\nsize = [0.1, 0.1, 0.1]\n\
             on = \"ground_top\"\nwith = \"thing_tip\"\nposition = [-1, 0]\n[[object.interface]]\nname = \
             \"thing_tip\"\nside = \"-z\"\nkind = \"point\"\nlands = true\ncontacts = [\"unilateral_patch\"]\n",
            "test.toml:",
            "their common contact types need a patch where there is a point",
        ),
        case(
            "[\"crate_bottom\", \"ground_top\"]",
            "[\"crate_bottom\", \"shelf_top\"]",
            "test.toml:55: \"crate_bottom\" cannot touch \"shelf_top\": 0.200 m × 0.300 m does not fit onto 0.100 m × \
             0.100 m; set overhang = true at \"shelf_top\"",
            "",
        ),
        case(
            "[\"crate_bottom\", \"ground_top\"]",
            "[\"crate_bottom\", \"ground_top\"], [\"crate_bottom\", \"table_top\"]",
            "test.toml:55: \"crate_bottom\" cannot touch \"table_top\": it is to land on \"ground_top\" as well; demand",
            "",
        ),
    ]);
}

#[test]
fn starts_that_do_not_hold() {
    assert_messages(&[
        case(
            "position = [0.0, 0.0]\njoints",
            "position = [0.0, 0.0, 0.9]\njoints",
            "test.toml:5: start contact of \"left_foot\" on \"ground_top\" does not hold: it is 127.",
            "mm above the surface; correct the start pose",
        ),
        case(
            "joints = { waist_yaw_joint = 0.1 }",
            "joints = { left_knee_joint = 0.6 }",
            "test.toml:5: start contact of \"left_foot\" on \"ground_top\" does not hold: the surfaces are 5.73° from \
             parallel",
            "",
        ),
        case(
            "joints = {",
            "contacts = [[\"left_hand\", \"crate_handle\"]]\njoints = {",
            "test.toml:5: nothing to stand on: the height of the base is not given and no foot",
            "add a [[static]] with plane = true",
        ),
        case(
            "plane = true",
            "size = [0.2, 0.2, 0.2]\nposition = [5, 5, -0.1]",
            "test.toml:5: nothing to stand on: \"left_foot\" at x = 0.0",
            "is over no surface that it can stand on",
        ),
        case(
            "position = [0.6, 0.1, 0.95]",
            "position = [0.6, 0.1, 0.962]",
            "test.toml:44: object \"cup\" has no contact at the start: \"cup_foot\" is nearest to \"crate_lid\": it is \
             12.0 mm above the surface; place it with on",
            "",
        ),
        case(
            "position = [0.6, 0.1, 0.95]",
            "position = [0.6, 0.145, 0.9495]",
            "test.toml:44: object \"cup\" has no contact at the start: \"cup_foot\" is nearest to \"crate_lid\": it is \
             0.5 mm below the surface, reaches 15.0 mm beyond the edge",
            "",
        ),
        case(
            "lands = true",
            "",
            "test.toml:44: object \"cup\" has no contact at the start: none of its interfaces faces a surface",
            "",
        ),
        case(
            "on = \"table_top\"\nposition = [0.0, 0.0]",
            "on = \"table_top\"\nposition = [0.0, 0.2]",
            "test.toml:27: start contact of \"crate_bottom\" on \"table_top\" does not hold: it reaches 50.0 mm beyond",
            "",
        ),
        case(
            "on = \"table_top\"",
            "on = \"shelf_top\"",
            "test.toml:26: \"crate_bottom\" cannot touch \"shelf_top\": 0.200 m × 0.300 m does not fit",
            "",
        ),
        case(
            "on = \"table_top\"\nposition = [0.0, 0.0]",
            "position = [0.6, 0.0, 0.83]",
            "test.toml:26: \"crate\" and \"table\" overlap by 20.0 mm at the start; move one of them",
            "",
        ),
        case(
            "on = \"table_top\"\nposition = [0.0, 0.0]",
            "position = [0.6, 2.0, 0.05]",
            "test.toml:26: \"crate\" and \"ground\" overlap by 50.0 mm at the start",
            "",
        ),
    ]);
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
