//! Where the mesh files of robots are.

use crate::failure::Failure;
use crate::{Exit, output};
use clap::Args;
use plan::Plan;
use std::env;
use std::path::PathBuf;
use view::Meshes;

/// Where ROS keeps packages: variables with lists of folders, and where in these the packages are.
const PACKAGES: [(&str, &str); 2] = [("ROS_PACKAGE_PATH", ""), ("AMENT_PREFIX_PATH", "share")];

#[derive(Debug, Args)]
pub(crate) struct MeshOptions {
    /// Draw the robot with its mesh files, found by their names in its URDF below this folder; may be given several times.
    /// The folders of ROS_PACKAGE_PATH and AMENT_PREFIX_PATH are searched after it
    #[arg(long = "meshes", value_name = "DIR")]
    pub given: Vec<PathBuf>,
}

impl MeshOptions {
    /// The folders to search, none if no meshes are wanted.
    ///
    /// # Errors
    /// One that was given is no folder.
    pub fn folders(&self) -> Result<Vec<PathBuf>, Failure> {
        if let Some(wrong) = self.given.iter().find(|x| !x.is_dir()) {
            let wrong = wrong.display();
            return Err(Failure::new(
                Exit::BadInput,
                format_args!(
                    "--meshes {wrong}: there is no such folder; give that of the robot's package, or one above it"
                ),
            ));
        }
        let mut folders = self.given.clone();
        for (variable, below) in PACKAGES {
            let paths = env::var_os(variable).filter(|_| !self.given.is_empty());
            let paths = paths.unwrap_or_default();
            folders.extend(
                env::split_paths(&paths)
                    .filter(|x| x.is_absolute())
                    .map(|path| path.join(below)),
            );
        }
        Ok(folders)
    }

    /// The meshes of the robots of plans, simplified to `budget` bytes; says on standard error what is left out.
    ///
    /// # Errors
    /// As [`MeshOptions::folders`].
    pub fn meshes(&self, plans: &[Plan], budget: usize) -> Result<Meshes, Failure> {
        let folders = self.folders()?;
        if folders.is_empty() {
            return Ok(Meshes::default());
        }
        let meshes = Meshes::load(
            plans.iter().map(|x| x.robot.urdf.as_str()),
            &folders,
            budget,
        );
        warn(&meshes);
        Ok(meshes)
    }
}

/// Says on standard error which meshes are left out, and why.
pub(crate) fn warn(meshes: &Meshes) {
    for warning in meshes.warnings() {
        output::error(&format!("warning: {warning}\n"));
    }
}
