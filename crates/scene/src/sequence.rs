//! Contact sequences from files: the contacts of every phase, validated against a scene.
//!
//! The file format is described in `docs/sequence-format.md` and, derived from the types of [`crate::sequence_file`], in
//! `docs/sequence.schema.json`.

use crate::draft::Draft;
use crate::goal;
use crate::parse::parse;
use crate::sequence_file::{ExpectEntry, PhaseEntry, SequenceEntry};
use crate::source::{At, Source};
use crate::start::{Asked, listed_contact, two_partners};
use crate::{Fault, GoalContact, RegionGoal, Scene, SceneError, options};
use std::path::{Path, PathBuf};
use symbolic::{Contact, ContactState, ContactType};

/// One phase of a sequence.
#[derive(Debug, Clone, PartialEq)]
pub struct SequencePhase {
    /// What it is, for people; `None`: to be derived from the contacts that change.
    pub label: Option<String>,
    /// All contacts of the scene in this phase.
    pub state: ContactState,
    /// Number of intervals N_k.
    pub steps: usize,
}

/// What must hold at the end, instead of the scene's goal.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SequenceGoal {
    /// Contacts demanded at the end.
    pub contacts: Vec<GoalContact>,
    /// Regions demanded at the end.
    pub regions: Vec<RegionGoal>,
}

/// Whether a motion exists, as the author of a sequence claims.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Expectation {
    /// There is a motion.
    Feasible,
    /// There is none.
    Infeasible {
        /// The reason.
        why: String,
    },
}

/// A contact sequence of one scene, validated: the first phase has the contacts of the start, the last those of the goal.
#[derive(Debug, Clone, PartialEq)]
pub struct Sequence {
    /// Name, for people.
    pub name: String,
    /// What it shows, for people; may be empty.
    pub description: String,
    /// At least one phase.
    pub phases: Vec<SequencePhase>,
    /// The goal if it is not the scene's.
    pub goal: Option<SequenceGoal>,
    /// What its author claims, if anything.
    pub expect: Option<Expectation>,
    /// Configurations at the phase boundaries, one more than phases, each that of the robot (base position [m], base quaternion
    /// xyzw, joints [rad or m]) with the poses of all objects (position [m], quaternion xyzw); none if nothing is known.
    pub configurations: Vec<Vec<f64>>,
}

impl Sequence {
    /// Reads the sequence file at `path` for a scene.
    ///
    /// # Errors
    /// [`SceneError`] with the place in the file, as [`Scene::load`].
    pub fn load(path: impl AsRef<Path>, scene: &Scene) -> Result<Self, SceneError> {
        SequenceFile::load(path)?.resolve(scene)
    }
}

/// A sequence file that was read but not yet related to a scene.
#[derive(Debug)]
pub struct SequenceFile {
    source: Source,
    folder: PathBuf,
    /// Name if the file gives none.
    stem: String,
    entry: SequenceEntry,
}

impl SequenceFile {
    /// All .toml files below a folder, in the order of their names.
    ///
    /// # Errors
    /// If a folder cannot be read.
    pub fn find(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
        let mut paths = Vec::new();
        for entry in std::fs::read_dir(folder)? {
            let path = entry?.path();
            if path.is_dir() {
                paths.extend(Self::find(&path)?);
            } else if path.extension().is_some_and(|e| e == "toml") {
                paths.push(path);
            }
        }
        paths.sort();
        Ok(paths)
    }

