//! Why a text or a list of joints is no usable robot.
#![allow(
    missing_docs,
    reason = "the message of a variant says what its fields are"
)]

/// Why a robot cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ModelError {
    /// The text is no well-formed XML.
    #[error("URDF: malformed XML: {message}")]
    Xml { message: String },
    /// The outermost element is something else than a robot.
    #[error("URDF line {line}: the outermost element is <{found}>, expected <robot>")]
    NotARobot { found: String, line: u32 },
    /// An element or attribute that must be there is not.
    #[error("URDF line {line}: {owner}: missing {missing}")]
    Missing {
        owner: String,
        missing: &'static str,
        line: u32,
    },
    /// An attribute that is not the number or numbers that it should be.
    #[error("URDF line {line}: {owner}: {attribute}={text:?}, expected {expected}")]
    BadNumber {
        owner: String,
        attribute: &'static str,
        text: String,
        expected: &'static str,
        line: u32,
    },
    /// Two links or two joints of one name.
    #[error("URDF line {line}: a second {kind} named {name:?}; names must be unique")]
    Duplicate {
        kind: &'static str,
        name: String,
        line: u32,
    },
    /// A joint connects a link that does not exist.
    #[error("URDF line {line}: joint {joint:?}: no link {link:?}; did you mean {nearest:?}?")]
    UnknownLink {
        joint: String,
        link: String,
        nearest: String,
        line: u32,
    },
    /// The robot has no link.
    #[error("URDF: the robot {robot:?} has no <link>, expected at least one")]
    NoLinks { robot: String },
    /// A link is the child of two joints.
    #[error(
        "URDF: link {link:?} is the child of joints {first:?} and {second:?}; only trees are supported, so cut the loop \
         by removing one of them"
    )]
    TwoParents {
        link: String,
        first: String,
        second: String,
    },
    /// More than one link has no parent.
    #[error(
        "URDF: links {roots:?} have no parent joint, expected exactly one root; connect the others with joints"
    )]
    SeveralRoots { roots: Vec<String> },
    /// Links that form a ring and hang on no root.
    #[error(
        "URDF: link {link:?} is its own ancestor; only trees are supported, so cut the loop by removing a joint"
    )]
    Loop { link: String },
    /// A joint type that is not supported.
    #[error(
        "URDF line {line}: joint {joint:?}: type {kind:?} is not supported, expected revolute, continuous, prismatic or \
         fixed; a floating base is added by the loader, leave it out of the file"
    )]
    UnsupportedJoint {
        joint: String,
        kind: String,
        line: u32,
    },
    /// An axis without direction.
    #[error(
        "joint {joint:?}: the axis has length {length}, expected a direction such as \"0 0 1\""
    )]
    BadAxis { joint: String, length: f64 },
    /// A revolute or prismatic joint without limits.
    #[error(
        "joint {joint:?}: a {kind} joint needs <limit lower upper effort velocity>; use continuous for no range"
    )]
    MissingLimits { joint: String, kind: &'static str },
    /// Limits in the wrong order.
    #[error("joint {joint:?}: limits [{lower}, {upper}], expected lower ≤ upper")]
    BadLimits {
        joint: String,
        lower: f64,
        upper: f64,
    },
    /// An effort limit below zero.
    #[error(
        "joint {joint:?}: the effort limit is {effort} N·m (N for a slider), expected a positive number, or 0 for no limit"
    )]
    BadEffort { joint: String, effort: f64 },
    /// A mass below zero.
    #[error(
        "link {link:?}: mass is {mass} kg, expected a positive number; leave <inertial> out of massless frames"
    )]
    BadMass { link: String, mass: f64 },
    /// A rotational inertia that no body can have.
    #[error(
        "joint {joint:?}: the body behind it has the moment of inertia {eigenvalue:.1e} kg·m², expected none below zero; \
         check the signs and axes of the <inertia> of its links"
    )]
    BadInertia { joint: String, eigenvalue: f64 },
    /// A joint moves nothing that has mass.
    #[error(
        "joint {joint:?} moves nothing that has mass; give link {link:?} an <inertial> with a mass above zero, or make the joint fixed"
    )]
    MissingInertia { joint: String, link: String },
    /// A list of joints that is no tree in the required order.
    #[error("joint {joint:?} (number {index}): {problem}")]
    BadTree {
        joint: String,
        index: usize,
        problem: &'static str,
    },
    /// More joints than the algorithms are meant for.
    #[error("the robot has more than {limit} moving joints; fix those that do not matter")]
    TooManyJoints { limit: usize },
}
