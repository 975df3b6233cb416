//! `locotamp view`: one self-contained page from one or several plan files, or from the folder of a run.

use crate::Exit;
use crate::failure::Failure;
use crate::mesh_options::{self, MeshOptions};
use crate::plan_file;
use clap::Args;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use view::{Meshes, Named, Run, ViewError};

#[derive(Debug, Args)]
pub(crate) struct ViewOptions {
    /// Plan files; several are shown by tab or side by side. Or the folder of a run of `plan`: its search
    #[arg(required = true, value_name = "PLAN")]
    pub plans: Vec<PathBuf>,
    /// The HTML file to write
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    #[command(flatten)]
    pub meshes: MeshOptions,
    /// Show it in the browser
    #[arg(long)]
    pub open: bool,
}

/// Reads the plans, writes the page, opens it if asked.
pub(crate) fn run(options: &ViewOptions) -> Result<Exit, Failure> {
    let page = match options.plans.as_slice() {
        [folder] if folder.is_dir() => page_of_run(folder, &options.meshes)?,
        files => page_of_plans(files, &options.meshes)?,
    };
    let page = page.map_err(|error| Failure::new(Exit::BadInput, error))?;
    fs::write(&options.out, page).map_err(|error| Failure::path("write", &options.out, &error))?;
    if options.open {
        open(&options.out)?;
    }
    Ok(Exit::Done)
}

/// The page of a search.
fn page_of_run(folder: &Path, wanted: &MeshOptions) -> Result<Result<String, ViewError>, Failure> {
    let folders = wanted.folders()?;
    Ok(Run::open(folder).and_then(|mut run| {
        if !folders.is_empty() {
            run = run.with_meshes(&folders);
            mesh_options::warn(run.meshes());
        }
        run.page(false)
    }))
}

/// The page of plan files.
fn page_of_plans(
    files: &[PathBuf],
    wanted: &MeshOptions,
) -> Result<Result<String, ViewError>, Failure> {
    let plans = plan_file::read_all(files)?;
    let names = plan_file::names(files);
    let named = plans.iter().zip(&names);
    let named: Vec<_> = named.map(|(plan, name)| Named { name, plan }).collect();
    Ok(view::plan_page(
        &named,
        &wanted.meshes(&plans, Meshes::PAGE)?,
    ))
}

/// Hands a file to the desktop's opener.
fn open(path: &Path) -> Result<(), Failure> {
    let (program, first): (&str, &[&str]) = if cfg!(target_os = "macos") {
        ("open", &[])
    } else if cfg!(windows) {
        ("cmd", &["/C", "start", ""])
    } else {
        ("xdg-open", &[])
    };
    let mut command = Command::new(program);
    command
        .args(first)
        .arg(path)
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    command.spawn().map(|_| ()).map_err(|error| {
        let path = path.display();
        Failure::new(
            Exit::BadInput,
            format_args!("cannot start {program}: {error}; open {path} in a browser by hand"),
        )
    })
}
