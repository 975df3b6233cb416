//! What can be wrong with an MJCF file.

use mjcf_rs::ParseError;

/// Why a file is no usable robot.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MjcfError {
    /// A file that cannot be read or is no XML.
    #[error("{file}: {reason}")]
    File {
        /// The file.
        file: String,
        /// What is wrong.
        reason: String,
    },
    /// The text is no MJCF.
    #[error("{0}")]
    Parse(String),
    /// Nothing moves.
    #[error("there is no body with joints in <worldbody>")]
    NoRobot,
    /// A joint that is no hinge and no slide.
    #[error("joint {joint:?} of body {body:?} is a ball joint; give it as three hinges")]
    BallJoint {
        /// The joint.
        joint: String,
        /// The body that it moves.
        body: String,
    },
    /// A body whose mass is that of meshes.
    #[error(
        "body {body:?} has no <inertial>, and its mass would be that of a mesh; MuJoCo writes inertias out with mj_saveLastXML"
    )]
    MeshInertia {
        /// The body.
        body: String,
    },
}

impl From<ParseError> for MjcfError {
    fn from(error: ParseError) -> Self {
        Self::Parse(error.to_string())
    }
}
