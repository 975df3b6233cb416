//! The robot: a built-in one, a robot file beside its URDF or MJCF, or one of these alone.

use crate::builtin;
use crate::file::RobotInterfaceEntry;
use crate::for_readers::for_readers;
use crate::interfaces::{Friction, robot_interface};
use crate::mesh_path::MeshFolders;
use crate::mesh_shapes::{Axes, with_fitted_shapes};
use crate::nearest::{list, nearest};
use crate::parse::parse;
use crate::source::{At, Place, Source};
use crate::split::Triangle;
use crate::tiny_masses::with_tiny_masses;
use crate::torque_speed::{TorqueSpeedEntry, set_torque_speed};
use crate::{Fault, Interface, Owner, PlacedShape, Robot, SceneError, Shape};
use multibody::{Joint, JointKind, Model, Root};
use nalgebra::Vector3;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Entries of q that belong to the floating base.
pub(crate) const BASE: usize = 7;

/// The parts of a capsule may miss each other by this much [m].
pub(crate) const CAPSULE_PLAY: f64 = 1e-4;

/// A robot file: what a planner needs beside the URDF or MJCF.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a robot")]
#[allow(dead_code, reason = "source and licence are for people")]
pub(crate) struct RobotFile {
    /// Name, for people and plan files.
    pub name: At<String>,
    /// Path of the URDF or MJCF, relative to this file.
    pub urdf: At<String>,
    /// Folder with the mesh files that the description names, relative to this file.
    pub meshes: Option<At<String>>,
    /// Where the description comes from.
    pub source: Option<String>,
    /// Its licence.
    pub licence: Option<String>,
    /// Joint positions of a nominal stand [rad or m]; joints not named are at 0 or at the nearest limit.
    #[serde(default)]
    pub home: BTreeMap<At<String>, At<f64>>,
    /// How the torques of joints fall with speed.
    #[serde(default)]
    pub torque_speed: Vec<TorqueSpeedEntry>,
    /// Hands and feet.
    #[serde(default)]
    pub interface: Vec<RobotInterfaceEntry>,
}

/// A robot with its interfaces.
pub(crate) struct LoadedRobot {
    pub robot: Robot,
    pub interfaces: Vec<Interface>,
    /// True if the robot came without a home posture.
    pub bare: bool,
    /// Links with meshes that could not be read.
    pub unread: Vec<String>,
    /// Corners of the triangles of the meshes that each link collides with, in its frame [m].
    pub mesh_corners: Vec<Vec<Vector3<f64>>>,
    /// The other shapes that each link collides with, as they are described.
    pub primitives: Vec<Vec<PlacedShape>>,
}

/// Texts that a robot is made of.
struct Texts {
    description: Description,
    /// Where the description is named.
    place: Place,
    /// Where it is; `None` if it is built in.
    path: Option<PathBuf>,
    file: Option<(Source, RobotFile)>,
}

/// A robot as its designer gives it.
#[derive(Default)]
struct Description {
    urdf: String,
    /// Positions of joints by name, within or outside their limits.
    home: Vec<(String, f64)>,
    notes: Vec<String>,
    /// True if it was in another format.
    converted: bool,
}

