//! Tests of the symbolic layer against examples worked by hand and against brute force.

mod ahead;
mod brute_force;
mod costs;
mod domain;
mod fixtures;
mod graph;
mod kinds;
mod oracles;
mod pddl;
mod problems;
mod rules;
mod search;
mod sequences;
mod skeletons;
mod statistics;
mod task;
mod tree;
