//! From the text of a scene file to a validated scene.

use crate::bodies::{self, NamedInterface, UnplacedObject};
use crate::draft::Draft;
use crate::file::{ObjectEntry, SceneFile};
use crate::goal::{BASE_NAME, goal};
use crate::interfaces::Friction;
use crate::mesh_shapes::give_patches_shapes;
use crate::parse::parse;
use crate::place::{place_supported, world_pose};
use crate::robot::{self, LoadedRobot, mesh_folder};
use crate::source::{At, Source};
use crate::start::start;
use crate::{
    Fault, GoalContact, Interface, Object, Owner, Role, Scene, SceneError, StaticBody, options,
    overlap, pace,
};
use nalgebra::Vector3;
use std::ops::Range;
use std::path::Path;
use symbolic::ContactState;

/// Gravity if none is given [m/s²].
pub(crate) const STANDARD_GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

/// Friction if none is given.
pub(crate) const DEFAULT_FRICTION: Friction = Friction {
    mu: 0.7,
    mu_r: 0.02,
};

impl Scene {
    /// Reads and validates a scene file; relative paths in it start at its folder.
    ///
    /// # Errors
    /// [`SceneError`] with the place in the file for everything that makes the scene unusable; no text makes it panic.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        let path = path.as_ref();
        let text = std::fs::read_to_string(path).map_err(|error| {
            SceneError::nowhere(Fault::Read {
                path: path.display().to_string(),
                reason: error.to_string(),
            })
        })?;
        let base_dir = path.parent().unwrap_or(Path::new(""));
        Self::from_toml(&text, &path.display().to_string(), base_dir)
    }

    /// Validates the text of a scene file that people know as `source_name`; relative paths in it start at `base_dir`.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn from_toml(text: &str, source_name: &str, base_dir: &Path) -> Result<Self, SceneError> {
        let source = Source::new(source_name, text);
        let file: SceneFile = parse(&source, text)?;
        build(&source, &file, base_dir)
    }

    /// The contacts at the start as a symbolic state.
    pub fn start_state(&self) -> ContactState {
        ContactState {
            contacts: self.start_contacts.iter().copied().collect(),
        }
    }
}

fn build(source: &Source, file: &SceneFile, base_dir: &Path) -> Result<Scene, SceneError> {
    let gravity = match &file.gravity {
        Some(gravity) => source.point("gravity", gravity)?,
        None => STANDARD_GRAVITY,
    };
    let friction = DEFAULT_FRICTION.overridden(
        source,
        "[friction]",
        file.friction.mu.as_ref(),
        file.friction.mu_r.as_ref(),
    )?;
    let robot_place = source.place(file.robot.span());
    let meshes = mesh_folder(source, file.meshes.as_ref(), base_dir)?;
    let LoadedRobot {
        mut robot,
        interfaces,
        bare,
        unread,
        ..
    } = robot::load(
        &file.robot,
        robot_place,
        base_dir,
        meshes,
        friction,
        gravity,
    )?;
    let mut named: Vec<NamedInterface> = interfaces
        .into_iter()
        .map(|interface| (interface, file.robot.span()))
        .collect();
    let own = robot::robot_interfaces(source, &robot.model, &file.robot_interface, friction)?;
    let own_names = file.robot_interface.iter().map(|entry| entry.name.span());
    named.extend(own.into_iter().zip(own_names));
    if named.is_empty() {
        let problem = "it has no interfaces; list its hands and feet as [[robot_interface]]";
        return Err(source.bad_keys(file.robot.span(), "robot", problem));
    }
    let limbs = named.iter().map(|(interface, _)| interface);
    give_patches_shapes(&mut robot, limbs, &unread);
    let links = robot.model.frames.iter().map(|frame| frame.name.as_str());
    check_body_names(source, file, links)?;
    let (objects, statics) = read_bodies(source, file, friction, &mut named)?;
    check_interface_names(source, &named)?;
    let mut draft = Draft {
        source,
        robot,
        objects,
        statics,
        interfaces: named.into_iter().map(|(interface, _)| interface).collect(),
    };
    let supports = place_supported(&mut draft, &file.object)?;
    overlap::check(&draft, &file.object)?;
    let start = start(
        &draft,
        &file.start,
        &file.object,
        supports,
        file.robot.span(),
    )?;
    let goal = goal(&draft, file)?;
    if bare {
        draft.robot.home.copy_from_slice(&start.q[robot::BASE..]);
    }
    let mut search = options::search(source, &file.search, base_dir)?;
    search.support_hands |=
        file.search.support_hands.is_none() && leans_at_end(&goal.contacts, &draft.interfaces);
    let durations = pace::durations(&draft.robot, &draft.interfaces, gravity.norm());
    Ok(Scene {
        name: (*file.name).clone(),
        gravity,
        robot: draft.robot,
        start: start.q,
        objects: draft.objects,
        statics: draft.statics,
        interfaces: draft.interfaces,
        start_contacts: start.contacts,
        goal_contacts: goal.contacts,
        goal_regions: goal.regions,
        objective: goal.objective,
        search,
        optimiser: options::optimiser(source, &file.optimiser, durations)?,
        doubts: crate::doubts::doubts(file, gravity),
    })
}

