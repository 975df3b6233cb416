//! The text of the URDF.

use crate::error::MjcfError;
use crate::inertia;
use crate::limits::{Limit, Limits};
use crate::pose::{pose, shift, turn, vector};
use crate::robot::{Robot, is_hinge_or_slide};
use crate::shapes::{self, Colliding};
use mjcf_rs::Model;
use mjcf_rs::body::{Body, Joint, JointType};
use multibody::rpy_from_rotation;
use nalgebra::Vector3;
use spatial::{Inertia, Pose};
use std::collections::BTreeSet;

/// Anchors nearer to the origin of a body than this are there [m].
const AT_ORIGIN: f64 = 1e-12;

/// The URDF of a model's robot; `notes` take what it cannot say.
pub fn write(
    model: &Model,
    robot: &Robot,
    limits: Limits,
    notes: &mut Vec<String>,
) -> Result<String, MjcfError> {
    let name = model.name.as_deref().unwrap_or("robot");
    let bodies = robot.bodies();
    let colliding = Colliding::of(model, &bodies);
    let mut writer = Writer {
        text: format!("<robot name={}>\n", quoted(name)),
        limits,
        left_out: vec![],
        names: robot.names.iter().cloned().collect(),
        colliding,
    };
    for &body in &bodies {
        writer.body(model, robot, body)?;
    }
    let Writer {
        mut text,
        limits,
        left_out,
        ..
    } = writer;
    text += "</robot>\n";
    notes.extend(limits.notes());
    notes.extend(left_out);
    notes.extend(colliding.note());
    notes.extend(cannot_say(model, &bodies));
    Ok(text)
}

/// Armatures, springs and couplings.
fn cannot_say(model: &Model, bodies: &[usize]) -> Vec<String> {
    let joints = bodies.iter().flat_map(|&b| &model.bodies[b].body.joints);
    let joints: Vec<&Joint> = joints.filter(|j| is_hinge_or_slide(j)).collect();
    let most = |of: fn(&Joint) -> f64| joints.iter().map(|j| of(j)).fold(0.0, f64::max);
    let (armature, stiffness) = (most(|j| j.armature), most(|j| j.stiffness));
    let mut notes = vec![];
    if armature > 0.0 {
        notes.push(format!(
            "armatures of joints (up to {armature} kg m²) are left out: a plan's robot is a URDF, which knows none"
        ));
    }
    if stiffness > 0.0 {
        notes.push(format!(
            "springs of joints (up to {stiffness} N·m/rad) are left out"
        ));
    }
    let (couplings, tendons) = (model.equality.len(), model.tendons.len());
    if couplings + tendons > 0 {
        notes.push(format!(
            "{couplings} equality constraints and {tendons} tendons are left out"
        ));
    }
    notes
}

struct Writer {
    text: String,
    limits: Limits,
    colliding: Colliding,
    /// Geoms that cannot be given, as sentences.
    left_out: Vec<String>,
    /// Names of links.
    names: BTreeSet<String>,
}

impl Writer {
    fn add(&mut self, elements: &str) {
        self.text += elements;
    }

    /// A body's link, what joins it to its parent, and its sites.
    fn body(&mut self, model: &Model, robot: &Robot, id: usize) -> Result<(), MjcfError> {
        let entry = &model.bodies[id];
        let (body, name) = (&entry.body, &robot.names[id]);
        self.link(model, body, name)?;
        if let (true, Some(parent)) = (id != robot.root, entry.parent) {
            self.joints(robot, id, body, &robot.names[parent])?;
        }
        for site in &body.sites {
            let Some(site_name) = &site.name else {
                continue;
            };
            if self.names.insert(site_name.clone()) {
                self.massless(site_name);
                self.fixed(name, site_name, &pose(&site.pose));
            }
        }
        Ok(())
    }

    fn link(&mut self, model: &Model, body: &Body, name: &str) -> Result<(), MjcfError> {
        let inertia = inertia::of_body(model, body, name)?;
        self.add(&format!("  <link name={}>\n", quoted(name)));
        // A mass that is none is told by who reads the URDF.
        if inertia.mass != 0.0 {
            self.inertial(&inertia);
        }
        for geom in &body.geoms {
            match shapes::elements(model, geom, self.colliding) {
                Ok(elements) => self.text += &elements,
                Err(what) => self
                    .left_out
                    .push(format!("body {name:?}: {what} is left out")),
            }
        }
        self.text += "  </link>\n";
        Ok(())
    }

