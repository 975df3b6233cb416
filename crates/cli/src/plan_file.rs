//! Plan files given on the command line.

use crate::Exit;
use crate::failure::Failure;
use plan::Plan;
use std::path::{Path, PathBuf};

/// Reads a plan; the message of a failure begins with the path.
pub(crate) fn read(path: &Path) -> Result<Plan, Failure> {
    Plan::read(path).map_err(|error| {
        let path = path.display().to_string();
        let text = error.to_string();
        let named = if text.starts_with(&path) {
            text
        } else {
            format!("{path}: {text}")
        };
        Failure::new(Exit::BadInput, named)
    })
}

/// Reads all plans.
pub(crate) fn read_all(paths: &[PathBuf]) -> Result<Vec<Plan>, Failure> {
    paths.iter().map(|path| read(path)).collect()
}

/// Short names of plan files: the file's, or of a `plan.json` its folder's; the whole path where those are not unique.
pub(crate) fn names(paths: &[PathBuf]) -> Vec<String> {
    let short: Vec<_> = paths.iter().map(|path| short_name(path)).collect();
    let unique = |name: &String| short.iter().filter(|x| *x == name).count() == 1;
    let named = paths.iter().zip(&short);
    named
        .map(|(path, name)| {
            if unique(name) {
                name.clone()
            } else {
                path.display().to_string()
            }
        })
        .collect()
}

fn short_name(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let folder = path.parent().and_then(Path::file_name);
    match folder {
        Some(folder) if stem == "plan" => folder.to_string_lossy().into_owned(),
        _ => stem.into_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plans_are_called_by_their_folder_or_file() {
        let called = |paths: &[&str]| {
            let paths: Vec<_> = paths.iter().map(PathBuf::from).collect();
            names(&paths)
        };
        assert_eq!(called(&["runs/a/plan.json", "b.json"]), ["a", "b"]);
        assert_eq!(called(&["plan.json"]), ["plan"]);
        assert_eq!(
            called(&["x/a/plan.json", "y/a/plan.json"]),
            ["x/a/plan.json", "y/a/plan.json"]
        );
    }
}
