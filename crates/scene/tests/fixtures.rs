//! A scene to spoil, and how tests read it.

use scene::{Scene, SceneError};
use std::path::Path;

/// Uses most of the format; valid.
pub const VALID: &str = r#"name = "test"
robot = "g1"

[start]
position = [0.0, 0.0]
joints = { waist_yaw_joint = 0.1 }

[[static]]
name = "ground"
plane = true

[[static]]
name = "table"
size = [0.4, 0.6, 0.04]
position = [0.6, 0.0, 0.73]

[[static]]
name = "shelf"
size = [0.1, 0.1, 0.04]
position = [0.6, 0.8, 0.73]

[[object]]
name = "crate"
mass = 2.0
size = [0.2, 0.3, 0.2]
on = "table_top"
position = [0.0, 0.0]

[[object.interface]]
name = "crate_handle"
side = "+y"
position = [0.0, 0.18, 0.0]
half_size = [0.03, 0.03]
contacts = ["bilateral_patch"]

[[object.interface]]
name = "crate_lid"
side = "+z"

[[object]]
name = "cup"
mass = 0.2
shape = [{ capsule = { radius = 0.03, length = 0.1 }, position = [0.0, 0.0, 0.08] }]
position = [0.6, 0.1, 0.95]
inertia = [1e-4, 1e-4, 1e-4, 0.0, 0.0, 0.0]

[[object.interface]]
name = "cup_foot"
side = "-z"
position = [0.0, 0.0, 0.0]
half_size = [0.02, 0.02]
lands = true

[goal]
contacts = [["crate_bottom", "ground_top"]]

[[goal.region]]
body = "base"
x = [-0.5, 0.5]

[search]
max_changes = 2

[optimiser]
steps = 8
min_duration = 0.3
"#;

/// Reads a text as the scene file "test.toml".
pub fn read(text: &str) -> Result<Scene, SceneError> {
    Scene::from_toml(text, "test.toml", Path::new(""))
}

/// [`VALID`] with one piece replaced; the piece must be there.
pub fn spoiled(piece: &str, replacement: &str) -> String {
    assert!(VALID.contains(piece), "no {piece:?} in the valid scene");
    VALID.replacen(piece, replacement, 1)
}
