//! Tests of the checker, one binary.

mod hostile;
mod spoiled;
mod toy;
mod valid;
