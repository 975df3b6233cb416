//! What is in the picture: static bodies, objects and robot at a time of the motion.

use super::camera::Camera;
use super::mesh::triangles;
use super::painter::{Face, Ground, Picture, paint};
use super::shadow::Shadow;
use crate::meshes::{Meshes, Triangle};
use crate::motion::Motion;
use crate::palette;
use crate::robot::{Form, Look, looks};
use crate::viewpoint::Viewpoint;
use multibody::Shape;
use nalgebra::Vector3;
use plan::{Geometry, Plan, StaticBody};
use spatial::Pose;

/// Times of the motion at which everything must be in the picture.
const LOOKS: usize = 12;

/// The lamp stands so far to the viewer's left [rad].
const LAMP: f64 = 0.55;

/// Of a part with more corners, the camera looks at the corners of the box around them.
const MANY: usize = 5000;

/// A shape that moves with something.
struct Part {
    frame_from_shape: Pose,
    triangles: Vec<Triangle>,
    /// Corners around it, for the camera.
    around: Vec<Vector3<f64>>,
    color: [f64; 3],
}

impl Part {
    fn new(frame_from_shape: Pose, triangles: Vec<Triangle>, color: [f64; 3]) -> Self {
        let mut around: Vec<_> = triangles.iter().flatten().map(|x| x.0).collect();
        if around.len() > MANY {
            around = box_around(&around);
        }
        Self {
            frame_from_shape,
            triangles,
            around,
            color,
        }
    }

    fn of_robot(look: &Look, meshes: &Meshes) -> Self {
        let triangles = match &look.form {
            Form::Primitive(shape) => triangles(shape),
            Form::Surface { index, mirror } => {
                let mirror = Vector3::from(*mirror);
                let mirrored = |x: Vector3<f64>| x.component_mul(&mirror);
                let triangles = meshes.triangles(*index).into_iter();
                triangles
                    .map(|corners| {
                        corners.map(|(place, normal)| (mirrored(place), mirrored(normal)))
                    })
                    .collect()
            }
        };
        Self::new(look.frame_from_shape, triangles, look.color)
    }

    fn faces(&self, world_from_shape: &Pose) -> impl Iterator<Item = Face> {
        self.triangles.iter().map(|corners| Face {
            places: corners.map(|(place, _)| world_from_shape.act(place)),
            normals: corners.map(|(_, normal)| world_from_shape.rotate(normal)),
            color: self.color,
        })
    }
}

/// All shapes of a plan, its camera and ground.
pub(crate) struct Scenery<'a> {
    motion: &'a Motion<'a>,
    /// Frame of the model, part.
    robot: Vec<(usize, Part)>,
    /// Index of the object, part.
    objects: Vec<(usize, Part)>,
    fixed: Vec<Face>,
    /// Of the static bodies that are touched; others may stand outside of the picture.
    touched: Vec<Face>,
    ground: Ground,
    /// Corners of everything over the whole motion.
    points: Vec<Vector3<f64>>,
    /// Towards the viewer.
    away: Vector3<f64>,
    light: Vector3<f64>,
}

impl<'a> Scenery<'a> {
    /// Gathers the shapes and chooses a place to look from.
    pub fn new(motion: &'a Motion<'a>, meshes: &Meshes) -> Self {
        let plan = motion.plan;
        let (looks, _) = looks(&motion.model, &plan.robot.urdf, meshes);
        let robot = looks.iter().map(|x| (x.frame, Part::of_robot(x, meshes)));
        let objects = plan.objects.iter().enumerate().flat_map(|(i, object)| {
            let color = palette::to_rgb(&palette::of_object(plan, i));
            parts(&object.geometry, color).map(move |part| (i, part))
        });
        let fixed = |body: &StaticBody| {
            let color = palette::to_rgb(&palette::of_static(plan, &body.name));
            let pale = color.map(|c| 0.6 * c + 0.4);
            let faces = parts(&body.geometry, pale)
                .flat_map(|part| part.faces(&part.frame_from_shape).collect::<Vec<_>>());
            faces.collect::<Vec<_>>()
        };
        let touched = plan
            .environment
            .iter()
            .filter(|body| is_touched(plan, &body.name));
        let touched = touched.flat_map(fixed).collect();
        let fixed = plan.environment.iter().flat_map(fixed).collect();
        let (robot, objects) = (robot.collect(), objects.collect());
        let mut scenery = Self {
            motion,
            robot,
            objects,
            fixed,
            touched,
            ground: Ground {
                height: ground_height(plan),
                center: Vector3::zeros(),
                reach: 1.0,
            },
            points: Vec::new(),
            away: Vector3::x(),
            light: Vector3::z(),
        };
        scenery.look_around();
        scenery
    }

