//! The categories of residuals: names, units, tolerances.

use Category as C;
use Level::{Fail, Warn};
use serde::Serialize;

/// Whether a residual beyond its tolerance rejects the plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    /// It does.
    Fail,
    /// It is a measurement, reported but not held against the plan.
    Warn,
}

/// A kind of residual. The order is that of [`SPECS`] and of the report.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Category {
    Schema,
    Quaternion,
    TimeGrid,
    IntegrationQ,
    IntegrationV,
    IntegrationObjQ,
    IntegrationObjV,
    MomentumFile,
    CentroidalForce,
    CentroidalMoment,
    UnactuatedForce,
    UnactuatedMoment,
    TorqueFile,
    TorqueLimit,
    TorqueSpeed,
    JointPosition,
    JointVelocity,
    ContactDistance,
    ContactAlignment,
    Halfspace,
    ContactVelocity,
    ContactSpin,
    NodeVelocity,
    EndVelocity,
    ContactBounds,
    SlipPhase,
    SlipYawPhase,
    SlipContact,
    Touchdown,
    NormalForce,
    FrictionCone,
    Cop,
    Torsion,
    PointMoment,
    ObjectForce,
    ObjectMoment,
    Goal,
    GoalRegion,
    GoalOrientation,
    Transitions,
    MuR,
    InterfaceSurface,
    InterfaceRobot,
    CollisionEnv,
    CollisionObj,
    CollisionScene,
    CollisionSelf,
    ContactOverlap,
    NotCollided,
}

/// What a category means and how it is judged.
#[derive(Debug)]
pub(crate) struct Spec {
    pub category: Category,
    pub name: &'static str,
    pub what: &'static str,
    pub unit: &'static str,
    /// Tolerance of the default profile.
    pub tolerance: f64,
    /// Tolerance of the profile `accept`: what a plan must reach to be reported as feasible.
    pub accept: f64,
    pub level: Level,
}

impl Category {
    /// Its row of the table.
    pub fn spec(self) -> &'static Spec {
        &SPECS[self as usize]
    }
}

const fn spec(
    category: Category,
    name: &'static str,
    what: &'static str,
    unit: &'static str,
    tolerances: (f64, f64),
    level: Level,
) -> Spec {
    let (tolerance, accept) = tolerances;
    Spec {
        category,
        name,
        what,
        unit,
        tolerance,
        accept,
        level,
    }
}

const fn same(tolerance: f64) -> (f64, f64) {
    (tolerance, tolerance)
}

