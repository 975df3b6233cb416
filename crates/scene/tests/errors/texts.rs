//! Faults of the text: syntax, keys, numbers, names.

use super::Case;

/// Texts that are not TOML, unknown and missing keys, wrong types.
pub const SYNTAX: &[Case] = &[
    ("[start]", "[start", "test.toml:4: malformed TOML: "),
    (
        "robot = \"g1\"",
        "robot = g1",
        "test.toml:2: malformed TOML: ",
    ),
    (
        "mass = 2.0",
        "mas = 2.0",
        "test.toml:24: unknown key \"mas\"; did you mean \"mass\"? known: name, mass … position",
    ),
    (
        "max_changes = 2",
        "qqqqqqqqqqqq = 2",
        "test.toml:62: unknown key \"qqqqqqqqqqqq\"; known: max_phases",
    ),
    (
        "mass = 2.0",
        "mass = \"2 kg\"",
        "test.toml:24: invalid type: string \"2 kg\", expected a number",
    ),
    ("mass = 2.0\n", "", "test.toml:22: missing key `mass`"),
    (
        "size = [0.4, 0.6, 0.04]",
        "size = [0.4, 0.6]",
        "test.toml:14: invalid length 2, expected an array of length 3",
    ),
    (
        "side = \"+y\"",
        "side = \"left\"",
        "test.toml:31: unknown value `left`, expected one of `+x`, `-x`",
    ),
    (
        "[\"bilateral_patch\"]",
        "[\"sticky\"]",
        "test.toml:34: unknown value `sticky`, expected one of `unilateral_point`",
    ),
    (
        "max_changes = 2",
        "max_changes = 1.5",
        "test.toml:62: invalid type: number `1.5`, expected a whole number",
    ),
];

/// Numbers outside their ranges.
pub const NUMBERS: &[Case] = &[
    (
        "mass = 2.0",
        "mass = -1",
        "test.toml:24: mass of object \"crate\" is -1 kg, expected a positive number",
    ),
    (
        "mass = 2.0",
        "mass = nan",
        "test.toml:24: mass of object \"crate\" is NaN kg",
    ),
    (
        "mass = 2.0",
        "mass = inf",
        "test.toml:24: mass of object \"crate\" is inf kg",
    ),
    (
        "mass = 2.0",
        "mass = 1e9",
        "test.toml:24: object \"crate\": a mass of 1000000000 kg, expected at most 100000 kg",
    ),
    (
        "size = [0.2, 0.3, 0.2]",
        "size = [0.2, -0.3, 0.2]",
        "test.toml:25: size of object \"crate\" is [0.2, -0.3, 0.2] m, expected 3 positive numbers",
    ),
    (
        "position = [0.6, 0.0, 0.73]",
        "position = [0.6, nan, 0.73]",
        "test.toml:15: position of static body \"table\" is [0.6, NaN, 0.73], expected finite numbers",
    ),
    (
        "position = [0.6, 0.0, 0.73]",
        "position = [0.6, 0.0, 0.73]\nquaternion = [0, 0, 0, 2]",
        "test.toml:16: quaternion [x, y, z, w] of static body \"table\" is [0.0, 0.0, 0.0, 2.0] of length 2.0000, expected length 1; [0, 0, 0, 1] means no rotation",
    ),
    (
        "position = [0.6, 0.0, 0.73]",
        "position = [0.6, 0.0, 0.73]\nyaw = inf",
        "test.toml:16: yaw of static body \"table\" is inf, expected a finite number",
    ),
    (
        "radius = 0.03",
        "radius = 0",
        "test.toml:43: capsule radius of \"cup\" is 0 m, expected a positive number",
    ),
    (
        "length = 0.1",
        "length = -0.1",
        "test.toml:43: capsule length of \"cup\" is -0.1 m, expected a finite number that is not negative",
    ),
    (
        "half_size = [0.03, 0.03]",
        "half_size = [0.03, 0]",
        "test.toml:33: half_size of interface \"crate_handle\" is [0.03, 0.0] m",
    ),
    (
        "inertia = [1e-4, 1e-4, 1e-4,",
        "inertia = [1e-4, 1e-4, 3e-4,",
        "test.toml:45: object \"cup\": inertia [0.0001, 0.0001, 0.0003, 0.0, 0.0, 0.0] kg·m² is that of no body … none larger than the sum of the other two",
    ),
    (
        "side = \"+z\"",
        "side = \"+z\"\nmu = -0.1",
        "test.toml:39: mu of interface \"crate_lid\" is -0.1, expected a finite number that is not negative",
    ),
    (
        "side = \"+z\"",
        "side = \"+z\"\nmax_force = 0",
        "test.toml:39: max_force of interface \"crate_lid\" is 0 N, expected a positive number",
    ),
    (
        "robot = \"g1\"",
        "robot = \"g1\"\ngravity = [0, 0, nan]",
        "test.toml:3: gravity is [0.0, 0.0, NaN], expected finite numbers",
    ),
    (
        "steps = 8",
        "steps = 0",
        "test.toml:65: steps is 0, expected a whole number from 1 to 200",
    ),
    (
        "min_duration = 0.3",
        "min_duration = 0.3\nmax_duration = 0.2",
        "test.toml:67: max_duration: 0.2 s is less than min_duration, 0.3 s; raise it",
    ),
    (
        "x = [-0.5, 0.5]",
        "x = [0.5, -0.5]",
        "test.toml:59: goal region of \"base\" is [0.5, -0.5], expected [smallest, largest]",
    ),
    (
        "x = [-0.5, 0.5]",
        "yaw = [0.0, 6.3]",
        "test.toml:59: yaw of goal region of \"base\" is [0.0, 6.3] rad, expected [smallest, largest] … a full turn of 2π rad apart",
    ),
    (
        "x = [-0.5, 0.5]",
        "x = [-0.5, 0.5]\n[[goal.region]]\nbody = \"base\"\nx = [0.6, 0.7]",
        "test.toml:62: x of goal region of \"base\" is [0.6, 0.7] m, expected something in common with [-0.5, 0.5] m",
    ),
    (
        "x = [-0.5, 0.5]",
        "tilt = 0.0",
        "test.toml:59: tilt of goal region of \"base\" is 0 rad, expected a number from 0.01 to π/2",
    ),
    (
        "[search]",
        "[objective]\nkind = \"reach\"\nbody = \"left_hand\"\ndirection = [0, 0, 0]\n[search]",
        "test.toml:64: direction of the objective is [0.0, 0.0, 0.0], expected three numbers that are not all zero",
    ),
    (
        "[search]",
        "[objective]\nkind = \"reach\"\nbody = \"left_foo\"\ndirection = [0, 0, 1]\n[search]",
        "test.toml:63: objective: no object, robot link or interface that can move is called \"left_foo\" … \"left_foot\"",
    ),
    (
        "joints = { waist_yaw_joint = 0.1 }",
        "joints = { waist_yaw_joint = 9.5 }",
        "test.toml:6: joint \"waist_yaw_joint\" starts at 9.5, expected a value within its limits [-2.618, 2.618]; set it to a value from -2.618 to 2.618",
    ),
    (
        "joints = { waist_yaw_joint = 0.1 }",
        "joints = { waist_yaw_joint = nan }",
        "test.toml:6: position of joint \"waist_yaw_joint\" is NaN, expected a finite number",
    ),
];

