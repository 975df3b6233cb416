//! Faults of the meaning: keys and interfaces that do not go together, starts that do not hold.

use super::Case;

/// Keys that do not go together.
pub const KEYS: &[Case] = &[
    (
        "half_size = [0.02, 0.02]",
        "kind = \"point\"\ncontacts = [\"unilateral_patch\"]",
        "test.toml:52: interface \"cup_foot\": a point cannot take part in unilateral_patch, expected unilateral_point",
    ),
    (
        "side = \"+z\"",
        "",
        "test.toml:37: interface \"crate_lid\": expected exactly one of side and quaternion",
    ),
    (
        "side = \"-z\"\nposition = [0.0, 0.0, 0.0]",
        "side = \"-z\"",
        "test.toml:48: interface \"cup_foot\": expected a position",
    ),
    (
        "half_size = [0.02, 0.02]",
        "",
        "test.toml:48: interface \"cup_foot\": expected half_size = [x, y]",
    ),
    (
        "half_size = [0.02, 0.02]",
        "kind = \"point\"\nhalf_size = [0.02, 0.02]",
        "test.toml:52: interface \"cup_foot\": a point has no half_size",
    ),
    (
        "[\"bilateral_patch\"]",
        "[]",
        "test.toml:34: interface \"crate_handle\": contacts is empty",
    ),
    (
        "size = [0.1, 0.1, 0.04]",
        "size = [0.1, 0.1, 0.04]\nplane = true",
        "test.toml:20: static body \"shelf\": a plane has no size and no shape",
    ),
    (
        "size = [0.1, 0.1, 0.04]",
        "",
        "test.toml:18: static body \"shelf\": expected size = [x, y, z], plane = true or a [[static.shape]]",
    ),
    (
        "size = [0.2, 0.3, 0.2]",
        "bottom = false",
        "test.toml:23: object \"crate\": expected size = [x, y, z] or an [[object.shape]]",
    ),
    (
        "capsule = { radius = 0.03, length = 0.1 }, ",
        "",
        "test.toml:43: shape of \"cup\": expected exactly one of box, sphere, capsule",
    ),
    (
        "capsule = { radius = 0.03, length = 0.1 }, ",
        "box = [1e-160, 1e-160, 1e-160], ",
        "test.toml:41: object \"cup\": the shapes are too small or too large",
    ),
    (
        "on = \"table_top\"\nposition = [0.0, 0.0]",
        "",
        "test.toml:23: object \"crate\": expected position = [x, y, z] or on = \"<interface>\"",
    ),
    (
        "on = \"table_top\"\n",
        "",
        "test.toml:26: object \"crate\": expected position = [x, y, z], or two numbers together with on",
    ),
    (
        "on = \"table_top\"\nposition = [0.0, 0.0]",
        "on = \"table_top\"\nposition = [0.0, 0.0, 0.0]",
        "test.toml:27: object \"crate\": expected position = [x, y] in the plane",
    ),
    (
        "on = \"table_top\"",
        "on = \"table_top\"\nquaternion = [0, 0, 0, 1]",
        "test.toml:27: object \"crate\": a quaternion cannot be given together with on",
    ),
    (
        "on = \"table_top\"",
        "on = \"table_top\"\nwith = \"table_top\"",
        "test.toml:27: object \"crate\": `with` names an interface of something else",
    ),
    (
        "inertia = [1e-4",
        "with = \"cup_foot\"\ninertia = [1e-4",
        "test.toml:45: object \"cup\": `with` names what stands on `on`, which is missing",
    ),
    (
        "position = [0.6, 0.1, 0.95]",
        "on = \"crate_lid\"",
        "test.toml:44: object \"cup\": it has no interface \"cup_bottom\" to stand on; name one with = \"…\"",
    ),
    (
        "position = [0.6, 0.0, 0.73]",
        "yaw = 0\nquaternion = [0, 0, 0, 1]",
        "test.toml:16: static body \"table\": both yaw and quaternion are given",
    ),
    (
        "position = [0.0, 0.0]\njoints",
        "position = [0.0]\njoints",
        "test.toml:5: position of the start: expected [x, y] or [x, y, z]",
    ),
    (
        "joints = {",
        "contacts = [[\"left_foot\"]]\njoints = {",
        "test.toml:6: start contact: expected [interface, interface] or",
    ),
    (
        "[\"crate_bottom\", \"ground_top\"]",
        "[\"crate_bottom\"]",
        "test.toml:55: goal contact: expected a pair [interface, interface]",
    ),
    (
        "x = [-0.5, 0.5]",
        "",
        "test.toml:57: goal region of \"base\": expected at least one of x, y, z, yaw",
    ),
    (
        "[search]",
        "[objective]\nkind = \"reach\"\nbody = \"left_hand\"\n[search]",
        "test.toml:62: objective: kind = \"reach\" needs body = \"…\" and direction = [x, y, z]",
    ),
    (
        "[search]",
        "[objective]\nkind = \"time\"\ndirection = [1, 0, 0]\n[search]",
        "test.toml:63: objective: body and direction go with kind = \"reach\" only",
    ),
    (
        "size = [0.1, 0.1, 0.04]",
        "size = [0.1, 0.1, 0.04]\ninterface = [{ name = \"s\", side = \"+x\", lands = true }]",
        "test.toml:20: interface \"s\": a surface of a static body cannot land on anything",
    ),
];

