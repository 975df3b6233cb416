//! Text of a PDDL file, and errors that say where in it something is wrong.

use std::ops::Range;

/// What is wrong in a PDDL file, where, and what to do.
///
/// `Display` is one line, `file:line:column: what is wrong; what to do`.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{file}:{line}:{column}: {problem}; {remedy}")]
pub struct PddlError {
    /// Name of the file as it was given.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// Bytes of the text that the error is about.
    pub span: Range<usize>,
    /// What is wrong, with the value found and what was expected.
    pub problem: String,
    /// What to do.
    pub remedy: String,
}

/// A text with its name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Source {
    pub name: String,
    pub text: String,
}

impl Source {
    pub fn new(name: &str, text: &str) -> Self {
        Self {
            name: name.to_owned(),
            text: text.to_owned(),
        }
    }

    /// An error about the bytes `span`.
    pub fn error(
        &self,
        span: Range<usize>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> PddlError {
        let before = self.text.get(..span.start).unwrap_or(&self.text);
        let line_start = before.rfind('\n').map_or(0, |n| n + 1);
        PddlError {
            file: self.name.clone(),
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
            span,
            problem: problem.into(),
            remedy: remedy.into(),
        }
    }
}
