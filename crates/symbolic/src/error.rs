//! Why a symbolic problem cannot be posed.

use crate::pddl::PddlError;

/// Why a domain, a start state, a goal or a list of operators cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SymbolicError {
    /// Two interfaces, or two objects, have the same name.
    #[error("the name {name:?} is used twice; interfaces and objects need names of their own")]
    DuplicateName {
        /// The name.
        name: String,
    },
    /// An interface without a contact type can never touch anything.
    #[error(
        "interface {interface:?}: no contact type; name at least one, e.g. \"unilateral_patch\""
    )]
    NoContactType {
        /// Name of the interface.
        interface: String,
    },
    /// A point lists a patch type.
    #[error(
        "interface {interface:?}: it is a point, so it cannot support {kind:?}; declare it a patch or use a point type"
    )]
    PatchTypeOnPoint {
        /// Name of the interface.
        interface: String,
        /// Name of the contact type.
        kind: &'static str,
    },
    /// An interface belongs to an object that does not exist.
    #[error("interface {interface:?}: object number {index}, but there are only {count}")]
    UnknownObject {
        /// Name of the interface.
        interface: String,
        /// The index given.
        index: usize,
        /// Number of objects.
        count: usize,
    },
    /// A foot or hand that is not part of the robot.
    #[error(
        "interface {interface:?}: only the robot has feet and hands; an object or static body has surfaces"
    )]
    EffectorWithoutRobot {
        /// Name of the interface.
        interface: String,
    },
    /// An index beyond the list of interfaces.
    #[error("interface number {index}, but there are only {count}")]
    UnknownInterface {
        /// The index given.
        index: usize,
        /// Number of interfaces.
        count: usize,
    },
    /// Two surfaces that cannot be squeezed between two hands.
    #[error("squeeze of {a:?} and {b:?}: expected two different patches of one object")]
    BadSqueeze {
        /// Name of one surface.
        a: String,
        /// Name of the other.
        b: String,
    },
    /// A start state that breaks a rule.
    #[error("start contacts: {fault}")]
    IllegalStart {
        /// The broken rule in words.
        fault: String,
    },
    /// A goal pair that can never touch.
    #[error("goal contact {a:?} and {b:?}: {reason}")]
    ImpossibleGoal {
        /// Name of one interface.
        a: String,
        /// Name of the other.
        b: String,
        /// Why they cannot touch.
        reason: String,
    },
    /// An operator, the start or the goal names a fact that is not declared.
    #[error("{place}: fact number {fact}, but only {count} facts are declared")]
    UnknownFact {
        /// Label of the operator, "start" or "goal".
        place: String,
        /// The index given.
        fact: usize,
        /// Number of facts.
        count: usize,
    },
    /// A PDDL domain that is not understood, or does not fit the scene.
    #[error("{0}")]
    Pddl(#[from] PddlError),
    /// The manipulation states within the action limit are too many to list.
    #[error(
        "more than {limit} manipulation states within reach; lower the largest number of skeleton actions"
    )]
    TooManyStates {
        /// The limit that was exceeded.
        limit: usize,
    },
}
