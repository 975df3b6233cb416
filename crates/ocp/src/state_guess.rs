//! Initial guesses for a lone state: configurations near which it may be satisfied, the likeliest first.
//!
//! Source: ours.

use std::f64::consts::PI;

use crate::guess;
use crate::program::Phase;
use crate::settings::Arrangement;
use crate::system::System;
use multibody::Kinematics;
use nalgebra::{Vector3, Vector6};
use scene::{Owner, Role, Scene};
use spatial::Pose;
use symbolic::{Contact, ContactState, InterfaceId};

/// Shares of the way of the base, and turns of the base and of all objects [rad].
const PLACES: [(f64, f64, f64); 8] = [
    (1.0, 0.0, 0.0),
    (0.0, 0.0, 0.0),
    (1.0, 0.0, PI),
    (1.6, 0.0, 0.0),
    (1.0, 1.0, 0.0),
    (1.0, -1.0, 0.0),
    (1.0, 0.0, 0.5 * PI),
    (1.0, 0.0, -0.5 * PI),
];
/// Turns of the base about the vertical at the place where hands meet what they hold [rad].
const MEETINGS: [f64; 3] = [0.0, 0.7, -0.7];
/// Room between a hand and what it meets [m].
const ROOM: f64 = 0.05;
/// Distances of the base from a wall that a hand touches, the second one if something stands before it [m], and turns of the
/// base from facing it [rad].
const BEFORE: [f64; 2] = [0.45, 0.75];
const SIDES: [f64; 3] = [0.0, 0.5 * PI, -0.5 * PI];
/// Horizontal part of a normal below which it says nothing of a direction.
const UPRIGHT: f64 = 0.3;

/// Objects on their supports or where they start; the base moved along with the feet and with what the hands handle, by more or
/// less of the way, one or the other turned about the vertical; or where the hands of the start posture meet what they hold.
pub fn states(scene: &Scene, system: &System, state: &ContactState) -> Vec<Vec<f64>> {
    let phase = |state: ContactState| Phase { state, steps: 1 };
    let start = scene.start_contacts.iter().copied().collect();
    let phases = [
        phase(start),
        phase(ContactState::default()),
        phase(state.clone()),
    ];
    let (from, to) = (
        system.start(scene),
        guess::keyframes(scene, system, &phases, Arrangement::default()).swap_remove(3),
    );
    let Some(base_to) = to.first_chunk::<7>().map(Pose::from_xyzquat) else {
        return vec![to];
    };
    let at = |&(share, turn, object_turn): &(f64, f64, f64)| {
        let mut q = with_base(&to, &turned(&base_to, turn));
        for i in 0..3 {
            q[i] = from[i] + share * (to[i] - from[i]);
        }
        for o in 0..scene.objects.len() {
            let first = system.object_q(o);
            if let Some(pose) = q[first..].first_chunk::<7>().map(Pose::from_xyzquat) {
                let pose = turned(&pose, object_turn);
                q[first..first + 7].copy_from_slice(&pose.to_xyzquat());
            }
        }
        q
    };
    let is_object = |i: InterfaceId| matches!(scene.interfaces[i.0].owner, Owner::Object(_));
    let handled = state.iter().any(|c| is_object(c.a) || is_object(c.b));
    let mut places = PLACES.iter().filter(|place| handled || place.2 == 0.0);
    let mut guesses: Vec<_> = places.next().map(at).into_iter().collect();
    guesses.extend(
        MEETINGS
            .iter()
            .filter_map(|&turn| meeting(scene, system, state, (&to, turn))),
    );
    guesses.extend(places.map(at));
    guesses
}

