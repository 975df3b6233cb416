//! From the links and joints of a URDF to a [`Model`]: finds the root, walks the tree, merges what cannot move.

use crate::urdf::{self, Connection, Description, Limit};
use crate::{Frame, Joint, JointKind, Model, ModelError, Root};
use nalgebra::Vector3;
use spatial::{Inertia, Pose};

/// Name of the joint that a floating base gets.
const FLOATING_JOINT: &str = "root_joint";

/// Axes shorter than this have no direction.
const MIN_AXIS: f64 = 1e-9;

impl Model {
    /// A robot from the text of a URDF file, its root link floating or fixed.
    ///
    /// Joints come depth first, children in the order of the file. Fixed joints are merged. Joints that mimic another and
    /// joints of zero range are locked, geometry of unknown kind is skipped, damping and friction of joints are left out; each
    /// leaves a sentence in [`Model::notes`]. So does an effort or velocity limit that is missing or zero: it counts as unlimited.
    ///
    /// # Errors
    /// [`ModelError`] for everything that is no tree of rigid bodies with mass; no text makes it panic.
    pub fn from_urdf(text: &str, root: Root) -> Result<Self, ModelError> {
        let description = urdf::parse(text)?;
        let tree = Tree::new(&description)?;
        let mut walk = Walk {
            joints: Vec::new(),
            frames: Vec::new(),
            notes: description.notes.clone(),
            locked: Vec::new(),
            mimics: Vec::new(),
            without_range: Vec::new(),
            unlimited: Vec::new(),
            unlimited_speed: Vec::new(),
        };
        walk.run(&description, &tree, root)?;
        for (joints, what) in [
            (&walk.mimics, "joints that mimic another cannot move here"),
            (
                &walk.without_range,
                "joints with a range of zero cannot move",
            ),
        ] {
            walk.notes.extend(locked_note(joints, what));
        }
        walk.notes
            .extend(resistance_note(&description, &walk.joints));
        let mut model = Model::new(&description.name, walk.joints, walk.frames)
            .map_err(|error| name_the_link(error, &description))?;
        model.notes = walk.notes;
        model.locked = walk.locked;
        for (joints, limit, units) in [
            (walk.unlimited, "effort", "N·m or N"),
            (walk.unlimited_speed, "velocity", "rad/s or m/s"),
        ] {
            if !joints.is_empty() {
                model.notes.push(format!(
                    "no limit on the {limit} of {}: it is missing or 0 in the URDF; <limit {limit}=…> sets one [{units}]",
                    joints.join(", ")
                ));
            }
        }
        Ok(model)
    }
}

/// A joint without mass behind it is reported with its child link.
fn name_the_link(error: ModelError, description: &Description) -> ModelError {
    match error {
        ModelError::MissingInertia { joint, link } => {
            let connection = description
                .joints
                .iter()
                .find(|connection| connection.name == joint);
            let root = description.links.first().map(|link| link.name.clone());
            let link = connection
                .map(|connection| connection.child.clone())
                .or(root)
                .unwrap_or(link);
            ModelError::MissingInertia { joint, link }
        }
        other => other,
    }
}

/// Who hangs on whom, by index of link and joint.
struct Tree {
    root: usize,
    /// Per link its joints to children, in the order of the file.
    children: Vec<Vec<usize>>,
    /// Per joint its child link.
    child_of: Vec<usize>,
}

impl Tree {
    fn new(description: &Description) -> Result<Self, ModelError> {
        let links = &description.links;
        if links.is_empty() {
            return Err(ModelError::NoLinks {
                robot: description.name.clone(),
            });
        }
        let mut by_name: Vec<usize> = (0..links.len()).collect();
        by_name.sort_by_key(|&link| &links[link].name);
        let find = |joint: &Connection, name: &String| {
            let found = by_name.binary_search_by_key(&name, |&link| &links[link].name);
            found
                .map(|at| by_name[at])
                .map_err(|_| ModelError::UnknownLink {
                    joint: joint.name.clone(),
                    link: name.clone(),
                    nearest: nearest(name, links.iter().map(|link| link.name.as_str())).to_owned(),
                    line: joint.line,
                })
        };

        let mut parent_joint: Vec<Option<usize>> = vec![None; links.len()];
        let mut children = vec![Vec::new(); links.len()];
        let mut child_of = Vec::new();
        for (index, joint) in description.joints.iter().enumerate() {
            let (parent, child) = (find(joint, &joint.parent)?, find(joint, &joint.child)?);
            if let Some(first) = parent_joint[child].replace(index) {
                return Err(ModelError::TwoParents {
                    link: joint.child.clone(),
                    first: description.joints[first].name.clone(),
                    second: joint.name.clone(),
                });
            }
            children[parent].push(index);
            child_of.push(child);
        }
        let name_of = |link: usize| links[link].name.clone();
        let roots: Vec<usize> = (0..links.len())
            .filter(|&link| parent_joint[link].is_none())
            .collect();
        match roots[..] {
            [root] => Ok(Self {
                root,
                children,
                child_of,
            }),
            [] => Err(ModelError::Loop { link: name_of(0) }),
            _ => Err(ModelError::SeveralRoots {
                roots: roots.into_iter().map(name_of).collect(),
            }),
        }
    }
}

