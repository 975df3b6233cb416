//! Where the mesh files of a URDF are: names with `package://` and `file://`, absolute and relative paths.
//!
//! Source: wiki.ros.org/urdf/XML/link (mesh file names), wiki.ros.org/ROS/EnvironmentVariables (`ROS_PACKAGE_PATH`).

use std::env;
use std::path::{Path, PathBuf};

/// Where ROS keeps packages: variables with lists of folders, and where in these the packages are.
const PACKAGES: [(&str, &str); 2] = [("ROS_PACKAGE_PATH", ""), ("AMENT_PREFIX_PATH", "share")];

/// Folders in which meshes are looked for.
#[derive(Debug, Default)]
pub(crate) struct MeshFolders {
    /// Those that scene and robot file name: the longest end of a name's path below them counts.
    pub given: Vec<PathBuf>,
    /// That of the URDF, absolute; `None` for one that is built in.
    pub urdf: Option<PathBuf>,
    /// Those with packages, or packages themselves.
    pub packages: Vec<PathBuf>,
}

impl MeshFolders {
    /// Those of a URDF file, with the packages that ROS knows.
    pub fn of_urdf(path: &Path, given: Vec<PathBuf>) -> Self {
        let whole = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
        let packages = PACKAGES.iter().flat_map(|(variable, below)| {
            let folders = env::var_os(variable).unwrap_or_default();
            let folders: Vec<_> = env::split_paths(&folders).collect();
            let absolute = folders.into_iter().filter(|folder| folder.is_absolute());
            absolute.map(move |folder| folder.join(below))
        });
        Self {
            given,
            urdf: whole.parent().map(Path::to_path_buf),
            packages: packages.collect(),
        }
    }

    /// The file of a name in the URDF; `None` if it is not there or the name is of another kind.
    ///
    /// `package://NAME/rest` is `rest` in a folder called NAME: below one that is given, among or in the packages of ROS, above the
    /// URDF or beside what is above it.
    pub fn find(&self, name: &str) -> Option<PathBuf> {
        if let Ok(Some(file)) = mesh::locate(name, &self.given) {
            return Some(file);
        }
        let here = self.urdf.as_deref();
        let files: Vec<PathBuf> = match name.split_once("://") {
            Some(("package" | "model", path)) => {
                let (package, rest) = path.split_once('/')?;
                let above = here.into_iter().flat_map(Path::ancestors);
                let roots = self.packages.iter().map(PathBuf::as_path).chain(above);
                roots
                    .flat_map(|root| {
                        let is_it = root.file_name().is_some_and(|name| name == package);
                        let itself = is_it.then(|| root.join(rest));
                        itself.into_iter().chain([root.join(package).join(rest)])
                    })
                    .collect()
            }
            Some(("file", path)) => here.map(|folder| folder.join(path)).into_iter().collect(),
            Some(_) => return None,
            None => here.map(|folder| folder.join(name)).into_iter().collect(),
        };
        files.into_iter().find(|file| file.is_file())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn names_of_packages_and_paths_are_found_above_the_urdf_in_packages_and_in_given_folders() {
        let root = tempfile::tempdir().unwrap();
        let root = root.path().canonicalize().unwrap();
        let arm = root.join("share/robot/meshes/arm.stl");
        for folder in ["share/robot/meshes", "share/robot/urdf", "elsewhere"] {
            fs::create_dir_all(root.join(folder)).unwrap();
        }
        fs::write(&arm, "").unwrap();
        let found = |name: &str, urdf: &str, package: Option<&str>, given: Option<&str>| {
            let folders = MeshFolders {
                given: given.iter().map(|x| root.join(x)).collect(),
                urdf: Some(root.join(urdf)),
                packages: package.iter().map(|x| root.join(x)).collect(),
            };
            let file = folders.find(name);
            file.is_some_and(|file| file.canonicalize().unwrap() == arm)
        };
        let package = "package://robot/meshes/arm.stl";
        let (own, other) = ("share/robot/urdf", "elsewhere");
        assert!(found(package, own, None, None), "the URDF is inside");
        assert!(found(package, "share", None, None), "it is beside");
        assert!(!found(package, other, None, None));
        assert!(found(package, other, Some("share"), None));
        assert!(found(package, other, Some("share/robot"), None));
        assert!(found(package, other, None, Some("share/robot/meshes")));
        assert!(found("../meshes/arm.stl", own, None, None));
        assert!(!found("arm.stl", own, None, None));
        let absolute = arm.display().to_string();
        assert!(found(&absolute, other, None, None));
        assert!(found(&format!("file://{absolute}"), other, None, None));
        assert!(!found("http://robot/meshes/arm.stl", own, None, None));
        assert!(!found("package://robot", own, None, None));
    }
}
