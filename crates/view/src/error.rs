//! Why a plan cannot be shown.

/// Why a plan cannot be shown.
#[derive(Debug, thiserror::Error)]
pub enum ViewError {
    /// The plan contradicts itself.
    #[error("{plan}: {source}; `locotamp check` lists all faults")]
    Plan {
        /// Name of the plan.
        plan: String,
        /// The first fault.
        source: plan::PlanError,
    },
    /// The URDF inside the plan cannot be read.
    #[error("{plan}: robot.urdf: {source}")]
    Robot {
        /// Name of the plan.
        plan: String,
        /// What is wrong with it.
        source: multibody::ModelError,
    },
    /// A joint of the plan that the URDF does not have.
    #[error("{plan}: robot.joints[{index}]: the URDF has no moving joint {joint:?}")]
    UnknownJoint {
        /// Name of the plan.
        plan: String,
        /// Place in the list.
        index: usize,
        /// The name.
        joint: String,
    },
    /// An interface on a body that is neither an object, a static body nor a link.
    #[error("{plan}: interfaces[{index}].body: no object, static body or link {body:?}")]
    UnknownBody {
        /// Name of the plan.
        plan: String,
        /// Place in the list.
        index: usize,
        /// The name.
        body: String,
    },
    /// The journal of a search cannot be read.
    #[error("{path}: {what}")]
    Journal {
        /// File or folder.
        path: String,
        /// What is wrong.
        what: String,
    },
    /// A joint for a figure that the robot does not have.
    #[error("no joint {joint:?}; the plan has {known}")]
    NoSuchJoint {
        /// The name.
        joint: String,
        /// The names there are.
        known: String,
    },
    /// A figure cannot be drawn: a bug.
    #[error("a figure cannot be drawn: {what}")]
    Figure {
        /// What the drawing library says.
        what: String,
    },
    /// The page's data cannot be written as JSON: a bug.
    #[error("the page's data cannot be written: {0}")]
    Json(#[from] serde_json::Error),
}
