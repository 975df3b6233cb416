//! The sequence file as written: one struct per TOML table.
//!
//! The doc comments here become the descriptions in `docs/sequence.schema.json`.

use crate::file::{ContactEntry, GoalEntry};
use crate::source::At;
use schemars::JsonSchema;
use serde::Deserialize;

/// A contact sequence for a scene: the contacts of every phase.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a contact sequence")]
#[schemars(title = "locotamp contact sequence")]
pub(crate) struct SequenceEntry {
    /// Name, for people; default: that of the file.
    pub name: Option<String>,
    /// What it shows, for people.
    #[serde(default)]
    pub description: String,
    /// Path of the scene file (.toml), relative to this file, or name of a built-in scene; `locotamp bench` needs it.
    pub scene: Option<At<String>>,
    /// Intervals of the phases that give none; default: `optimiser.steps` of the scene.
    pub steps: Option<At<usize>>,
    /// Is there a motion, as the author claims.
    pub expect: Option<At<ExpectEntry>>,
    /// Why there is none; with expect = "infeasible".
    pub why: Option<At<String>>,
    /// What must hold at the end, instead of the scene's goal; an empty table: nothing but the contacts of the last phase.
    pub goal: Option<GoalEntry>,
    /// The phases in order; the first has the contacts of the scene's start.
    #[schemars(length(min = 1))]
    pub phase: Vec<PhaseEntry>,
}

/// What the author of a sequence claims.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum ExpectEntry {
    /// There is a motion.
    Feasible,
    /// There is none.
    Infeasible,
}

/// One phase.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table with contacts")]
pub(crate) struct PhaseEntry {
    /// What it is, for people; default: the contacts that change.
    pub label: Option<String>,
    /// All contacts of the scene in this phase, objects on tables included: [interface, surface] or [interface, surface,
    /// type], in either order.
    pub contacts: At<Vec<At<ContactEntry>>>,
    /// Number of intervals, 1 to 200.
    pub steps: Option<At<usize>>,
}
