//! `locotamp report`: the paper's figures of one plan, or of two for comparison.

use crate::failure::Failure;
use crate::mesh_options::MeshOptions;
use crate::{Exit, output, plan_file};
use clap::Args;
use std::fs;
use std::path::PathBuf;
use view::{FigureOptions, Meshes, Named};

#[derive(Debug, Args)]
pub(crate) struct ReportOptions {
    /// A plan file, or two to compare
    #[arg(required = true, num_args = 1..=2, value_name = "PLAN")]
    pub plans: Vec<PathBuf>,
    /// Folder for the figures
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Joints whose torques are shown, separated by commas [default: the four most loaded]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub joints: Vec<String>,
    /// Snapshots of each plan
    #[arg(long, value_name = "N", default_value_t = 6, value_parser = clap::value_parser!(u8).range(2..=24))]
    pub snapshots: u8,
    #[command(flatten)]
    pub meshes: MeshOptions,
    /// Leave out the animated picture
    #[arg(long)]
    pub no_animation: bool,
}

/// Reads the plans, draws, writes, and lists what was written.
pub(crate) fn run(options: &ReportOptions) -> Result<Exit, Failure> {
    let plans = plan_file::read_all(&options.plans)?;
    let names = plan_file::names(&options.plans);
    let named = plans.iter().zip(&names);
    let named: Vec<_> = named.map(|(plan, name)| Named { name, plan }).collect();
    let wanted = FigureOptions {
        joints: options.joints.clone(),
        snapshots: options.snapshots.into(),
        animation: !options.no_animation,
        ..FigureOptions::default()
    };
    let figures = view::figures(
        &named,
        &options.meshes.meshes(&plans, Meshes::FIGURE)?,
        &wanted,
    )
    .map_err(|error| Failure::new(Exit::BadInput, error))?;
    fs::create_dir_all(&options.out)
        .map_err(|error| Failure::path("make the folder", &options.out, &error))?;
    for figure in figures {
        let path = options.out.join(&figure.file);
        fs::write(&path, &figure.bytes).map_err(|error| Failure::path("write", &path, &error))?;
        output::result(&format!("{}\n", path.display()));
    }
    Ok(Exit::Done)
}
