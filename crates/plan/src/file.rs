//! Reading and writing plan files.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde_json::Value;

use crate::{FORMAT, Plan, PlanError, layout};

/// What is read before anything else, so that another version gives a message about the version.
#[derive(Deserialize)]
struct Head {
    #[serde(default)]
    format: Value,
}

impl Plan {
    /// Reads a plan file. Sizes and values are not judged: see [`Plan::validate`].
    ///
    /// # Errors
    /// The file cannot be read, is not JSON, is of another format, or misses or mistypes a key.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, PlanError> {
        let path = path.as_ref();
        let text = fs::read_to_string(path).map_err(|source| PlanError::Io {
            path: path.into(),
            source,
        })?;
        Self::from_json(&text)
    }

    /// Reads a plan from its JSON text. Sizes and values are not judged: see [`Plan::validate`].
    ///
    /// # Errors
    /// The text is not JSON, is of another format, or misses or mistypes a key; the message names the place.
    pub fn from_json(text: &str) -> Result<Self, PlanError> {
        let head: Head =
            serde_json::from_str(text).map_err(|error| json_error(String::new(), &error))?;
        check_format(&head.format)?;
        let deserializer = &mut serde_json::Deserializer::from_str(text);
        serde_path_to_error::deserialize(deserializer)
            .map_err(|error| json_error(error.path().to_string(), error.inner()))
    }

    /// The JSON text of the plan, one row of numbers per line; numbers read back to the same values.
    ///
    /// # Errors
    /// The first fault that [`Plan::validate`] finds: a faulty plan is not written.
    pub fn to_json(&self) -> Result<String, PlanError> {
        self.validate()?;
        let value =
            serde_json::to_value(self).map_err(|error| json_error(String::new(), &error))?;
        Ok(layout::to_text(&value))
    }

    /// Writes the plan file whole or not at all: into a temporary file beside `path`, then renamed.
    ///
    /// # Errors
    /// The plan is faulty (see [`Plan::to_json`]) or the file cannot be written.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), PlanError> {
        let path = path.as_ref();
        let text = self.to_json()?;
        let temporary = temporary_beside(path);
        let written = fs::File::create(&temporary)
            .and_then(|mut file| {
                file.write_all(text.as_bytes())
                    .and_then(|()| file.sync_all())
            })
            .and_then(|()| fs::rename(&temporary, path));
        written.map_err(|source| {
            // The first error is the one to report; a left-over file only costs space.
            let _ = fs::remove_file(&temporary);
            PlanError::Io {
                path: path.into(),
                source,
            }
        })
    }
}

fn temporary_beside(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(format!(".{}.tmp", std::process::id()));
    path.with_file_name(name)
}

fn json_error(path: String, error: &serde_json::Error) -> PlanError {
    let place = if path.is_empty() || path == "." {
        "plan file".to_owned()
    } else {
        path
    };
    PlanError::Json {
        place,
        message: error.to_string(),
    }
}

fn check_format(found: &Value) -> Result<(), PlanError> {
    let (found, hint) = match found {
        Value::String(text) if text == FORMAT => return Ok(()),
        Value::String(text) if text.starts_with("locotamp.plan/") => (
            format!("{text:?}"),
            "; another version of locotamp wrote it, plan again or use that version",
        ),
        Value::Null => (
            "a file without a format string".to_owned(),
            "; is it a plan file?",
        ),
        other => (other.to_string(), "; is it a plan file?"),
    };
    Err(PlanError::Format { found, hint })
}
