//! Shows plans: one self-contained page per plan or set of plans.
//!
//! [`plan_page`] evaluates a plan once (poses, centre of mass, loads of the contacts, the checker's verdict), rounds
//! everything to what can be seen and puts it into the page that `viewer/` builds.
//!
//! Frames: `world`; `frame`, a link of the robot; `shape`, a shape's own.

mod compact;
mod convert;
mod error;
mod loads;
mod motion;
mod page;
mod page_data;
mod robot;

pub use error::ViewError;
pub use page::{Named, plan_page};
