//! The text of a robot file.

use crate::bodies::Bodies;
use crate::patch::Patch;
use std::fmt::Write;

/// Friction of hands and feet.
pub(crate) const MU: f64 = 0.7;
/// Share of what uniform pressure gives in torsion that is taken.
const TORSION: f64 = 0.9;
/// What one foot bears, as a multiple of the robot's weight, and one hand.
const FOOT_LOAD: f64 = 1.8;
const HAND_LOAD: f64 = 0.2;
/// Moments beyond what the edges of a sole bear, and of a hand per newton [m].
const EDGES: f64 = 1.15;
const HAND_LEVER: f64 = 0.08;
/// Decimals of joint positions.
const DECIMALS: f64 = 1e6;

/// A hand or foot as it is written.
pub(crate) struct Interface<'a> {
    pub name: String,
    pub is_foot: bool,
    pub patch: &'a Patch,
}

/// The tables of hands and feet, under this header, for a robot of this weight [N].
pub(crate) fn interfaces(
    bodies: &Bodies,
    header: &str,
    interfaces: &[Interface],
    weight: f64,
) -> String {
    let mut out = String::new();
    for (index, interface) in interfaces.iter().enumerate() {
        let first = index == 0 || interfaces[index - 1].is_foot != interface.is_foot;
        if header == "interface" && first {
            out += if interface.is_foot { FEET } else { HANDS };
        }
        table(&mut out, bodies, header, interface, weight);
    }
    out
}

const FEET: &str = "\
# Soles: rectangles inside the lowest face of the shapes. Assumed: max_force, 1.8 times the robot's weight; friction. max_moment does not
# bind, the edges do.
";

const HANDS: &str = "\
# Palms: nothing of the hand is beyond their planes. Assumed: that the sides that face inward in [home] are the palms; max_force, a fifth of
# the robot's weight, which wrists may not bear; friction. Where a hand can close around things, contacts may have \"bilateral_patch\" too.
";

fn table(out: &mut String, bodies: &Bodies, header: &str, interface: &Interface, weight: f64) {
    let patch = interface.patch;
    let link = &bodies.model().frames[patch.frame].name;
    let [x, y] = patch.half_size;
    let (role, force, moment) = if interface.is_foot {
        let force = round_up(FOOT_LOAD * weight, 50.0);
        ("foot", force, round_up(EDGES * force * x.max(y), 5.0))
    } else {
        let force = round_up(HAND_LOAD * weight, 5.0);
        ("hand", force, round_up(HAND_LEVER * force, 0.5))
    };
    let mu_r = (TORSION * MU * patch.mean_radius() * 1e3).floor() / 1e3;
    let [px, py, pz, quaternion @ ..] = patch.frame_from_patch.to_xyzquat();
    let pose = [px, py, pz].map(|p| rounded(p, 6)).into_iter();
    let pose: Vec<f64> = pose.chain(quaternion.map(|c| rounded(c, 15))).collect();
    let name = &interface.name;
    let _ = write!(
        out,
        "[[{header}]]\nname = {name:?}\nlink = {link:?}\nkind = \"patch\"\nrole = \"{role}\"\npose = {pose:?}\n\
         half_size = [{x:?}, {y:?}]\nlimb = [0.0, 0.0, -1.0]\ncontacts = [\"unilateral_patch\"]\nmax_force = {force:?}\n\
         max_moment = {moment:?}\nmu = {MU}\nmu_r = {mu_r:?}\n\n"
    );
}

fn round_up(value: f64, unit: f64) -> f64 {
    (value / unit).ceil() * unit
}

/// The number with so many decimals; no −0.
fn rounded(x: f64, decimals: i32) -> f64 {
    let unit = 10f64.powi(decimals);
    (x * unit).round() / unit + 0.0
}

/// Joint positions as they are written, by name; those that the description gives anyway are left out unless they are not zero.
pub(crate) fn home(bodies: &Bodies, q: &[f64]) -> Vec<(String, f64)> {
    let joints = bodies.model().joints[1..].iter();
    let told = joints.filter_map(|joint| {
        let (rest, value) = (bodies.q[joint.idx_q], q[joint.idx_q]);
        if value == rest {
            return None;
        }
        let near = (value * DECIMALS).round() / DECIMALS;
        let inside = if near < joint.lower {
            near + 1.0 / DECIMALS
        } else if near > joint.upper {
            near - 1.0 / DECIMALS
        } else {
            near
        };
        let value = rounded(inside, 6);
        (value != 0.0 || rest != 0.0).then(|| (joint.name.clone(), value))
    });
    told.collect()
}

/// Lines of joint positions.
pub(crate) fn home_lines(home: &[(String, f64)]) -> String {
    let lines = home
        .iter()
        .map(|(name, value)| format!("{} = {value:.6}\n", key(name)));
    lines.collect()
}

/// A key as TOML has it.
pub(crate) fn key(name: &str) -> String {
    let is_bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if !name.is_empty() && name.chars().all(is_bare) {
        name.to_owned()
    } else {
        format!("{name:?}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_are_no_bare_keys_are_quoted() {
        assert_eq!(key("left_knee-1"), "left_knee-1");
        assert_eq!(key("left.knee"), "\"left.knee\"");
    }

    #[test]
    fn loads_are_rounded_up() {
        assert_eq!(round_up(589.0, 50.0), 600.0);
        assert_eq!(round_up(600.0, 50.0), 600.0);
        assert_eq!(rounded(-1e-9, 6).to_string(), "0");
    }
}
