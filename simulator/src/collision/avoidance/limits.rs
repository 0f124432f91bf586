//! Motion limits of a joint.

use crate::robot::Joint;

/// Limits of one joint's motion, rad or m and s.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Limits {
    /// Smallest position.
    pub lower: f64,
    /// Greatest position.
    pub upper: f64,
    /// Greatest speed.
    pub speed: f64,
    /// Greatest acceleration, either way.
    pub acceleration: f64,
    /// Greatest jerk, either way.
    pub jerk: f64,
}

impl Limits {
    /// The joint's range, the smaller of its speed limit and `speed`, and the given acceleration
    /// and jerk.
    pub fn new(joint: &Joint, speed: f64, acceleration: f64, jerk: f64) -> Self {
        Limits { lower: joint.lower, upper: joint.upper, speed: joint.velocity_limit.min(speed), acceleration, jerk }
    }
}
