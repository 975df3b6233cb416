//! Why a scene cannot be used, and how that is shown.

use crate::source::Place;
use mjcf::MjcfError;
use multibody::ModelError;
use std::fmt;

/// What is wrong with a scene, a robot file or a URDF.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[allow(
    missing_docs,
    reason = "the message of a variant says what its fields are"
)]
pub enum Fault {
    /// A file that cannot be read.
    #[error("cannot read {path}: {reason}")]
    Read { path: String, reason: String },
    /// A name that no built-in scene has.
    #[error("no scene {name:?} is built in")]
    UnknownBuiltin {
        name: String,
        nearest: Option<String>,
        known: String,
    },
    /// The text is not TOML.
    #[error("malformed TOML: {message}")]
    Syntax { message: String },
    /// A key that the format does not have.
    #[error("unknown key {key:?}")]
    UnknownKey {
        key: String,
        nearest: Option<String>,
        known: String,
    },
    /// A key that is missing, or a value of the wrong type or length.
    #[error("{message}")]
    Type { message: String },
    /// A number outside its range.
    #[error("{what} is {value}, expected {expected}")]
    Value {
        what: String,
        value: String,
        expected: String,
    },
    /// Keys that do not go together, or one that is needed here.
    #[error("{what}: {problem}")]
    Keys { what: String, problem: String },
    /// A name given twice.
    #[error("the {kind} {name:?} exists already")]
    Duplicate { kind: &'static str, name: String },
    /// A name that nothing has.
    #[error("{user}: no {kind} is called {name:?}")]
    UnknownName {
        user: String,
        kind: &'static str,
        name: String,
        nearest: Option<String>,
        known: String,
    },
    /// The URDF is no usable robot.
    #[error("robot {robot:?}: {source}")]
    Robot { robot: String, source: ModelError },
    /// The MJCF is no usable robot.
    #[error("{path}: {source}")]
    Mjcf { path: String, source: MjcfError },
    /// A start position that the joint cannot take.
    #[error(
        "joint {joint:?} starts at {value}, expected a value within its limits [{lower}, {upper}]"
    )]
    JointLimit {
        joint: String,
        value: f64,
        lower: f64,
        upper: f64,
    },
    /// A PDDL domain that is not understood.
    #[error("{problem}")]
    Pddl { problem: String, remedy: String },
    /// Neither goal nor objective.
    #[error("the scene asks for nothing: {found}")]
    EmptyGoal { found: &'static str },
    /// Two interfaces that can never touch, or not in this way.
    #[error("{a:?} cannot touch {b:?}: {reason}")]
    Impossible {
        a: String,
        b: String,
        reason: String,
        remedy: String,
    },
    /// A contact of the start state that the start poses do not have.
    #[error("start contact of {a:?} on {b:?} does not hold: {gap}")]
    Broken { a: String, b: String, gap: String },
    /// An object that nothing holds at the start.
    #[error("object {object:?} has no contact at the start: {nearest}")]
    Floating { object: String, nearest: String },
    /// Objects that stand on each other in a ring.
    #[error("objects {objects} stand on each other in a ring")]
    SupportRing { objects: String },
    /// A foot with nothing to stand on.
    #[error("nothing to stand on: {reason}")]
    NoGround { reason: String },
    /// Bodies that share space at the start.
    #[error("{first:?} and {second:?} overlap by {depth} at the start")]
    Overlap {
        first: String,
        second: String,
        depth: String,
    },
}

