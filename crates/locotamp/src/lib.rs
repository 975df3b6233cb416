//! Task and motion planning for humanoid loco-manipulation: from a scene to a plan.
//!
//! [`plan`] searches contact sequences ([`symbolic`]), rejects what keyframes show impossible, optimises the rest
//! ([`ocp`]) and returns the best plan with a summary. [`solve`] optimises one given sequence. Nothing here prints or exits: progress goes to the caller's
//! observer, which can stop the search at any time and then gets the best so far.

mod api;
mod checks;
mod departures;
mod domain;
mod explain;
mod export;
mod journal;
mod lapse;
mod quality;
mod refine;
mod search;
mod solve;
mod start;
mod strides;
mod summary;
mod swings;
mod weight;

pub use api::{
    Alternative, Attempt, Error, Event, Explained, Found, Impossible, Outcome, Possible, Reached,
    Refusal, Request, Search, Stop,
};
pub use departures::with_places_to_leave;
pub use domain::{Skeletons, domain, pddl, skeletons};
pub use ocp::{Integrator, Preset, Refinement, Sticking};
pub use plan::Explanation;
pub use quality::{Margin, Peak, Quality, Residuals, Swing};
pub use refine::Refined;
pub use search::plan;
pub use solve::{KeyframeReport, MotionReport, Solved, solve};
pub use solver::{Status, Timing};
pub use start::home_note;
pub use summary::{PhaseSummary, Summary};
