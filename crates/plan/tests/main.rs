//! Tests of the plan file as a whole, one binary.

mod reading;
mod sample;
mod schema;
mod validation;
mod writing;
