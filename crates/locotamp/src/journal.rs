//! The journal of a search: one JSON object per line and answer, so that a run that was killed goes on without asking again.
//!
//! A search is a function of scene, options, seed and the answers that it gets. The journal keeps the answers by content:
//! `state` (is there a configuration with these contacts), `prefix` (are there keyframes of this beginning), `coarse` (the
//! motion of a sequence on the coarse grid) and `sequence` (how far a complete sequence got). Format: docs/journal-format.md.

use crate::api::Error;
use crate::lapse::Lapse;
use ocp::Point;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;

/// Contacts per phase, "a on b" or "a holds b".
pub type States = Vec<Vec<String>>;

/// Version of the format.
const FORMAT: &str = "locotamp.journal/1";

/// The first line.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// Version of the format.
    pub format: String,
    /// Name of the scene.
    pub scene: String,
    /// Name of the search policy.
    pub search: String,
    /// Seed of every random choice.
    pub seed: u64,
    /// Hash of scene and options: the journal of another problem is refused.
    pub fingerprint: String,
    /// Largest number of phases K_max.
    pub max_phases: usize,
    /// Contacts of the goal, "a on b".
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub goal: Vec<String>,
}

impl Header {
    pub(crate) fn new(
        scene: &str,
        search: &str,
        seed: u64,
        content: &str,
        max_phases: usize,
        goal: Vec<String>,
    ) -> Self {
        Self {
            format: FORMAT.into(),
            scene: scene.into(),
            search: search.into(),
            seed,
            fingerprint: fingerprint(content),
            max_phases,
            goal,
        }
    }

    /// True if answers of one hold for the other; journals of older versions do not name the goal.
    fn is_same_run(&self, other: &Self) -> bool {
        let goal = other.goal.clone();
        Self {
            goal,
            ..self.clone()
        } == *other
    }
}

/// Whether contacts are possible, and why not.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Answer {
    /// Contacts of the state, or of every phase of the beginning.
    pub states: States,
    /// Nothing speaks against them.
    pub possible: bool,
    /// What does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Time that the answer took [s].
    pub seconds: f64,
}

/// Where a complete sequence got more steps than it was drawn with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Steps {
    /// Contacts per phase, as drawn.
    pub states: States,
    /// One after the other: the phase in which all feet were set anew, and which of them first, both from 0.
    pub rounds: Vec<(usize, usize)>,
}

/// A motion on the coarse grid, of a sequence that may be tried on a finer one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Coarse {
    /// Number of the sequence, from 1.
    pub number: usize,
    /// Seconds since the search began.
    pub at: f64,
    /// Contacts per phase.
    pub states: States,
    /// Cost that its keyframes promised.
    pub promise: f64,
    /// Cost of the motion.
    pub cost: f64,
    /// The part of it that is the scene's objective, mostly negative.
    #[serde(default)]
    pub objective: f64,
    /// The phase that costs most, from 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dearest_phase: Option<usize>,
    /// What it lacks between its nodes.
    #[serde(default)]
    pub lapse: Lapse,
    /// Its largest violation (scaled rows).
    pub violation: f64,
    /// Iterations of the optimiser.
    pub iterations: usize,
    /// Work of the optimiser, as of [`Tried`].
    pub work: u64,
    /// Time of the optimiser [s].
    pub seconds: f64,
    /// The motion.
    pub point: PointEntry,
}

/// A complete sequence that was tried.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Tried {
    /// Its number, from 1.
    pub number: usize,
    /// Seconds since the search began.
    pub at: f64,
    /// What changes on entering each phase.
    pub labels: Vec<String>,
    /// Contacts per phase.
    pub states: States,
    /// `keyframes`, `alike`, `optimised` or `feasible`.
    pub reached: String,
    /// Why it got no further.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Cost of the motion.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cost: Option<f64>,
    /// Cost that its keyframes promised, if it was optimised.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub promise: Option<f64>,
    /// Phase in which the motion failed, from 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub failed_phase: Option<usize>,
    /// Phase that costs most, from 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dearest_phase: Option<usize>,
    /// What a motion that holds but for that lacks between its nodes.
    #[serde(default, skip_serializing_if = "Lapse::is_slight")]
    pub lapse: Lapse,
    /// Largest violation (scaled rows) of the motion.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub violation: Option<f64>,
    /// Iterations of the optimiser.
    pub iterations: usize,
    /// Work of the optimiser: elements of the problem, summed over the iterations.
    #[serde(default)]
    pub work: u64,
    /// Time of the optimiser [s].
    pub seconds: f64,
    /// What the search was told, between 0 and 1.
    pub reward: f64,
    /// How often the search had gone through the beginnings of the sequence by then, the start first, as far as its tree reaches.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub visits: Vec<u32>,
    /// Mean reward of these visits.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub values: Vec<f64>,
    /// The motion, if it is feasible or the best so far.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub point: Option<PointEntry>,
}

