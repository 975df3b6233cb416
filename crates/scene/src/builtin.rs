//! Robots and scenes that are part of the program, so that it needs no files.

use crate::{Fault, Scene, SceneError, nearest::nearest};
use std::path::Path;

/// The texts of a built-in robot.
pub(crate) struct BuiltinRobot {
    name: &'static str,
    /// Its robot file.
    pub file: &'static str,
    pub urdf: &'static str,
}

const ROBOTS: [BuiltinRobot; 1] = [BuiltinRobot {
    name: "g1",
    file: include_str!("../../../robots/g1.toml"),
    urdf: include_str!("../../../robots/g1.urdf"),
}];

/// Name and text of every built-in scene.
const SCENES: [(&str, &str); 6] = [
    (
        "pick-place",
        include_str!("../../../scenes/pick-place.toml"),
    ),
    ("two-box", include_str!("../../../scenes/two-box.toml")),
    (
        "three-boxes",
        include_str!("../../../scenes/three-boxes.toml"),
    ),
    ("climb", include_str!("../../../scenes/climb.toml")),
    ("lift-box", include_str!("../../../scenes/lift-box.toml")),
    ("side-step", include_str!("../../../scenes/side-step.toml")),
];

/// The built-in robot of a name.
pub(crate) fn robot(name: &str) -> Option<&'static BuiltinRobot> {
    ROBOTS.iter().find(|robot| robot.name == name)
}

/// Names of the built-in robots.
pub(crate) fn robot_names() -> impl Iterator<Item = &'static str> {
    ROBOTS.iter().map(|robot| robot.name)
}

impl Scene {
    /// Names of the built-in scenes.
    pub fn builtin_names() -> impl Iterator<Item = &'static str> {
        SCENES.iter().map(|(name, _)| *name)
    }

    /// The text of a built-in scene, a file to start one's own from.
    pub fn builtin_text(name: &str) -> Option<&'static str> {
        SCENES
            .iter()
            .find(|(known, _)| *known == name)
            .map(|(_, text)| *text)
    }

    /// A built-in scene by its name, such as "pick-place".
    ///
    /// # Errors
    /// [`Fault::UnknownBuiltin`] for another name.
    pub fn builtin(name: &str) -> Result<Self, SceneError> {
        let Some(text) = Self::builtin_text(name) else {
            let known: Vec<&str> = Self::builtin_names().collect();
            return Err(SceneError::nowhere(Fault::UnknownBuiltin {
                name: name.to_owned(),
                nearest: nearest(name, known.iter().copied()).map(str::to_owned),
                known: known.join(", "),
            }));
        };
        Self::from_toml(text, &format!("built-in scene {name}"), Path::new(""))
    }
}
