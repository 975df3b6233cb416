//! Configuration of the robot and all contacts at the start.

use crate::draft::Draft;
use crate::file::{ContactEntry, ObjectEntry, StartEntry};
use crate::robot::{BASE, set_joints, unknown_name};
use crate::source::At;
use crate::touch::{Touch, millimetres, offset};
use crate::values::Orientation;
use crate::{Fault, Owner, Role, SceneError};
use multibody::Kinematics;
use nalgebra::Vector3;
use spatial::Pose;
use std::ops::Range;
use symbolic::{Contact, ContactType, InterfaceId};

/// A surface is looked for below a foot only if its normal has at least this vertical component.
const LEAST_UPWARD: f64 = 0.5;

/// Faces that are further from parallel are not named as the nearest support of a floating object [rad].
const NEARLY_PARALLEL: f64 = 0.2;

/// What lists contacts in a scene file, for messages.
const START_CONTACT: &str = "start contact";

/// The start of a scene.
pub(crate) struct Start {
    /// Base position, base quaternion, joints.
    pub q: Vec<f64>,
    pub contacts: Vec<Contact>,
}

/// A contact with the bytes that ask for it.
pub(crate) struct Asked {
    /// Of the first of `types`.
    pub contact: Contact,
    pub span: Range<usize>,
    /// All types that are possible and were not excluded.
    pub types: Vec<ContactType>,
}

/// Finds the start configuration and contacts, given those of the objects that were placed on something.
///
/// `fallback` are the bytes to blame where the file says nothing about the start.
pub(crate) fn start(
    draft: &Draft,
    entry: &StartEntry,
    objects: &[ObjectEntry],
    supports: Vec<Contact>,
    fallback: Range<usize>,
) -> Result<Start, SceneError> {
    let listed = entry
        .contacts
        .as_ref()
        .map(|list| {
            list.iter()
                .map(|c| listed_contact(draft, c, START_CONTACT))
                .collect()
        })
        .transpose()?;
    let base_span = entry
        .position
        .as_ref()
        .map_or(fallback, super::source::At::span);
    let mut q = configuration(draft, entry)?;
    let mut kinematics = Kinematics::new(&draft.robot.model);
    kinematics.update(&draft.robot.model, &q);
    let world = World {
        draft,
        kinematics: &kinematics,
    };
    let on_ground = entry
        .position
        .as_ref()
        .is_none_or(|position| position.0.len() == 2);
    let (asked, lift) = world.robot_contacts(listed, on_ground, &base_span)?;
    q[2] += lift;
    kinematics.update(&draft.robot.model, &q);
    let world = World {
        draft,
        kinematics: &kinematics,
    };
    for (index, Asked { contact, span, .. }) in asked.iter().enumerate() {
        if let Some(other) = asked[..index].iter().find(|o| o.contact.a == contact.a) {
            return Err(two_partners(draft, contact, &other.contact, span));
        }
    }
    for Asked { contact, span, .. } in &asked {
        world.require(contact, span)?;
    }
    let mut contacts: Vec<Contact> = asked.into_iter().map(|asked| asked.contact).collect();
    contacts.extend(supports);
    for (index, object) in objects.iter().enumerate() {
        if object.on.is_none() {
            world.support_object(index, object, &mut contacts)?;
        }
    }
    contacts.sort();
    contacts.dedup();
    Ok(Start { q, contacts })
}

/// The fault of an interface that lands on two others.
pub(crate) fn two_partners(
    draft: &Draft,
    contact: &Contact,
    other: &Contact,
    span: &Range<usize>,
) -> SceneError {
    let name = |id: InterfaceId| draft.interfaces[id.0].name.clone();
    let fault = Fault::Impossible {
        a: name(contact.a),
        b: name(contact.b),
        reason: format!("it is to touch {:?} as well", name(other.b)),
        remedy: "list one of the two".to_owned(),
    };
    draft.source.fault(span.clone(), fault)
}

