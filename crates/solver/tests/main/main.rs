//! Solver tests: factorisation and whole solves against dense twins, small programs with known answers, long chains,
//! and everything that goes wrong.
mod chain;
mod front;
mod hardships;
mod programs;
mod quadratic;
mod samples;
mod twin;
