//! Joint positions and velocities against the limits of the URDF.

use crate::categories::Category;
use crate::measure::Measurements;
use crate::motion::Motion;

/// Judges every joint at every node.
pub(crate) fn judge(motion: &Motion, found: &mut Measurements) {
    for t in 0..motion.n_nodes() {
        for (j, limit) in motion.robot.limits.iter().enumerate() {
            let position = motion.plan.q[t][7 + j];
            let velocity = motion.plan.v[t][6 + j];
            let beyond = (limit.lower - position)
                .max(position - limit.upper)
                .max(0.0);
            let place = || motion.place(t, &motion.robot.joints[j]);
            found.add(Category::JointPosition, beyond, place);
            found.add(
                Category::JointVelocity,
                (velocity.abs() - limit.velocity).max(0.0),
                place,
            );
        }
    }
}
