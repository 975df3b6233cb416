//! Contacts (i, j, θ) and contact states s, as in the paper, "Symbolic state and actions".

use std::collections::BTreeSet;

/// Index of an interface in the scene's list 𝓘.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct InterfaceId(pub usize);

/// Contact type θ ∈ 𝒯; the absence of a contact ∅ is the absence of the pair from the state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ContactType {
    /// A point pushes on a patch: friction cone, no moment.
    UnilateralPoint,
    /// A point held by a patch (ball joint): any force up to a limit, no moment.
    BilateralPoint,
    /// A patch pushes on a patch: friction cone, centre of pressure and torsion limits.
    UnilateralPatch,
    /// A full grasp: any wrench up to a limit, no relative motion.
    BilateralPatch,
}

impl ContactType {
    /// The name used in scene and plan files.
    pub fn name(self) -> &'static str {
        match self {
            Self::UnilateralPoint => "unilateral_point",
            Self::BilateralPoint => "bilateral_point",
            Self::UnilateralPatch => "unilateral_patch",
            Self::BilateralPatch => "bilateral_patch",
        }
    }

    /// True if the contact can only push.
    pub fn is_unilateral(self) -> bool {
        matches!(self, Self::UnilateralPoint | Self::UnilateralPatch)
    }

    /// True if both interfaces are patches, so that their normals align.
    pub fn is_patch(self) -> bool {
        matches!(self, Self::UnilateralPatch | Self::BilateralPatch)
    }
}

/// One contact (i, j, θ): interface `a` lands on interface `b`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Contact {
    /// The foot, hand or object surface that touches.
    pub a: InterfaceId,
    /// The surface that is touched.
    pub b: InterfaceId,
    /// How they touch.
    pub kind: ContactType,
}

/// A symbolic state s: the set of all contacts of the scene.
#[derive(Debug, Clone, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ContactState {
    /// The contacts, ordered.
    pub contacts: BTreeSet<Contact>,
}
