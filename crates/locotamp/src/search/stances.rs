//! Where in a sequence the feet may be set anew: where the robot leans far, or will on what it carries.

use scene::{Owner, Role, Scene};
use symbolic::{Contact, ContactState};

/// Lean ([`ocp::Planner::leans`]) from which on more steps are looked for.
const FAR_LEAN: f64 = 0.42;

/// What contact states say of feet and of what is carried.
pub(super) struct Stances<'a> {
    scene: &'a Scene,
}

impl<'a> Stances<'a> {
    pub fn new(scene: &'a Scene) -> Self {
        Self { scene }
    }

    /// Contacts of feet in a state.
    pub fn feet(&self, state: &ContactState) -> Vec<Contact> {
        state.iter().filter(|c| self.is_foot(c)).collect()
    }

    /// Contacts of all feet in a phase; of those in the air, the last that they had, but on what is carried by then.
    pub fn whole(&self, states: &[ContactState], at: usize) -> Vec<Contact> {
        let carried = self.carried(&states[at]);
        let before = states[..=at].iter().rev();
        let mut stance: Vec<Contact> = vec![];
        for contact in before.flat_map(|state| self.feet(state)) {
            let on = self.scene.interfaces[contact.b.0].owner;
            if !carried.contains(&on) && stance.iter().all(|c| c.a != contact.a) {
                stance.push(contact);
            }
        }
        stance.sort();
        stance
    }

    /// Phases in which the feet may be set anew, told the leans at the end of each: between two other changes where the robot leans far
    /// before the next one, or later on what it carries meanwhile: where that is put down decides how far it leans then. There the first
    /// stance on all feet, or, with something in its hands, that which it has. Those of the farthest leans first. None on a single foot.
    pub fn strained(&self, states: &[ContactState], leans: &[f64]) -> Vec<usize> {
        let all = self.feet(&states[0]).len();
        let others = |k: usize| -> Vec<Contact> {
            let is_other = |c: &Contact| !self.is_foot(c);
            states[k].iter().filter(is_other).collect()
        };
        let mut places: Vec<(usize, f64)> = vec![];
        let mut first = 0;
        while first < states.len() && all > 1 {
            let same = |&k: &usize| others(k) == others(first);
            let end = first + (first..states.len()).take_while(same).count();
            let carried = self.carried(&states[first]);
            let later = (end..states.len()).filter(|&k| self.stands_on(&states[k], &carried));
            let lean = (first..end)
                .chain(later)
                .filter_map(|k| leans.get(k).copied());
            let lean = lean.fold(0.0, f64::max);
            let on = |feet: usize| (first..end).find(|&k| self.feet(&states[k]).len() >= feet);
            let with_hands = || on(1).filter(|&k| self.whole(states, k).len() == all);
            let stance = on(all).or_else(|| with_hands().filter(|_| !carried.is_empty()));
            places.extend(stance.filter(|_| lean > FAR_LEAN).map(|k| (k, lean)));
            first = end;
        }
        places.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        places.into_iter().map(|(k, _)| k).collect()
    }

    /// The number of phases after which feet only leave what they stand on and are set down on it again.
    pub fn idle_after(&self, states: &[ContactState]) -> usize {
        let Some((last, before)) = states.split_last() else {
            return 0;
        };
        let is_idle = |state: &ContactState| {
            let more = last.iter().filter(|c| !state.contains(c));
            more.into_iter().all(|c| self.is_foot(&c)) && state.iter().all(|c| last.contains(&c))
        };
        let idle = before
            .iter()
            .rev()
            .take_while(|state| is_idle(state))
            .count();
        let first = before.len() - idle;
        let same = |k: &usize| states[*k] == *last;
        1 + (first..states.len()).find(same).unwrap_or(before.len())
    }

    /// Objects that the robot has hold of and that rest on nothing.
    fn carried(&self, state: &ContactState) -> Vec<Owner> {
        let owner = |i: symbolic::InterfaceId| self.scene.interfaces[i.0].owner;
        let pairs = || state.iter().map(|c| (owner(c.a), owner(c.b)));
        let rests = |object: &Owner| pairs().any(|(a, _)| a == *object);
        let held = pairs().filter_map(|(a, b)| match (a, b) {
            (Owner::Robot { .. }, Owner::Object(_)) => Some(b),
            _ => None,
        });
        held.filter(|object| !rests(object)).collect()
    }

