//! Slopes of joint efforts: what stiff drives, joint friction and stops contribute to the derivative of the equations
//! of motion.

use super::drives::Drives;
use super::joint_efforts::JointStop;
use crate::robot::{DriveMode, JointId, Model};
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
        let state = |q: f64, v: f64| move |l: usize| if l == j { (q, v) } else { (self.joints[l], self.rates[l]) };
        let servo = |q: f64, v: f64| self.drives.servo_at(self.model, j, self.command, state(q, v));
        let stop = |q: f64, v: f64| self.stops.map_or(0.0, |stops| stops[j].effort(joint, q, v));
        let passive = |q: f64, v: f64| joint.friction_law().effort(v) + stop(q, v);
        let slopes = |effort: &dyn Fn(f64, f64) -> f64| {
            let at = effort(q, v);
            [(at - effort(q + SPAN, v)) / SPAN, (at - effort(q, v + SPAN)) / SPAN]
        };
        let is_limited = !(joint.lag > 0.0) && (self.motors_limit(j) || servo(q, v) != self.drives.servo[j]);
        [if is_limited { [0.0; 2] } else { slopes(&servo) }, slopes(&passive)]
    }

    /// Whether the torques of the motors of a transmission, given by its number among those that couple joints,
    /// depend on the state otherwise than the efforts of its joints do.
    pub fn has_stiff_motors(&self, coupled: usize) -> bool {
        let motors = &self.drives.coupled[coupled];
        motors.is_limited || self.model.transmissions[motors.transmission].friction.is_some()
    }

    /// Whether one of these motors drives the joint.
    pub fn has_stiff_motor(&self, j: usize) -> bool {
        let drives =
            |c: usize| self.model.transmissions[self.drives.coupled[c].transmission].joints.contains(&JointId(j));
        (0..self.drives.coupled.len()).any(|c| drives(c) && self.has_stiff_motors(c))
    }

    /// Gains of the servo of a joint: decrease of its effort per change of position and velocity, where no limit
    /// acts. None where the actuator lags, which makes the effort a state.
    pub fn gains(&self, j: usize) -> Slopes {
        let (kp, kd) = (self.command.kp[j], self.command.kd[j]);
        match self.command.mode[j] {
            _ if self.model.joints[j].lag > 0.0 => [0.0; 2],
            DriveMode::Position => [kp, kd],
            DriveMode::Velocity => [0.0, kd],
            DriveMode::Force | DriveMode::Passive | DriveMode::Kinematic => [0.0; 2],
        }
    }

    /// Whether limits act on motors that a transmission couples, one of which drives the joint.
    fn motors_limit(&self, j: usize) -> bool {
        let mut limited = self.drives.coupled.iter().filter(|motors| motors.is_limited);
        limited.any(|motors| self.model.transmissions[motors.transmission].joints.contains(&JointId(j)))
    }
}