/// The joints and frames found so far.
struct Walk {
    joints: Vec<Joint>,
    frames: Vec<Frame>,
    notes: Vec<String>,
    locked: Vec<(String, f64)>,
    /// Joints that mimic another, and those with a range of zero: how they are locked.
    mimics: Vec<String>,
    without_range: Vec<String>,
    /// Joints without a limit on their effort, and on their velocity.
    unlimited: Vec<String>,
    unlimited_speed: Vec<String>,
}

/// A link to be visited.
struct Visit {
    link: usize,
    /// The joint of the file that leads to it; `None` for the root link.
    connection: Option<usize>,
    /// The moving joint that carries the parent link, and the pose of the parent link there.
    carrier: Option<usize>,
    carrier_from_parent: Pose,
}

impl Walk {
    fn run(
        &mut self,
        description: &Description,
        tree: &Tree,
        root: Root,
    ) -> Result<(), ModelError> {
        let carrier = (root == Root::Floating).then(|| self.push(floating_joint()));
        let mut open = vec![Visit {
            link: tree.root,
            connection: None,
            carrier,
            carrier_from_parent: Pose::identity(),
        }];
        let mut seen = vec![false; description.links.len()];
        while let Some(visit) = open.pop() {
            seen[visit.link] = true;
            let (carrier, carrier_from_link) = self.cross(description, &visit)?;
            self.attach(&description.links[visit.link], carrier, carrier_from_link);
            // Reversed, so that the first child of the file is on top of the stack.
            open.extend(
                tree.children[visit.link]
                    .iter()
                    .rev()
                    .map(|&connection| Visit {
                        link: tree.child_of[connection],
                        connection: Some(connection),
                        carrier,
                        carrier_from_parent: carrier_from_link,
                    }),
            );
        }
        match seen.iter().position(|seen| !seen) {
            Some(lost) => Err(ModelError::Loop {
                link: description.links[lost].name.clone(),
            }),
            None => Ok(()),
        }
    }

    /// The moving joint that carries the visited link, and the pose of the link there; makes the joint if there is one.
    fn cross(
        &mut self,
        description: &Description,
        visit: &Visit,
    ) -> Result<(Option<usize>, Pose), ModelError> {
        let Some(index) = visit.connection else {
            return Ok((visit.carrier, visit.carrier_from_parent));
        };
        let connection = &description.joints[index];
        let carrier_from_child = visit.carrier_from_parent * connection.parent_from_child;
        let Some((kind, lower, upper)) = motion_of(connection)? else {
            return Ok((visit.carrier, carrier_from_child));
        };
        if let Some(position) = locked_at(connection, lower, upper) {
            let name = &connection.name;
            match &connection.mimic {
                Some(mimic) => self
                    .mimics
                    .push(format!("{name:?} (of {:?}) at {position}", mimic.joint)),
                None => self.without_range.push(format!("{name:?} at {position}")),
            }
            self.locked.push((name.clone(), position));
            return Ok((
                visit.carrier,
                carrier_from_child * kind.displacement(position),
            ));
        }
        let effort = connection.limit.as_ref().map_or(0.0, |limit| limit.effort);
        if effort < 0.0 {
            return Err(ModelError::BadEffort {
                joint: connection.name.clone(),
                effort,
            });
        }
        if effort == 0.0 {
            self.unlimited.push(connection.name.clone());
        }
        let limit_or_infinite =
            |value: Option<f64>| value.filter(|x| *x > 0.0).unwrap_or(f64::INFINITY);
        let velocity = connection.limit.as_ref().map(|limit| limit.velocity);
        let velocity_limit = limit_or_infinite(velocity);
        if velocity_limit.is_infinite() {
            self.unlimited_speed.push(connection.name.clone());
        }
        let joint = self.push(Joint {
            name: connection.name.clone(),
            kind,
            parent: visit.carrier,
            parent_from_joint: carrier_from_child,
            lower,
            upper,
            velocity_limit,
            torque_limit: limit_or_infinite(Some(effort)),
            ..floating_joint()
        });
        Ok((Some(joint), Pose::identity()))
    }

    fn push(&mut self, joint: Joint) -> usize {
        self.joints.push(joint);
        self.joints.len() - 1
    }

