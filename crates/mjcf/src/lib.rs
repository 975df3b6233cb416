//! Robots in MuJoCo's format: the same robot as the text of a URDF, which is what plan files carry and every reader of them knows.
//!
//! Bodies become links with the same frames, joints with an anchor or several to a body links without mass between, named sites
//! links without mass. What a URDF cannot say is left out and noted; what a planner cannot do without is an error.
//!
//! Source: mujoco.readthedocs.io/en/stable/XMLreference.html; wiki.ros.org/urdf/XML.

mod error;
mod force_ranges;
mod home;
mod include;
mod inertia;
mod limits;
mod pose;
mod robot;
mod shapes;
mod urdf;

pub use error::MjcfError;

use mjcf_rs::Model;
use std::path::Path;

/// A robot as a URDF.
#[derive(Debug, Clone, PartialEq)]
pub struct Converted {
    /// The text. Mesh files are named from the folder of the MJCF.
    pub urdf: String,
    /// Joint positions [rad or m] of the keyframe called "home" or "stand", or the first one; empty without any.
    pub home: Vec<(String, f64)>,
    /// What was left out or assumed, as sentences.
    pub notes: Vec<String>,
}

/// True if the text is XML whose outermost element is `<mujoco>`.
pub fn is_mjcf(text: &str) -> bool {
    roxmltree::Document::parse(text)
        .is_ok_and(|document| document.root_element().has_tag_name("mujoco"))
}

/// The robot of an MJCF file, that with the most joints if there are several.
///
/// # Errors
/// If the file, or one that it includes, is no MJCF; if it has no joints; ball joints, and bodies whose mass is that of meshes.
pub fn to_urdf(path: &Path) -> Result<Converted, MjcfError> {
    let text = include::whole_text(path)?;
    let model = Model::from_str(&text, path.parent().unwrap_or(Path::new("")))?;
    let mut notes = vec![];
    let robot = robot::find(&model, &mut notes)?;
    let ranges = force_ranges::read(&text);
    let home = home::home(&model, &robot);
    let limits = limits::Limits::new(&model, ranges, &home, &mut notes);
    let urdf = urdf::write(&model, &robot, limits, &mut notes)?;
    Ok(Converted { urdf, home, notes })
}