/// All categories, in the order of [`Category`].
#[rustfmt::skip]
pub(crate) static SPECS: [Spec; 49] = [
    spec(C::Schema, "schema", "sizes, numbers, names, types and kinds that do not agree (count)", "", same(0.0), Fail),
    spec(C::Quaternion, "quaternion", "| |quaternion| - 1 |", "", same(1e-5), Fail),
    spec(C::TimeGrid, "time_grid", "time[t+1] - time[t] vs duration / steps; durations > 0", "s", same(1e-6), Fail),
    spec(C::IntegrationQ, "integration_q", "robot q under the named integrator", "m|rad", (1e-4, 1e-5), Fail),
    spec(C::IntegrationV, "integration_v", "robot v under the named integrator", "m/s|rad/s", (1e-3, 1e-4), Fail),
    spec(C::IntegrationObjQ, "integration_obj_q", "object pose under the named integrator", "m|rad", (1e-4, 1e-5), Fail),
    spec(C::IntegrationObjV, "integration_obj_v", "object twist under the named integrator", "m/s|rad/s", (1e-3, 1e-4), Fail),
    spec(C::MomentumFile, "momentum_file", "h in the file vs A(q) v", "kg m/s|..", (1e-2, 1e-3), Fail),
    spec(C::CentroidalForce, "centroidal_force", "linear momentum balance per interval", "N", (1.0, 0.05), Fail),
    spec(C::CentroidalMoment, "centroidal_moment", "angular momentum balance per interval", "N m", (1.0, 0.02), Fail),
    spec(C::UnactuatedForce, "unactuated_force", "base rows of M a + b - J'l, force (gap to centroidal = time step)", "N", same(40.0), Warn),
    spec(C::UnactuatedMoment, "unactuated_moment", "base rows of M a + b - J'l, moment about the CoM", "N m", same(15.0), Warn),
    spec(C::TorqueFile, "torque_file", "tau in the file vs inverse dynamics", "N m", (0.1, 1e-2), Fail),
    spec(C::TorqueLimit, "torque_limit", "recomputed torque over the URDF effort limit", "N m", (0.1, 1e-2), Fail),
    spec(C::TorqueSpeed, "torque_speed", "recomputed driving torque over what is left of the limit at speed", "N m", (0.1, 1e-2), Fail),
    spec(C::JointPosition, "joint_position", "joint position beyond URDF limits", "rad", (1e-3, 1e-4), Fail),
    spec(C::JointVelocity, "joint_velocity", "joint velocity beyond URDF limits", "rad/s", (1e-2, 1e-3), Fail),
    spec(C::ContactDistance, "contact_distance", "origin of a off the plane of b", "m", (1e-3, 1e-4), Fail),
    spec(C::ContactAlignment, "contact_alignment", "patch normals not opposite", "rad", (5e-3, 1e-3), Fail),
    spec(C::Halfspace, "halfspace", "point contact: limb direction below b's plane", "rad", same(1e-3), Fail),
    spec(C::ContactVelocity, "contact_velocity", "sliding: smaller of node velocity and pose change / dt", "m/s", same(5e-3), Fail),
    spec(C::ContactSpin, "contact_spin", "spin of patches about the normal, measured likewise", "rad/s", same(2e-2), Fail),
    spec(C::NodeVelocity, "node_velocity", "sliding velocity at the nodes, the paper's literal condition", "m/s", same(5e-3), Warn),
    spec(C::EndVelocity, "end_velocity", "relative velocity of the contacts at the very last node", "m/s", same(5e-3), Warn),
    spec(C::ContactBounds, "contact_bounds", "point, or corner of a's patch, outside b's extent", "m", (1e-3, 1e-4), Fail),
    spec(C::SlipPhase, "slip_phase", "drift of a on b over a phase, from poses", "mm", same(2.0), Fail),
    spec(C::SlipYawPhase, "slip_yaw_phase", "yaw of patch a on b over a phase, from poses", "deg", same(1.0), Fail),
    spec(C::SlipContact, "slip_contact", "drift of a on b over the whole contact", "mm", same(6.0), Warn),
    spec(C::Touchdown, "touchdown", "relative velocity when a new contact starts", "m/s", same(0.05), Warn),
    spec(C::NormalForce, "normal_force", "unilateral contact pulls", "N", (0.1, 0.02), Fail),
    spec(C::FrictionCone, "friction_cone", "tangential force over mu fn", "N", (0.1, 0.02), Fail),
    spec(C::Cop, "cop", "unilateral patch: CoP outside the overlap of both patches, times fn", "N m", (0.05, 0.01), Fail),
    spec(C::Torsion, "torsion", "unilateral patch: |k_z| - mu_r fn", "N m", (0.05, 0.01), Fail),
    spec(C::PointMoment, "point_moment", "moment at a point contact", "N m", (0.02, 0.01), Fail),
    spec(C::ObjectForce, "object_force", "object Newton-Euler, force rows", "N", (0.1, 0.02), Fail),
    spec(C::ObjectMoment, "object_moment", "object Newton-Euler, moment rows", "N m", (0.05, 0.01), Fail),
    spec(C::Goal, "goal", "goal contacts the last phase does not list (count)", "", same(0.0), Fail),
    spec(C::GoalRegion, "goal_region", "body outside its goal region at the last node", "m", (1e-3, 1e-4), Fail),
    spec(C::GoalOrientation, "goal_orientation", "heading or tilt outside its goal region at the last node", "deg", (0.1, 0.02), Fail),
    spec(C::Transitions, "transitions", "two partners, switching or retyping without a free phase (count)", "", same(0.0), Fail),
    spec(C::MuR, "mu_r", "unilateral patch: mu_r beyond mu x mean radius of a", "m", same(2e-3), Warn),
    spec(C::InterfaceSurface, "interface_surface", "object or static patch off its body's surface", "m", same(2e-3), Warn),
    spec(C::InterfaceRobot, "interface_robot", "robot interface away from its link's shape", "mm", same(50.0), Warn),
    spec(C::CollisionEnv, "collision_env", "robot into environment", "mm", (10.0, 5.0), Fail),
    spec(C::CollisionObj, "collision_obj", "robot into objects", "mm", (10.0, 5.0), Fail),
    spec(C::CollisionScene, "collision_scene", "objects into environment and each other", "mm", same(5.0), Fail),
    spec(C::CollisionSelf, "collision_self", "robot into itself (links more than two joints apart)", "mm", (15.0, 5.0), Fail),
    spec(C::ContactOverlap, "contact_overlap", "overlap of the bodies that are in contact (excluded above)", "mm", same(30.0), Warn),
    spec(C::NotCollided, "not_checked", "bodies whose shape is not read, so not collided (count)", "", same(0.0), Warn),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_in_the_order_of_the_enum() {
        for (i, row) in SPECS.iter().enumerate() {
            assert_eq!(row.category as usize, i, "{}", row.name);
            assert!(row.accept <= row.tolerance, "{}", row.name);
        }
        assert_eq!(Category::NotCollided as usize + 1, SPECS.len());
    }
}
