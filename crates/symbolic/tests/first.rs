//! The first sequences of pick-place.

use crate::fixtures::{id, one_box, standing};
use symbolic::search::AcceptAll;
use symbolic::{BestFirst, Costs, Goal, GraphOptions, SearchLimits, SkeletonGraph};

#[test]
fn pick_place_begins_with_the_bare_skeleton() {
    let domain = one_box(2);
    let start = standing(&domain, "red_box_bottom on table_a_top");
    let goal = Goal::of_pairs([(id(&domain, "red_box_bottom"), id(&domain, "table_b_top"))]);
    let graph = SkeletonGraph::new(domain, start, goal, GraphOptions::default())
        .expect("the problem is valid");
    let mut search = BestFirst::new(graph, &SearchLimits::default(), Costs::default());
    let first = search.next(&mut AcceptAll).expect("there is a plan");
    let labels = [
        "start",
        "grasp red_box with left_hand",
        "lift red_box",
        "place red_box on table_b_top",
        "release red_box",
    ];
    assert_eq!(first.labels, labels);
}
