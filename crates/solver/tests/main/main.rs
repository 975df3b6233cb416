//! Solver tests: factorisation against a dense twin, small programs with known answers.
mod front;
mod programs;
