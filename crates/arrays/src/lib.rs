//! A plan as arrays over time, sampled at a fixed rate, and as a NumPy archive (`.npz`): what controllers and motion trackers
//! read.
//!
//! [`sample`] evaluates a plan between its nodes as its integrator says and names every array; [`npz`] makes a file of them.
//! `docs/npz-format.md` lists the arrays.
//!
//! Frames: `world`; quaternions of the arrays have their scalar first, all others of this repository last.
//! Legend: T samples, J joints of the plan, B links, O objects, C contacts.

mod array;
mod error;
mod grid;
mod links;
mod npz;
mod phases;
mod sample;
mod states;

pub use array::{Array, Values};
pub use error::ArraysError;
pub use npz::npz;
pub use sample::sample;

/// Least and greatest number of samples per second [Hz].
pub const RATES: std::ops::RangeInclusive<f64> = 1.0..=1000.0;

/// Most samples: an hour at 50 Hz, three minutes at 1 kHz.
pub const MOST_SAMPLES: usize = 200_000;
