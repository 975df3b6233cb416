//! Geoms as collision and visual elements of a URDF.

use crate::inertia::body_from_geom;
use crate::pose::between;
use crate::urdf::{number, numbers, origin, quoted};
use mjcf_rs::Model;
use mjcf_rs::body::{Geom, GeomType};
use nalgebra::Vector3;
use spatial::Pose;
use std::path::Path;

/// Sizes of a geom [m]: between two points the half length is theirs, of capsules and cylinders the second one, of boxes and ellipsoids
/// the third one, and these are as wide as thick.
pub fn size(geom: &Geom) -> [f64; 3] {
    let [a, b, c] = geom.size;
    match (geom.fromto.map(|ends| between(ends).1), geom.type_) {
        (Some(half), GeomType::Box | GeomType::Ellipsoid) => [a, a, half],
        (Some(half), _) => [a, half, c],
        (None, _) => [a, b, c],
    }
}

/// Group of the geoms that collide, by custom (MuJoCo Menagerie).
const COLLISION_GROUP: i32 = 3;

/// Which geoms collide.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Colliding {
    /// Those with a contact type or affinity.
    ByType,
    /// Those of the custom's group: none of the robot has either, as where contacts are given pair by pair.
    ByGroup,
}

impl Colliding {
    /// Of a robot with given bodies.
    pub fn of(model: &Model, bodies: &[usize]) -> Self {
        let mut geoms = bodies.iter().flat_map(|&b| &model.bodies[b].body.geoms);
        let is_marked = |geom: &Geom| geom.group == COLLISION_GROUP;
        if !geoms.clone().any(has_type) && geoms.any(is_marked) {
            Self::ByGroup
        } else {
            Self::ByType
        }
    }

    /// What a user should know.
    pub fn note(self) -> Option<String> {
        (self == Self::ByGroup).then(|| {
            format!(
                "no geom has a contype or conaffinity: those of group {COLLISION_GROUP} are taken as what collides"
            )
        })
    }

    fn has(self, geom: &Geom) -> bool {
        match self {
            Self::ByType => has_type(geom),
            Self::ByGroup => geom.group == COLLISION_GROUP,
        }
    }
}

fn has_type(geom: &Geom) -> bool {
    geom.contype != 0 || geom.conaffinity != 0
}

/// The elements of a geom, and what cannot be given.
pub fn elements(model: &Model, geom: &Geom, colliding: Colliding) -> Result<String, String> {
    let collides = colliding.has(geom);
    let frame = body_from_geom(geom);
    let tag = if collides { "collision" } else { "visual" };
    if !collides && geom.type_ != GeomType::Mesh {
        return Ok(String::new());
    }
    let element = |at: &Pose, shape: &str| {
        format!(
            "    <{tag}>{}<geometry>{shape}</geometry></{tag}>\n",
            origin(at)
        )
    };
    let [a, b, c] = size(geom);
    let ball = || format!("<sphere radius={}/>", quoted(&number(a)));
    let cuboid = |x: f64, y: f64, z: f64| {
        let size = numbers(&(2.0 * Vector3::new(x, y, z)));
        format!("<box size={}/>", quoted(&size))
    };
    let tube = || {
        let (radius, length) = (quoted(&number(a)), quoted(&number(2.0 * b)));
        format!("<cylinder radius={radius} length={length}/>")
    };
    Ok(match geom.type_ {
        GeomType::Sphere => element(&frame, &ball()),
        GeomType::Box | GeomType::Ellipsoid => element(&frame, &cuboid(a, b, c)),
        GeomType::Cylinder => element(&frame, &tube()),
        GeomType::Capsule => {
            let end = |z: f64| element(&(frame * Pose::from_translation(0.0, 0.0, z)), &ball());
            [element(&frame, &tube()), end(b), end(-b)].concat()
        }
        GeomType::Mesh => {
            let name = geom.mesh.as_deref().unwrap_or_default();
            let mesh = model.assets.mesh(name);
            let file = mesh.and_then(|m| Some((m, model.resolve_mesh_file(m, Path::new(""))?)));
            let Some((mesh, file)) = file else {
                return Err(format!("mesh {name:?} without a file"));
            };
            let scale = quoted(&numbers(&Vector3::from(mesh.scale)));
            let file = quoted(&file.display().to_string());
            element(&frame, &format!("<mesh filename={file} scale={scale}/>"))
        }
        GeomType::Plane => return Err("a plane".into()),
        GeomType::Hfield => return Err("a height field".into()),
        GeomType::Sdf => return Err("a signed distance field".into()),
    })
}