/// [`Point`] as it is written.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PointEntry {
    /// Intervals per phase.
    pub steps: Vec<usize>,
    nodes: Vec<Vec<f64>>,
    wrenches: Vec<Vec<f64>>,
    velocities: Vec<Vec<f64>>,
    durations: Vec<f64>,
}

impl PointEntry {
    /// A point with its intervals per phase.
    pub fn new(steps: &[usize], point: &Point) -> Self {
        Self {
            steps: steps.to_vec(),
            nodes: point.nodes.clone(),
            wrenches: point.wrenches.clone(),
            velocities: point.velocities.clone(),
            durations: point.durations.clone(),
        }
    }
}

impl From<PointEntry> for Point {
    fn from(entry: PointEntry) -> Self {
        Self {
            nodes: entry.nodes,
            wrenches: entry.wrenches,
            velocities: entry.velocities,
            durations: entry.durations,
        }
    }
}

/// One line.
#[derive(Debug, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
enum Line {
    Run(Header),
    State(Answer),
    Prefix(Answer),
    Steps(Steps),
    Coarse(Box<Coarse>),
    Sequence(Box<Tried>),
}

/// Answers of this run and of the one that it continues.
#[derive(Debug, Default)]
pub(crate) struct Journal {
    file: Option<File>,
    states: BTreeMap<States, Answer>,
    prefixes: BTreeMap<States, Answer>,
    steps: BTreeMap<States, Vec<(usize, usize)>>,
    coarse: BTreeMap<States, Coarse>,
    sequences: BTreeMap<States, Tried>,
}

/// Name of the journal of the run before, if a new one begins in its folder.
const EARLIER: &str = "journal-before.jsonl";

impl Journal {
    /// Opens the journal at `path`: a new one, or with `resume` the one that is there, whose answers are read. One that is in the way
    /// of a new one gets the name [`EARLIER`].
    ///
    /// # Errors
    /// If the file cannot be used, or is of another problem.
    pub fn open(path: &Path, resume: bool, header: &Header) -> Result<Self, Error> {
        let failed = |reason: String| Error::Journal {
            path: path.display().to_string(),
            reason,
        };
        let mut journal = Self::default();
        let mut whole = 0;
        let known = resume && path.exists();
        if known {
            whole = journal.read(path, header).map_err(failed)?;
        } else if path.exists() {
            // Hours of work, maybe: who forgot to ask for them can still have them.
            fs::rename(path, path.with_file_name(EARLIER)).map_err(|e| failed(e.to_string()))?;
        }
        let file = OpenOptions::new()
            .create(true)
            .write(true)
            .truncate(!known)
            .open(path);
        let file = file.map_err(|error| failed(error.to_string()))?;
        if known {
            // What was being written when the run was killed goes.
            file.set_len(whole)
                .map_err(|error| failed(error.to_string()))?;
        }
        drop(file);
        let file = OpenOptions::new().append(true).open(path);
        journal.file = Some(file.map_err(|error| failed(error.to_string()))?);
        if whole == 0 {
            journal.write(&Line::Run(header.clone()));
        }
        Ok(journal)
    }

    /// Reads all whole lines; their length in bytes.
    fn read(&mut self, path: &Path, header: &Header) -> Result<u64, String> {
        let file = File::open(path).map_err(|error| error.to_string())?;
        let mut reader = BufReader::new(file);
        let (mut whole, mut number) = (0, 0);
        loop {
            let mut text = String::new();
            let read = reader
                .read_line(&mut text)
                .map_err(|error| error.to_string())?;
            if read == 0 || !text.ends_with('\n') {
                return Ok(whole);
            }
            number += 1;
            let line: Line = serde_json::from_str(&text)
                .map_err(|error| format!("line {number} is no line of a journal: {error}"))?;
            match line {
                Line::Run(found) if !found.is_same_run(header) => {
                    return Err(format!(
                        "it is of another run (scene {}, search {}, seed {}, fingerprint {}; now {}, {}, {}, {}): start \
                         without resuming, or in another folder",
                        found.scene,
                        found.search,
                        found.seed,
                        found.fingerprint,
                        header.scene,
                        header.search,
                        header.seed,
                        header.fingerprint
                    ));
                }
                Line::Run(_) => {}
                Line::State(answer) => {
                    self.states.insert(answer.states.clone(), answer);
                }
                Line::Prefix(answer) => {
                    self.prefixes.insert(answer.states.clone(), answer);
                }
                Line::Steps(steps) => {
                    self.steps.insert(steps.states, steps.rounds);
                }
                Line::Coarse(coarse) => {
                    self.coarse.insert(coarse.states.clone(), *coarse);
                }
                Line::Sequence(tried) => {
                    self.sequences.insert(tried.states.clone(), *tried);
                }
            }
            if number == 1 && self.sequences.len() + self.states.len() + self.prefixes.len() > 0 {
                return Err("its first line does not say of which run it is".into());
            }
            whole += read as u64;
        }
    }

