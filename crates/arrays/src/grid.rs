//! Where the samples lie among the nodes of a plan.

use crate::{ArraysError, MOST_SAMPLES, RATES};
use plan::Plan;

/// A sample this near a node is at it, so that a node whose time is off by rounding keeps its own phase [s].
const AT_NODE: f64 = 1e-9;

/// A time of the plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Moment {
    /// The last node that is not after it.
    pub node: usize,
    /// The interval that it belongs to: the one that the node begins, at the end of the plan the last one.
    pub interval: usize,
    /// Time since the node [s]; exactly 0 at a node.
    pub since: f64,
}

/// The samples at k / rate, k = 0, 1, …, up to the last of the nodes, whose times rise from 0.
pub(crate) fn moments(nodes: &[f64], rate: f64) -> Result<Vec<Moment>, ArraysError> {
    if !RATES.contains(&rate) {
        return Err(ArraysError::BadRate { rate });
    }
    let (last, end) = (nodes.len() - 1, nodes[nodes.len() - 1]);
    let samples = ((end + AT_NODE) * rate).floor() + 1.0;
    if samples > MOST_SAMPLES as f64 {
        let duration = end;
        return Err(ArraysError::TooMany { duration, rate });
    }
    let moment = |k: usize| {
        let time = k as f64 / rate;
        let node = nodes.partition_point(|x| *x <= time + AT_NODE) - 1;
        let since = time - nodes[node];
        Moment {
            node,
            interval: node.min(last - 1),
            since: if since > AT_NODE && node < last {
                since
            } else {
                0.0
            },
        }
    };
    Ok((0..samples as usize).map(moment).collect())
}

/// Times of the nodes [s], from the durations of the phases and their steps; the plan must have no faults.
pub(crate) fn node_times(plan: &Plan) -> Vec<f64> {
    let mut times = vec![0.0];
    let mut start = 0.0;
    for phase in &plan.phases {
        let steps = phase.steps as f64;
        times.extend((1..=phase.steps).map(|i| start + phase.duration * (i as f64 / steps)));
        start += phase.duration;
    }
    times
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(nodes: &[f64], rate: f64) -> Vec<(usize, usize, f64)> {
        let moments = moments(nodes, rate).unwrap();
        let found = moments.iter().map(|x| (x.node, x.interval, x.since));
        found.collect()
    }

    #[test]
    fn a_node_that_is_off_by_rounding_has_its_sample() {
        let nodes = [0.0, 0.1 - 1e-12, 0.2 + 1e-12, 0.3 + 1e-12];
        let at_nodes = [(0, 0, 0.0), (1, 1, 0.0), (2, 2, 0.0), (3, 2, 0.0)];
        assert_eq!(found(&nodes, 10.0), at_nodes);
    }

    #[test]
    fn between_nodes_the_time_since_the_last_one_counts() {
        let moments = found(&[0.0, 0.3, 0.45], 4.0);
        assert_eq!((moments.len(), moments[0]), (2, (0, 0, 0.0)));
        assert_eq!(moments[1], (0, 0, 0.25));
        let moments = found(&[0.0, 0.3, 0.55], 2.0);
        assert_eq!((moments[1].0, moments[1].1), (1, 1));
        assert!((moments[1].2 - 0.2).abs() < 1e-15);
    }
}