/// Configurations with the base before the upright face of something fixed that a hand touches, facing it or with
/// it at its sides: from where hands of the start posture meet it a robot may be in it. None where no hand touches such a face.
pub fn before_walls(scene: &Scene, system: &System, state: &ContactState) -> Vec<Vec<f64>> {
    let q = system.start(scene);
    let fixed = |c: &Contact| {
        let [a, b] = [c.a, c.b].map(|i| &scene.interfaces[i.0]);
        (a.role == Role::Hand && matches!(b.owner, Owner::Static(_))).then_some(b)
    };
    let (Some(face), Some(base)) = (
        state.iter().find_map(|c| fixed(&c)),
        q.first_chunk::<7>().map(Pose::from_xyzquat),
    ) else {
        return vec![];
    };
    let world_from_face = face.body_from_interface;
    let normal = world_from_face.rotate(Vector3::z());
    if normal.xy().norm() < UPRIGHT {
        return vec![];
    }
    // Beside the place of the face that is nearest to the start.
    let mut place = world_from_face.inverse().act(base.origin());
    if let Some([x, y]) = face.half_size {
        (place.x, place.y) = (place.x.clamp(-x, x), place.y.clamp(-y, y));
    }
    place.z = 0.0;
    let ahead = base.rotate(Vector3::x());
    let facing = (-normal.y).atan2(-normal.x) - ahead.y.atan2(ahead.x);
    let at = |(before, side): (f64, f64)| {
        let mut origin = world_from_face.act(place) + before * normal;
        origin.z = base.origin().z;
        let about = turned(&base, facing + side);
        with_base(&q, &Pose::from_parts(*about.rotation(), origin))
    };
    let places = BEFORE.iter().flat_map(|&d| SIDES.map(|side| (d, side)));
    places.map(at).collect()
}

fn turned(pose: &Pose, angle: f64) -> Pose {
    let about_z = Pose::exp(&Vector6::new(0.0, 0.0, 0.0, 0.0, 0.0, angle));
    Pose::from_parts(about_z.rotation() * pose.rotation(), pose.origin())
}

/// A configuration with the base where the hands, in the posture of `q`, meet what they touch or hold, in the mean: normals
/// against normals but for a turn [rad] about the vertical, a little apart; heights only if no foot stands. `None` without hands.
fn meeting(
    scene: &Scene,
    system: &System,
    state: &ContactState,
    (q, turn): (&[f64], f64),
) -> Option<Vec<f64>> {
    let role = |c: &Contact| scene.interfaces[c.a.0].role;
    let hands: Vec<_> = state.iter().filter(|c| role(c) == Role::Hand).collect();
    let mut kinematics = Kinematics::new(&system.model);
    kinematics.update(&system.model, q);
    let place = |i: InterfaceId| system.world_from_interface(&scene.interfaces[i.0], &kinematics);
    let (mut hand, mut goal) = (Vector3::zeros(), Vector3::zeros());
    let (mut along, mut across) = (0.0, 0.0);
    for contact in &hands {
        let (a, b) = (place(contact.a), place(contact.b));
        let (from, to) = (a.rotate(Vector3::z()), -b.rotate(Vector3::z()));
        along += from.x * to.x + from.y * to.y;
        across += from.x * to.y - from.y * to.x;
        hand += a.origin() / hands.len() as f64;
        goal += (b.origin() - ROOM * to) / hands.len() as f64;
    }
    // Vertical normals say nothing of a direction.
    let tells = along.hypot(across) > UPRIGHT;
    let about = turn + if tells { across.atan2(along) } else { 0.0 };
    let base = q.first_chunk::<7>().map(Pose::from_xyzquat)?;
    let from_hand = turned(&Pose::identity(), about).rotate(base.origin() - hand);
    let mut origin = goal + from_hand;
    if state.iter().any(|c| role(&c) == Role::Foot) {
        origin.z = base.origin().z;
    }
    let base = Pose::from_parts(*turned(&base, about).rotation(), origin);
    (!hands.is_empty()).then(|| with_base(q, &base))
}

