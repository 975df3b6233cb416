//! Text of a file, and where in it a value stands.

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Deserialize;
use std::borrow::Cow;
use std::cmp::Ordering;
use std::fmt;
use std::ops::{Deref, Range};
use std::sync::Arc;

/// A value of a TOML file with the bytes it was read from.
#[derive(Debug, Clone, Deserialize)]
#[serde(transparent)]
pub(crate) struct At<T>(toml::Spanned<T>);

impl<T> At<T> {
    /// Bytes of the value in the text.
    pub fn span(&self) -> Range<usize> {
        self.0.span()
    }
}

impl<T> Deref for At<T> {
    type Target = T;

    fn deref(&self) -> &T {
        self.0.get_ref()
    }
}

impl<T: PartialEq> PartialEq for At<T> {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl<T: Eq> Eq for At<T> {}

impl<T: PartialOrd> PartialOrd for At<T> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        (**self).partial_cmp(&**other)
    }
}

impl<T: Ord> Ord for At<T> {
    fn cmp(&self, other: &Self) -> Ordering {
        (**self).cmp(&**other)
    }
}

/// In the schema the value stands for itself.
impl<T: JsonSchema> JsonSchema for At<T> {
    fn inline_schema() -> bool {
        T::inline_schema()
    }

    fn schema_name() -> Cow<'static, str> {
        T::schema_name()
    }

    fn schema_id() -> Cow<'static, str> {
        T::schema_id()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        T::json_schema(generator)
    }
}

/// A text file that was read: its name for people and its content.
#[derive(Debug, Clone)]
pub(crate) struct Source {
    name: Arc<str>,
    text: Arc<str>,
}

impl Source {
    pub fn new(name: &str, text: &str) -> Self {
        Self {
            name: name.into(),
            text: text.into(),
        }
    }

    /// The place of some bytes; bytes outside the text are moved to its end.
    pub fn place(&self, span: Range<usize>) -> Place {
        let start = char_boundary(&self.text, span.start);
        let end = char_boundary(&self.text, span.end.max(span.start)).max(start);
        Place {
            file: self.name.clone(),
            text: self.text.clone(),
            span: start..end,
        }
    }
}

/// The last character boundary at or before `index`.
fn char_boundary(text: &str, index: usize) -> usize {
    let mut index = index.min(text.len());
    while !text.is_char_boundary(index) {
        index -= 1;
    }
    index
}

/// A stretch of a text file.
#[derive(Clone)]
pub struct Place {
    file: Arc<str>,
    text: Arc<str>,
    span: Range<usize>,
}

impl Place {
    /// Name of the file as it was given.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// Line of the first character, from 1.
    pub fn line(&self) -> usize {
        self.text[..self.span.start].matches('\n').count() + 1
    }

    /// Column of the first character in its line, in characters from 1.
    pub fn column(&self) -> usize {
        let before = &self.text[..self.span.start];
        let line_start = before.rfind('\n').map_or(0, |n| n + 1);
        before[line_start..].chars().count() + 1
    }

    /// The text at this place.
    pub fn excerpt(&self) -> &str {
        &self.text[self.span.clone()]
    }

    /// The whole text of the file.
    pub(crate) fn text(&self) -> &str {
        &self.text
    }

    /// Bytes of the first line of this place, at least one character unless the text ends here.
    pub(crate) fn first_line(&self) -> Range<usize> {
        let rest = &self.text[self.span.clone()];
        let line = rest.find(['\n', '\r']).unwrap_or(rest.len());
        let next = self.text[self.span.start..]
            .chars()
            .next()
            .map_or(0, char::len_utf8);
        self.span.start..self.span.start + line.max(next)
    }
}

impl fmt::Debug for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{} {:?}", self.file, self.line(), self.excerpt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_knows_its_line_and_text() {
        let source = Source::new("a.toml", "one\ntwö\nthree\n");
        let place = source.place(4..8);
        assert_eq!((place.line(), place.excerpt()), (2, "twö"));
        assert_eq!((place.column(), source.place(6..8).column()), (1, 3));
        assert_eq!(source.place(4..12).first_line(), 4..8);
    }

    #[test]
    fn a_place_outside_the_text_or_inside_a_character_is_moved() {
        let source = Source::new("a.toml", "twö");
        assert_eq!(source.place(90..95).excerpt(), "");
        assert_eq!(source.place(3..9).excerpt(), "ö");
        assert_eq!(source.place(Range { start: 3, end: 2 }).first_line(), 2..4);
    }
}
