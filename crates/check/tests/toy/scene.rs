//! What stands around the toy robot, and where it can touch.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use plan::{Extra, Geometry, Interface, InterfaceKind, Object, Pose7, Robot, StaticBody};

use super::planar::{Snapshot, xz};

const URDF: &str = include_str!("../toy.urdf");
/// Centre of the sole, seen from the leg [m].
pub(super) const SOLE_IN_LEG: [f64; 3] = [0.05, 0.0, -0.4];
/// Half the edge of the box [m].
pub(super) const BOX_HALF: f64 = 0.05;
/// [kg]
pub(super) const BOX_MASS: f64 = 1.2;
/// About every axis [kg m²].
pub(super) const BOX_INERTIA: f64 = 0.003;
pub(super) const NO_TURN: [f64; 4] = [0.0, 0.0, 0.0, 1.0];
const UPSIDE_DOWN: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

pub(super) fn pose7(p: Vector3<f64>, [x, y, z, w]: [f64; 4]) -> Pose7 {
    [p.x, p.y, p.z, x, y, z, w]
}

/// The toy robot.
pub(super) fn robot() -> Robot {
    Robot {
        name: "toy".into(),
        urdf: URDF.into(),
        joints: ["left_slide", "right_slide", "shoulder", "wrist"]
            .map(String::from)
            .to_vec(),
        torque_limits: Some(vec![Some(200.0), Some(200.0), Some(30.0), Some(10.0)]),
        torque_speed: BTreeMap::new(),
        extra: Extra::new(),
    }
}

/// The box.
pub(super) fn object() -> Object {
    Object {
        name: "box".into(),
        mass: BOX_MASS,
        inertia: [BOX_INERTIA, BOX_INERTIA, BOX_INERTIA, 0.0, 0.0, 0.0],
        geometry: vec![Geometry::cuboid(
            [BOX_HALF; 3],
            pose7(Vector3::zeros(), NO_TURN),
        )],
        extra: Extra::new(),
    }
}

pub(super) fn environment(start: &Snapshot) -> Vec<StaticBody> {
    let block = |name: &str, top: Vector3<f64>, half: f64| StaticBody {
        name: name.into(),
        geometry: vec![Geometry::cuboid(
            [half, half, 0.02],
            pose7(top - xz(0.0, 0.02), NO_TURN),
        )],
        extra: Extra::new(),
    };
    let ground = Geometry::half_space(pose7(Vector3::zeros(), NO_TURN));
    vec![
        StaticBody {
            name: "ground".into(),
            geometry: vec![ground],
            extra: Extra::new(),
        },
        block("table", start.palm - xz(0.0, 2.0 * BOX_HALF), 0.08),
        block("shelf", start.stick_tip, 0.05),
    ]
}

pub(super) fn interfaces(start: &Snapshot) -> Vec<Interface> {
    let interface =
        |name: &str, body: &str, at: Vector3<f64>, turn, kind, half: Option<[f64; 2]>| Interface {
            name: name.into(),
            body: body.into(),
            pose: pose7(at, turn),
            kind,
            half_size: half.map(|half| half.map(Some)),
            limb: None,
            extra: Extra::new(),
        };
    let (patch, point) = (InterfaceKind::Patch, InterfaceKind::Point);
    let sole = Some([0.12, 0.04]);
    vec![
        interface(
            "left_foot",
            "left_leg",
            SOLE_IN_LEG.into(),
            UPSIDE_DOWN,
            patch,
            sole,
        ),
        interface(
            "right_foot",
            "right_leg",
            SOLE_IN_LEG.into(),
            UPSIDE_DOWN,
            patch,
            sole,
        ),
        interface(
            "palm",
            "hand",
            xz(0.08, -0.03),
            UPSIDE_DOWN,
            patch,
            Some([0.02, 0.02]),
        ),
        interface("tip", "stick", xz(-0.4, -0.015), UPSIDE_DOWN, point, None),
        interface(
            "box_bottom",
            "box",
            xz(0.0, -BOX_HALF),
            UPSIDE_DOWN,
            patch,
            Some([BOX_HALF; 2]),
        ),
        interface(
            "box_top",
            "box",
            xz(0.0, BOX_HALF),
            NO_TURN,
            patch,
            Some([BOX_HALF; 2]),
        ),
        interface(
            "ground_top",
            "ground",
            Vector3::zeros(),
            NO_TURN,
            patch,
            None,
        ),
        interface(
            "table_top",
            "table",
            start.palm - xz(0.0, 2.0 * BOX_HALF),
            NO_TURN,
            patch,
            Some([0.08; 2]),
        ),
        interface(
            "shelf_top",
            "shelf",
            start.stick_tip,
            NO_TURN,
            patch,
            Some([0.05; 2]),
        ),
    ]
}
