//! Tests of scene files as a whole, one binary.

mod builtin;
