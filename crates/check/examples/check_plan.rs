//! Judges a plan file: `cargo run -p check --example check_plan -- PLAN.json [--json] [--accept]`.
//! Exit code 0: every category within tolerance; 1: some category fails; 2: the file cannot be read.

use std::process::ExitCode;

use check::Options;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let flag = |name: &str| arguments.iter().any(|argument| argument == name);
    let Some(path) = arguments
        .iter()
        .find(|argument| !argument.starts_with("--"))
    else {
        eprintln!("usage: check_plan PLAN.json [--json] [--accept]");
        return ExitCode::from(2);
    };
    let plan = match plan::Plan::read(path) {
        Ok(plan) => plan,
        Err(error) => {
            eprintln!("{error}");
            return ExitCode::from(2);
        }
    };
    let options = if flag("--accept") {
        Options::accept()
    } else {
        Options::default()
    };
    let start = std::time::Instant::now();
    let report = check::check(&plan, &options);
    eprintln!("judged in {:.0} ms", start.elapsed().as_secs_f64() * 1e3);
    if flag("--json") {
        match serde_json::to_string(&report) {
            Ok(text) => println!("{text}"),
            Err(error) => eprintln!("{error}"),
        }
    } else {
        println!("{report}");
    }
    ExitCode::from(u8::from(!report.ok()))
}
