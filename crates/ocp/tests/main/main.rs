//! Tests of the trajectory problem as a whole.
mod derivatives;
mod fine_grids;
mod idle;
mod integrators;
mod keyframes;
mod paper;
mod rests;
mod scenes;
