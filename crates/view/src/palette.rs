//! Colours of bodies and contacts: the same as in the page (`viewer/src/colors.ts`).

use plan::{Interface, Plan};

const NAMED: [(&str, &str); 8] = [
    ("red", "#d8473c"),
    ("green", "#3d9b55"),
    ("blue", "#3f7fd6"),
    ("yellow", "#d9ab35"),
    ("orange", "#e08a2c"),
    ("purple", "#8f6bc7"),
    ("white", "#c9ccd1"),
    ("black", "#4a4d55"),
];
const STATIC: [&str; 6] = [
    "#b18b5a", "#4f9d97", "#8d7cc4", "#c07a9c", "#8aa352", "#6d8fb8",
];
const OBJECT: [&str; 5] = ["#d8473c", "#3d9b55", "#3f7fd6", "#d9ab35", "#8f6bc7"];
const GROUND: &str = "#7f8a99";
const LEFT: &str = "#2d8fd5";
const RIGHT: &str = "#ee8d2b";
const OTHER: &str = "#8f6bc7";

/// Colour of an object: what its name says, or by its place.
pub(crate) fn of_object(plan: &Plan, index: usize) -> String {
    let words = plan.objects[index].name.split('_');
    let mut named = words.filter_map(|word| NAMED.iter().find(|(name, _)| *name == word));
    named
        .next()
        .map_or(OBJECT[index % OBJECT.len()], |(_, color)| color)
        .to_owned()
}

/// Colour of a static body: grey for the ground, the others by their place.
pub(crate) fn of_static(plan: &Plan, name: &str) -> String {
    let mut next = STATIC.iter().cycle();
    for body in &plan.environment {
        let is_ground = body.geometry.iter().any(plan::Geometry::is_plane);
        let color = if is_ground {
            GROUND
        } else {
            next.next().expect("a cycle has no end")
        };
        if body.name == name {
            return color.to_owned();
        }
    }
    OTHER.to_owned()
}

/// Colour of what an interface belongs to; of a robot's, its side.
pub(crate) fn of_interface(plan: &Plan, interface: &Interface) -> String {
    if let Some(index) = plan.objects.iter().position(|x| x.name == interface.body) {
        return of_object(plan, index);
    }
    if plan.environment.iter().any(|x| x.name == interface.body) {
        return of_static(plan, &interface.body);
    }
    let mut sides = interface.name.split('_').filter_map(|word| match word {
        "left" | "l" => Some(LEFT),
        "right" | "r" => Some(RIGHT),
        _ => None,
    });
    sides.next().unwrap_or(OTHER).to_owned()
}

/// `#rrggbb` as red, green, blue from 0 to 1.
pub(crate) fn to_rgb(color: &str) -> [f64; 3] {
    [1, 3, 5].map(|at| {
        let part = color
            .get(at..at + 2)
            .and_then(|x| u8::from_str_radix(x, 16).ok());
        f64::from(part.unwrap_or(128)) / 255.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_colour_is_three_shares() {
        assert_eq!(to_rgb("#ff8000"), [1.0, 128.0 / 255.0, 0.0]);
    }
}
