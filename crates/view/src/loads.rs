//! What a contact bears: normal force, share of friction used, centre of pressure.
//!
//! Frames: the plan's wrench acts on `a` in world axes about the origin of `a`; the normal is that of `b`, the centre of
//! pressure is in the axes of `a`.

use crate::motion::Motion;
use nalgebra::Vector3;
use plan::Contact;

/// Forces below this have neither direction nor centre of pressure [N].
const LOADED: f64 = 2.0;

/// What a contact bears in one interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Load {
    /// Force along the normal of `b`, positive if it presses [N].
    pub normal: f64,
    /// Tangential force over friction coefficient times normal force; zero if hardly loaded or two-sided.
    pub friction: f64,
    /// Centre of pressure on `a` along its x and y [m]; zero if hardly loaded or two-sided.
    pub pressure: [f64; 2],
}

/// The loads of a contact, one per interval of its phase, which begins at node `start`.
pub(crate) fn loads(motion: &Motion, contact: &Contact, start: usize) -> Vec<Load> {
    let [a, b] = [&contact.a, &contact.b].map(|name| motion.interfaces[name.as_str()]);
    let rows = contact.wrench.iter().enumerate();
    rows.map(|(k, w)| {
        let world_from_a = motion.world_from_interface(start + k, a);
        let world_from_b = motion.world_from_interface(start + k, b);
        let force_in_b = world_from_b.rotate_inverse(Vector3::new(w[0], w[1], w[2]));
        let force_in_a = world_from_a.rotate_inverse(Vector3::new(w[0], w[1], w[2]));
        let moment_in_a = world_from_a.rotate_inverse(Vector3::new(w[3], w[4], w[5]));
        let normal = force_in_b.z;
        let bears = contact.kind.is_unilateral() && normal > LOADED;
        // The force on `a` along its own normal is −fn, so k_y = −(−fn) x: x = k_y / fn and y = −k_x / fn.
        let along_a = -force_in_a.z;
        let has_centre = bears && contact.kind.is_patch() && along_a > LOADED;
        Load {
            normal,
            friction: if bears {
                force_in_b.xy().norm() / (contact.mu * normal).max(1e-9)
            } else {
                0.0
            },
            pressure: if has_centre {
                [moment_in_a.y / along_a, -moment_in_a.x / along_a]
            } else {
                [0.0; 2]
            },
        }
    })
    .collect()
}
