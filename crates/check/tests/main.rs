//! Tests of the checker, one binary.

mod details;
mod g1;
mod hostile;
mod spoiled;
mod toy;
mod valid;