    /// True if a foot stands on one of the objects.
    fn stands_on(&self, state: &ContactState, objects: &[Owner]) -> bool {
        let owner = |c: &Contact| self.scene.interfaces[c.b.0].owner;
        self.feet(state).iter().any(|c| objects.contains(&owner(c)))
    }

    fn is_foot(&self, contact: &Contact) -> bool {
        self.scene.interfaces[contact.a.0].role == Role::Foot
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checks::tests::state;

    const LEFT: (&str, &str) = ("left_foot", "ground_top");
    const RIGHT: (&str, &str) = ("right_foot", "ground_top");
    const HANDS: [(&str, &str); 2] = [("left_hand", "box_left"), ("right_hand", "box_right")];
    const REST: (&str, &str) = ("box_bottom", "ground_top");
    const ON_BOX: [(&str, &str); 2] = [("left_foot", "box_top"), REST];

    /// The box is carried on the left foot, and stepped on.
    fn climb(scene: &Scene) -> Vec<ContactState> {
        let states: [&[&[(&str, &str)]]; 6] = [
            &[&[LEFT, RIGHT, REST]],
            &[&[LEFT, REST], &HANDS],
            &[&[LEFT], &HANDS],
            &[&[LEFT, REST], &HANDS],
            &[&[LEFT, RIGHT, REST]],
            &[&[RIGHT], &ON_BOX],
        ];
        states.map(|pairs| state(scene, &pairs.concat())).into()
    }

    #[test]
    fn feet_are_set_anew_while_something_is_carried_on_which_the_robot_leans_far_later() {
        let scene = Scene::builtin("climb").expect("a built-in scene");
        let stances = Stances::new(&scene);
        let states = climb(&scene);
        let leans = |at: usize| {
            let lean = |k| if k == at { 2.0 * FAR_LEAN } else { 0.0 };
            (0..states.len()).map(lean).collect::<Vec<f64>>()
        };
        let on_the_box = stances.strained(&states, &leans(5));
        assert_eq!(
            on_the_box,
            [2, 4],
            "while it is carried, or before the step"
        );
        assert_eq!(stances.strained(&states, &leans(4)), [4]);
        assert_eq!(stances.strained(&states, &leans(0)), [0]);
        assert!(stances.strained(&states, &leans(6)).is_empty());
    }

    #[test]
    fn swings_in_place_at_the_end_are_idle() {
        let scene = Scene::builtin("climb").expect("a built-in scene");
        let stances = Stances::new(&scene);
        let mut states = climb(&scene);
        assert_eq!(stances.idle_after(&states), 6, "nothing is");
        states.push(states[4].clone());
        let end = states.len();
        for foot in stances.feet(&states[4]) {
            let lifted = states[4].iter().filter(|c| *c != foot).collect();
            states.extend([lifted, states[4].clone()]);
        }
        assert_eq!(stances.idle_after(&states), end);
        assert_eq!(stances.idle_after(&states[..end - 1]), 6);
        assert_eq!(stances.idle_after(&[states[0].clone()]), 1);
    }

    #[test]
    fn the_whole_stance_has_the_foot_in_the_air_where_it_stood_last() {
        let scene = Scene::builtin("climb").expect("a built-in scene");
        let stances = Stances::new(&scene);
        let states = climb(&scene);
        assert_eq!(stances.whole(&states, 2), stances.feet(&states[0]));
        assert_eq!(stances.whole(&states, 5), stances.feet(&states[5]));
        // The right foot was on the box that is carried now.
        let box_top = stances.feet(&states[5])[0].b;
        let mut before = states.clone();
        let right = stances.feet(&states[5])[1];
        before[0] = before[0].iter().filter(|c| *c != right).collect();
        before[0] = before[0]
            .iter()
            .chain([Contact {
                b: box_top,
                ..right
            }])
            .collect();
        assert_eq!(stances.whole(&before, 2), stances.feet(&before[2]));
    }
}
