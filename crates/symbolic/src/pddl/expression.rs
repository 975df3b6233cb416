//! Symbols and lists in parentheses, the notation of PDDL. A semicolon begins a comment; case does not matter.

use super::source::{PddlError, Source};
use std::ops::Range;

/// Deepest nesting of parentheses.
const DEEPEST: usize = 100;

/// A symbol or a list.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Expression {
    /// A word in small letters.
    Symbol(String, Range<usize>),
    /// What stands between two parentheses.
    List(Vec<Expression>, Range<usize>),
}

impl Expression {
    /// Bytes in the text.
    pub fn span(&self) -> Range<usize> {
        match self {
            Self::Symbol(_, span) | Self::List(_, span) => span.clone(),
        }
    }

    /// The word, if it is one.
    pub fn symbol(&self) -> Option<&str> {
        match self {
            Self::Symbol(word, _) => Some(word),
            Self::List(..) => None,
        }
    }

    /// The elements, if it is a list.
    pub fn list(&self) -> Option<&[Self]> {
        match self {
            Self::Symbol(..) => None,
            Self::List(elements, _) => Some(elements),
        }
    }

    /// The first word of a list and what follows it.
    pub fn headed(&self) -> Option<(&str, &[Self])> {
        let (head, rest) = self.list()?.split_first()?;
        Some((head.symbol()?, rest))
    }
}

/// Reads a text that is one list.
pub(crate) fn read(source: &Source) -> Result<Expression, PddlError> {
    let text = &source.text;
    let mut open: Vec<(Vec<Expression>, usize)> = Vec::new();
    let mut whole: Option<Expression> = None;
    for (token, span) in tokens(text) {
        if whole.is_some() {
            return Err(source.error(
                span,
                format!("{token:?} after the end, expected nothing"),
                "remove it, or look for a parenthesis too many before it",
            ));
        }
        let complete = match token {
            "(" if open.len() == DEEPEST => {
                let problem = format!("more than {DEEPEST} parentheses are open");
                return Err(source.error(span, problem, "close some of them"));
            }
            "(" => {
                open.push((Vec::new(), span.start));
                continue;
            }
            ")" => {
                let Some((elements, start)) = open.pop() else {
                    let problem = "\")\" without \"(\" before it";
                    return Err(source.error(span, problem, "begin with (define (domain …) …)"));
                };
                Expression::List(elements, start..span.end)
            }
            word => Expression::Symbol(word.to_lowercase(), span),
        };
        match open.last_mut() {
            Some((elements, _)) => elements.push(complete),
            None => whole = Some(complete),
        }
    }
    if let Some((_, start)) = open.last() {
        let problem = "\"(\" is never closed";
        return Err(source.error(*start..start + 1, problem, "add \")\" where its list ends"));
    }
    whole.ok_or_else(|| {
        let end = text.len();
        source.error(
            end..end,
            "the text is empty",
            "begin with (define (domain …) …)",
        )
    })
}

/// Parentheses and words with their bytes, comments left out.
fn tokens(text: &str) -> impl Iterator<Item = (&str, Range<usize>)> {
    let mut at = 0;
    std::iter::from_fn(move || {
        loop {
            let rest = &text[at..];
            let first = rest.chars().next()?;
            let length = match first {
                ';' => {
                    at += rest.find('\n').unwrap_or(rest.len());
                    continue;
                }
                space if space.is_whitespace() => {
                    at += space.len_utf8();
                    continue;
                }
                '(' | ')' => 1,
                _ => rest
                    .find(|c: char| c.is_whitespace() || "();".contains(c))
                    .unwrap_or(rest.len()),
            };
            let span = at..at + length;
            at = span.end;
            return Some((&text[span.clone()], span));
        }
    })
}
