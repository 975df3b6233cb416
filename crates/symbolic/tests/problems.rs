//! Problems that the tests of the searches share.

use crate::fixtures::{id, one_box, standing, two_boxes};
use symbolic::{
    BestFirst, Costs, Domain, Goal, GraphOptions, Oracle, Policy, SearchLimits, Sequence,
    SkeletonGraph,
};

/// One box from table a to table b.
pub fn pick_place() -> SkeletonGraph {
    let domain = one_box(2);
    let goal = Goal::of_pairs([(id(&domain, "red_box_bottom"), id(&domain, "table_b_top"))]);
    let start = standing(&domain, "red_box_bottom on table_a_top");
    SkeletonGraph::new(domain, start, goal, GraphOptions::default()).expect("the problem is valid")
}

/// Two boxes to table c.
pub fn two_box() -> SkeletonGraph {
    let domain = two_boxes(3);
    let goal = Goal::of_pairs(
        ["red_box_bottom", "green_box_bottom"]
            .map(|b| (id(&domain, b), id(&domain, "table_c_top"))),
    );
    let start = standing(
        &domain,
        "red_box_bottom on table_a_top, green_box_bottom on table_b_top",
    );
    SkeletonGraph::new(domain, start, goal, GraphOptions::default()).expect("the problem is valid")
}

/// The box on table a, and a goal.
pub fn with_goal(domain: Domain, goal: Goal) -> SkeletonGraph {
    let start = standing(&domain, "red_box_bottom on table_a_top");
    SkeletonGraph::new(domain, start, goal, GraphOptions::default()).expect("the problem is valid")
}

/// A search with default limits and costs.
pub fn best_first(graph: SkeletonGraph) -> BestFirst {
    BestFirst::new(graph, &SearchLimits::default(), Costs::default())
}

/// The next sequences, at most `count`.
pub fn take(search: &mut BestFirst, count: usize, oracle: &mut dyn Oracle) -> Vec<Sequence> {
    std::iter::from_fn(|| search.next(oracle))
        .take(count)
        .collect()
}

/// Pick-place with two steps while the box is in the air.
pub const NATURAL: [&str; 9] = [
    "start",
    "grasp red_box with left_hand",
    "lift red_box",
    "left_foot off ground_top",
    "left_foot on ground_top",
    "right_foot off ground_top",
    "right_foot on ground_top",
    "place red_box on table_b_top",
    "release red_box",
];
