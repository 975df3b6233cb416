//! Tests of the trajectory problem as a whole.
mod derivatives;
mod idle;
mod keyframes;
mod paper;
mod rests;
mod scenes;
