//! Tests of scene files as a whole, one binary.

mod builtin;
mod damage;
mod errors;
mod fixtures;
mod placing;
mod robots;
mod rules;
mod schema;
mod sequences;
