//! The library from outside.

mod explanations;
mod searching;
mod solving;
