//! Shows plans: one self-contained page per plan or set of plans, and the figures of a paper.
//!
//! [`plan_page`] evaluates a plan once (poses, centre of mass, loads of the contacts, the checker's verdict), rounds
//! everything to what can be seen and puts it into the page that `viewer/` builds.
//!
//! [`figures`] draws the contact sequence, torques and snapshots as SVG and PNG and the motion as a GIF, with a small software
//! renderer, so no display is needed.
//!
//! [`Meshes`] are the robots' mesh files, which a plan only names; page and figures draw them where they are given.
//!
//! [`Run`] makes the page of a search from the journal in the folder of a run.
//!
//! Frames: `world`; `frame`, a link of the robot; `shape`, a shape's own.

mod compact;
mod convert;
mod error;
mod figures;
mod loads;
mod meshes;
mod motion;
mod page;
mod page_data;
mod palette;
mod render;
mod robot;
mod search;
mod torques;
mod viewpoint;

pub use error::ViewError;
pub use figures::{Figure, FigureOptions, figures};
pub use meshes::Meshes;
pub use page::{Named, plan_page};
pub use search::Run;
