//! `locotamp check`: judges a plan file.

use crate::arguments::{CheckOptions, ProfileName};
use crate::failure::Failure;
use crate::{Exit, output};
use check::{Options, Profile};
use plan::Plan;

/// Reads, judges and tells.
pub(crate) fn run(options: &CheckOptions) -> Result<Exit, Failure> {
    let plan = Plan::read(&options.plan).map_err(|error| {
        let path = options.plan.display().to_string();
        let text = error.to_string();
        let named = if text.starts_with(&path) {
            text
        } else {
            format!("{path}: {text}")
        };
        Failure::new(Exit::BadInput, named)
    })?;
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
