//! What a row speaks of, for reports.

use symbolic::Contact;

/// Where a row comes from, for reports.
#[derive(Debug, Clone, PartialEq)]
pub struct RowLabel {
    /// Category, as the checker names it.
    pub category: &'static str,
    /// Contact, joint or pair, by index into what the category speaks of.
    pub subject: Subject,
    /// SI value = row value · scale.
    pub scale: f64,
    /// Unit of the SI value.
    pub unit: &'static str,
}

/// What a row speaks of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Subject {
    /// Velocity index of the system.
    Coordinate(usize),
    /// A contact.
    Contact(Contact),
    /// Two bodies, as indices of joints; the second one is the world if `None`.
    Pair(usize, Option<usize>),
    /// A goal region of the scene.
    Goal(usize),
    /// The duration of a phase.
    Duration,
}

/// A row label from its parts.
pub(super) fn label(
    category: &'static str,
    subject: Subject,
    scale: f64,
    unit: &'static str,
) -> RowLabel {
    RowLabel {
        category,
        subject,
        scale,
        unit,
    }
}
