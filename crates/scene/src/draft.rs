//! A scene in the making: bodies and interfaces are known, poses and contacts follow.

use crate::robot::unknown_name;
use crate::rules::{self, Obstacle, possible_types};
use crate::source::{At, Source};
use crate::{Fault, Interface, Object, Owner, Robot, SceneError, StaticBody};
use spatial::Pose;
use std::ops::Range;
use symbolic::{ContactType, InterfaceId};

/// Bodies and interfaces of a scene.
pub(crate) struct Draft<'a> {
    pub source: &'a Source,
    pub robot: Robot,
    pub objects: Vec<Object>,
    pub statics: Vec<StaticBody>,
    pub interfaces: Vec<Interface>,
}

impl Draft<'_> {
    /// The interface that is written as `name`, for `user`.
    pub fn interface(&self, name: &At<String>, user: &str) -> Result<InterfaceId, SceneError> {
        let found = self.interfaces.iter().position(|i| i.name == **name);
        found.map(InterfaceId).ok_or_else(|| {
            let known = self.interfaces.iter().map(|i| i.name.as_str());
            unknown_name(self.source, name, user, "interface", known)
        })
    }

    /// The landing side and the other of a pair, with the types that are possible; `only` restricts the types.
    pub fn landing_pair(
        &self,
        span: Range<usize>,
        (first, second): (InterfaceId, InterfaceId),
        only: Option<ContactType>,
    ) -> Result<(InterfaceId, InterfaceId, Vec<ContactType>), SceneError> {
        let allowed = |kind: &ContactType| only.is_none_or(|only| only == *kind);
        let (x, y) = (&self.interfaces[first.0], &self.interfaces[second.0]);
        for (a, b) in [(first, second), (second, first)] {
            let (on, under) = (&self.interfaces[a.0], &self.interfaces[b.0]);
            let types: Vec<ContactType> = possible_types(on, under)
                .into_iter()
                .filter(allowed)
                .collect();
            if !types.is_empty() {
                return Ok((a, b, types));
            }
        }
        // of all failed tries, the one that came furthest says most; of equal ones the last, in the order of the file
        let obstacle = ContactType::ALL
            .iter()
            .filter(|kind| allowed(kind))
            .flat_map(|kind| [(y, x), (x, y)].map(|(a, b)| (rules::check(a, b, *kind).err(), a, b)))
            .filter_map(|(obstacle, a, b)| Some((obstacle?, a, b)))
            .max_by_key(|(obstacle, ..)| *obstacle)
            .unwrap_or((Obstacle::Type, x, y));
        let fault = impossible(obstacle, only);
        Err(self.source.fault(span, fault))
    }

    /// Pose of an interface of an object (at its start pose) or a static body in the world; `None` for the robot's.
    pub fn world_from_surface(&self, id: InterfaceId) -> Option<Pose> {
        let interface = &self.interfaces[id.0];
        match interface.owner {
            Owner::Robot { .. } => None,
            Owner::Object(index) => {
                Some(self.objects[index].world_from_start * interface.body_from_interface)
            }
            Owner::Static(_) => Some(interface.body_from_interface),
        }
    }
}

/// The fault of a pair that cannot touch.
fn impossible(
    (obstacle, a, b): (Obstacle, &Interface, &Interface),
    only: Option<ContactType>,
) -> Fault {
    let list = |i: &Interface| {
        let names: Vec<&str> = i.contact_types.iter().map(|kind| kind.name()).collect();
        names.join(", ")
    };
    let size = |i: &Interface| match i.half_size {
        Some([x, y]) => format!("{:.3} m × {:.3} m", 2.0 * x, 2.0 * y),
        None => "unbounded".to_owned(),
    };
    let (reason, remedy) = match obstacle {
        Obstacle::NeverLands => match (a.owner, b.owner) {
            (Owner::Static(_), Owner::Static(_)) => (
                "both belong to static bodies".to_owned(),
                "name an interface of the robot or of an object".to_owned(),
            ),
            _ => (
                "neither is made to land on the other".to_owned(),
                "set lands = true at the interface of the object that is to be set down".to_owned(),
            ),
        },
        Obstacle::SameBody => (
            "both belong to the same object".to_owned(),
            "name interfaces of two bodies".to_owned(),
        ),
        Obstacle::OntoRobot => (
            "nothing lands on the robot".to_owned(),
            "name one interface of the robot and one of another body".to_owned(),
        ),
        Obstacle::NoFeet => (
            format!("no foot may stand on {:?}", b.name),
            format!("leave out feet = false at {:?}", b.name),
        ),
        Obstacle::Type => {
            let wanted = only.map_or(String::new(), |kind| format!(" ({} asked for)", kind.name()));
            (
                format!(
                    "no contact type in common: one takes {}, the other {}{wanted}",
                    list(a),
                    list(b)
                ),
                "add a common type to the contacts of one of them".to_owned(),
            )
        }
        Obstacle::Shape => (
            "their common contact types need a patch where there is a point, or a point where there is a patch"
                .to_owned(),
            "unilateral_patch and bilateral_patch are for two patches, the point types for a point on a patch"
                .to_owned(),
        ),
        Obstacle::Size => (
            format!("{} does not fit onto {}", size(a), size(b)),
            format!(
                "set overhang = true at {:?} if it may reach beyond the edge",
                b.name
            ),
        ),
    };
    Fault::Impossible {
        a: a.name.clone(),
        b: b.name.clone(),
        reason,
        remedy,
    }
}
