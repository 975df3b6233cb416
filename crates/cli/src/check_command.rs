//! `locotamp check`: judges a plan file.

use crate::arguments::{CheckOptions, ProfileName};
use crate::failure::Failure;
use crate::{Exit, output, plan_file};
use check::{Options, Profile};

/// Reads, judges and tells.
pub(crate) fn run(options: &CheckOptions) -> Result<Exit, Failure> {
    let plan = plan_file::read(&options.plan)?;
    let profile = match options.profile {
        ProfileName::Default => Profile::Default,
        ProfileName::Accept => Profile::Accept,
    };
    let judged_by = Options {
        profile,
        strict: options.strict,
        substeps: options.substeps,
        ..Options::default()
    };
    let report = check::check(&plan, &judged_by);
    let text = if options.json {
        serde_json::to_string(&report).map_err(|error| Failure::new(Exit::Rejected, error))?
    } else {
        report.to_string()
    };
    output::result(&format!("{text}\n"));
    Ok(if report.ok() {
        Exit::Done
    } else {
        Exit::Rejected
    })
}
