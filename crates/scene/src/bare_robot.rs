//! A robot as its URDF or MJCF describes it, before anyone has said which links are hands and feet.

use crate::load::{DEFAULT_FRICTION, STANDARD_GRAVITY};
use crate::notes::tips;
use crate::robot::{self, LoadedRobot};
use crate::source::Source;
use crate::{Fault, PlacedShape, Robot, SceneError};
use nalgebra::Vector3;
use std::path::{Path, PathBuf};

/// A robot without robot file.
#[derive(Debug, Clone)]
pub struct BareRobot {
    /// The robot. Its home is the keyframe of an MJCF, or all joints at zero or at the nearest limit.
    pub robot: Robot,
    /// Links with meshes that could not be read.
    pub unread: Vec<String>,
    mesh_corners: Vec<Vec<Vector3<f64>>>,
    primitives: Vec<Vec<PlacedShape>>,
}

impl BareRobot {
    /// Reads a URDF (`.urdf`, `.xml`) or MJCF (`.xml`); its meshes are looked for in `meshes` first, then as for any robot.
    ///
    /// # Errors
    /// What is wrong with the file, or that it is none of the two.
    pub fn load(path: &Path, meshes: Option<&Path>) -> Result<Self, SceneError> {
        let name = path.display().to_string();
        let extension = path.extension().and_then(|e| e.to_str());
        let known = extension.is_some_and(|e| ["urdf", "xml"].contains(&&*e.to_ascii_lowercase()));
        if !known {
            return Err(SceneError::nowhere(Fault::Value {
                what: "the robot's description".into(),
                value: name,
                expected: "a file that ends in .urdf or .xml (URDF or MJCF)".into(),
            }));
        }
        let loaded = robot::load(
            &name,
            Source::new(&name, "").place(0..0),
            Path::new(""),
            meshes.map(PathBuf::from),
            DEFAULT_FRICTION,
            STANDARD_GRAVITY,
        );
        // The place would be one in a scene file, and there is none.
        let LoadedRobot {
            robot,
            unread,
            mesh_corners,
            primitives,
            ..
        } = loaded.map_err(|error| SceneError::nowhere(error.fault().clone()))?;
        Ok(Self {
            robot,
            unread,
            mesh_corners,
            primitives,
        })
    }

    /// Points of a link in its frame, each with the radius of what is round about it [m], one of which is farthest out in any
    /// direction: corners of its meshes and of its other shapes.
    ///
    /// # Panics
    /// If there is no such frame.
    pub fn points(&self, frame: usize) -> Vec<(Vector3<f64>, f64)> {
        let corners = self.mesh_corners[frame].iter().map(|corner| (*corner, 0.0));
        corners.chain(tips_of(&self.primitives[frame])).collect()
    }
}

impl Robot {
    /// Points of the shapes that a link is planned with, as [`BareRobot::points`].
    ///
    /// # Panics
    /// If there is no such frame.
    pub fn tips(&self, frame: usize) -> Vec<(Vector3<f64>, f64)> {
        tips_of(&self.shapes[frame]).collect()
    }
}

fn tips_of(shapes: &[PlacedShape]) -> impl Iterator<Item = (Vector3<f64>, f64)> {
    shapes.iter().flat_map(|placed| {
        let points = tips(&placed.shape).into_iter();
        points.map(|(p, radius)| (placed.body_from_shape.act(p), radius))
    })
}
