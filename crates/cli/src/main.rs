//! The command `locotamp`: plans a scene, solves given contact sequences, judges, shows and exports a plan, drafts robot files, lists what is
//! built in.
//!
//! The only place that prints and exits. Results go to standard output, progress and errors to standard error. Exit
//! codes: 0 done, 1 no plan or plan rejected, 2 bad usage or input.

mod arguments;
mod bench_command;
mod bench_table;
mod check_command;
mod counts;
mod export_command;
mod failure;
mod folder;
mod interrupt;
mod memory;
mod mesh_options;
mod output;
mod plan_command;
mod plan_file;
mod plan_sequence;
mod progress;
mod reasons;
mod report_command;
mod result_json;
mod result_text;
mod robot_command;
mod scene_commands;
mod solve_command;
mod symbols_command;
mod symbols_graph;
mod symbols_text;
mod view_command;
mod watch_command;

use arguments::{Arguments, Command};
use clap::Parser;
use std::process::ExitCode;

/// The command's exit codes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Exit {
    /// Feasible plan, or plan accepted.
    Done = 0,
    /// No plan, or plan rejected.
    Rejected = 1,
    /// Bad usage or input.
    BadInput = 2,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let done = match &arguments.command {
        Command::Plan(options) => plan_command::run(options),
        Command::Solve(options) => solve_command::run(options),
        Command::Bench(options) => bench_command::run(options),
        Command::Check(options) => check_command::run(options),
        Command::View(options) => view_command::run(options),
        Command::Watch(options) => watch_command::run(options),
        Command::Report(options) => report_command::run(options),
        Command::Export(options) => export_command::run(options),
        Command::Scenes { name } => scene_commands::scenes(name.as_deref()),
        Command::Symbols(options) => symbols_command::run(options),
        Command::Robot(options) => robot_command::run(options),
    };
    match done {
        Ok(exit) => exit.into(),
        Err(failure) => {
            failure.report(arguments.command.for_machines());
            failure.exit().into()
        }
    }
}
