//! Why a plan cannot be written as arrays.

use crate::{MOST_SAMPLES, RATES};

/// Why a plan cannot be written as arrays.
#[derive(Debug, thiserror::Error)]
pub enum ArraysError {
    /// The plan contradicts itself.
    #[error("{0}; `locotamp check` lists all faults")]
    Plan(#[from] plan::PlanError),
    /// The URDF inside the plan cannot be read.
    #[error("robot.urdf: {0}")]
    Robot(#[from] multibody::ModelError),
    /// A joint of the plan that the URDF does not have.
    #[error("robot.joints[{index}]: the URDF has no moving joint {joint:?}")]
    UnknownJoint {
        /// Place in the list.
        index: usize,
        /// The name.
        joint: String,
    },
    /// A rate that is no number or out of range.
    #[error("the rate is {rate} Hz, expected a number from {} to {}", RATES.start(), RATES.end())]
    BadRate {
        /// As given [Hz].
        rate: f64,
    },
    /// More samples than are good for memory.
    #[error(
        "{duration} s at {rate} Hz are more than {MOST_SAMPLES} samples; a lower rate gives fewer"
    )]
    TooMany {
        /// Of the plan [s].
        duration: f64,
        /// As given [Hz].
        rate: f64,
    },
    /// The archive cannot be made: an array of more than 4 GB, or a bug.
    #[error("the archive cannot be made: {0}")]
    Archive(#[from] zip::result::ZipError),
}
