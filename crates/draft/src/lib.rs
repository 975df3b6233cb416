//! Drafts a robot file from a URDF or MJCF: which links are feet and hands, soles, palms, and a nominal stance.
//!
//! Everything is geometry of the description, nothing is known of a robot: feet are the lowest ends of limbs that are like each other left
//! and right, soles their lowest faces, hands the ends of other such limbs, palms their sides that face inward in the
//! stance. The stance solves a least-squares problem on the robot's kinematics.
//!
//! Frames: `base`, the root link, upright; `joint`, that of a body; `patch`, z out of the link.

mod bodies;
mod error;
mod face;
mod heading;
mod home;
mod hull;
mod least_squares;
mod limbs;
mod mirror;
mod palm;
mod patch;
mod posture;
mod report;
mod sole;
mod text;

pub use error::DraftError;
pub use heading::Forward;

use bodies::Bodies;
use heading::Heading;
use home::{Home, reaches};
use limbs::Ends;
use mirror::mirrored;
use multibody::Kinematics;
use nalgebra::Vector3;
use palm::{Hand, palm};
use patch::Patch;
use posture::{Posture, Stand, Wish};
use scene::{BareRobot, Scene};
use spatial::Pose;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// What of a stance must hold: angle of soles [rad], difference of their heights [m], centre of mass beside their middle [m].
const STANDS: (f64, f64, f64) = (1e-3, 1e-4, 0.01);
/// A centre of mass further to the left or right of the middle than this makes the legs move apart [m].
const ASIDE: f64 = 5e-4;
/// Soles that are further from being mirror images are told [m].
const MIRRORED: f64 = 0.005;
/// Standard gravity [m/s²].
const GRAVITY: f64 = 9.81;

/// What the user knows.
#[derive(Debug, Clone, Default)]
pub struct Wishes {
    /// Links of the feet.
    pub feet: Option<[String; 2]>,
    /// Links of the hands.
    pub hands: Option<[String; 2]>,
    /// Where the robot looks.
    pub forward: Option<Forward>,
    /// Name of the robot; that of the description if none.
    pub name: Option<String>,
    /// Folder of the mesh files.
    pub meshes: Option<PathBuf>,
}

/// A robot file, and what is to be told of it.
#[derive(Debug, Clone)]
pub struct Draft {
    /// The text of the file.
    pub text: String,
    /// What was found and how, as lines.
    pub found: Vec<String>,
    /// What is to be checked by hand, as sentences.
    pub doubts: Vec<String>,
}

/// Everything that is found before the stance.
struct Parts<'a> {
    bodies: &'a Bodies<'a>,
    heading: Heading,
    feet: Ends,
    soles: [Patch; 2],
    hands: Option<(Ends, [Hand; 2])>,
    doubts: Vec<String>,
}

/// Drafts a robot file for a URDF or MJCF; paths in it are as seen from `folder`.
///
/// # Errors
/// The description cannot be used; feet, hands or the direction of sight are not clear; feet have no flat face; no stance is found.
pub fn draft(description: &Path, folder: &Path, wishes: &Wishes) -> Result<Draft, DraftError> {
    let bare = BareRobot::load(description, wishes.meshes.as_deref())?;
    let bodies = Bodies::new(&bare);
    let mut parts = find(&bodies, wishes)?;
    let soles = [0, 1].map(|side| on_body(&bodies, &parts.soles[side]));
    let arms = parts.hands.as_ref().map(|(ends, _)| ends);
    let limbs = (&parts.feet, arms);
    let mut posture = Posture::new(&bodies, &parts.heading, soles, limbs, false);
    let half_width = parts.soles[0].half_size[1].max(parts.soles[1].half_size[1]);
    let stance = home::stance(&posture, &bodies, half_width);
    let palms = sides(&parts, &posture, stance);
    let hands_at = |way: home::Way| match (&parts.hands, &palms) {
        (Some((ends, hands)), Some(palms)) => {
            reaches(&bodies, &parts.heading, ends, hands, palms, way)
        }
        _ => vec![],
    };
    let first = Wish {
        stance,
        hands: hands_at(home::WAYS[0]),
    };
    let mut q = posture.solve(&first).0;
    // Legs that are mirror images do not do where their soles, or masses, are not.
    let stand = posture.stand(&q);
    if stand.com[1].abs() > ASIDE || stand.tilt > STANDS.0 || stand.uneven > STANDS.1 {
        posture = Posture::new(&bodies, &parts.heading, soles, limbs, true);
        q = posture.solve(&first).0;
    }
    check(&posture.stand(&q), &parts)?;
    let weight = bare.robot.model.total_mass() * GRAVITY;
    let here = Here {
        description,
        wishes,
        weight,
    };
    // Shapes around meshes lie along the patches: first guesses of these give the robot that is planned with.
    let patches = palm_patches(&parts, palms.as_ref(), &bare.robot, &q).0;
    let mut scene = here.standing(&parts, &patches, &q)?;
    let Home { q, nearest } = home::home(&bodies, &posture, &mut scene, arms, stance, &hands_at)?;
    let stand = posture.stand(&q);
    check(&stand, &parts)?;
    let (patches, notes) = palm_patches(&parts, palms.as_ref(), &scene.robot, &q);
    parts.doubts.extend(notes);
    let knees = posture.knees(&q);
    let told = report::Told {
        parts: &parts,
        patches: &patches,
        q: &q,
        stand,
        knees,
        nearest,
    };
    Ok(Draft {
        text: here.text(&parts, &patches, folder, &told),
        found: told.lines(),
        doubts: told.doubts(),
    })
}

