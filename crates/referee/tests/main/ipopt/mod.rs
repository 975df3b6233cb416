//! Tests that need IPOPT; `.ci/run` picks them out by the name of this module.
mod small;
mod yardstick;