    fn attach(&mut self, link: &urdf::Link, joint: Option<usize>, joint_from_frame: Pose) {
        if let Some(joint) = joint {
            let inertia = &mut self.joints[joint].inertia;
            *inertia = *inertia + link.inertia.transformed(&joint_from_frame);
        }
        let (name, shapes) = (link.name.clone(), link.shapes.clone());
        self.frames.push(Frame {
            name,
            joint,
            joint_from_frame,
            shapes,
        });
    }
}

/// The free flyer of a floating base, without mass yet; also the blank from which other joints are made.
fn floating_joint() -> Joint {
    Joint {
        name: FLOATING_JOINT.to_owned(),
        kind: JointKind::FreeFlyer,
        parent: None,
        parent_from_joint: Pose::identity(),
        inertia: Inertia::zero(),
        idx_q: 0,
        idx_v: 0,
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
        velocity_limit: f64::INFINITY,
        torque_limit: f64::INFINITY,
        torque_speed: None,
    }
}

/// Kind and limits of a joint that can move, `None` for a fixed one.
fn motion_of(connection: &Connection) -> Result<Option<(JointKind, f64, f64)>, ModelError> {
    let joint = || connection.name.clone();
    let axis = || -> Result<Vector3<f64>, ModelError> {
        let length = connection.axis.norm();
        if length > MIN_AXIS && length.is_finite() {
            Ok(connection.axis / length)
        } else {
            Err(ModelError::BadAxis {
                joint: joint(),
                length,
            })
        }
    };
    let range = |kind| match &connection.limit {
        None => Err(ModelError::MissingLimits {
            joint: joint(),
            kind,
        }),
        Some(Limit { lower, upper, .. }) if lower > upper => Err(ModelError::BadLimits {
            joint: joint(),
            lower: *lower,
            upper: *upper,
        }),
        Some(Limit { lower, upper, .. }) => Ok((*lower, *upper)),
    };
    let (kind, (lower, upper)) = match connection.kind.as_str() {
        "fixed" => return Ok(None),
        "revolute" => (JointKind::Revolute { axis: axis()? }, range("revolute")?),
        "continuous" => (
            JointKind::Revolute { axis: axis()? },
            (f64::NEG_INFINITY, f64::INFINITY),
        ),
        "prismatic" => (JointKind::Prismatic { axis: axis()? }, range("prismatic")?),
        other => {
            let (kind, line) = (other.to_owned(), connection.line);
            return Err(ModelError::UnsupportedJoint {
                joint: joint(),
                kind,
                line,
            });
        }
    };
    Ok(Some((kind, lower, upper)))
}

/// Position of a joint that cannot move on its own.
fn locked_at(connection: &Connection, lower: f64, upper: f64) -> Option<f64> {
    if let Some(mimic) = &connection.mimic {
        // the joint that it follows is at zero
        return Some(
            Some(mimic.offset)
                .filter(|at| at.is_finite())
                .unwrap_or(0.0),
        );
    }
    (lower == upper && lower.is_finite()).then_some(lower)
}

/// What is said of joints that are locked for one reason; the first few are named.
fn locked_note(joints: &[String], what: &str) -> Option<String> {
    const NAMED: usize = 4;
    let more = match joints.len().saturating_sub(NAMED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let named = joints[..joints.len().min(NAMED)].join(", ");
    (!joints.is_empty()).then(|| format!("{what} and are locked: {named}{more}"))
}

/// What `<dynamics>` says of the moving joints, none of which is in the equations of motion.
fn resistance_note(description: &Description, joints: &[Joint]) -> Option<String> {
    let connections = description.joints.iter();
    let moving = connections.filter(|c| joints.iter().any(|joint| joint.name == c.name));
    let resisted: Vec<_> = moving
        .filter(|c| c.damping != 0.0 || c.friction != 0.0)
        .collect();
    let largest = |of: fn(&Connection) -> f64| resisted.iter().map(|c| of(c)).fold(0.0, f64::max);
    let (damping, friction) = (largest(|c| c.damping), largest(|c| c.friction));
    (!resisted.is_empty()).then(|| {
        format!(
            "damping and friction of {} joints (<dynamics>: damping up to {damping} N·m·s/rad, friction up to {friction} N·m) \
             are left out, of the plan's URDF too: motors must give that much more than the plan's torques, and a controller has to add \
             it; lower the effort limits by it where it counts",
            resisted.len()
        )
    })
}

/// The candidate with the fewest edits (Levenshtein distance), the first of equals; empty if there is none.
fn nearest<'n>(name: &str, candidates: impl Iterator<Item = &'n str>) -> &'n str {
    candidates
        .min_by_key(|candidate| edits(name, candidate))
        .unwrap_or_default()
}

fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(x != *y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edits_count_insertions_deletions_and_replacements() {
        assert_eq!(edits("kitten", "sitting"), 3);
        assert_eq!(edits("", "abc"), 3);
        assert_eq!(
            nearest("left_foot_lnk", ["torso", "left_foot_link"].into_iter()),
            "left_foot_link"
        );
    }
}
