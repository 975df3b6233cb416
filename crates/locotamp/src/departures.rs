//! Objects that the goal moves on what they stand on already.
//!
//! Where the goal's contacts of an object hold at the start and its regions do not, nothing of it is left to do for the symbols: a
//! manipulation that ends in the contacts it began with would be a loop. So the surface gets another name for the object to leave: the
//! same patch of the same body as an interface of its own, which bears the object at the start.

use nalgebra::Vector3;
use scene::{Owner, RegionGoal, Scene};
use spatial::Pose;
use symbolic::InterfaceId;

/// The scene with such surfaces, as [`crate::plan`] searches it; `None` if there is no such object.
pub fn with_places_to_leave(scene: &Scene) -> Option<Scene> {
    let mut changed = scene.clone();
    for goal in &scene.goal_contacts {
        let holds = |c: &&mut symbolic::Contact| {
            (c.a, c.b) == (goal.a, goal.b) || (c.a, c.b) == (goal.b, goal.a)
        };
        let Some(contact) = changed.start_contacts.iter_mut().find(holds) else {
            continue;
        };
        let Owner::Object(object) = scene.interfaces[contact.a.0].owner else {
            continue;
        };
        if !scene
            .goal_regions
            .iter()
            .any(|region| is_away(scene, object, region))
        {
            continue;
        }
        let mut place = scene.interfaces[contact.b.0].clone();
        place.name = unused_name(&changed.interfaces, &place.name);
        contact.b = InterfaceId(changed.interfaces.len());
        changed.interfaces.push(place);
    }
    (changed.interfaces.len() > scene.interfaces.len()).then_some(changed)
}

fn unused_name(interfaces: &[scene::Interface], name: &str) -> String {
    let mut name = format!("{name}_start");
    while interfaces.iter().any(|i| i.name == name) {
        name.push('_');
    }
    name
}

/// True if a region is one of an object, or of an interface of it, and does not hold at the start.
fn is_away(scene: &Scene, object: usize, region: &RegionGoal) -> bool {
    let start = scene.objects[object].world_from_start;
    let of_object = |i: &&scene::Interface| i.owner == Owner::Object(object);
    let mut interfaces = scene.interfaces.iter().filter(of_object);
    let pose = if region.body == scene.objects[object].name {
        start
    } else if let Some(interface) = interfaces.find(|i| i.name == region.body) {
        start * interface.body_from_interface
    } else {
        return false;
    };
    !holds(region, &pose)
}

fn holds(region: &RegionGoal, pose: &Pose) -> bool {
    let place = pose.origin();
    let inside = (0..3).all(|i| region.lower[i] <= place[i] && place[i] <= region.upper[i]);
    let axis = |of: Vector3<f64>| pose.rotate(of);
    let upright = region
        .tilt
        .is_none_or(|most| axis(Vector3::z()).z >= most.cos());
    let heads = region.yaw.is_none_or(|[least, most]| {
        let x = axis(Vector3::x());
        let from_middle = x.y.atan2(x.x) - f64::midpoint(least, most);
        from_middle.sin().atan2(from_middle.cos()).abs() <= 0.5 * (most - least)
    });
    inside && upright && heads
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain::skeletons;
    use std::path::Path;

    /// A can on a table that is to be turned to between these angles there.
    fn turned(least: f64, most: f64) -> Scene {
        let text = format!(
            "name = \"s\"\nrobot = \"g1\"\n[[static]]\nname = \"ground\"\nplane = true\n[[static]]\nname = \"table\"\n\
             size = [0.34, 0.7, 0.03]\nposition = [0.45, 0, 0.735]\n[[object]]\nname = \"can\"\nmass = 0.5\n\
             size = [0.08, 0.08, 0.2]\non = \"table_top\"\nposition = [-0.08, 0.1]\n[[object.interface]]\n\
             name = \"handle\"\nside = \"+y\"\ncontacts = [\"bilateral_patch\"]\n[goal]\n\
             contacts = [[\"can_bottom\", \"table_top\"]]\n[[goal.region]]\nbody = \"can\"\nyaw = [{least}, {most}]\n"
        );
        Scene::from_toml(&text, "s.toml", Path::new(".")).expect("a scene")
    }

    #[test]
    fn an_object_that_is_to_be_turned_where_it_stands_is_grasped_and_put_down() {
        let away = turned(1.5, 1.6);
        assert_eq!(skeletons(&away).unwrap().graph.shortest_skeleton(), Some(0));
        let changed = with_places_to_leave(&away).expect("a place to leave");
        let left = changed.interfaces.last().unwrap();
        assert_eq!(left.name, "table_top_start");
        let shortest = skeletons(&changed).unwrap().graph.shortest_skeleton();
        // Grasp, lift, place; it may stay in the hand.
        assert!(shortest.is_some_and(|n| n >= 3), "{shortest:?}");
        assert!(with_places_to_leave(&turned(-0.1, 0.1)).is_none());
    }
}
