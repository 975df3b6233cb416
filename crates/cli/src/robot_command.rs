//! `locotamp robot`: drafts a robot file from a URDF or MJCF.

use crate::failure::Failure;
use crate::{Exit, output};
use clap::Args;
use draft::{DraftError, Forward, Wishes};
use scene::Scene;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub(crate) struct RobotOptions {
    /// The URDF (.urdf, .xml) or MJCF (.xml)
    pub model: PathBuf,
    /// Links of the feet [default: the lowest ends of two limbs that are like each other]
    #[arg(long, value_name = "LINK,LINK", value_parser = two_links)]
    pub feet: Option<[String; 2]>,
    /// Links of the hands [default: the ends of two other such limbs, if there are any]
    #[arg(long, value_name = "LINK,LINK", value_parser = two_links)]
    pub hands: Option<[String; 2]>,
    /// Where the robot looks, an axis of its base: x, -x, y or -y [default: told by soles and knees]
    #[arg(long, value_name = "AXIS", value_parser = forward, allow_hyphen_values = true)]
    pub forward: Option<Forward>,
    /// Name of the robot [default: that of the model]
    #[arg(long)]
    pub name: Option<String>,
    /// Folder with the mesh files that the model names
    #[arg(long, value_name = "DIR")]
    pub meshes: Option<PathBuf>,
    /// The robot file to write [default: the model's name with .toml, in this folder]
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Write over a file that is there
    #[arg(long)]
    pub force: bool,
}

/// Drafts the file, writes it, reads it again and says what was found and what is to be checked.
pub(crate) fn run(options: &RobotOptions) -> Result<Exit, Failure> {
    let out = out(options)?;
    if out.exists() && !options.force {
        let message = format!(
            "{} is there already; write over it with --force, or name another file with --out",
            out.display()
        );
        return Err(Failure::new(Exit::BadInput, message));
    }
    if let Some(wrong) = options.meshes.as_ref().filter(|folder| !folder.is_dir()) {
        let message = format!("--meshes {}: there is no such folder", wrong.display());
        return Err(Failure::new(Exit::BadInput, message));
    }
    let folder = match out.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let wishes = Wishes {
        feet: options.feet.clone(),
        hands: options.hands.clone(),
        forward: options.forward,
        name: options.name.clone(),
        meshes: options.meshes.clone(),
    };
    let drafted = draft::draft(&options.model, folder, &wishes).map_err(|error| match error {
        DraftError::Scene(error) => error.into(),
        error => Failure::new(Exit::BadInput, error),
    })?;
    fs::write(&out, &drafted.text).map_err(|error| Failure::path("write", &out, &error))?;
    let name = out.file_name().unwrap_or_default().to_string_lossy();
    let text = draft::standing_scene(&name);
    let scene = Scene::from_toml(&text, "the robot on level ground", folder)?;
    let mut told = String::new();
    for line in &drafted.found {
        let _ = writeln!(told, "{line}");
    }
    let _ = writeln!(told, "wrote {}", out.display());
    for doubt in &drafted.doubts {
        let _ = writeln!(told, "check: {doubt}");
    }
    for note in scene
        .notes()
        .into_iter()
        .chain(locotamp::home_note(&scene)?)
    {
        let _ = writeln!(told, "note: {note}");
    }
    output::result(&told);
    Ok(Exit::Done)
}

/// The file to write.
fn out(options: &RobotOptions) -> Result<PathBuf, Failure> {
    let out = match (&options.out, options.model.file_stem()) {
        (Some(out), _) => out.clone(),
        (None, Some(stem)) => PathBuf::from(format!("{}.toml", stem.to_string_lossy())),
        (None, None) => PathBuf::from("robot.toml"),
    };
    if out.extension().is_none_or(|x| x != "toml") {
        let message = format!(
            "--out {}: expected a file name that ends in .toml",
            out.display()
        );
        return Err(Failure::new(Exit::BadInput, message));
    }
    Ok(out)
}

fn two_links(text: &str) -> Result<[String; 2], String> {
    match text
        .split(',')
        .map(str::trim)
        .collect::<Vec<_>>()
        .as_slice()
    {
        [a, b] if !a.is_empty() && !b.is_empty() && a != b => Ok([(*a).into(), (*b).into()]),
        _ => Err("expected the names of two links, LEFT,RIGHT".into()),
    }
}

fn forward(text: &str) -> Result<Forward, String> {
    let plain = text.strip_prefix('+').unwrap_or(text);
    let found = Forward::ALL.into_iter().find(|axis| axis.name() == plain);
    found.ok_or_else(|| "expected x, -x, y or -y".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_are_two_names_with_a_comma_between() {
        assert_eq!(two_links("a, b"), Ok(["a".into(), "b".into()]));
        for bad in ["a", "a,", "a,b,c", "a,a", ""] {
            assert!(two_links(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn forward_is_an_axis_of_the_base() {
        assert_eq!(forward("-x"), Ok(Forward::MinusX));
        assert_eq!(forward("+y"), Ok(Forward::Y));
        assert!(forward("z").is_err());
    }
}
