//! The library from outside.

mod explanations;