/// Base pose, at height zero if none is given, and joints.
fn configuration(draft: &Draft, entry: &StartEntry) -> Result<Vec<f64>, SceneError> {
    let source = draft.source;
    let mut position = Vector3::zeros();
    if let Some(given) = &entry.position {
        if !(2..=3).contains(&given.0.len()) {
            let problem = "expected [x, y] or [x, y, z]";
            return Err(source.bad_keys(given.span(), "position of the start", problem));
        }
        source.coordinates("position of the start", given.span(), &given.0)?;
        for (i, value) in given.0.iter().enumerate() {
            position[i] = *value;
        }
    }
    let orientation = Orientation {
        yaw: entry.yaw.as_ref(),
        quaternion: entry.quaternion.as_ref(),
    };
    let world_from_base = source.pose("the start", position, &orientation)?;
    let mut q = world_from_base.to_xyzquat().to_vec();
    q.extend(&draft.robot.home);
    set_joints(source, &draft.robot.model, &entry.joints, &mut q[BASE..])?;
    Ok(q)
}

/// A contact that a file lists, for `user`.
pub(crate) fn listed_contact(
    draft: &Draft,
    entry: &At<ContactEntry>,
    user: &str,
) -> Result<Asked, SceneError> {
    let (first, second, kind) = match entry.0.as_slice() {
        [first, second] => (first, second, None),
        [first, second, kind] => (first, second, Some(kind)),
        _ => {
            let problem = "expected [interface, interface] or [interface, interface, type]";
            return Err(draft.source.bad_keys(entry.span(), user, problem));
        }
    };
    let only = kind
        .map(|name| contact_type(draft, name, user))
        .transpose()?;
    let pair = (
        draft.interface(first, user)?,
        draft.interface(second, user)?,
    );
    let (a, b, types) = draft.landing_pair(entry.span(), pair, only)?;
    Ok(Asked {
        contact: Contact {
            a,
            b,
            kind: types[0],
        },
        span: entry.span(),
        types,
    })
}

fn contact_type(draft: &Draft, name: &At<String>, user: &str) -> Result<ContactType, SceneError> {
    let found = ContactType::ALL
        .into_iter()
        .find(|kind| kind.name() == **name);
    found.ok_or_else(|| {
        let known = ContactType::ALL.iter().map(|kind| kind.name());
        unknown_name(draft.source, name, user, "contact type", known)
    })
}

/// The scene at a configuration of the robot.
struct World<'a> {
    draft: &'a Draft<'a>,
    kinematics: &'a Kinematics,
}

