//! Tests of the trajectory problem as a whole.
mod derivatives;
mod paper;
mod scenes;
