//! Slopes of joint efforts: what stiff drives, joint friction and stops contribute to the derivative of the equations
//! of motion.

use super::drives::Drives;
use super::joint_efforts::{self, JointStop};
use crate::robot::Model;
use crate::task::Command;

/// Change of a position (rad or m) or velocity in a difference quotient of an effort.
const SPAN: f64 = 1e-6;

/// Decrease of an effort per change of position and velocity.
pub type Slopes = [f64; 2];

/// The drives of a mechanism at a state.
pub struct DrivesAt<'a> {
    /// Its joints.
    pub model: &'a Model,
    /// Their efforts at the state.
    pub drives: &'a Drives,
    /// Efforts of friction and stops at the state.
    pub passive: &'a [f64],
    /// Their stops, if there are any.
    pub stops: Option<&'a [JointStop]>,
    /// Positions.
    pub joints: &'a [f64],
    /// Velocities.
    pub rates: &'a [f64],
    /// Commands.
    pub command: &'a Command,
}

impl DrivesAt<'_> {
    /// Slopes of the servo of a joint, and of its friction and stop. Where a speed limits the drive it has none.
    pub fn slopes(&self, j: usize) -> [Slopes; 2] {
        let (joint, q, v) = (&self.model.joints[j], self.joints[j], self.rates[j]);
        let servo = |q: f64, v: f64| joint_efforts::servo(joint, j, q, v, self.command).0;
        let stop = |q: f64, v: f64| self.stops.map_or(0.0, |stops| stops[j].effort(joint, q, v));
        let passive = |q: f64, v: f64| joint.friction_law().effort(v) + stop(q, v);
        let slopes = |effort: &dyn Fn(f64, f64) -> f64| {
            let at = effort(q, v);
            [(at - effort(q + SPAN, v)) / SPAN, (at - effort(q, v + SPAN)) / SPAN]
        };
        let is_limited = !(joint.lag > 0.0) && servo(q, v) != self.drives.servo[j];
        [if is_limited { [0.0; 2] } else { slopes(&servo) }, slopes(&passive)]
    }
}