/// The robot that `name` names, at `place` of a scene file in `base_dir`; its meshes are first looked for in `meshes`.
pub(crate) fn load(
    name: &str,
    place: Place,
    base_dir: &Path,
    meshes: Option<PathBuf>,
    friction: Friction,
    gravity: Vector3<f64>,
) -> Result<LoadedRobot, SceneError> {
    let texts = find_texts(name, place, base_dir)?;
    let read = |urdf: &str| {
        Model::from_urdf(urdf, Root::Floating).map_err(|source| {
            let robot = if texts.description.converted {
                format!("{name}, as a URDF")
            } else {
                name.to_owned()
            };
            SceneError::at(texts.place.clone(), Fault::Robot { robot, source })
        })
    };
    let Description {
        urdf, home, notes, ..
    } = &texts.description;
    let urdf = &with_tiny_masses(urdf);
    let mut model = read(urdf)?;
    let mut interfaces = Vec::new();
    if let Some((source, file)) = &texts.file {
        interfaces = robot_interfaces(source, &model, &file.interface, friction)?;
    }
    let fitted = with_fitted_shapes(
        urdf,
        &mesh_folders(&texts, &base_dir.join(name), meshes)?,
        &axes_of_patches(&model, &interfaces),
    );
    let primitives = collision_shapes(&mut model.clone());
    if fitted.urdf != *urdf {
        model = read(&fitted.urdf)?;
    }
    let mesh_corners = corners_by_link(&model, fitted.meshes);
    model.notes.extend(notes.iter().cloned());
    model.notes.extend(fitted.notes);
    model.gravity = gravity;
    let mut home = within_limits(&model, home);
    let mut robot_name = model.name.clone();
    if let Some((source, file)) = &texts.file {
        robot_name.clone_from(&file.name);
        set_joints(source, &model, &file.home, &mut home)?;
        set_torque_speed(source, &mut model, &file.torque_speed)?;
    }
    let shapes = collision_shapes(&mut model);
    Ok(LoadedRobot {
        robot: Robot {
            name: robot_name,
            urdf: for_readers(&fitted.urdf, &model.locked),
            model,
            home,
            shapes,
        },
        interfaces,
        bare: texts.file.is_none(),
        unread: fitted.unread,
        mesh_corners,
        primitives,
    })
}

/// Corners of the meshes of each link of the model.
fn corners_by_link(model: &Model, meshes: Vec<(String, Vec<Triangle>)>) -> Vec<Vec<Vector3<f64>>> {
    let mut out = vec![vec![]; model.frames.len()];
    for (link, triangles) in meshes {
        if let Some(frame) = model.frame_id(&link) {
            out[frame].extend(triangles.into_iter().flatten());
        }
    }
    out
}

/// Axes of the links that carry patches.
fn axes_of_patches(model: &Model, interfaces: &[Interface]) -> Vec<Axes> {
    let axes = |interface: &Interface| {
        let Owner::Robot { frame } = interface.owner else {
            return None;
        };
        interface.half_size?;
        let rotation = *interface.body_from_interface.rotation();
        Some((model.frames[frame].name.clone(), rotation))
    };
    interfaces.iter().filter_map(axes).collect()
}

/// Where the meshes of a robot may be: in the folder that the scene names, then that of its own file.
fn mesh_folders(
    texts: &Texts,
    robot_file: &Path,
    of_scene: Option<PathBuf>,
) -> Result<MeshFolders, SceneError> {
    let mut given: Vec<PathBuf> = of_scene.into_iter().collect();
    if let Some((source, file)) = &texts.file {
        let beside = robot_file.parent().unwrap_or(Path::new(""));
        given.extend(mesh_folder(source, file.meshes.as_ref(), beside)?);
    }
    Ok(match &texts.path {
        Some(path) => MeshFolders::of_urdf(path, given),
        None => MeshFolders::default(),
    })
}

/// The folder that the key `meshes` names, from the folder of its file.
pub(crate) fn mesh_folder(
    source: &Source,
    entry: Option<&At<String>>,
    beside: &Path,
) -> Result<Option<PathBuf>, SceneError> {
    let Some(entry) = entry else {
        return Ok(None);
    };
    let folder = beside.join(&**entry);
    if folder.is_dir() {
        return Ok(Some(folder));
    }
    let problem = format!(
        "there is no folder {}; give that of the robot's package, or one above it",
        folder.display()
    );
    Err(source.bad_keys(entry.span(), "meshes", &problem))
}

