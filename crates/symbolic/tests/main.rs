//! Tests of the symbolic layer against hand-worked examples and brute force.

mod first;
mod fixtures;
