//! The command from outside: exit codes, messages, and the whole chain on small scenes.

mod bad_input;
mod chain;
mod exporting;
mod robots;
mod sequences;
mod symbols;
mod viewing;

use assert_cmd::Command;
use std::path::PathBuf;
use std::process::Output;

/// A robot with one telescopic leg on a block, planned in milliseconds.
fn hopper() -> PathBuf {
    PathBuf::from(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../scene/tests/scenes/hopper.toml"
    ))
}

/// Runs `locotamp` in a folder.
fn locotamp(folder: &std::path::Path, arguments: &[&str]) -> Output {
    let mut command =
        Command::cargo_bin("locotamp").expect("cargo builds the command for its tests");
    command.current_dir(folder).args(arguments);
    command.output().expect("the command starts")
}

fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A folder with a plan of the hopper, `plan.json`.
fn planned() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let scene = hopper();
    let scene = scene.to_str().expect("paths of this repository are text");
    let output = locotamp(folder.path(), &["plan", scene, "--out", ".", "--quiet"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    folder
}

/// Runs a command that must be refused; its message.
fn refused(folder: &std::path::Path, arguments: &[&str]) -> String {
    let output = locotamp(folder, arguments);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert_eq!(stdout(&output), "");
    message
}
