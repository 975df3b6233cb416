//! Numbers of a scene that a user can change, one at a time: their value, their name, and the scene with another value.

use multibody::JointKind;
use nalgebra::{Matrix3, Vector3};
use scene::{Owner, Scene, Shape};
use spatial::Pose;

/// Least size of an object that is told [m].
const LEAST_WIDTH: f64 = 0.03;
/// Cosine of an axis of an interface with one of its body that counts as the same direction.
pub(super) const ALONG: f64 = 0.999;

/// One number. Indices: objects, interfaces, joints of the robot, static bodies, goal regions of the scene; axes 0 to 2 are
/// x, y, z of the world.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Knob {
    /// Mass of an object; its inertia scales with it.
    Mass(usize),
    /// Sliding friction coefficient of surfaces, the smallest of them; smaller ones are raised to the new value.
    Friction(Vec<usize>),
    /// Torsional friction coefficient, likewise.
    Torsion(Vec<usize>),
    /// Torque limit of joints, the smallest of them; smaller ones are raised to the new value.
    Torque(Vec<usize>),
    /// Factor on all torque limits.
    AllTorques,
    /// Velocity limit of joints, likewise.
    Velocity(Vec<usize>),
    /// Lower or (true) upper end of a joint's range.
    Range(usize, bool),
    /// Largest force through a contact of interfaces, the smallest of them; smaller ones are raised.
    Force(Vec<usize>),
    /// Largest moment, likewise.
    Moment(Vec<usize>),
    /// Longest phase.
    Longest,
    /// Shortest phase.
    Shortest,
    /// Coordinate of a static body with what stands on it.
    Static(usize, usize),
    /// Horizontal coordinate of an object at the start.
    Object(usize, usize),
    /// Size of an object that is one box, along a horizontal axis of its own.
    Width(usize, usize),
    /// Lower or (true) upper bound of a goal region on an axis.
    Goal(usize, usize, bool),
}

/// Smallest of some numbers.
fn least(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(f64::INFINITY, f64::min)
}

impl Knob {
    /// True for numbers that are compared by ratio, false for lengths and angles.
    pub fn is_ratio(&self) -> bool {
        !matches!(
            self,
            Self::Static(..)
                | Self::Object(..)
                | Self::Width(..)
                | Self::Goal(..)
                | Self::Range(..)
        )
    }

    /// Its value in a scene.
    pub fn value(&self, scene: &Scene) -> f64 {
        let interfaces = &scene.interfaces;
        let joints = &scene.robot.model.joints;
        match self {
            Self::Mass(o) => scene.objects[*o].mass,
            Self::Friction(of) => least(of.iter().map(|&i| interfaces[i].mu)),
            Self::Torsion(of) => least(of.iter().map(|&i| interfaces[i].mu_r)),
            Self::Torque(of) => least(of.iter().map(|&j| joints[j].torque_limit)),
            Self::AllTorques => 1.0,
            Self::Velocity(of) => least(of.iter().map(|&j| joints[j].velocity_limit)),
            Self::Range(j, false) => joints[*j].lower,
            Self::Range(j, true) => joints[*j].upper,
            Self::Force(of) => least(of.iter().map(|&i| interfaces[i].max_force)),
            Self::Moment(of) => least(of.iter().map(|&i| interfaces[i].max_moment)),
            Self::Longest => scene.optimiser.max_duration,
            Self::Shortest => scene.optimiser.min_duration,
            Self::Static(s, axis) => body_origin(scene, *s)[*axis],
            Self::Object(o, axis) => scene.objects[*o].world_from_start.origin()[*axis],
            Self::Width(o, axis) => width(scene, *o, *axis).unwrap_or(f64::NAN),
            Self::Goal(r, axis, false) => scene.goal_regions[*r].lower[*axis],
            Self::Goal(r, axis, true) => scene.goal_regions[*r].upper[*axis],
        }
    }

