//! Why no robot file can be drafted.

use scene::SceneError;

/// Why no robot file can be drafted.
#[derive(Debug, thiserror::Error)]
#[allow(
    missing_docs,
    reason = "the message of a variant says what its fields are"
)]
pub enum DraftError {
    /// The description cannot be used, or what was drafted cannot.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The parts do not make a model.
    #[error("the robot: {0}")]
    Model(#[from] multibody::ModelError),
    /// A name that no link has.
    #[error("{option}: no link is called {name:?}; {hint}")]
    UnknownLink {
        option: &'static str,
        name: String,
        hint: String,
    },
    /// A link that no joint moves.
    #[error("{option}: link {name:?} is one body with the base, no joint moves it")]
    NotMoved { option: &'static str, name: String },
    /// Two links that are one body, or one inside the limb of the other.
    #[error("{option}: {first:?} and {second:?} are not on two limbs")]
    OneLimb {
        option: &'static str,
        first: String,
        second: String,
    },
    /// Nothing that looks like legs.
    #[error(
        "found no feet: no two chains of at least {joints} joints that are like each other left and right and come lowest (z of the base is up); name the feet as --feet \
         LEFT,RIGHT; ends of chains: {ends}"
    )]
    NoFeet { joints: usize, ends: String },
    /// More than one pair of limbs.
    #[error(
        "cannot tell which are the {what}: {candidates} all look like some; name two of them as {option} LEFT,RIGHT"
    )]
    Ambiguous {
        what: &'static str,
        candidates: String,
        option: &'static str,
    },
    /// A body without shapes.
    #[error("{what} {link:?} has no collision shape that could be read{unread}")]
    NoShape {
        what: &'static str,
        link: String,
        unread: String,
    },
    /// A sole that is a line or a point.
    #[error(
        "the lowest face of {link:?} is {length:.0} x {width:.0} mm, too small for a sole: give the link a flat face there, or name other \
         feet as --feet LEFT,RIGHT"
    )]
    SmallSole {
        link: String,
        length: f64,
        width: f64,
    },
    /// Nothing tells front from back.
    #[error(
        "cannot tell which way the robot looks: its soles reach {front:.0} mm before and {back:.0} mm behind the ankles, and its knees bend \
         either way; say it as --forward x, -x, y or -y"
    )]
    NoFront { front: f64, back: f64 },
    /// The given direction is that from one foot to the other.
    #[error(
        "--forward {given}: the feet stand beside each other along that axis, expected {expected}"
    )]
    Sideways { given: String, expected: String },
    /// The legs do not get the soles level.
    #[error(
        "found no posture with level soles under the centre of mass: at best they are {tilt:.4} rad from level, {height:.2} mm apart in \
         height and {com:.0} mm from below the centre of mass; check the joint limits of the legs and the links of the feet ({feet})"
    )]
    NoStand {
        tilt: f64,
        height: f64,
        com: f64,
        feet: String,
    },
}
