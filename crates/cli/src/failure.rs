//! Why a command ended early, and how that is said.

use crate::{Exit, output};
use std::path::Path;

/// Why a command ended early.
#[derive(Debug)]
pub(crate) struct Failure {
    exit: Exit,
    /// The whole text for people, one or several lines.
    text: String,
}

impl Failure {
    /// The text for people, ending with a line break.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// A failure with a message of its own.
    pub fn new(exit: Exit, message: impl std::fmt::Display) -> Self {
        Self {
            exit,
            text: format!("error: {message}\n"),
        }
    }

    /// A file or folder that cannot be used.
    pub fn path(action: &str, path: &Path, error: &std::io::Error) -> Self {
        Self::new(
            Exit::BadInput,
            format_args!("cannot {action} {}: {error}", path.display()),
        )
    }

    /// The exit code.
    pub fn exit(&self) -> Exit {
        self.exit
    }

    /// Says it on standard error, and to machines on standard output as well.
    pub fn report(&self, for_machines: bool) {
        output::error(&self.text);
        if for_machines {
            let status = if self.exit == Exit::BadInput {
                "error"
            } else {
                "none"
            };
            output::result(&format!(
                "{}\n",
                serde_json::json!({ "status": status, "reason": self.text.trim_end() })
            ));
        }
    }
}

impl From<scene::SceneError> for Failure {
    fn from(error: scene::SceneError) -> Self {
        Self {
            exit: Exit::BadInput,
            text: error.render(),
        }
    }
}

impl From<locotamp::Error> for Failure {
    fn from(error: locotamp::Error) -> Self {
        match &error {
            locotamp::Error::Unreachable(_) => {
                Self::new(Exit::Rejected, format_args!("no plan: {error}"))
            }
            _ => Self::new(Exit::BadInput, error),
        }
    }
}