fn find_texts(name: &str, place: Place, base_dir: &Path) -> Result<Texts, SceneError> {
    if let Some(robot) = builtin::robot(name) {
        let source = Source::new(&format!("built-in robot {name}"), robot.file);
        let file = parse(&source, robot.file)?;
        return Ok(Texts {
            description: Description {
                urdf: robot.urdf.to_owned(),
                ..Description::default()
            },
            place,
            path: None,
            file: Some((source, file)),
        });
    }
    let path = base_dir.join(name);
    let extension = path.extension().and_then(|e| e.to_str());
    match extension.map(str::to_ascii_lowercase).as_deref() {
        Some("urdf" | "xml") => Ok(Texts {
            description: describe(&path, &place)?,
            place,
            path: Some(path),
            file: None,
        }),
        Some("toml") => {
            let text = read(&path, &place)?;
            let source = Source::new(&path.display().to_string(), &text);
            let file: RobotFile = parse(&source, &text)?;
            let urdf_path = path.parent().unwrap_or(Path::new("")).join(&*file.urdf);
            let urdf_place = source.place(file.urdf.span());
            Ok(Texts {
                description: describe(&urdf_path, &urdf_place)?,
                place: urdf_place,
                path: Some(urdf_path),
                file: Some((source, file)),
            })
        }
        _ => Err(SceneError::at(
            place,
            Fault::UnknownName {
                user: "robot".into(),
                kind: "built-in robot",
                name: name.to_owned(),
                nearest: nearest(name, builtin::robot_names()).map(str::to_owned),
                known: format!(
                    "{}, or a path that ends in .toml, .urdf or .xml (URDF or MJCF)",
                    builtin::robot_names().collect::<Vec<_>>().join(", ")
                ),
            },
        )),
    }
}

/// The text of a file that is named at `place`.
pub(crate) fn read(path: &Path, place: &Place) -> Result<String, SceneError> {
    std::fs::read_to_string(path).map_err(|error| {
        let fault = Fault::Read {
            path: path.display().to_string(),
            reason: error.to_string(),
        };
        SceneError::at(place.clone(), fault)
    })
}

/// The URDF or MJCF at a path.
fn describe(path: &Path, place: &Place) -> Result<Description, SceneError> {
    let urdf = read(path, place)?;
    if !mjcf::is_mjcf(&urdf) {
        return Ok(Description {
            urdf,
            ..Description::default()
        });
    }
    let mjcf::Converted { urdf, home, notes } = mjcf::to_urdf(path).map_err(|source| {
        let path = path.display().to_string();
        SceneError::at(place.clone(), Fault::Mjcf { path, source })
    })?;
    Ok(Description {
        urdf,
        home,
        notes,
        converted: true,
    })
}

/// Joint positions of length n: those given, or zero, or the limit that is nearest.
fn within_limits(model: &Model, home: &[(String, f64)]) -> Vec<f64> {
    let joints = model.joints.iter();
    let moving = joints.filter(|joint| joint.kind != JointKind::FreeFlyer);
    let position = |joint: &Joint| {
        let given = home.iter().find(|(name, _)| *name == joint.name);
        let wish = given.map_or(0.0, |(_, position)| *position);
        wish.max(joint.lower).min(joint.upper)
    };
    moving.map(position).collect()
}

/// Writes the named joint positions into `joints` (length n), within limits.
pub(crate) fn set_joints(
    source: &Source,
    model: &Model,
    entries: &BTreeMap<At<String>, At<f64>>,
    joints: &mut [f64],
) -> Result<(), SceneError> {
    for (name, value) in entries {
        let named = model
            .joints
            .iter()
            .find(|joint| joint.name == **name && joint.kind != JointKind::FreeFlyer);
        let Some(joint) = named else {
            let known = model.joints.iter().skip(1).map(|joint| joint.name.as_str());
            let is_this = |(locked, _): &&(String, f64)| *locked == **name;
            let locked = model.locked.iter().find(is_this);
            let user = locked.map_or("robot".to_owned(), |(joint, at)| {
                format!("robot, whose joint {joint:?} cannot move and is locked at {at},")
            });
            return Err(unknown_name(source, name, &user, "moving joint", known));
        };
        let position = source.finite(&format!("position of joint {:?}", joint.name), value)?;
        if position < joint.lower || position > joint.upper {
            let fault = Fault::JointLimit {
                joint: joint.name.clone(),
                value: position,
                lower: joint.lower,
                upper: joint.upper,
            };
            return Err(source.fault(value.span(), fault));
        }
        joints[joint.idx_q - BASE] = position;
    }
    Ok(())
}

/// The interfaces of the robot that a file lists.
pub(crate) fn robot_interfaces(
    source: &Source,
    model: &Model,
    entries: &[RobotInterfaceEntry],
    friction: Friction,
) -> Result<Vec<Interface>, SceneError> {
    entries
        .iter()
        .map(|entry| {
            let frame = model.frames.iter().position(|f| f.name == *entry.link);
            let Some(frame) = frame else {
                let user = format!("interface {:?}", *entry.name);
                let known = model.frames.iter().map(|frame| frame.name.as_str());
                return Err(unknown_name(source, &entry.link, &user, "link", known));
            };
            robot_interface(source, entry, frame, friction)
        })
        .collect()
}