    fn look_around(&mut self) {
        let duration = self.motion.plan.duration();
        let mut points = Vec::new();
        let touched = self.touched.iter().flat_map(|face| face.places);
        self.points.extend(touched);
        for look in 0..=LOOKS {
            for (world_from_shape, part) in self.moving(duration * look as f64 / LOOKS as f64) {
                let around = part.around.iter().map(|x| world_from_shape.act(*x));
                points.extend(around);
            }
        }
        self.points.extend(points);
        let mut low = Vector3::repeat(f64::INFINITY);
        let mut high = -low;
        for point in &self.points {
            (low, high) = (low.inf(point), high.sup(point));
        }
        self.ground.center = (low + high) / 2.0;
        self.ground.reach = 0.9 * (high - low).norm() + 0.6;
        let view = Viewpoint::of(self.motion);
        self.away = view.away();
        let lamp = view.azimuth - LAMP;
        self.light = Vector3::new(lamp.cos(), lamp.sin(), 1.9);
    }

    /// A camera that sees the whole motion; the shape of its picture is within `aspects`.
    pub fn camera(&self, aspects: [f64; 2]) -> Camera {
        Camera::framing(&self.points, &self.away, aspects)
    }

    /// The picture at a time, so many pixels high.
    pub fn picture(&self, time: f64, camera: &Camera, height: usize) -> Picture {
        let mut faces = self.fixed.clone();
        for (world_from_shape, part) in self.moving(time) {
            faces.extend(part.faces(&world_from_shape));
        }
        let mut shadow = Shadow::new(&self.points, &self.light);
        for face in &faces {
            shadow.add(face.places);
        }
        paint(&faces, &self.ground, camera, &shadow, height)
    }

    /// Parts of robot and objects at a time, with the poses of the shapes in the world.
    fn moving(&self, time: f64) -> impl Iterator<Item = (Pose, &Part)> {
        let moment = self.motion.at(time);
        let frames = self.robot.iter().map(|(frame, part)| {
            let world_from_frame = moment.robot.frame_pose(&self.motion.model, *frame);
            (world_from_frame * part.frame_from_shape, part)
        });
        let objects = self.objects.iter();
        let objects = objects.map(|(i, part)| (moment.objects[*i] * part.frame_from_shape, part));
        frames.chain(objects).collect::<Vec<_>>().into_iter()
    }
}

fn parts(geometry: &[Geometry], color: [f64; 3]) -> impl Iterator<Item = Part> + '_ {
    geometry.iter().filter_map(move |shape| {
        let half_size = Vector3::from(shape.half_size?);
        let triangles = triangles(&Shape::Box { half_size });
        let frame_from_shape = Pose::from_xyzquat(&shape.pose);
        Some(Part::new(frame_from_shape, triangles, color))
    })
}

/// The corners of the box around places.
fn box_around(places: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let infinite = Vector3::repeat(f64::INFINITY);
    let (low, high) = places.iter().fold((infinite, -infinite), |(low, high), x| {
        (low.inf(x), high.sup(x))
    });
    let corner =
        |i: usize| Vector3::from([0, 1, 2].map(|k| if i >> k & 1 == 0 { low[k] } else { high[k] }));
    (0..8).map(corner).collect()
}

/// True if some contact is with the static body.
fn is_touched(plan: &Plan, body: &str) -> bool {
    let of_body = |name: &String| {
        let mut interfaces = plan.interfaces.iter();
        interfaces.any(|x| x.name == *name && x.body == body)
    };
    let mut contacts = plan.phases.iter().flat_map(|phase| &phase.contacts);
    contacts.any(|contact| of_body(&contact.a) || of_body(&contact.b))
}

fn ground_height(plan: &Plan) -> f64 {
    let shapes = plan.environment.iter().flat_map(|body| &body.geometry);
    let planes = shapes
        .filter(|shape| shape.is_plane())
        .map(|shape| shape.pose[2]);
    planes.reduce(f64::min).unwrap_or(0.0)
}
