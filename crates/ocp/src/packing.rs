//! Places on a support that leave room for all objects that stand there at the same time.

use crate::resting::ROOM;
use nalgebra::Vector2;

/// Grid of places [m].
const GRID: f64 = 0.05;
/// Room between two objects [m]: as much as can be of this, then as a motion demands, then none.
const ROOMS: [f64; 3] = [ROOM, 0.02, 0.0];
/// What a step towards where an object comes from counts for, in a step away from the middle of the support.
const TOWARDS: f64 = 0.1;
/// Places that are looked at before the search ends without a result.
const MOST_TRIED: usize = 20_000;
/// Rounding [m].
const SMALL: f64 = 1e-9;

/// Something that stands on a support, in the axes of its surface [m].
#[derive(Debug, Clone)]
pub struct Item {
    /// Least and greatest coordinates of its shapes, from the middle of its own surface.
    pub shape: [Vector2<f64>; 2],
    /// Half the extent of its own surface, which lies on the support.
    pub surface: Vector2<f64>,
    /// Where it comes from.
    pub from: Vector2<f64>,
    /// Where it stands.
    pub place: Vector2<f64>,
    /// Must it stand there?
    pub stays: bool,
}

impl Item {
    /// How far from the middle of a support its place may be; zero where it is larger than the support.
    fn most(&self, half: Vector2<f64>) -> Vector2<f64> {
        (half - self.surface).map(|most| most.max(0.0))
    }

    fn is_on(&self, half: Vector2<f64>) -> bool {
        let beyond = self.place.abs() - self.most(half);
        beyond.max() <= SMALL
    }

    fn is_apart(&self, other: &Self, room: f64) -> bool {
        let before = |a: &Self, b: &Self| (b.place + b.shape[0]) - (a.place + a.shape[1]);
        before(self, other).max().max(before(other, self).max()) >= room - SMALL
    }

    /// Places by their distance from the middle, and a little from where it comes from.
    fn places(&self, half: Vector2<f64>) -> Vec<Vector2<f64>> {
        let most = self.most(half);
        let along = |most: f64| {
            let steps = (most / GRID).floor() as i32;
            let grid = (-steps..=steps).map(|k| f64::from(k) * GRID);
            grid.chain([-most, most]).collect::<Vec<_>>()
        };
        let (xs, ys) = (along(most.x), along(most.y));
        let all = xs
            .iter()
            .flat_map(|&x| ys.iter().map(move |&y| Vector2::new(x, y)));
        let mut all: Vec<_> = all.collect();
        let way = |p: &Vector2<f64>| p.norm() + TOWARDS * (p - self.from).norm();
        all.sort_by(|p, q| way(p).total_cmp(&way(q)));
        all
    }
}

/// Are all on the support, those that meet apart?
pub fn fit(items: &[Item], half: Vector2<f64>, meet: &dyn Fn(usize, usize) -> bool) -> bool {
    let apart = |i: usize| (0..i).all(|j| !meet(i, j) || items[i].is_apart(&items[j], 0.0));
    (0..items.len()).all(|i| (items[i].stays || items[i].is_on(half)) && apart(i))
}

/// Moves those that may move to where all fit, what comes first as near to the middle as the rest allows; false if no such places
/// are found, and nothing is moved then. `half` are the support's half sizes, `meet` says who stands there at the same time.
pub fn pack(items: &mut [Item], half: Vector2<f64>, meet: &dyn Fn(usize, usize) -> bool) -> bool {
    let places: Vec<_> = items
        .iter()
        .map(|item| {
            if item.stays {
                vec![item.place]
            } else {
                item.places(half)
            }
        })
        .collect();
    let stay: Vec<usize> = (0..items.len()).filter(|&i| items[i].stays).collect();
    let move_: Vec<usize> = (0..items.len()).filter(|&i| !items[i].stays).collect();
    let order = [stay, move_].concat();
    let found = ROOMS.iter().find_map(|&room| {
        let mut trial = items.to_vec();
        let mut tried = 0;
        place_from(&mut trial, &places, (&order, 0), (room, meet), &mut tried).then_some(trial)
    });
    let Some(found) = found else {
        return false;
    };
    items.clone_from_slice(&found);
    true
}

/// Places what comes at `k` and after it in an order, one after the other, going back where one has no place.
fn place_from(
    items: &mut [Item],
    places: &[Vec<Vector2<f64>>],
    (order, k): (&[usize], usize),
    (room, meet): (f64, &dyn Fn(usize, usize) -> bool),
    tried: &mut usize,
) -> bool {
    let Some(&i) = order.get(k) else {
        return true;
    };
    for &place in &places[i] {
        *tried += 1;
        if *tried > MOST_TRIED {
            return false;
        }
        items[i].place = place;
        let both_stay = |j: usize| items[i].stays && items[j].stays;
        let free = |&j: &usize| !meet(i, j) || both_stay(j) || items[i].is_apart(&items[j], room);
        let is_free = order[..k].iter().all(free);
        if is_free && place_from(items, places, (order, k + 1), (room, meet), tried) {
            return true;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box with these half sides that may stand anywhere.
    fn item(x: f64, y: f64) -> Item {
        let surface = Vector2::new(x, y);
        Item {
            shape: [-surface, surface],
            surface,
            from: Vector2::zeros(),
            place: Vector2::zeros(),
            stays: false,
        }
    }

    #[test]
    fn two_boxes_stand_side_by_side_where_there_is_hardly_room_for_them() {
        for room in ROOMS {
            let half = Vector2::new(0.1, 0.5 * (0.2 + 0.15 + room) + 1e-6);
            let mut items = [item(0.1, 0.1), item(0.075, 0.075)];
            assert!(!fit(&items, half, &|_, _| true));
            assert!(pack(&mut items, half, &|_, _| true), "{room} m");
            assert!(fit(&items, half, &|_, _| true), "{room} m");
            let apart = (items[0].place.y - items[1].place.y).abs();
            assert!(apart >= 0.175 + room - 1e-9, "{apart} m");
        }
        let half = Vector2::new(0.1, 0.17);
        let mut items = [item(0.1, 0.1), item(0.075, 0.075)];
        assert!(!pack(&mut items, half, &|_, _| true), "no room");
        assert_eq!(items[1].place, Vector2::zeros());
        assert!(fit(&items, half, &|_, _| false), "one after the other");
    }

    #[test]
    fn what_stays_stays_and_the_first_of_the_others_is_nearest_to_the_middle() {
        let half = Vector2::new(0.05, 0.5);
        let mut items = [item(0.05, 0.05), item(0.05, 0.05), item(0.05, 0.05)];
        items[2].stays = true;
        items[2].place.y = 0.05;
        assert!(pack(&mut items, half, &|_, _| true));
        assert!((items[2].place.y - 0.05).abs() < 1e-12);
        assert!(
            (items[0].place.y + 0.1).abs() < 1e-9,
            "{:?}",
            items[0].place
        );
        assert!(fit(&items, half, &|_, _| true));
    }

    #[test]
    fn a_box_stands_on_the_side_that_it_comes_from_unless_a_knob_is_there() {
        let half = Vector2::new(0.05, 0.5);
        for (knob, side, expected) in [(0.0, -1.0, -0.15), (0.0, 1.0, 0.15), (0.1, 1.0, -0.15)] {
            let mut items = [item(0.05, 0.05), item(0.05, 0.05)];
            items[0].shape[1].y += knob;
            items[0].stays = true;
            items[1].from.y = side;
            assert!(pack(&mut items, half, &|_, _| true));
            let place = items[1].place.y;
            assert!((place - expected).abs() < 1e-9, "{place} m");
        }
    }
}