    /// The scene with another value.
    pub fn with(&self, scene: &Scene, to: f64) -> Scene {
        let change = to - self.value(scene);
        let mut scene = scene.clone();
        let raise = |x: &mut f64| *x = x.max(to);
        let joints = &mut scene.robot.model.joints;
        match self {
            Self::Mass(o) => {
                let object = &mut scene.objects[*o];
                object.inertia *= to / object.mass;
                object.mass = to;
            }
            Self::Friction(of) => of.iter().for_each(|&i| raise(&mut scene.interfaces[i].mu)),
            Self::Torsion(of) => of
                .iter()
                .for_each(|&i| raise(&mut scene.interfaces[i].mu_r)),
            Self::Torque(of) => of.iter().for_each(|&j| raise(&mut joints[j].torque_limit)),
            Self::AllTorques => joints.iter_mut().for_each(|j| j.torque_limit *= to),
            Self::Velocity(of) => of
                .iter()
                .for_each(|&j| raise(&mut joints[j].velocity_limit)),
            Self::Range(j, false) => joints[*j].lower = to,
            Self::Range(j, true) => joints[*j].upper = to,
            Self::Force(of) => of
                .iter()
                .for_each(|&i| raise(&mut scene.interfaces[i].max_force)),
            Self::Moment(of) => of
                .iter()
                .for_each(|&i| raise(&mut scene.interfaces[i].max_moment)),
            Self::Longest => scene.optimiser.max_duration = to,
            Self::Shortest => scene.optimiser.min_duration = to,
            Self::Static(s, axis) => {
                let offset = Vector3::ith(*axis, change);
                move_static(&mut scene, *s, &offset);
            }
            Self::Object(o, axis) => {
                let pose = &mut scene.objects[*o].world_from_start;
                *pose = moved(pose, &Vector3::ith(*axis, change));
            }
            Self::Width(o, axis) => widen(&mut scene, *o, *axis, to / (to - change)),
            Self::Goal(r, axis, false) => scene.goal_regions[*r].lower[*axis] = to,
            Self::Goal(r, axis, true) => scene.goal_regions[*r].upper[*axis] = to,
        }
        scene
    }

