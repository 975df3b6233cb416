//! What is in the picture: static bodies, objects and robot at a time of the motion.

use super::camera::Camera;
use super::mesh::{Triangle, triangles};
use super::painter::{Face, Ground, Picture, paint};
use super::shadow::Shadow;
use crate::motion::Motion;
use crate::palette;
use crate::robot::looks;
use multibody::Shape;
use nalgebra::Vector3;
use plan::{Geometry, Plan, StaticBody};
use spatial::Pose;

/// Times of the motion at which everything must be in the picture.
const LOOKS: usize = 12;

/// A shape that moves with something.
struct Part {
    frame_from_shape: Pose,
    triangles: Vec<Triangle>,
    color: [f64; 3],
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
    /// Gathers the shapes and chooses a place to look from: obliquely from before the robot's first stand.
    pub fn new(motion: &'a Motion<'a>) -> Self {
        let plan = motion.plan;
        let (looks, _) = looks(&motion.model, &plan.robot.urdf);
        let robot = looks.into_iter().map(|look| {
            let part = Part {
                frame_from_shape: look.placed.frame_from_shape,
                triangles: triangles(&look.placed.shape),
                color: look.color,
            };
            (look.frame, part)
        });
        let objects = plan.objects.iter().enumerate().flat_map(|(i, object)| {
            let color = palette::to_rgb(&palette::of_object(plan, i));
            parts(&object.geometry, color).map(move |part| (i, part))
        });
        let fixed = |body: &StaticBody| {
            let color = palette::to_rgb(&palette::of_static(plan, &body.name));
            let pale = color.map(|c| 0.6 * c + 0.4);
            let faces = parts(&body.geometry, pale)
                .flat_map(|part| faces(&Pose::identity(), &part).collect::<Vec<_>>());
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
        let places = |faces: Vec<Face>| faces.into_iter().flat_map(|face| face.places);
        self.points.extend(places(self.touched.clone()));
        for look in 0..=LOOKS {
            let faces = self.moving(duration * look as f64 / LOOKS as f64);
            self.points.extend(places(faces));
        }
        let mut low = Vector3::repeat(f64::INFINITY);
        let mut high = -low;
        for point in &self.points {
            (low, high) = (low.inf(point), high.sup(point));
        }
        self.ground.center = (low + high) / 2.0;
        self.ground.reach = 0.9 * (high - low).norm() + 0.6;
        let facing = self.motion.world_from_frame(0, 0).rotate(Vector3::x());
        let heading = facing.y.atan2(facing.x);
        let direction =
            |turn: f64, up: f64| Vector3::new((heading + turn).cos(), (heading + turn).sin(), up);
        self.away = direction(-0.95, 0.36);
        self.light = direction(-1.5, 1.9);
    }

    /// A camera that sees the whole motion; the shape of its picture is within `aspects`.
    pub fn camera(&self, aspects: [f64; 2]) -> Camera {
        Camera::framing(&self.points, &self.away, aspects)
    }

    /// The picture at a time, so many pixels high.
    pub fn picture(&self, time: f64, camera: &Camera, height: usize) -> Picture {
        let mut faces = self.moving(time);
        faces.extend_from_slice(&self.fixed);
        let mut shadow = Shadow::new(&self.points, &self.light);
        for face in &faces {
            shadow.add(face.places);
        }
        paint(&faces, &self.ground, camera, &shadow, height)
    }

    /// Robot and objects at a time.
    fn moving(&self, time: f64) -> Vec<Face> {
        let moment = self.motion.at(time);
        let mut all = Vec::new();
        for (frame, part) in &self.robot {
            let world_from_frame = moment.robot.frame_pose(&self.motion.model, *frame);
            all.extend(faces(&world_from_frame, part));
        }
        for (object, part) in &self.objects {
            all.extend(faces(&moment.objects[*object], part));
        }
        all
    }
}

fn parts(geometry: &[Geometry], color: [f64; 3]) -> impl Iterator<Item = Part> + '_ {
    geometry.iter().filter_map(move |shape| {
        let half_size = Vector3::from(shape.half_size?);
        Some(Part {
            frame_from_shape: Pose::from_xyzquat(&shape.pose),
            triangles: triangles(&Shape::Box { half_size }),
            color,
        })
    })
}

fn faces<'p>(world_from_frame: &Pose, part: &'p Part) -> impl Iterator<Item = Face> + use<'p> {
    let world_from_shape = *world_from_frame * part.frame_from_shape;
    part.triangles.iter().map(move |corners| Face {
        places: corners.map(|(place, _)| world_from_shape.act(place)),
        normals: corners.map(|(_, normal)| world_from_shape.rotate(normal)),
        color: part.color,
    })
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
