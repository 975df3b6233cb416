//! The record: one JSON object per line and run.

use crate::runs::Run;
use serde::{Deserialize, Serialize};
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::Path;

/// What has been done up to some moment.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Effort {
    /// Wall time [s].
    pub seconds: f64,
    /// Processor time of all threads [s]; 0 where the system does not tell it as Linux does.
    pub processor_seconds: f64,
    /// Contact sequences that the policy proposed.
    pub drawn: usize,
    /// Sequences of whose optimisation the search had seen an iteration: up to three more than results.
    pub begun: usize,
    /// Sequences whose motion was optimised and the result taken.
    pub optimised: usize,
    /// Iterations of the optimiser for these results; the same on every machine.
    pub iterations: usize,
    /// Iterations that the search had seen, with those of motions that were still under way.
    pub seen: usize,
}

/// What the checker says with the profile `accept`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    pub accepted: bool,
    /// Categories that fail.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub failed: Vec<String>,
}

/// Where the feet get in a scene with a platform.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Feet {
    /// All stand on the platform in the last phase.
    pub on_platform: bool,
    /// One is on the box in some phase.
    pub over_box: bool,
}

impl Feet {
    /// True if the platform is reached over the box.
    pub fn climbed(self) -> bool {
        self.on_platform && self.over_box
    }
}

/// A plan, as far as the tables need it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Judged {
    pub verdict: Verdict,
    /// Only with a platform.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub feet: Option<Feet>,
    /// Cost of the optimiser.
    pub cost: Option<f64>,
    /// Sum of the durations [s].
    pub duration: f64,
    /// Of the base at the end [m].
    pub height: f64,
    pub phases: usize,
}

impl Judged {
    pub fn climbed(&self) -> bool {
        self.feet.is_some_and(Feet::climbed)
    }
}

/// A plan of the search, before refinement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Solution {
    /// Number of its sequence.
    pub number: usize,
    /// What it took to find it.
    pub effort: Effort,
    /// True if it is among the plans that differ in their loaded contacts.
    pub different: bool,
    #[serde(flatten)]
    pub judged: Judged,
}

/// What the run returned: a plan, or the motion that comes nearest to one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Returned {
    pub feasible: bool,
    /// "yes", "no", or why the refinement failed.
    pub refined: String,
    #[serde(flatten)]
    pub judged: Judged,
}

/// One run and its result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Record {
    #[serde(flatten)]
    pub run: Run,
    /// When it began, in seconds since 1970.
    pub begun_at: u64,
    /// Threads that optimise motions.
    pub threads: usize,
    /// Why the scene could not be planned at all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// True if it is no problem, since the variant starts in collision.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub left_out: bool,
    /// Why the search ended.
    pub ended: String,
    /// Wall time of the whole run [s].
    pub seconds: f64,
    /// Until the search ended, the refinement apart.
    pub search: Effort,
    /// Iterations of the refinement.
    pub refinement_iterations: usize,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub returned: Option<Returned>,
    /// All plans, in the order in which they were found.
    pub solutions: Vec<Solution>,
}

impl Record {
    /// What the first plan took.
    pub fn first(&self) -> Option<Effort> {
        self.solutions.first().map(|solution| solution.effort)
    }

    /// What the first plan over the box took.
    pub fn first_climbed(&self) -> Option<Effort> {
        let mut climbed = self.solutions.iter().filter(|s| s.judged.climbed());
        climbed.next().map(|solution| solution.effort)
    }

    /// The plans that differ in their loaded contacts.
    pub fn different(&self) -> impl Iterator<Item = &Solution> {
        self.solutions.iter().filter(|s| s.different)
    }

    /// True if the run returned a plan that the checker accepts.
    pub fn accepted(&self) -> bool {
        let good = |r: &Returned| r.feasible && r.judged.verdict.accepted;
        self.returned.as_ref().is_some_and(good)
    }
}

/// What a record is opened for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// More runs: it is made if there is none, and a last line that is not whole is cut off.
    Write,
    /// To see what is missing: there may be none.
    List,
    /// Its tables.
    Print,
}

/// The file of records.
pub struct Book {
    pub records: Vec<Record>,
    /// Where records are added.
    file: Option<File>,
}

impl Book {
    /// Reads the file, but for a last line that is not whole.
    pub fn open(path: &Path, mode: Mode) -> io::Result<Self> {
        let optional = mode != Mode::Print;
        let text = match std::fs::read_to_string(path) {
            Err(error) if optional && error.kind() == io::ErrorKind::NotFound => String::new(),
            Err(error) => {
                let message = format!("{}: {error}", path.display());
                return Err(io::Error::new(error.kind(), message));
            }
            Ok(text) => text,
        };
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        let parse = |(number, line): (usize, &str)| {
            serde_json::from_str(line).map_err(|error| {
                let message = format!("{}, line {number}: {error}", path.display());
                io::Error::new(io::ErrorKind::InvalidData, message)
            })
        };
        let records = (1..).zip(text[..whole].lines()).map(parse);
        let records = records.collect::<io::Result<_>>()?;
        let mut file = None;
        if mode == Mode::Write {
            let opened = OpenOptions::new().create(true).append(true).open(path)?;
            opened.set_len(whole as u64)?;
            file = Some(opened);
        }
        Ok(Self { records, file })
    }

    /// True if the run has been made.
    pub fn has(&self, run: &Run) -> bool {
        self.records.iter().any(|record| record.run == *run)
    }

    /// Writes a record.
    pub fn add(&mut self, record: Record) -> io::Result<()> {
        if let Some(file) = &mut self.file {
            let line = serde_json::to_string(&record)? + "\n";
            file.write_all(line.as_bytes())?;
            file.sync_data()?;
        }
        self.records.push(record);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::record;

    #[test]
    fn a_half_line_is_dropped_and_its_run_made_again() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("record.jsonl");
        let (first, second) = (record(1, Some(2.0)), record(2, None));
        let mut book = Book::open(&path, Mode::Write).expect("a new file");
        book.add(first.clone()).expect("written");
        book.add(second.clone()).expect("written");
        let text = std::fs::read_to_string(&path).expect("a file");
        std::fs::write(&path, &text[..text.len() - 20]).expect("cut");

        let read = Book::open(&path, Mode::Print).expect("a record");
        assert_eq!(read.records, std::slice::from_ref(&first));
        let mut book = Book::open(&path, Mode::Write).expect("a record");
        assert!(book.has(&first.run) && !book.has(&second.run));
        book.add(second).expect("written");
        assert_eq!(std::fs::read_to_string(&path).expect("a file"), text);
    }

    #[test]
    fn a_spoiled_line_is_named_and_nothing_is_lost() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("record.jsonl");
        std::fs::write(&path, "{}\n").expect("written");
        let error = Book::open(&path, Mode::Write).err().expect("no record");
        assert!(error.to_string().contains("line 1"), "{error}");
        assert_eq!(std::fs::read_to_string(&path).expect("a file"), "{}\n");
    }

    #[test]
    fn only_what_writes_makes_a_file() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("none");
        assert!(Book::open(&path, Mode::Print).is_err());
        let listed = Book::open(&path, Mode::List).expect("nothing yet");
        assert!(listed.records.is_empty() && !path.exists());
    }
}
