//! A point of the search space: configurations, wrenches, durations.

/// Configurations of all nodes, scaled wrenches of all intervals, durations of all phases.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// q of the system per node, N + 1 of them.
    pub nodes: Vec<Vec<f64>>,
    /// Scaled wrench variables per interval, in the order of its contacts.
    pub wrenches: Vec<Vec<f64>>,
    /// Velocities of all nodes where they are unknowns of their own ([`crate::Integrator::has_velocities`]), else none.
    pub velocities: Vec<Vec<f64>>,
    /// Durations per phase [s] (all 1 for keyframes).
    pub durations: Vec<f64>,
}
