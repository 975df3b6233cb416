//! Files by the names that URDFs give them: `package://`, `model://`, `file://`, absolute and relative.

use std::path::{Component, Path, PathBuf};

/// The file of a name; `None` where there is none. An absolute name is itself looked for first. Below the folders the longest
/// end of the name's path counts, of equal ones the first folder's.
///
/// # Errors
/// The name is of a kind that is not read: what is wrong with it.
pub fn locate(name: &str, folders: &[PathBuf]) -> Result<Option<PathBuf>, String> {
    let path = match name.split_once("://") {
        Some(("package" | "model" | "file", path)) => path,
        Some((scheme, _)) => {
            return Err(format!(
                "{scheme}:// is not read; package://, file:// and paths are"
            ));
        }
        None => name,
    };
    let path = Path::new(path);
    if path.is_absolute() && path.is_file() {
        return Ok(Some(path.into()));
    }
    // Without `/`, `.` and `..`: where a URDF stood is not known.
    let words: Vec<_> = path
        .components()
        .filter(|word| matches!(word, Component::Normal(_)))
        .collect();
    let ends = (0..words.len()).map(|from| words[from..].iter().collect::<PathBuf>());
    let mut files = ends.flat_map(|end| folders.iter().map(move |folder| folder.join(&end)));
    Ok(files.find(|file| file.is_file()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn names_are_found_by_their_longest_end_below_a_folder() {
        let root = tempfile::tempdir().unwrap();
        let [robot, other] = ["share/robot/meshes", "other"].map(|x| root.path().join(x));
        for folder in [&robot, &other] {
            fs::create_dir_all(folder).unwrap();
            fs::write(folder.join("arm.stl"), "").unwrap();
        }
        let arm = robot.join("arm.stl");
        let found = |name: &str, folder: &str| {
            let folders = [other.clone(), root.path().join(folder)];
            locate(name, &folders).unwrap()
        };
        let package = "package://robot/meshes/arm.stl";
        assert_eq!(found(package, "share"), Some(arm.clone()));
        assert_eq!(found(package, "share/robot"), Some(arm.clone()));
        assert_eq!(found("../meshes/arm.stl", "share/robot"), Some(arm.clone()));
        assert_eq!(found("arm.stl", "share"), Some(other.join("arm.stl")));
        let absolute = arm.display();
        assert_eq!(found(&format!("file://{absolute}"), ""), Some(arm.clone()));
        assert_eq!(found(&absolute.to_string(), ""), Some(arm.clone()));
        assert_eq!(
            found("file:///gone/meshes/arm.stl", "share/robot"),
            Some(arm)
        );
        assert_eq!(found("package://robot/leg.stl", "share"), None);
        assert_eq!(
            found("package://robot/meshes", "share"),
            None,
            "a folder is no mesh"
        );
    }

    #[test]
    fn nothing_is_asked_of_the_network() {
        let message = locate("http://host/arm.stl", &[]).unwrap_err();
        assert!(message.contains("http:// is not read"), "{message}");
    }
}