/// Feet, hands, soles and the direction of sight.
fn find<'a>(bodies: &'a Bodies<'a>, wishes: &Wishes) -> Result<Parts<'a>, DraftError> {
    let mut feet = match &wishes.feet {
        Some(names) => limbs::named(bodies, names, "--feet")?,
        None => limbs::feet(bodies)?,
    };
    for frame in feet.frames {
        sole::require_shape(bodies, "foot", frame)?;
    }
    let heading = heading::heading(bodies, &feet, wishes.forward)?;
    feet = left_first(bodies, feet, &heading);
    let hands = match &wishes.hands {
        Some(names) => Some(limbs::named(bodies, names, "--hands")?),
        None => limbs::hands(bodies, &feet)?,
    };
    let hands = hands.map(|ends| left_first(bodies, ends, &heading));
    let mut doubts: Vec<String> = heading.doubt.iter().cloned().collect();
    let [left, right] = feet.frames.map(|frame| sole::sole(bodies, frame, &heading));
    let (left, right) = (left?, right?);
    let soles = [left.patch, right.patch];
    doubts.extend(left.note.or(right.note));
    doubts.extend(unlike(bodies, &soles, &heading));
    let hands = match hands {
        Some(ends) => {
            let length = 2.0 * soles[0].half_size[0];
            let [left, right] = ends.frames.map(|frame| palm::hand(bodies, frame, length));
            Some((ends, [left?, right?]))
        }
        None => None,
    };
    Ok(Parts {
        bodies,
        heading,
        feet,
        soles,
        hands,
        doubts,
    })
}

/// Two limbs, that of the left first.
fn left_first(bodies: &Bodies, ends: Ends, heading: &Heading) -> Ends {
    let [a, b] = ends
        .pair
        .ends()
        .map(|j| bodies.origin(j).dot(&heading.left));
    if a >= b { ends } else { ends.swapped() }
}

/// Says if two soles are no mirror images at rest.
fn unlike(bodies: &Bodies, soles: &[Patch; 2], heading: &Heading) -> Option<String> {
    let ankles = soles.each_ref().map(|sole| {
        let (joint, joint_from_sole) = on_body(bodies, sole);
        let place = bodies.kinematics.world_from_joint[joint].act(joint_from_sole.origin());
        place - bodies.origin(joint)
    });
    let off = (mirrored(&ankles[0], &heading.left) - ankles[1]).norm();
    (off > MIRRORED).then(|| {
        format!(
            "the soles are {:.0} mm from being mirror images of each other: look at the collision shapes of the feet",
            1e3 * off
        )
    })
}

/// The body of a patch and the patch in its joint.
fn on_body(bodies: &Bodies, patch: &Patch) -> (usize, Pose) {
    let frame = &bodies.model().frames[patch.frame];
    let pose = frame.joint_from_frame * patch.frame_from_patch;
    (frame.joint.unwrap_or(0), pose)
}

/// The sides of the hands that are the palms: those that face inward once the arms are before the body.
fn sides(parts: &Parts, posture: &Posture, stance: f64) -> Option<[Vector3<f64>; 2]> {
    let (ends, hands) = parts.hands.as_ref()?;
    let (bodies, heading) = (parts.bodies, &parts.heading);
    let mut palms = palm::palms_at_rest(bodies, hands, heading);
    let wish = Wish {
        stance,
        hands: reaches(bodies, heading, ends, hands, &palms, home::WAYS[0]),
    };
    let q = posture.solve(&wish).0;
    let mut kinematics = Kinematics::new(bodies.model());
    kinematics.update(bodies.model(), &q);
    let inward = kinematics.world_from_joint[hands[0].joint].rotate(palms[0]);
    if -inward.dot(&heading.left) < palm::INWARD {
        palms = palm::palms_inward(bodies, hands, heading, &kinematics);
    }
    Some(palms)
}

/// Palms in a posture, outside of the shapes of `robot`, with what is to be told of them.
fn palm_patches(
    parts: &Parts,
    palms: Option<&[Vector3<f64>; 2]>,
    robot: &scene::Robot,
    q: &[f64],
) -> (Vec<Patch>, Vec<String>) {
    let (Some((_, hands)), Some(palms)) = (&parts.hands, palms) else {
        return (vec![], vec![]);
    };
    let model = parts.bodies.model();
    let mut kinematics = Kinematics::new(model);
    kinematics.update(model, q);
    let both =
        [0, 1].map(|side| palm(parts.bodies, &hands[side], &palms[side], robot, &kinematics));
    let notes = both.iter().find_map(|palm| palm.note.clone());
    (
        both.map(|palm| palm.patch).into(),
        notes.into_iter().collect(),
    )
}