    /// A disk that is full does not end a search: the journal just ends.
    fn write(&mut self, line: &Line) {
        if let (Some(file), Ok(mut text)) = (&mut self.file, serde_json::to_string(line)) {
            text.push('\n');
            if file.write_all(text.as_bytes()).is_err() {
                self.file = None;
            }
        }
    }

    pub fn state(&self, states: &States) -> Option<&Answer> {
        self.states.get(states)
    }

    pub fn note_state(&mut self, answer: Answer) {
        self.states.insert(answer.states.clone(), answer.clone());
        self.write(&Line::State(answer));
    }

    pub fn prefix(&self, states: &States) -> Option<&Answer> {
        self.prefixes.get(states)
    }

    pub fn note_prefix(&mut self, answer: Answer) {
        self.prefixes.insert(answer.states.clone(), answer.clone());
        self.write(&Line::Prefix(answer));
    }

    /// Where a sequence got more steps; empty if it did not.
    pub fn steps(&self, states: &States) -> &[(usize, usize)] {
        self.steps.get(states).map_or(&[], Vec::as_slice)
    }

    pub fn note_steps(&mut self, states: States, rounds: Vec<(usize, usize)>) {
        if !self.steps.contains_key(&states) {
            self.write(&Line::Steps(Steps { states, rounds }));
        }
    }

    /// What is known of a sequence from the run that is continued.
    pub fn take_sequence(&mut self, states: &States) -> Option<Tried> {
        self.sequences.remove(states)
    }

    /// The same of its motion on the coarse grid.
    pub fn coarse(&self, states: &States) -> Option<&Coarse> {
        self.coarse.get(states)
    }

    pub fn note_coarse(&mut self, coarse: Coarse) {
        if !self.coarse.contains_key(&coarse.states) {
            self.write(&Line::Coarse(Box::new(coarse)));
        }
    }

    pub fn note_sequence(&mut self, tried: Tried) {
        self.write(&Line::Sequence(Box::new(tried)));
    }
}

/// A hash of a text (FNV-1a; Fowler, Noll, Vo), the same on every platform.
fn fingerprint(text: &str) -> String {
    let step = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    format!("{:016x}", text.bytes().fold(0xcbf2_9ce4_8422_2325, step))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(content: &str) -> Header {
        Header::new("scene", "tree", 3, content, 13, vec![])
    }

    fn answer(name: &str) -> Answer {
        Answer {
            states: vec![vec![name.to_owned()]],
            possible: false,
            reason: Some("too far".into()),
            seconds: 0.25,
        }
    }

    #[test]
    fn a_journal_that_does_not_name_the_goal_goes_on_and_that_of_another_problem_does_not() {
        let named = Header {
            goal: vec!["box on table".into()],
            ..header("x")
        };
        assert!(header("x").is_same_run(&named));
        assert!(!header("y").is_same_run(&named));
    }

    #[test]
    fn a_half_written_line_is_dropped_and_the_rest_known_again() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("journal.jsonl");
        let mut journal = Journal::open(&path, false, &header("x")).expect("a new journal");
        journal.note_state(answer("one"));
        journal.note_prefix(answer("two"));
        drop(journal);
        let text = std::fs::read_to_string(&path).expect("text");
        std::fs::write(&path, format!("{text}{{\"kind\":\"sta")).expect("written");
        let mut again = Journal::open(&path, true, &header("x")).expect("the same run");
        assert_eq!(again.state(&answer("one").states), Some(&answer("one")));
        assert_eq!(again.prefix(&answer("two").states), Some(&answer("two")));
        again.note_state(answer("three"));
        let lines = std::fs::read_to_string(&path).expect("text");
        assert_eq!(lines.lines().count(), 4);
        Journal::open(&path, true, &header("x")).expect("still a journal");
    }

    #[test]
    fn the_journal_of_another_problem_is_refused_and_without_resuming_put_aside() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("journal.jsonl");
        drop(Journal::open(&path, false, &header("x")));
        let before = fs::read_to_string(&path).expect("text");
        let error = Journal::open(&path, true, &header("y")).expect_err("another scene");
        assert!(error.to_string().contains("of another run"), "{error}");
        Journal::open(&path, false, &header("y")).expect("a new one");
        let aside = fs::read_to_string(path.with_file_name(EARLIER)).expect("the earlier one");
        assert_eq!(aside, before);
    }
}