impl World<'_> {
    fn pose(&self, id: InterfaceId) -> Pose {
        let interface = &self.draft.interfaces[id.0];
        match interface.owner {
            Owner::Robot { frame } => {
                let model = &self.draft.robot.model;
                self.kinematics.frame_pose(model, frame) * interface.body_from_interface
            }
            _ => self
                .draft
                .world_from_surface(id)
                .unwrap_or_else(Pose::identity),
        }
    }

    fn touch(&self, contact: &Contact) -> Touch {
        let interfaces = &self.draft.interfaces;
        Touch::measure(
            contact.kind,
            (&interfaces[contact.a.0], &self.pose(contact.a)),
            (&interfaces[contact.b.0], &self.pose(contact.b)),
        )
    }

    fn require(&self, contact: &Contact, span: &Range<usize>) -> Result<(), SceneError> {
        let Some(gap) = self.touch(contact).gap() else {
            return Ok(());
        };
        let fault = Fault::Broken {
            a: self.draft.interfaces[contact.a.0].name.clone(),
            b: self.draft.interfaces[contact.b.0].name.clone(),
            gap,
        };
        Err(self.draft.source.fault(span.clone(), fault))
    }

    /// Contacts of the robot, listed or found below its feet, and how far the base must be lifted for them [m].
    fn robot_contacts(
        &self,
        listed: Option<Vec<Asked>>,
        on_ground: bool,
        base_span: &Range<usize>,
    ) -> Result<(Vec<Asked>, f64), SceneError> {
        let asked = match listed {
            Some(listed) => listed,
            None => self.feet_on_surfaces(on_ground, base_span)?,
        };
        if !on_ground {
            return Ok((asked, 0.0));
        }
        // the lowest foot touches, the others must then touch as well or are found out
        let lift = asked
            .iter()
            .filter(|asked| self.draft.interfaces[asked.contact.a.0].role == Role::Foot)
            .filter_map(|asked| self.height_above(asked.contact.a, asked.contact.b))
            .map(|height| -height)
            .reduce(f64::max);
        if let Some(lift) = lift {
            return Ok((asked, lift));
        }
        let mut feet = self.draft.interfaces.iter();
        let why = if feet.any(|i| i.role == Role::Foot) {
            "no foot is on an upward surface"
        } else {
            "the robot has no interface with role = \"foot\""
        };
        let reason = format!("the height of the base is not given and {why}");
        Err(self.no_ground(base_span, &reason))
    }

    /// Every foot on the surface below it.
    fn feet_on_surfaces(
        &self,
        highest: bool,
        base_span: &Range<usize>,
    ) -> Result<Vec<Asked>, SceneError> {
        let interfaces = &self.draft.interfaces;
        let feet: Vec<InterfaceId> = (0..interfaces.len())
            .map(InterfaceId)
            .filter(|id| interfaces[id.0].role == Role::Foot)
            .collect();
        let below: Vec<Vec<(InterfaceId, f64)>> =
            feet.iter().map(|foot| self.surfaces_under(*foot)).collect();
        let common = below.first().and_then(|first| {
            first
                .iter()
                .filter(|(b, _)| below.iter().all(|list| list.iter().any(|(c, _)| c == b)))
                .min_by(|x, y| rank(x.1, highest).total_cmp(&rank(y.1, highest)))
        });
        let mut asked = Vec::new();
        for (foot, surfaces) in feet.iter().zip(&below) {
            let nearest = surfaces
                .iter()
                .min_by(|x, y| rank(x.1, highest).total_cmp(&rank(y.1, highest)));
            let Some((b, _)) = common.or(nearest) else {
                let at = self.pose(*foot).origin();
                let name = &interfaces[foot.0].name;
                let reason = format!(
                    "{name:?} at x = {:.3} m, y = {:.3} m is over no surface that it can stand on",
                    at.x, at.y
                );
                return Err(self.no_ground(base_span, &reason));
            };
            if let Some(kind) = self.standing_type(*foot, *b) {
                asked.push(Asked {
                    contact: Contact {
                        a: *foot,
                        b: *b,
                        kind,
                    },
                    span: base_span.clone(),
                    types: vec![kind],
                });
            }
        }
        Ok(asked)
    }

    /// Upward surfaces that the origin of a foot is over or under, with its height above them [m].
    fn surfaces_under(&self, foot: InterfaceId) -> Vec<(InterfaceId, f64)> {
        let interfaces = &self.draft.interfaces;
        (0..interfaces.len())
            .map(InterfaceId)
            .filter(|b| self.standing_type(foot, *b).is_some())
            .filter_map(|b| {
                let height = self.height_above(foot, b)?;
                let below = self.pose(foot).origin() - Vector3::z() * height;
                let in_surface = self.pose(b).inverse().act(below);
                let inside = interfaces[b.0]
                    .half_size
                    .is_none_or(|[x, y]| in_surface.x.abs() <= x && in_surface.y.abs() <= y);
                inside.then_some((b, height))
            })
            .collect()
    }

    /// The first unilateral type with which a foot can stand on a surface.
    fn standing_type(&self, foot: InterfaceId, b: InterfaceId) -> Option<ContactType> {
        let interfaces = &self.draft.interfaces;
        crate::rules::possible_types(&interfaces[foot.0], &interfaces[b.0])
            .into_iter()
            .find(|kind| kind.is_unilateral())
    }

    /// Vertical distance of the origin of `a` above the plane of `b` [m]; `None` unless `b` faces up.
    fn height_above(&self, a: InterfaceId, b: InterfaceId) -> Option<f64> {
        let world_from_b = self.pose(b);
        let upward = world_from_b.rotation()[(2, 2)];
        let height = world_from_b.inverse().act(self.pose(a).origin()).z;
        (upward >= LEAST_UPWARD).then(|| height / upward)
    }

    fn no_ground(&self, span: &Range<usize>, reason: &str) -> SceneError {
        let fault = Fault::NoGround {
            reason: reason.to_owned(),
        };
        self.draft.source.fault(span.clone(), fault)
    }

    /// Adds the contacts of an object that the file places in the world; it needs at least one.
    fn support_object(
        &self,
        index: usize,
        entry: &ObjectEntry,
        contacts: &mut Vec<Contact>,
    ) -> Result<(), SceneError> {
        let interfaces = &self.draft.interfaces;
        let mine = |id: InterfaceId| interfaces[id.0].owner == Owner::Object(index);
        let candidates = self.landings(index);
        for (contact, touch) in &candidates {
            if touch.holds() && contacts.iter().all(|c| c.a != contact.a) {
                contacts.push(*contact);
            }
        }
        if contacts.iter().any(|c| mine(c.a) || mine(c.b)) {
            return Ok(());
        }
        let nearest = candidates
            .iter()
            .filter(|(_, touch)| touch.angle < NEARLY_PARALLEL)
            .min_by(|x, y| badness(&x.1).total_cmp(&badness(&y.1)));
        let nearest = match nearest {
            Some((contact, touch)) => self.describe_miss(contact, touch),
            None => "none of its interfaces faces a surface that it could stand on".to_owned(),
        };
        let fault = Fault::Floating {
            object: (*entry.name).clone(),
            nearest,
        };
        let span = entry
            .position
            .as_ref()
            .map_or(entry.name.span(), super::source::At::span);
        Err(self.draft.source.fault(span, fault))
    }

    /// All ways in which an object could stand on something, with its distances from doing so.
    fn landings(&self, index: usize) -> Vec<(Contact, Touch)> {
        let interfaces = &self.draft.interfaces;
        let kind = ContactType::UnilateralPatch;
        let ids = || (0..interfaces.len()).map(InterfaceId);
        ids()
            .filter(|a| interfaces[a.0].owner == Owner::Object(index))
            .flat_map(|a| ids().map(move |b| Contact { a, b, kind }))
            .filter(|c| crate::rules::check(&interfaces[c.a.0], &interfaces[c.b.0], kind).is_ok())
            .map(|contact| (contact, self.touch(&contact)))
            .collect()
    }

    /// "red_box_bottom is nearest to table_top: it is 3.0 mm above the surface".
    fn describe_miss(&self, contact: &Contact, touch: &Touch) -> String {
        let name = |id: InterfaceId| &self.draft.interfaces[id.0].name;
        let mut parts = vec![offset(touch.height)];
        if touch.outside > 0.0 {
            parts.push(format!(
                "reaches {} beyond the edge",
                millimetres(touch.outside)
            ));
        }
        if touch.angle > 0.0 {
            parts.push(format!("{:.2}° from parallel", touch.angle.to_degrees()));
        }
        let (a, b) = (name(contact.a), name(contact.b));
        format!("{a:?} is nearest to {b:?}: {}", parts.join(", "))
    }
}

/// Least is best: the highest surface, or the one at the smallest distance.
fn rank(height: f64, highest: bool) -> f64 {
    if highest { height } else { height.abs() }
}

/// Distance of a face from lying on a surface [m].
fn badness(touch: &Touch) -> f64 {
    touch.height.abs() + touch.outside
}