    /// Reads a sequence file.
    ///
    /// # Errors
    /// If it cannot be read, is no TOML or has keys or types that the format does not have.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        let path = path.as_ref();
        let text = std::fs::read_to_string(path).map_err(|error| {
            SceneError::nowhere(Fault::Read {
                path: path.display().to_string(),
                reason: error.to_string(),
            })
        })?;
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::from_toml(&text, &path.display().to_string(), folder)
    }

    /// Reads the text of a sequence file that people know as `source_name`; the path of its scene starts at `folder`.
    ///
    /// # Errors
    /// As [`SequenceFile::load`].
    pub fn from_toml(text: &str, source_name: &str, folder: &Path) -> Result<Self, SceneError> {
        let source = Source::new(source_name, text);
        let entry = parse(&source, text)?;
        let stem = Path::new(source_name).file_stem();
        Ok(Self {
            source,
            folder: folder.into(),
            stem: stem.map_or_else(|| source_name.into(), |s| s.to_string_lossy().into_owned()),
            entry,
        })
    }

    /// The name of the sequence, or that of its file.
    pub fn name(&self) -> &str {
        self.entry.name.as_deref().unwrap_or(&self.stem)
    }

    /// What `scene` names: the path of a scene file, relative to the working folder, or the name of a built-in scene.
    pub fn scene_name(&self) -> Option<String> {
        let name = self.entry.scene.as_deref()?;
        Some(if is_path(name) {
            self.folder.join(name).display().to_string()
        } else {
            name.clone()
        })
    }

    /// The scene that the file names.
    ///
    /// # Errors
    /// If it names none, or one that cannot be used.
    pub fn load_scene(&self) -> Result<Scene, SceneError> {
        let Some(name) = &self.entry.scene else {
            let problem =
                "it is missing; expected the path of a scene file or the name of a built-in scene";
            return Err(self.source.bad_keys(0..0, "scene", problem));
        };
        let scene = if is_path(name) {
            Scene::load(self.folder.join(name.as_str()))
        } else {
            Scene::builtin(name)
        };
        scene.map_err(|error| match error.place() {
            Some(_) => error,
            None => self.source.fault(name.span(), error.fault().clone()),
        })
    }

    /// The sequence, validated for a scene.
    ///
    /// # Errors
    /// Unknown interfaces and contact types, contacts that cannot be or are ambiguous, counts out of range, a first phase
    /// that is not the start, a last phase without the goal's contacts.
    pub fn resolve(&self, scene: &Scene) -> Result<Sequence, SceneError> {
        let draft = Draft {
            source: &self.source,
            robot: scene.robot.clone(),
            objects: scene.objects.clone(),
            statics: scene.statics.clone(),
            interfaces: scene.interfaces.clone(),
        };
        let steps = |value: Option<&At<usize>>, otherwise: usize| {
            value.map_or(Ok(otherwise), |value| options::steps(&self.source, value))
        };
        let otherwise = steps(self.entry.steps.as_ref(), scene.optimiser.steps)?;
        let mut phases = Vec::new();
        for entry in &self.entry.phase {
            phases.push(SequencePhase {
                label: entry.label.as_deref().map(str::to_owned),
                state: state(&draft, entry)?,
                steps: steps(entry.steps.as_ref(), otherwise)?,
            });
        }
        let (Some(first), Some(last)) = (self.entry.phase.first(), self.entry.phase.last()) else {
            let problem = "there is none; expected at least one [[phase]] with its contacts";
            return Err(self.source.bad_keys(0..0, "phase", problem));
        };
        check_start(&draft, scene, &phases[0].state, first)?;
        let goal = match &self.entry.goal {
            Some(entry) => {
                let (contacts, regions) = goal::demands(&draft, entry)?;
                Some(SequenceGoal { contacts, regions })
            }
            None => None,
        };
        let demanded = goal.as_ref().map_or(&scene.goal_contacts, |g| &g.contacts);
        check_goal(&draft, demanded, &phases[phases.len() - 1].state, last)?;
        Ok(Sequence {
            name: self.name().to_owned(),
            description: self.entry.description.clone(),
            phases,
            goal,
            expect: self.expectation()?,
            configurations: vec![],
        })
    }

    fn expectation(&self) -> Result<Option<Expectation>, SceneError> {
        let why = self.entry.why.as_ref();
        match (&self.entry.expect, why) {
            (Some(expect), Some(why)) if **expect == ExpectEntry::Infeasible => {
                Ok(Some(Expectation::Infeasible {
                    why: (**why).clone(),
                }))
            }
            (Some(expect), None) if **expect == ExpectEntry::Infeasible => {
                let problem = "it needs the reason as well, why = \"…\"";
                Err(self
                    .source
                    .bad_keys(expect.span(), "expect = \"infeasible\"", problem))
            }
            (_, Some(why)) => {
                let problem = "it goes with expect = \"infeasible\" only";
                Err(self.source.bad_keys(why.span(), "why", problem))
            }
            (Some(_), None) => Ok(Some(Expectation::Feasible)),
            (None, None) => Ok(None),
        }
    }
}

