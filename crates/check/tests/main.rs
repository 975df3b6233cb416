//! Tests of the checker, one binary.

mod toy;
mod valid;