/// # Errors
/// [`DraftError::NoStand`] if soles are not level or not under the centre of mass.
fn check(stand: &Stand, parts: &Parts) -> Result<(), DraftError> {
    let com = stand.com[0].hypot(stand.com[1]);
    if stand.tilt <= STANDS.0 && stand.uneven <= STANDS.1 && com <= STANDS.2 {
        return Ok(());
    }
    let frames = &parts.bodies.model().frames;
    Err(DraftError::NoStand {
        tilt: stand.tilt,
        height: 1e3 * stand.uneven,
        com: 1e3 * com,
        feet: parts
            .feet
            .frames
            .map(|f| frames[f].name.as_str())
            .join(", "),
    })
}

/// A scene with nothing but level ground and the robot of a file on it, to read the file with.
pub fn standing_scene(robot: &str) -> String {
    format!(
        "name = \"standing\"\nrobot = {robot:?}\n[[static]]\nname = \"ground\"\nplane = true\n[objective]\nkind = \"base_height\"\n"
    )
}

/// What texts are made of beside the parts.
struct Here<'a> {
    description: &'a Path,
    wishes: &'a Wishes,
    /// Of the robot [N].
    weight: f64,
}

impl Here<'_> {
    /// The robot on level ground in a posture, with its hands and feet.
    fn standing(&self, parts: &Parts, palms: &[Patch], q: &[f64]) -> Result<Scene, DraftError> {
        let mut text = standing_scene(&absolute(self.description).display().to_string());
        if let Some(meshes) = &self.wishes.meshes {
            text = format!(
                "meshes = {:?}\n{text}",
                absolute(meshes).display().to_string()
            );
        }
        text += "[start.joints]\n";
        text += &text::home_lines(&text::home(parts.bodies, q));
        text += &self.interfaces(parts, palms, "robot_interface");
        Ok(Scene::from_toml(&text, "drafted robot", Path::new(""))?)
    }

    fn interfaces(&self, parts: &Parts, palms: &[Patch], header: &str) -> String {
        let feet = parts.soles.iter().map(|patch| (patch, true));
        let hands = palms.iter().map(|patch| (patch, false));
        let interface = |(index, (patch, is_foot)): (usize, (&'_ Patch, bool))| {
            let side = ["left", "right"][index % 2];
            let end = if is_foot { "foot" } else { "hand" };
            (format!("{side}_{end}"), is_foot, patch.clone())
        };
        let all: Vec<(String, bool, Patch)> =
            feet.chain(hands).enumerate().map(interface).collect();
        let all: Vec<text::Interface> = (all.iter())
            .map(|(name, is_foot, patch)| text::Interface {
                name: name.clone(),
                is_foot: *is_foot,
                patch,
            })
            .collect();
        text::interfaces(parts.bodies, header, &all, self.weight)
    }

    fn text(&self, parts: &Parts, palms: &[Patch], folder: &Path, told: &report::Told) -> String {
        let model = parts.bodies.model();
        let name = self.wishes.name.as_ref().unwrap_or(&model.name);
        let file = self
            .description
            .file_name()
            .unwrap_or_default()
            .to_string_lossy();
        let mut out = format!(
            "# {name}: drafted from {file} by `locotamp robot`. SI units, radians; quaternions are x, y, z, w.\n\
             # What the numbers mean, and what to check by hand: docs/robots.md, \"Your own robot\".\n"
        );
        if let Some(line) = told.about_facing() {
            let _ = writeln!(out, "# {line}");
        }
        let urdf = seen_from(folder, self.description);
        let _ = writeln!(out, "name = {name:?}\nurdf = {urdf:?}");
        if let Some(meshes) = &self.wishes.meshes {
            let _ = writeln!(out, "meshes = {:?}", seen_from(folder, meshes));
        }
        out += "\n";
        for line in told.about_home() {
            let _ = writeln!(out, "# {line}");
        }
        out += "[home]\n";
        out += &text::home_lines(&text::home(parts.bodies, told.q));
        out += "\n";
        out += &self.interfaces(parts, palms, "interface");
        out.truncate(out.trim_end().len());
        out + "\n"
    }
}

fn absolute(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_path_buf())
}

/// A path as seen from a folder: relative to it, unless that leads far up.
fn seen_from(folder: &Path, path: &Path) -> String {
    const FAR_UP: usize = 3;
    let (from, to) = (absolute(folder), absolute(path));
    let common = from
        .components()
        .zip(to.components())
        .take_while(|(a, b)| a == b)
        .count();
    let up = from.components().count() - common;
    if up > FAR_UP || common <= 1 {
        return to.display().to_string();
    }
    let mut out: PathBuf = std::iter::repeat_n(Path::new(".."), up).collect();
    out.extend(to.components().skip(common));
    out.display().to_string()
}
