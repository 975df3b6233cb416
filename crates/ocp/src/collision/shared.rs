//! Balls and obstacles that rows of neighbouring nodes share: a sweep over the rows reads them once.

use super::Ball;
use crate::terms::distance::{Balls, Distance, Obstacle};
use spatial::Pose;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The last balls and obstacles of each pair of bodies, found again while they stay the same from node to node.
#[derive(Default)]
pub(super) struct Shared {
    balls: Last<Balls>,
    obstacles: Last<Obstacle>,
}

/// By index of the pair: body and primitive, or pair of links and nothing.
type Last<T> = BTreeMap<(usize, Option<usize>), Arc<T>>;

impl Shared {
    /// The row of a pair.
    pub fn row(
        &mut self,
        pair: (usize, Option<usize>),
        (balls, obstacle): (Vec<Ball>, Obstacle),
        obstacle_from_b: Pose,
        clearance: f64,
    ) -> Distance {
        let balls = share(&mut self.balls, pair, Balls::new(balls));
        let obstacle = share(&mut self.obstacles, pair, obstacle);
        Distance::sharing(balls, obstacle, obstacle_from_b, clearance)
    }
}

fn share<T: PartialEq>(last: &mut Last<T>, pair: (usize, Option<usize>), new: T) -> Arc<T> {
    match last.get(&pair) {
        Some(same) if **same == new => same.clone(),
        _ => {
            let new = Arc::new(new);
            last.insert(pair, new.clone());
            new
        }
    }
}
