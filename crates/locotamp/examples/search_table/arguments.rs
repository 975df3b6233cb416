//! The arguments of the benchmark.

use crate::record::Mode;
use crate::runs::{Extent, Part};
use std::path::PathBuf;

pub const USAGE: &str = "\
usage: search_table RECORD.jsonl [options]
  --parts LIST     of two-box, climb, scenes, policies, perturbed, diverse; all by default
  --seeds N        seeds 1 to N (5)
  --variants N     perturbations 1 to N of each scene (20)
  --only NAME      runs whose name contains NAME (see --list)
  --time-limit S   instead of each run's own limit
  --threads N      that optimise motions; one per processor by default
  --list           names of the runs that are not in RECORD yet
  --print          the tables of RECORD, no runs";

/// What is to be done.
#[derive(Debug, PartialEq)]
pub struct Arguments {
    pub record: PathBuf,
    pub extent: Extent,
    /// Part of the names of the runs that are meant.
    pub only: Option<String>,
    /// 0: one per processor.
    pub threads: usize,
    pub list: bool,
    pub print: bool,
}

impl Arguments {
    /// Reads what follows the program's name.
    pub fn parse(given: &[String]) -> Result<Self, String> {
        let mut record = None;
        let mut arguments = Self {
            record: PathBuf::new(),
            extent: Extent::default(),
            only: None,
            threads: 0,
            list: false,
            print: false,
        };
        let mut rest = given.iter();
        while let Some(argument) = rest.next() {
            let mut value = || {
                let value = rest.next();
                value.ok_or_else(|| format!("{argument} needs a value"))
            };
            let extent = &mut arguments.extent;
            match argument.as_str() {
                "--parts" => {
                    let names = value()?.split(',');
                    extent.parts = names.map(Part::named).collect::<Result<_, _>>()?;
                }
                "--seeds" => extent.seeds = number(argument, value()?)?,
                "--variants" => extent.variants = number(argument, value()?)?,
                "--time-limit" => {
                    let seconds: f64 = number(argument, value()?)?;
                    if !(seconds.is_finite() && seconds > 0.0) {
                        return Err(format!("{argument} {seconds}: expected seconds above zero"));
                    }
                    extent.time_limit = Some(seconds);
                }
                "--threads" => arguments.threads = number(argument, value()?)?,
                "--only" => arguments.only = Some(value()?.clone()),
                "--list" => arguments.list = true,
                "--print" => arguments.print = true,
                option if option.starts_with('-') => return Err(format!("unknown: {option}")),
                path if record.is_none() => record = Some(path.into()),
                path => return Err(format!("{path}: there is one RECORD only")),
            }
        }
        arguments.record = record.ok_or("RECORD is missing")?;
        Ok(arguments)
    }

    /// True if a run of this name is meant.
    pub fn wants(&self, name: &str) -> bool {
        self.only.as_ref().is_none_or(|only| name.contains(only))
    }

    /// What the record is needed for.
    pub fn mode(&self) -> Mode {
        match (self.list, self.print) {
            (true, _) => Mode::List,
            (false, true) => Mode::Print,
            (false, false) => Mode::Write,
        }
    }
}

fn number<T: std::str::FromStr>(option: &str, value: &str) -> Result<T, String> {
    let number = value.parse();
    number.map_err(|_| format!("{option} {value}: expected a number"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Arguments, String> {
        let given: Vec<String> = text.split_whitespace().map(str::to_owned).collect();
        Arguments::parse(&given)
    }

    #[test]
    fn options_are_read_in_any_order() {
        let read = parse("--parts climb,two-box r.jsonl --seeds 2 --time-limit 20 --only x");
        let read = read.expect("good arguments");
        assert_eq!(read.record, PathBuf::from("r.jsonl"));
        assert_eq!(read.extent.parts, [Part::Climb, Part::TwoBox]);
        assert_eq!((read.extent.seeds, read.extent.time_limit), (2, Some(20.0)));
        assert!(read.wants("a x b") && !read.wants("a b"));
        assert_eq!(read.mode(), Mode::Write);
    }

    #[test]
    fn bad_arguments_are_named() {
        for (text, part) in [
            ("", "RECORD is missing"),
            ("r --seeds", "--seeds needs a value"),
            ("r --seeds many", "--seeds many: expected a number"),
            ("r --time-limit 0", "above zero"),
            ("r --parts boxes", "boxes"),
            ("r --fast", "unknown: --fast"),
            ("r s", "one RECORD only"),
        ] {
            let message = parse(text).expect_err(text);
            assert!(message.contains(part), "{text}: {message}");
        }
    }
}