fn with_base(q: &[f64], base: &Pose) -> Vec<f64> {
    let mut q = q.to_vec();
    q[..7].copy_from_slice(&base.to_xyzquat());
    q
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Planner, Preset, Settings};
    use std::path::Path;
    use symbolic::ContactType;

    /// The start with one more contact.
    fn standing_with(
        scene: &Scene,
        hand: &str,
        on: &str,
        kind: ContactType,
    ) -> (Contact, ContactState) {
        let interface = |name: &str| scene.interface_id(name).unwrap();
        let (a, b) = (interface(hand), interface(on));
        let contact = Contact { a, b, kind };
        let start = scene.start_contacts.iter().copied();
        (contact, start.chain([contact]).collect())
    }

    #[test]
    fn a_hand_meets_what_it_holds() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/pick-place.toml");
        let scene = Scene::load(&path).unwrap();
        let system = System::new(&scene).unwrap();
        let grasp = ContactType::BilateralPatch;
        let (contact, state) = standing_with(&scene, "left_hand", "red_box_handle", grasp);
        let mut kinematics = Kinematics::new(&system.model);
        let mut nearest = |q: &[f64]| {
            kinematics.update(&system.model, q);
            let place =
                |i: InterfaceId| system.world_from_interface(&scene.interfaces[i.0], &kinematics);
            let (hand, handle) = (place(contact.a), place(contact.b));
            let apart = hand.origin() - handle.origin();
            let facing = -hand.rotate(Vector3::z()).dot(&handle.rotate(Vector3::z()));
            (apart.x.hypot(apart.y), facing)
        };
        let guesses = states(&scene, &system, &state);
        let (apart, facing) = nearest(&guesses[1]);
        assert!(apart < ROOM + 1e-9, "{apart} m apart");
        assert!(facing > 0.9, "{facing}");
        // Without hands there is no such guess.
        let standing: ContactState = scene.start_contacts.iter().copied().collect();
        let without = states(&scene, &system, &standing).len();
        assert_eq!(guesses.len(), without + MEETINGS.len());
    }

    /// From the posture of the start the robot would come to be in the wall, whose clearances push some links out at its back.
    #[test]
    fn a_hand_lies_on_a_large_wall() {
        let text = "name = \"s\"\nrobot = \"g1\"\n[[static]]\nname = \"ground\"\nplane = true\n[[static]]\nname = \"wall\"\n\
                    size = [0.1, 1.6, 2.0]\nposition = [0.55, 0.0, 1.0]\ntop = false\n[[static.interface]]\nname = \"wall_face\"\n\
                    side = \"-x\"\ncontacts = [\"unilateral_patch\"]\n[goal]\ncontacts = [[\"left_hand\", \"wall_face\"]]\n";
        let scene = Scene::from_toml(text, "s.toml", Path::new(".")).unwrap();
        let planner = Planner::new(&scene).unwrap();
        let settings = Settings::new(Preset::Default, &scene.optimiser);
        let leaning = ContactType::UnilateralPatch;
        let (_, state) = standing_with(&scene, "left_hand", "wall_face", leaning);
        assert_eq!(before_walls(&scene, &planner.system, &state).len(), 6);
        let found = planner.state(&state, &settings);
        assert!(found.possible, "{:?}", found.worst);
        // What is level is no wall.
        let (_, state) = standing_with(&scene, "left_hand", "ground_top", leaning);
        assert!(before_walls(&scene, &planner.system, &state).is_empty());
    }

    /// Close before the wall stands a table.
    #[test]
    fn a_hand_reaches_a_wall_over_a_table() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/button.toml");
        let scene = Scene::load(&path).unwrap();
        let planner = Planner::new(&scene).unwrap();
        let settings = Settings::new(Preset::Default, &scene.optimiser);
        let leaning = ContactType::UnilateralPatch;
        let (contact, state) = standing_with(&scene, "right_hand", "button", leaning);
        for state in [[contact].into_iter().collect(), state] {
            let found = planner.state(&state, &settings);
            assert!(found.possible, "{:?}", found.worst);
        }
    }
}
