//! Flags for the parts of the augmented data that a task reads (section II.B of the paper).

use std::ops::{BitOr, BitOrAssign};

/// A set of parts. A part includes the parts it is computed from.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct Needs(u32);

impl Needs {
    /// No parts.
    pub const NONE: Needs = Needs(0);
    /// Link transforms: kinematics of all links at the estimated state.
    pub const LINKS: Needs = Needs(1);
    /// Centre of mass and its velocity.
    pub const COM: Needs = Needs(1 << 1);
    /// Jacobian of the centre of mass in world axes.
    pub const COM_JACOBIAN: Needs = Needs(1 << 2);
    /// Jacobian of the centre of mass relative to the base, in base axes.
    pub const COM_JACOBIAN_BASE: Needs = Needs(1 << 3 | 1 << 2);
    /// Mass matrix.
    pub const MASS: Needs = Needs(1 << 4);
    /// Bias: Coriolis, centrifugal and gravity terms.
    pub const BIAS: Needs = Needs(1 << 5);
    /// Efforts that compensate gravity.
    pub const GRAVITY: Needs = Needs(1 << 6 | 1 << 2);
    /// Positions of the soles and their vertices.
    pub const SOLES: Needs = Needs(1 << 7);
    /// Jacobians of the soles' frames.
    pub const SOLE_JACOBIANS: Needs = Needs(1 << 8 | 1 << 7);
    /// Jacobians of the soles' vertices.
    pub const VERTEX_JACOBIANS: Needs = Needs(1 << 9 | 1 << 7);
    /// Poses, twists and Jacobians of the end effectors.
    pub const END_EFFECTORS: Needs = Needs(1 << 10);
    /// Load of the floor on each sole, in [`super::SensorReadings::soles`].
    pub const LOADS: Needs = Needs(1 << 11);
    /// Forces of the floor on the vertices, and which of them are in contact.
    pub const CONTACTS: Needs = Needs(1 << 12 | 1 << 11 | 1 << 7);
    /// Zero-moment point.
    pub const ZMP: Needs = Needs(1 << 13 | 1 << 11 | 1 << 7);
    /// Support polygon.
    pub const SUPPORT: Needs = Needs(1 << 14 | 1 << 12 | 1 << 11 | 1 << 7);
    /// Point of optimal stability.
    pub const STABLE_POINT: Needs = Needs(1 << 15 | 1 << 14 | 1 << 12 | 1 << 11 | 1 << 7);
    /// All parts.
    pub const ALL: Needs = Needs((1 << 16) - 1);

    /// Whether all of `parts` are in this set.
    pub fn contains(self, parts: Needs) -> bool {
        self.0 & parts.0 == parts.0
    }

    /// Whether any of `parts` is in this set.
    pub fn intersects(self, parts: Needs) -> bool {
        self.0 & parts.0 != 0
    }
}

impl BitOr for Needs {
    type Output = Needs;
    fn bitor(self, other: Needs) -> Needs {
        Needs(self.0 | other.0)
    }
}

impl BitOrAssign for Needs {
    fn bitor_assign(&mut self, other: Needs) {
        self.0 |= other.0;
    }
}