/// Names that nothing has, and names given twice.
pub const NAMES: &[Case] = &[
    (
        "on = \"table_top\"",
        "on = \"tabel_top\"",
        "test.toml:26: object \"crate\": no interface is called \"tabel_top\"; did you mean \"table_top\"? known:  … left_foot",
    ),
    (
        "[\"crate_bottom\", \"ground_top\"]",
        "[\"crate_bottom\", \"table_c_top\"]",
        "test.toml:55: goal contact: no interface is called \"table_c_top\"; did you mean \"table_top\"?",
    ),
    (
        "body = \"base\"",
        "body = \"bass\"",
        "test.toml:58: goal region: no object, robot link or interface that can move is called \"bass\"; did you mean \"base\"?",
    ),
    (
        "body = \"base\"",
        "body = \"table\"",
        "test.toml:58: goal region: no object, robot link or interface that can move is called \"table\"",
    ),
    (
        "waist_yaw_joint",
        "waist_jaw_joint",
        "test.toml:6: robot: no moving joint is called \"waist_jaw_joint\"; did you mean \"waist_yaw_joint\"?",
    ),
    (
        "robot = \"g1\"",
        "robot = \"g2\"",
        "test.toml:2: robot: no built-in robot is called \"g2\"; did you mean \"g1\"? known: g1, or a path",
    ),
    (
        "robot = \"g1\"",
        "robot = \"no/such/robot.toml\"",
        "test.toml:2: cannot read no/such/robot.toml:  … check the path",
    ),
    (
        "name = \"shelf\"",
        "name = \"table\"",
        "test.toml:18: the body \"table\" exists already; give it another name",
    ),
    (
        "name = \"cup\"",
        "name = \"pelvis\"",
        "test.toml:41: the body \"pelvis\" exists already",
    ),
    (
        "name = \"crate_lid\"",
        "name = \"left_hand\"",
        "test.toml:37: the interface \"left_hand\" exists already",
    ),
    (
        "name = \"shelf\"",
        "name = \" \"",
        "test.toml:18: name: it is empty",
    ),
    (
        "joints = {",
        "contacts = [[\"left_foot\", \"ground_top\", \"glue\"]]\njoints = {",
        "test.toml:6: start contact: no contact type is called \"glue\"; known: unilateral_point",
    ),
];
