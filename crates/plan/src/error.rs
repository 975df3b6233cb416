//! Why a plan file cannot be used.

use std::path::PathBuf;

/// Why a plan file cannot be read, written or used.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// The file cannot be read or written.
    #[error("{path}: {source}", path = path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The text is not JSON, or a value has the wrong type.
    #[error("{place}: {message}")]
    Json {
        /// Path of the value inside the file, such as `phases[2].contacts[0].type`.
        place: String,
        /// What was found and what was expected, with line and column.
        message: String,
    },
    /// The file is of another format or version.
    #[error("format: this is {found}, expected {expected:?}{hint}", expected = crate::FORMAT)]
    Format {
        /// What the file says.
        found: String,
        /// Remedy, or empty.
        hint: &'static str,
    },
    /// An array over time has the wrong number of rows, or a row the wrong length.
    #[error("{place}: {found} {what}, expected {expected}")]
    Size {
        /// The array or row.
        place: String,
        /// What is counted.
        what: &'static str,
        /// Count found.
        found: usize,
        /// Count expected.
        expected: usize,
    },
    /// A number is infinite or not a number.
    #[error("{place}: {value} is not a finite number")]
    NotFinite {
        /// The entry.
        place: String,
        /// Its value.
        value: f64,
    },
    /// A name that nothing has.
    #[error("{place}: no {kind} is called {name:?}; known: {known}")]
    UnknownName {
        /// Where the name is used.
        place: String,
        /// What was looked for.
        kind: &'static str,
        /// The name.
        name: String,
        /// What there is.
        known: String,
    },
    /// A name that two things have.
    #[error("{place}: the name {name:?} is taken")]
    DuplicateName {
        /// The second of the two.
        place: String,
        /// The name.
        name: String,
    },
    /// A quaternion that is not of unit norm.
    #[error("{place}: quaternion of norm {norm}, expected 1")]
    Quaternion {
        /// The pose.
        place: String,
        /// Its norm.
        norm: f64,
    },
    /// A duration that is not positive, or a time that does not follow from the durations.
    #[error("{place}: {value} s, expected {expected}")]
    Time {
        /// The entry.
        place: String,
        /// Its value [s].
        value: f64,
        /// What it should be.
        expected: &'static str,
    },
    /// A number outside its range.
    #[error("{place}: {value}, expected {expected}")]
    Value {
        /// The entry.
        place: String,
        /// Its value.
        value: f64,
        /// The range.
        expected: &'static str,
    },
}

impl PlanError {
    /// True for faults after which the arrays cannot be used at all (sizes, names, numbers that are not finite);
    /// false for values that are readable but wrong (quaternion norms, durations, masses).
    pub fn is_structural(&self) -> bool {
        !matches!(
            self,
            Self::Quaternion { .. } | Self::Time { .. } | Self::Value { .. }
        )
    }
}