fn is_path(scene: &str) -> bool {
    Path::new(scene)
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("toml"))
}

/// The contacts of a phase.
fn state(draft: &Draft, entry: &PhaseEntry) -> Result<ContactState, SceneError> {
    let user = "contact of a phase";
    let mut asked: Vec<Contact> = Vec::new();
    for item in entry.contacts.iter() {
        let Asked {
            contact,
            span,
            types,
        } = listed_contact(draft, item, user)?;
        if let [_, _, ..] = types.as_slice() {
            let names: Vec<&str> = types.iter().copied().map(ContactType::name).collect();
            let problem = format!(
                "they can touch as {}; name one of these as the third entry",
                names.join(" or ")
            );
            return Err(draft
                .source
                .bad_keys(span, &pair_name(draft, contact), &problem));
        }
        if let Some(other) = asked.iter().find(|o| o.a == contact.a) {
            if other.b == contact.b {
                let problem = "it is listed twice in this phase; leave one out";
                return Err(draft
                    .source
                    .bad_keys(span, &pair_name(draft, contact), problem));
            }
            return Err(two_partners(draft, &contact, other, &span));
        }
        let covered = |one: &Contact, other: &Contact| one.a == other.b;
        if let Some(other) = asked
            .iter()
            .find(|o| covered(&contact, o) || covered(o, &contact))
        {
            let problem = format!(
                "a surface cannot rest and be touched at once, and there is {}; leave one out",
                pair_name(draft, *other)
            );
            return Err(draft
                .source
                .bad_keys(span, &pair_name(draft, contact), &problem));
        }
        asked.push(contact);
    }
    Ok(asked.into_iter().collect())
}

/// "left_foot on ground_top".
fn pair_name(draft: &Draft, contact: Contact) -> String {
    let name = |id: symbolic::InterfaceId| draft.interfaces[id.0].name.as_str();
    format!("{} on {}", name(contact.a), name(contact.b))
}

/// The first phase has the contacts of the start, no more, no fewer.
fn check_start(
    draft: &Draft,
    scene: &Scene,
    first: &ContactState,
    entry: &PhaseEntry,
) -> Result<(), SceneError> {
    let start = scene.start_state();
    if *first == start {
        return Ok(());
    }
    let list = |from: &ContactState, to: &ContactState| {
        let names: Vec<String> = from
            .contacts
            .difference(&to.contacts)
            .map(|c| format!("{} ({})", pair_name(draft, *c), c.kind.name()))
            .collect();
        names.join(", ")
    };
    let (missing, more) = (list(&start, first), list(first, &start));
    let mut parts = Vec::new();
    if !missing.is_empty() {
        parts.push(format!("{missing} missing"));
    }
    if !more.is_empty() {
        parts.push(format!("{more} not there at the start"));
    }
    let problem = format!(
        "expected those of the scene's start, but {}",
        parts.join(", ")
    );
    let span = entry.contacts.span();
    Err(draft
        .source
        .bad_keys(span, "contacts of the first phase", &problem))
}

/// The last phase has the contacts of the goal.
fn check_goal(
    draft: &Draft,
    demanded: &[GoalContact],
    last: &ContactState,
    entry: &PhaseEntry,
) -> Result<(), SceneError> {
    let missing = demanded
        .iter()
        .find(|goal| !last.iter().any(|c| c.a == goal.a && c.b == goal.b));
    let Some(goal) = missing else {
        return Ok(());
    };
    let name = |id: symbolic::InterfaceId| draft.interfaces[id.0].name.as_str();
    let problem = format!(
        "{} on {}, which the goal demands, is missing; add it, or give the sequence a [goal] of its own",
        name(goal.a),
        name(goal.b)
    );
    let span = entry.contacts.span();
    Err(draft
        .source
        .bad_keys(span, "contacts of the last phase", &problem))
}
