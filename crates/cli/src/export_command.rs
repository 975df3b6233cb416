//! `locotamp export`: a plan as NumPy arrays, sampled at a fixed rate.

use crate::failure::Failure;
use crate::{Exit, output, plan_file};
use arrays::{Array, RATES};
use clap::Args;
use plan::Status;
use std::fs;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct ExportOptions {
    /// The plan file
    pub plan: PathBuf,
    /// The .npz file to write (docs/npz-format.md)
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// Samples per second
    #[arg(long, value_name = "HZ", default_value_t = 50.0, value_parser = rate, allow_negative_numbers = true)]
    pub rate: f64,
}

/// Reads the plan, samples it, writes the archive and says what is in it.
pub(crate) fn run(options: &ExportOptions) -> Result<Exit, Failure> {
    let out = options.out.display();
    if options.out.extension().is_none_or(|x| x != "npz") {
        let expected = format!("--out {out}: expected a file name that ends in .npz");
        return Err(Failure::new(Exit::BadInput, expected));
    }
    let plan = plan_file::read(&options.plan)?;
    let named = |error| {
        let path = options.plan.display();
        Failure::new(Exit::BadInput, format_args!("{path}: {error}"))
    };
    let arrays = arrays::sample(&plan, options.rate).map_err(named)?;
    let archive = arrays::npz(&arrays).map_err(named)?;
    fs::write(&options.out, archive)
        .map_err(|error| Failure::path("write", &options.out, &error))?;
    if plan.status == Status::Infeasible {
        let path = options.plan.display();
        output::error(&format!("note: {path} is infeasible by its own status\n"));
    }
    output::result(&format!("{out}: {}\n", summary(&arrays, options.rate)));
    Ok(Exit::Done)
}

/// Sizes, in one line.
fn summary(arrays: &[Array], rate: f64) -> String {
    let size = |name: &str| {
        let array = arrays.iter().find(|array| array.name == name);
        array.map_or(0, |array| array.shape[0])
    };
    let counted = |name: &str, one: &str| {
        let n = size(name);
        format!("{n} {one}{}", if n == 1 { "" } else { "s" })
    };
    format!(
        "{} at {rate} Hz, {}, {}, {}, {}",
        counted("time", "sample"),
        counted("joint_names", "joint"),
        counted("body_names", "link"),
        counted("object_names", "object"),
        counted("contact_names", "contact"),
    )
}

fn rate(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if RATES.contains(&value) => Ok(value),
        _ => {
            let (least, greatest) = (RATES.start(), RATES.end());
            Err(format!(
                "expected a number of samples per second from {least} to {greatest}"
            ))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rate_is_a_number_of_samples_that_memory_holds() {
        assert_eq!(rate("50"), Ok(50.0));
        assert_eq!(rate("29.97"), Ok(29.97));
        for bad in ["0", "-50", "nan", "inf", "1e9", "fast", ""] {
            assert!(rate(bad).is_err(), "{bad}");
        }
    }
}
