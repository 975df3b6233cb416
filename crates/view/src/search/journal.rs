//! Reads the journal of a search (`docs/journal-format.md`): one JSON object per line.
//!
//! Only what the page shows is read; keys and kinds of lines that are not known are passed over, and so is a last line that
//! is still being written.

use serde::Deserialize;

/// Contacts per phase.
pub(crate) type States = Vec<Vec<String>>;

/// The first line: which run it is.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Header {
    pub scene: String,
    pub search: String,
    pub seed: u64,
    pub max_phases: usize,
    /// Contacts of the goal.
    pub goal: Vec<String>,
}

/// Whether contacts, or a beginning, are possible.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Answer {
    pub states: States,
    pub possible: bool,
    pub reason: Option<String>,
    pub seconds: f64,
}

/// A complete sequence that was tried.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Tried {
    pub number: usize,
    pub at: f64,
    pub labels: Vec<String>,
    pub states: States,
    pub reached: String,
    pub reason: Option<String>,
    pub cost: Option<f64>,
    pub violation: Option<f64>,
    /// Phase in which the motion failed, from 0.
    pub failed_phase: Option<usize>,
    pub iterations: usize,
    pub seconds: f64,
    pub reward: f64,
    /// Per beginning, as far as the search's tree reaches.
    pub visits: Vec<u32>,
    pub values: Vec<f64>,
}

#[derive(Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
enum Line {
    Run(Header),
    State(Answer),
    Prefix(Answer),
    Sequence(Tried),
    #[serde(other)]
    Other,
}

/// All lines by kind.
#[derive(Debug, Default)]
pub(crate) struct Journal {
    pub header: Header,
    pub states: Vec<Answer>,
    pub prefixes: Vec<Answer>,
    pub sequences: Vec<Tried>,
}

impl Journal {
    /// Reads the text; a fault is told with its line.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut journal = Self::default();
        let whole = text.rfind('\n').map_or("", |end| &text[..end]);
        for (i, line) in whole.lines().enumerate() {
            let line = serde_json::from_str(line)
                .map_err(|error| format!("line {} is no line of a journal: {error}", i + 1))?;
            match line {
                Line::Run(header) => journal.header = header,
                Line::State(answer) => journal.states.push(answer),
                Line::Prefix(answer) => journal.prefixes.push(answer),
                Line::Sequence(tried) => journal.sequences.push(tried),
                Line::Other => {}
            }
        }
        Ok(journal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_kinds_and_half_lines_are_passed_over_and_faults_have_their_line() {
        let text = "{\"kind\":\"run\",\"scene\":\"s\",\"more\":1}\n{\"kind\":\"weather\"}\n{\"kind\":\"sequence\",\"number\":3}\n{\"kind\":\"st";
        let journal = Journal::parse(text).unwrap();
        assert_eq!(journal.header.scene, "s");
        assert_eq!(
            (journal.sequences.len(), journal.sequences[0].number),
            (1, 3)
        );
        let error = Journal::parse("{\"kind\":\"run\"}\nnonsense\n").unwrap_err();
        assert!(
            error.starts_with("line 2 is no line of a journal"),
            "{error}"
        );
    }
}
