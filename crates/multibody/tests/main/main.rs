//! Tests of the crate as its users see it: algorithms against other software, against each other, bad input.

mod allocation;
mod bad_urdf;
mod mechanics;
mod oracle;
