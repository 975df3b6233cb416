//! Our solver beside IPOPT, on small programs and on the robot's; derivatives by a chart's coordinates.
mod charts;
#[cfg(feature = "ipopt")]
mod ipopt;
#[cfg(feature = "ipopt")]
#[path = "../../../solver/tests/main/samples.rs"]
mod samples;
