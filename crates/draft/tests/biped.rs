//! A robot of boxes that looks along any axis.

use std::fmt::Write;

/// What a biped is like.
#[derive(Clone, Copy)]
pub struct Biped {
    /// Forward and left, as unit vectors of the base.
    pub forward: [f64; 2],
    /// How far the soles reach before and behind the ankles [m].
    pub sole: [f64; 2],
    /// Smallest and largest angle of knees about the left [rad].
    pub knee: [f64; 2],
    pub arms: bool,
    /// Also a second pair of legs, so far behind the first [m].
    pub more_legs: Option<f64>,
}

impl Default for Biped {
    fn default() -> Self {
        Self {
            forward: [1.0, 0.0],
            sole: [0.16, 0.06],
            knee: [0.0, 2.4],
            arms: true,
            more_legs: None,
        }
    }
}

impl Biped {
    /// Its URDF.
    pub fn urdf(&self) -> String {
        let mut out = String::from("<robot name=\"biped\">\n");
        self.link(&mut out, "pelvis", 8.0, [0.0, 0.0, 0.1], [0.12, 0.2, 0.2]);
        for (side, y) in [("left", 0.1), ("right", -0.1)] {
            self.leg(&mut out, side, 0.0, y);
            if let Some(behind) = self.more_legs {
                self.leg(&mut out, &format!("hind_{side}"), -behind, y);
            }
            if self.arms {
                self.arm(&mut out, side, 2.0 * y);
            }
        }
        out + "</robot>\n"
    }

    /// Forward, left, up as the text of a vector of the base.
    fn vector(&self, [f, l, z]: [f64; 3]) -> String {
        let [x, y] = self.forward;
        format!("{} {} {z}", f * x - l * y, f * y + l * x)
    }

    /// Sizes along forward, left, up.
    fn size(&self, [f, l, z]: [f64; 3]) -> String {
        let [x, y] = self.forward.map(f64::abs);
        format!("{} {} {z}", f * x + l * y, f * y + l * x)
    }

    fn link(&self, out: &mut String, name: &str, mass: f64, at: [f64; 3], size: [f64; 3]) {
        let (at, size) = (self.vector(at), self.size(size));
        let _ = writeln!(
            out,
            "<link name=\"{name}\"><inertial><origin xyz=\"{at}\"/><mass value=\"{mass}\"/><inertia ixx=\"0.02\" ixy=\"0\" ixz=\"0\" \
             iyy=\"0.02\" iyz=\"0\" izz=\"0.02\"/></inertial><collision><origin xyz=\"{at}\"/><geometry><box size=\"{size}\"/></geometry>\
             </collision></link>"
        );
    }

    fn joint(
        &self,
        out: &mut String,
        name: &str,
        [parent, child]: [&str; 2],
        at: [f64; 3],
        axis: [f64; 3],
        [lower, upper]: [f64; 2],
    ) {
        let (at, axis) = (self.vector(at), self.vector(axis));
        let _ = writeln!(
            out,
            "<joint name=\"{name}\" type=\"revolute\"><parent link=\"{parent}\"/><child link=\"{child}\"/><origin xyz=\"{at}\"/>\
             <axis xyz=\"{axis}\"/><limit lower=\"{lower}\" upper=\"{upper}\" effort=\"100\" velocity=\"10\"/></joint>"
        );
    }

    fn leg(&self, out: &mut String, side: &str, x: f64, y: f64) {
        let name = |part: &str| format!("{side}_{part}");
        let [heel, toe] = [-self.sole[1], self.sole[0]];
        self.link(out, &name("hip"), 1.0, [0.0; 3], [0.06, 0.06, 0.06]);
        self.link(
            out,
            &name("thigh"),
            3.0,
            [0.0, 0.0, -0.18],
            [0.08, 0.08, 0.3],
        );
        self.link(
            out,
            &name("shin"),
            2.0,
            [0.0, 0.0, -0.18],
            [0.07, 0.07, 0.28],
        );
        self.link(out, &name("ankle"), 0.3, [0.0; 3], [0.04, 0.04, 0.04]);
        self.link(
            out,
            &name("foot"),
            1.0,
            [f64::midpoint(heel, toe), 0.0, -0.06],
            [toe - heel, 0.08, 0.04],
        );
        let wide = [-1.5, 1.5];
        let (pitch, roll) = ([0.0, 1.0, 0.0], [1.0, 0.0, 0.0]);
        let (hip, thigh, shin, ankle, foot) = (
            name("hip"),
            name("thigh"),
            name("shin"),
            name("ankle"),
            name("foot"),
        );
        self.joint(
            out,
            &name("hip_roll"),
            ["pelvis", &hip],
            [x, y, -0.05],
            roll,
            wide,
        );
        self.joint(
            out,
            &name("hip_pitch"),
            [&hip, &thigh],
            [0.0; 3],
            pitch,
            wide,
        );
        self.joint(
            out,
            &name("knee"),
            [&thigh, &shin],
            [0.0, 0.0, -0.36],
            pitch,
            self.knee,
        );
        self.joint(
            out,
            &name("ankle_pitch"),
            [&shin, &ankle],
            [0.0, 0.0, -0.36],
            pitch,
            wide,
        );
        self.joint(
            out,
            &name("ankle_roll"),
            [&ankle, &foot],
            [0.0; 3],
            roll,
            wide,
        );
    }

    fn arm(&self, out: &mut String, side: &str, y: f64) {
        let name = |part: &str| format!("{side}_{part}");
        self.link(out, &name("shoulder"), 0.5, [0.0; 3], [0.05, 0.05, 0.05]);
        self.link(
            out,
            &name("upper_arm"),
            1.0,
            [0.0, 0.0, -0.13],
            [0.05, 0.05, 0.2],
        );
        self.link(
            out,
            &name("forearm"),
            0.8,
            [0.0, 0.0, -0.12],
            [0.04, 0.04, 0.18],
        );
        self.link(
            out,
            &name("hand"),
            0.3,
            [0.0, 0.0, -0.06],
            [0.06, 0.03, 0.12],
        );
        let wide = [-2.0, 2.0];
        let (pitch, roll) = ([0.0, 1.0, 0.0], [1.0, 0.0, 0.0]);
        let (shoulder, upper, fore, hand) = (
            name("shoulder"),
            name("upper_arm"),
            name("forearm"),
            name("hand"),
        );
        self.joint(
            out,
            &name("shoulder_pitch"),
            ["pelvis", &shoulder],
            [0.0, y, 0.35],
            pitch,
            wide,
        );
        self.joint(
            out,
            &name("shoulder_roll"),
            [&shoulder, &upper],
            [0.0; 3],
            roll,
            wide,
        );
        self.joint(
            out,
            &name("elbow"),
            [&upper, &fore],
            [0.0, 0.0, -0.25],
            pitch,
            [-2.4, 0.0],
        );
        self.joint(
            out,
            &name("wrist"),
            [&fore, &hand],
            [0.0, 0.0, -0.22],
            [0.0, 0.0, 1.0],
            wide,
        );
    }
}