/// Pairs that can never touch.
pub const CONTACTS: &[Case] = &[
    (
        "[\"crate_bottom\", \"ground_top\"]",
        "[\"table_top\", \"ground_top\"]",
        "test.toml:55: \"table_top\" cannot touch \"ground_top\": both belong to static bodies; name an interface",
    ),
    (
        "[\"crate_bottom\", \"ground_top\"]",
        "[\"crate_lid\", \"ground_top\"]",
        "test.toml:55: \"crate_lid\" cannot touch \"ground_top\": neither is made to land on the other; set lands",
    ),
    (
        "[\"crate_bottom\", \"ground_top\"]",
        "[\"crate_bottom\", \"crate_lid\"]",
        "test.toml:55: \"crate_bottom\" cannot touch \"crate_lid\": both belong to the same object",
    ),
    (
        "[\"crate_bottom\", \"ground_top\"]",
        "[\"left_hand\", \"right_hand\"]",
        "test.toml:55:  … nothing lands on the robot",
    ),
    (
        "[\"crate_bottom\", \"ground_top\"]",
        "[\"left_foot\", \"crate_handle\"]",
        "test.toml:55: \"left_foot\" cannot touch \"crate_handle\": no contact type in common: one takes unilateral_patch, the other bilateral_patch; add a common type",
    ),
    (
        "joints = {",
        "contacts = [[\"left_foot\", \"ground_top\", \"bilateral_patch\"]]\njoints = {",
        "test.toml:6: \"left_foot\" cannot touch \"ground_top\": no contact type in common … (bilateral_patch asked for)",
    ),
    (
        "lands = true\n\n[goal]\ncontacts = [[\"crate_bottom\", \"ground_top\"]]",
        "lands = true\n\n[[object.interface]]\nname = \"tip\"\nside = \"+z\"\nkind = \"point\"\nposition = [0, 0, 0.1]\nlands = true\n\n[[static]]\nname = \"nail\"\nsize = [0.1, 0.1, 0.1]\nposition = [5, 5, 5]\ninterface = [{ name = \"nail_tip\", side = \"+z\", kind = \"point\", position = [0, 0, 0] }]\n\n[goal]\ncontacts = [[\"tip\", \"nail_tip\"]]",
        "test.toml:68: \"tip\" cannot touch \"nail_tip\": their common contact types need a patch where there is a point",
    ),
    (
        "[\"crate_bottom\", \"ground_top\"]",
        "[\"crate_bottom\", \"shelf_top\"]",
        "test.toml:55: \"crate_bottom\" cannot touch \"shelf_top\": 0.200 m × 0.300 m does not fit onto 0.100 m × 0.100 m; set overhang = true at \"shelf_top\"",
    ),
    (
        "[\"crate_bottom\", \"ground_top\"]",
        "[\"crate_bottom\", \"ground_top\"], [\"crate_bottom\", \"table_top\"]",
        "test.toml:55: \"crate_bottom\" cannot touch \"table_top\": it is to land on \"ground_top\" as well; demand",
    ),
];

/// Start poses that do not hold.
pub const STARTS: &[Case] = &[
    (
        "joints = {",
        "contacts = [[\"left_foot\", \"ground_top\"], [\"left_foot\", \"table_top\"]]\njoints = {",
        "test.toml:6: \"left_foot\" cannot touch \"table_top\": it is to touch \"ground_top\" as well; list one",
    ),
    (
        "position = [0.0, 0.0]\njoints",
        "position = [0.0, 0.0, 0.9]\njoints",
        "test.toml:5: start contact of \"left_foot\" on \"ground_top\" does not hold: it is 128. … mm above the surface; correct the start pose",
    ),
    (
        "joints = { waist_yaw_joint = 0.1 }",
        "joints = { left_knee_joint = 0.6 }",
        "test.toml:5: start contact of \"left_foot\" on \"ground_top\" does not hold: the surfaces are 5.73° from parallel",
    ),
    (
        "joints = {",
        "contacts = [[\"left_hand\", \"crate_handle\"]]\njoints = {",
        "test.toml:5: nothing to stand on: the height of the base is not given and no foot … add a [[static]] with plane = true",
    ),
    (
        "plane = true",
        "size = [0.2, 0.2, 0.2]\nposition = [5, 5, -0.1]",
        "test.toml:5: nothing to stand on: \"left_foot\" at x = 0.0 … is over no surface that it can stand on",
    ),
    (
        "position = [0.6, 0.1, 0.95]",
        "position = [0.6, 0.1, 0.962]",
        "test.toml:44: object \"cup\" has no contact at the start: \"cup_foot\" is nearest to \"crate_lid\": it is 12.0 mm above the surface; place it with on",
    ),
    (
        "position = [0.6, 0.1, 0.95]",
        "position = [0.6, 0.145, 0.9495]",
        "test.toml:44: object \"cup\" has no contact at the start: \"cup_foot\" is nearest to \"crate_lid\": it is 0.5 mm below the surface, reaches 15.0 mm beyond the edge",
    ),
    (
        "lands = true",
        "",
        "test.toml:44: object \"cup\" has no contact at the start: none of its interfaces faces a surface",
    ),
    (
        "on = \"table_top\"\nposition = [0.0, 0.0]",
        "on = \"table_top\"\nposition = [0.0, 0.2]",
        "test.toml:27: start contact of \"crate_bottom\" on \"table_top\" does not hold: it reaches 50.0 mm beyond",
    ),
    (
        "on = \"table_top\"",
        "on = \"shelf_top\"",
        "test.toml:26: \"crate_bottom\" cannot touch \"shelf_top\": 0.200 m × 0.300 m does not fit",
    ),
    (
        "on = \"table_top\"\nposition = [0.0, 0.0]",
        "position = [0.6, 0.0, 0.83]",
        "test.toml:26: \"crate\" and \"table\" overlap by 20.0 mm at the start; move one of them",
    ),
    (
        "on = \"table_top\"\nposition = [0.0, 0.0]",
        "position = [0.6, 2.0, 0.05]",
        "test.toml:26: \"crate\" and \"ground\" overlap by 50.0 mm at the start",
    ),
];
