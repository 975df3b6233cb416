//! Tests of the checker, one binary.

mod g1;
mod hostile;
mod spoiled;
mod toy;
mod valid;
