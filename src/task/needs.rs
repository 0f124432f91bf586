//! Which parts of the augmented data a task reads: the paper's flags.

use std::ops::{BitOr, BitOrAssign};

/// A set of parts.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct Needs(u32);

impl Needs {
    /// Nothing.
    pub const NONE: Needs = Needs(0);
    /// Link transforms: kinematics of all links at the estimated state.
    pub const LINKS: Needs = Needs(1);
    /// Centre of mass and its velocity.
    pub const COM: Needs = Needs(1 << 1);
    /// Jacobian of the centre of mass in world axes.
    pub const COM_JACOBIAN: Needs = Needs(1 << 2);

    /// Are all of `parts` among these?
    pub fn contains(self, parts: Needs) -> bool {
        self.0 & parts.0 == parts.0
    }

    /// Is any of `parts` among these?
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
