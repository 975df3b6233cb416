//! The library from outside.

mod explanations;
mod searching;