/// Does the goal ask for a hand on something fixed.
fn leans_at_end(goals: &[GoalContact], interfaces: &[Interface]) -> bool {
    let is_hand = |i: &Interface| matches!(i.owner, Owner::Robot { .. }) && i.role == Role::Hand;
    let leans =
        |hand: &Interface, on: &Interface| is_hand(hand) && matches!(on.owner, Owner::Static(_));
    goals.iter().any(|goal| {
        let [a, b] = [goal.a, goal.b].map(|i| &interfaces[i.0]);
        leans(a, b) || leans(b, a)
    })
}

/// Objects (those without `on` at their start poses) and static bodies; their interfaces are added to `named`, objects' first.
fn read_bodies(
    source: &Source,
    file: &SceneFile,
    friction: Friction,
    named: &mut Vec<NamedInterface>,
) -> Result<(Vec<Object>, Vec<StaticBody>), SceneError> {
    let mut objects = Vec::new();
    for (index, entry) in file.object.iter().enumerate() {
        let unplaced = bodies::object(source, entry, index, friction)?;
        objects.push(placed_in_world(source, entry, &unplaced)?);
        named.extend(unplaced.interfaces);
    }
    let mut statics = Vec::new();
    for (index, entry) in file.statics.iter().enumerate() {
        let (body, interfaces) = bodies::static_body(source, entry, index, friction)?;
        statics.push(body);
        named.extend(interfaces);
    }
    Ok((objects, statics))
}

/// The object at its start pose if that is given in the world.
fn placed_in_world(
    source: &Source,
    entry: &ObjectEntry,
    unplaced: &UnplacedObject,
) -> Result<Object, SceneError> {
    let mut object = unplaced.object.clone();
    if entry.on.is_none() {
        object.world_from_start = world_pose(source, entry, unplaced)?;
    }
    Ok(object)
}

/// Names of bodies are unique, not empty, and none is that of a link or the base.
fn check_body_names<'a>(
    source: &Source,
    file: &'a SceneFile,
    links: impl Iterator<Item = &'a str>,
) -> Result<(), SceneError> {
    let mut taken: Vec<&str> = links.chain([BASE_NAME]).collect();
    let objects = file.object.iter().map(|entry| &entry.name);
    let statics = file.statics.iter().map(|entry| &entry.name);
    let bodies: Vec<&At<String>> = objects.chain(statics).collect();
    for name in std::iter::once(&file.name).chain(bodies.iter().copied()) {
        check_not_empty(source, name, name.span())?;
    }
    for name in bodies {
        if taken.contains(&name.as_str()) {
            return Err(duplicate(source, "body", name, name.span()));
        }
        taken.push(name);
    }
    Ok(())
}

fn check_interface_names(source: &Source, named: &[NamedInterface]) -> Result<(), SceneError> {
    for (index, (interface, span)) in named.iter().enumerate() {
        check_not_empty(source, &interface.name, span.clone())?;
        let before = &named[..index];
        if before.iter().any(|(other, _)| other.name == interface.name) {
            return Err(duplicate(
                source,
                "interface",
                &interface.name,
                span.clone(),
            ));
        }
    }
    Ok(())
}

fn check_not_empty(source: &Source, name: &str, span: Range<usize>) -> Result<(), SceneError> {
    if name.trim().is_empty() {
        return Err(source.bad_keys(span, "name", "it is empty, expected some text"));
    }
    Ok(())
}

fn duplicate(source: &Source, kind: &'static str, name: &str, span: Range<usize>) -> SceneError {
    let name = name.to_owned();
    source.fault(span, Fault::Duplicate { kind, name })
}