impl Fault {
    /// What to do about it, as a sentence; `None` if the message says it.
    pub fn help(&self) -> Option<String> {
        let text = match self {
            Self::Read { .. } => {
                "check the path; paths in a file are relative to the folder of that file".into()
            }
            Self::UnknownBuiltin { nearest, known, .. }
            | Self::UnknownKey { nearest, known, .. }
            | Self::UnknownName { nearest, known, .. } => suggestion(nearest.as_deref(), known),
            Self::Duplicate { .. } => "give it another name".into(),
            Self::Robot { .. } => "mend the URDF, or name another robot".into(),
            Self::Mjcf { .. } => "mend the MJCF, or name another robot".into(),
            Self::JointLimit { lower, upper, .. } => {
                format!("set it to a value from {lower} to {upper}")
            }
            Self::EmptyGoal { .. } => {
                "add contacts = [[\"…\", \"…\"]] or a [[goal.region]] to [goal], or an [objective] such as kind = \
                 \"base_height\""
                    .into()
            }
            Self::Impossible { remedy, .. } | Self::Pddl { remedy, .. } => remedy.clone(),
            Self::Broken { .. } => {
                "correct the start pose ([start] of the scene, [home] of the robot file) or the pose of the interface, or leave this \
                 contact out of start.contacts"
                    .into()
            }
            Self::Floating { .. } => {
                "place it with on = \"<interface>\", correct its position, or list who holds it in start.contacts".into()
            }
            Self::SupportRing { .. } => "give one of them a position instead of `on`".into(),
            Self::NoGround { .. } => {
                "move the robot, add a [[static]] with plane = true, or give the base height as the third number of \
                 start.position"
                    .into()
            }
            Self::Overlap { .. } => "move one of them".into(),
            Self::Syntax { .. } | Self::Type { .. } | Self::Value { .. } | Self::Keys { .. } => {
                return None;
            }
        };
        Some(text)
    }
}

/// "did you mean …?" with what there is.
fn suggestion(nearest: Option<&str>, known: &str) -> String {
    match nearest {
        Some(name) => format!("did you mean {name:?}? known: {known}"),
        None => format!("known: {known}"),
    }
}

/// Why a scene cannot be used: what is wrong, where it stands.
///
/// `Display` is one line, `file:line: what is wrong; what to do` (`file:line:column` in a PDDL domain). [`SceneError::render`] shows the source.
#[derive(Debug, Clone)]
pub struct SceneError {
    fault: Box<Fault>,
    place: Option<Box<Place>>,
}

impl SceneError {
    /// A fault of something that stands in no file.
    pub(crate) fn nowhere(fault: Fault) -> Self {
        Self {
            fault: Box::new(fault),
            place: None,
        }
    }

    /// A fault of something that stands at `place`.
    pub(crate) fn at(place: Place, fault: Fault) -> Self {
        Self {
            fault: Box::new(fault),
            place: Some(Box::new(place)),
        }
    }

    /// What is wrong.
    pub fn fault(&self) -> &Fault {
        &self.fault
    }

    /// Where it stands; `None` if no file could be read.
    pub fn place(&self) -> Option<&Place> {
        self.place.as_deref()
    }

    /// The message with an excerpt of the file, several lines without colours, for a terminal.
    pub fn render(&self) -> String {
        let Some(place) = self.place() else {
            return format!("error: {self}\n");
        };
        let mut lines = Vec::new();
        match self.report(place).write(
            (place.file(), ariadne::Source::from(place.text())),
            &mut lines,
        ) {
            Ok(()) => String::from_utf8_lossy(&lines).into_owned(),
            Err(_) => format!("error: {self}\n"),
        }
    }

    fn report<'a>(
        &self,
        place: &'a Place,
    ) -> ariadne::Report<'a, (&'a str, std::ops::Range<usize>)> {
        let span = (place.file(), place.first_line());
        let config = ariadne::Config::default()
            .with_color(false)
            .with_index_type(ariadne::IndexType::Byte);
        let mut report = ariadne::Report::build(ariadne::ReportKind::Error, span.clone())
            .with_config(config)
            .with_message(&self.fault)
            .with_label(ariadne::Label::new(span).with_message("here"));
        if let Some(help) = self.fault.help() {
            report = report.with_help(help);
        }
        report.finish()
    }
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(place) = self.place() {
            write!(f, "{}:{}", place.file(), place.line())?;
            if let Fault::Pddl { .. } = *self.fault {
                write!(f, ":{}", place.column())?;
            }
            write!(f, ": ")?;
        }
        write!(f, "{}", self.fault)?;
        match self.fault.help() {
            Some(help) => write!(f, "; {help}"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for SceneError {}