    fn inertial(&mut self, inertia: &Inertia) {
        let entry = |i: usize, j: usize| quoted(&number(inertia.inertia[(i, j)]));
        let centre = origin(&shift(inertia.com));
        let mass = quoted(&number(inertia.mass));
        self.add(&format!(
            "    <inertial>{centre}<mass value={mass}/><inertia ixx={} ixy={} ixz={} iyy={} iyz={} izz={}/></inertial>\n",
            entry(0, 0),
            entry(0, 1),
            entry(0, 2),
            entry(1, 1),
            entry(1, 2),
            entry(2, 2),
        ));
    }

    /// The joints of a body: T · Π shift(p) turn(a, q − q₀) shift(−p), with T its pose, p anchors, a axes and q₀ references.
    fn joints(
        &mut self,
        robot: &Robot,
        id: usize,
        body: &Body,
        parent: &str,
    ) -> Result<(), MjcfError> {
        let name = &robot.names[id];
        let moving: Vec<(usize, &Joint)> = body.joints.iter().enumerate().collect();
        let (mut parent, mut frame) = (parent.to_owned(), pose(&body.pose));
        for (n, (index, joint)) in moving.iter().enumerate() {
            let joint_name = robot.joint_name(id, *index, joint);
            if !is_hinge_or_slide(joint) {
                return Err(MjcfError::BallJoint {
                    joint: joint_name,
                    body: name.clone(),
                });
            }
            let (anchor, axis) = (vector(joint.pos), vector(joint.axis));
            let back = match joint.type_ {
                JointType::Hinge => turn(axis, -joint.ref_),
                _ => shift(axis.normalize() * -joint.ref_),
            };
            let is_last = n + 1 == moving.len() && anchor.norm() < AT_ORIGIN;
            let child = if is_last {
                name.clone()
            } else {
                let between = format!("{name}_after_{joint_name}");
                self.massless(&between);
                between
            };
            let limit = self.limits.of(&joint_name, joint);
            let at = frame * shift(anchor) * back;
            self.joint((&joint_name, joint), (&parent, &child), &at, &limit);
            (parent, frame) = (child, shift(-anchor));
        }
        if parent != *name {
            self.fixed(&parent, name, &frame);
        }
        Ok(())
    }

    fn joint(
        &mut self,
        (name, joint): (&str, &Joint),
        (parent, child): (&str, &str),
        at: &Pose,
        limit: &Limit,
    ) {
        let kind = match joint.type_ {
            JointType::Hinge => "revolute",
            _ => "prismatic",
        };
        let [lower, upper] = limit.range.map(|x| quoted(&number(x)));
        let [effort, velocity] = [limit.effort, limit.velocity].map(|x| quoted(&number(x)));
        let [damping, friction] = [joint.damping, joint.frictionloss].map(|x| quoted(&number(x)));
        let axis = quoted(&numbers(&vector(joint.axis).normalize()));
        self.add(&format!(
            "  <joint name={} type=\"{kind}\">\n    <parent link={}/><child link={}/>{}<axis xyz={axis}/>\n    \
             <limit lower={lower} upper={upper} effort={effort} velocity={velocity}/><dynamics damping={damping} \
             friction={friction}/>\n  </joint>\n",
            quoted(name),
            quoted(parent),
            quoted(child),
            origin(at),
        ));
    }

    fn massless(&mut self, name: &str) {
        self.add(&format!("  <link name={}/>\n", quoted(name)));
    }

    fn fixed(&mut self, parent: &str, child: &str, at: &Pose) {
        self.add(&format!(
            "  <joint name={} type=\"fixed\"><parent link={}/><child link={}/>{}</joint>\n",
            quoted(&format!("{child}_fixed")),
            quoted(parent),
            quoted(child),
            origin(at),
        ));
    }
}

/// An `<origin>`.
pub fn origin(at: &Pose) -> String {
    let (xyz, rpy) = (at.origin(), rpy_from_rotation(at.rotation()));
    let [xyz, rpy] = [xyz, rpy].map(|v| quoted(&numbers(&v)));
    format!("<origin xyz={xyz} rpy={rpy}/>")
}

/// A number that is read back as it is; no negative zero.
pub fn number(x: f64) -> String {
    (x + 0.0).to_string()
}

/// Three of them.
pub fn numbers(v: &Vector3<f64>) -> String {
    let words: Vec<String> = v.iter().map(|x| number(*x)).collect();
    words.join(" ")
}

/// A value of an attribute, with quotes.
pub fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' => out += "&quot;",
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            _ => out.push(c),
        }
    }
    out + "\""
}