/// The fault of a name that nothing has.
pub(crate) fn unknown_name<'a>(
    source: &Source,
    name: &At<String>,
    user: &str,
    kind: &'static str,
    known: impl Iterator<Item = &'a str>,
) -> SceneError {
    let known: Vec<&str> = known.collect();
    let fault = Fault::UnknownName {
        user: user.to_owned(),
        kind,
        name: (**name).clone(),
        nearest: nearest(name, known.iter().copied()).map(str::to_owned),
        known: list(&known),
    };
    source.fault(name.span(), fault)
}

/// Collision shapes per link. Capsules are put together again, other cylinders become boxes around them; meshes that are still
/// there are left out, with a note in the model of links that have nothing else.
fn collision_shapes(model: &mut Model) -> Vec<Vec<PlacedShape>> {
    let mut bare = Vec::new();
    let mut per_link = Vec::new();
    for frame in &model.frames {
        let mut used = vec![false; frame.shapes.len()];
        let mut shapes = Vec::new();
        for (index, placed) in frame.shapes.iter().enumerate() {
            if let Some(ends) = capsule_ends(&frame.shapes, index) {
                used[index] = true;
                for end in ends {
                    used[end] = true;
                }
                shapes.extend(capsule(placed));
            }
        }
        for (placed, _) in frame.shapes.iter().zip(&used).filter(|(_, used)| !**used) {
            shapes.extend(single_shape(placed));
        }
        if shapes.is_empty() && !frame.shapes.is_empty() {
            bare.push(frame.name.as_str());
        }
        per_link.push(shapes);
    }
    if !bare.is_empty() {
        let note = format!(
            "these links have meshes that could not be read, and no other shape: {}; give those that can touch something boxes, \
             spheres or capsules",
            bare.join(", ")
        );
        model.notes.push(note);
    }
    per_link
}

/// Indices of the two balls that round off the cylinder `index`: URDF has no capsule, so three elements stand for one.
fn capsule_ends(shapes: &[multibody::PlacedShape], index: usize) -> Option<[usize; 2]> {
    let multibody::Shape::Cylinder {
        radius,
        half_length,
    } = shapes[index].shape
    else {
        return None;
    };
    let ball_at = |z: f64| {
        let end = shapes[index]
            .frame_from_shape
            .act(Vector3::new(0.0, 0.0, z));
        shapes.iter().position(|other| match other.shape {
            multibody::Shape::Sphere { radius: ball } => {
                (ball - radius).abs() < CAPSULE_PLAY
                    && (other.frame_from_shape.origin() - end).norm() < CAPSULE_PLAY
            }
            _ => false,
        })
    };
    Some([ball_at(-half_length)?, ball_at(half_length)?])
}

/// The capsule of a cylinder with round ends.
fn capsule(cylinder: &multibody::PlacedShape) -> Option<PlacedShape> {
    match cylinder.shape {
        multibody::Shape::Cylinder {
            radius,
            half_length,
        } => Some(PlacedShape {
            body_from_shape: cylinder.frame_from_shape,
            shape: Shape::Capsule {
                radius,
                half_length,
            },
        }),
        _ => None,
    }
}

/// A shape that stands for itself; `None` for a mesh.
fn single_shape(placed: &multibody::PlacedShape) -> Option<PlacedShape> {
    let shape = match placed.shape {
        multibody::Shape::Box { half_size } => Shape::Box { half_size },
        multibody::Shape::Sphere { radius } => Shape::Sphere { radius },
        multibody::Shape::Capsule {
            radius,
            half_length,
        } => Shape::Capsule {
            radius,
            half_length,
        },
        multibody::Shape::Cylinder {
            radius,
            half_length,
        } => Shape::Box {
            half_size: Vector3::new(radius, radius, half_length),
        },
        multibody::Shape::Mesh { .. } => return None,
    };
    Some(PlacedShape {
        body_from_shape: placed.frame_from_shape,
        shape,
    })
}