    /// Which ways it may be changed: 1 up, −1 down.
    pub fn directions(&self) -> &'static [f64] {
        match self {
            Self::Mass(_)
            | Self::Shortest
            | Self::Width(..)
            | Self::Goal(_, _, false)
            | Self::Range(_, false) => &[-1.0],
            Self::Static(..) | Self::Object(..) => &[1.0, -1.0],
            _ => &[1.0],
        }
    }

    /// Values to try in a direction, the nearest first; the last is as far as makes sense.
    pub fn ladder(&self, scene: &Scene, direction: f64) -> Vec<f64> {
        let now = self.value(scene);
        match self {
            Self::Mass(_) => vec![now * 0.05],
            Self::Friction(_) => vec![now.max(2.0)],
            Self::Torsion(_) => vec![now.max(0.3)],
            Self::Torque(_) | Self::AllTorques | Self::Force(_) | Self::Moment(_) => {
                vec![now * 20.0]
            }
            Self::Velocity(_) => vec![now * 10.0],
            Self::Longest => vec![now * 4.0],
            Self::Shortest => vec![now * 0.2],
            Self::Range(..) => [0.3, 1.0].map(|d| now + direction * d).to_vec(),
            Self::Object(..) => [0.05, 0.1, 0.2].map(|d| now + direction * d).to_vec(),
            Self::Width(..) => {
                let wide = |size: &f64| *size >= LEAST_WIDTH;
                let steps = [0.05, 0.1, 0.2, 0.4, 0.7].map(|d| now + direction * d);
                steps.into_iter().filter(wide).collect()
            }
            Self::Static(..) => [0.1, 0.2, 0.4, 0.7, 1.0]
                .map(|d| now + direction * d)
                .to_vec(),
            Self::Goal(..) => [0.1, 0.4, 1.2, 4.0].map(|d| now + direction * d).to_vec(),
        }
    }

    /// The scene with the value as far in its favour as makes sense; of numbers that go one way only.
    pub fn relaxed(&self, scene: &Scene, base: &Scene) -> Scene {
        let direction = self.directions()[0];
        match self.ladder(base, direction).last() {
            Some(&far) => self.with(scene, far),
            None => scene.clone(),
        }
    }

    /// A value between, on the grid on which remedies are told: two figures, or centimetres; `None` if there is none.
    pub fn between(&self, refused: f64, accepted: f64) -> Option<f64> {
        let direction = (accepted - refused).signum();
        let middle = if self.is_ratio() && refused > 0.0 {
            (refused * accepted).sqrt()
        } else {
            0.5 * (refused + accepted)
        };
        let rounded = self.rounded(middle, direction);
        let inside =
            (rounded - refused) * direction > 0.0 && (accepted - rounded) * direction > 0.0;
        let close = self.is_ratio() && (accepted / refused).ln().abs() < 0.08;
        (inside && !close).then_some(rounded)
    }

    /// The next value of the grid, away from the present one.
    pub fn rounded(&self, value: f64, direction: f64) -> f64 {
        let step = if self.is_ratio() {
            10f64.powf(value.abs().log10().floor() - 1.0)
        } else {
            0.01
        };
        let steps = direction * (direction * value / step - 1e-6).ceil();
        // Division by a whole number gives the decimal fraction that is nearest.
        if step < 1.0 {
            steps / (1.0 / step).round()
        } else {
            steps * step
        }
    }

    /// How large a change is, to compare different numbers: the logarithm of a ratio, or 30 cm (or rad) as one; half of it
    /// for a number that is unusual now, twice it for one that would become so and for what a robot is built with.
    pub fn size(&self, scene: &Scene, to: f64) -> f64 {
        let from = self.value(scene);
        let size = if self.is_ratio() {
            (to / from.max(1e-3)).ln().abs()
        } else {
            (to - from).abs() / 0.3
        };
        match (self.is_unusual(scene, from), self.is_unusual(scene, to)) {
            (true, _) => 0.5 * size,
            (_, true) => 2.0 * size,
            _ if matches!(self, Self::Range(..) | Self::Velocity(_)) => 2.0 * size,
            _ => size,
        }
    }

    /// Friction of ice or glue, objects of more than a tenth of the robot's mass.
    fn is_unusual(&self, scene: &Scene, value: f64) -> bool {
        match self {
            Self::Friction(_) => !(0.25..=1.2).contains(&value),
            Self::Mass(_) => value > 0.1 * scene.robot.model.total_mass(),
            _ => false,
        }
    }

    /// Unit of its value.
    pub fn unit(&self, scene: &Scene) -> &'static str {
        let joints = &scene.robot.model.joints;
        let prismatic = |j: &usize| matches!(joints[*j].kind, JointKind::Prismatic { .. });
        match self {
            Self::Mass(_) => "kg",
            Self::Friction(_) | Self::AllTorques => "",
            Self::Torque(of) if of.iter().all(prismatic) => "N",
            Self::Velocity(of) if of.iter().all(prismatic) => "m/s",
            Self::Range(j, _) if prismatic(j) => "m",
            Self::Torque(_) | Self::Moment(_) => "N m",
            Self::Velocity(_) => "rad/s",
            Self::Range(..) => "rad",
            Self::Force(_) => "N",
            Self::Longest | Self::Shortest => "s",
            Self::Torsion(_)
            | Self::Static(..)
            | Self::Object(..)
            | Self::Width(..)
            | Self::Goal(..) => "m",
        }
    }
}

/// Size of an object that is one box, along an axis of its own; `None` for any other.
pub(super) fn width(scene: &Scene, object: usize, axis: usize) -> Option<f64> {
    let [placed] = scene.objects[object].shapes.as_slice() else {
        return None;
    };
    let straight = (placed.body_from_shape.rotation() - Matrix3::identity()).norm() < 1e-6;
    match placed.shape {
        Shape::Box { half_size } if straight => Some(2.0 * half_size[axis]),
        _ => None,
    }
}

/// Stretches an object that is one box along an axis of its own, with its interfaces; it keeps its mass.
fn widen(scene: &mut Scene, object: usize, axis: usize, factor: f64) {
    let along = |mut v: Vector3<f64>| {
        v[axis] *= factor;
        v
    };
    let stretched = |pose: &Pose| Pose::from_parts(*pose.rotation(), along(pose.origin()));
    let body = &mut scene.objects[object];
    for placed in &mut body.shapes {
        placed.body_from_shape = stretched(&placed.body_from_shape);
        if let Shape::Box { half_size } = &mut placed.shape {
            *half_size = along(*half_size);
        }
    }
    // ∫ r rᵀ dm = ½ tr(I) 1 − I, and back.
    let mut second = Matrix3::identity() * (0.5 * body.inertia.trace()) - body.inertia;
    for i in 0..3 {
        second[(axis, i)] *= factor;
        second[(i, axis)] *= factor;
    }
    body.inertia = Matrix3::identity() * second.trace() - second;
    let own = Owner::Object(object);
    for interface in scene.interfaces.iter_mut().filter(|i| i.owner == own) {
        let pose = &mut interface.body_from_interface;
        for (i, half) in interface.half_size.iter_mut().flatten().enumerate() {
            if pose.rotate(Vector3::ith(i, 1.0))[axis].abs() > ALONG {
                *half *= factor;
            }
        }
        *pose = stretched(pose);
    }
}

/// Where a static body is: the centre of its first shape, which is its position in a file that gives `size`.
fn body_origin(scene: &Scene, body: usize) -> Vector3<f64> {
    scene.statics[body].shapes[0].body_from_shape.origin()
}

fn moved(pose: &Pose, offset: &Vector3<f64>) -> Pose {
    Pose::from_parts(*pose.rotation(), pose.origin() + offset)
}

/// Moves a static body, its interfaces and the objects that stand on it, also on one another.
fn move_static(scene: &mut Scene, body: usize, offset: &Vector3<f64>) {
    for placed in &mut scene.statics[body].shapes {
        placed.body_from_shape = moved(&placed.body_from_shape, offset);
    }
    let own = Owner::Static(body);
    for interface in scene.interfaces.iter_mut().filter(|i| i.owner == own) {
        interface.body_from_interface = moved(&interface.body_from_interface, offset);
    }
    let mut carried = vec![own];
    let mut next = 0;
    while next < carried.len() {
        for contact in &scene.start_contacts {
            let (a, b) = (contact.a.0, contact.b.0);
            let (above, below) = (scene.interfaces[a].owner, scene.interfaces[b].owner);
            if let (Owner::Object(o), true) = (above, below == carried[next])
                && !carried.contains(&above)
            {
                let pose = &mut scene.objects[o].world_from_start;
                *pose = moved(pose, offset);
                carried.push(above);
            }
        }
        next += 1;
    }
}

/// True for a body that is no half-space.
pub(super) fn can_move(scene: &Scene, body: usize) -> bool {
    let shapes = &scene.statics[body].shapes;
    !shapes.is_empty() && shapes.iter().all(|s| s.shape != Shape::HalfSpace)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn a_box_with_another_width_is_the_one_of_a_scene_file_with_that_size() {
        let text = Scene::builtin_text("lift-box").expect("a scene");
        let scene = |size: &str| {
            let text = text.replace("size = [0.10, 0.25, 0.20]", size);
            Scene::from_toml(&text, "scene.toml", Path::new(".")).expect("a scene")
        };
        let narrow = scene("size = [0.10, 0.25, 0.20]");
        let (wide, expected) = (
            Knob::Width(0, 1).with(&narrow, 0.4),
            scene("size = [0.10, 0.40, 0.20]"),
        );
        let [one, other] = [&wide, &expected].map(|scene| &scene.objects[0]);
        assert!((one.inertia - other.inertia).norm() < 1e-12);
        let half = |scene: &Scene| match scene.objects[0].shapes[0].shape {
            Shape::Box { half_size } => half_size,
            _ => panic!("a box"),
        };
        assert!((half(&wide) - half(&expected)).norm() < 1e-12);
        for (one, other) in wide.interfaces.iter().zip(&expected.interfaces) {
            let moved = one.body_from_interface.origin() - other.body_from_interface.origin();
            assert!(moved.norm() < 1e-12, "{}", one.name);
            let halves = one
                .half_size
                .into_iter()
                .flatten()
                .zip(other.half_size.into_iter().flatten());
            for (one_half, other_half) in halves {
                assert!((one_half - other_half).abs() < 1e-12, "{}", one.name);
            }
        }
    }
}
