//! Joint efforts: servo, passive friction, stops.
//!
//! ```text
//! position  tau = clip(kp (q_des - q) + kd (qd_des - qd) + feed-forward, effort limit)
//! velocity  tau = clip(kd (qd_des - qd) + feed-forward, effort limit)
//! force     tau = clip(feed-forward, effort limit)
//! friction  see robot::friction
//! stop      tau = -max(0, k p + b p')   with p the travel beyond the limit
//! ```
//!
//! A stop is a stiff one-sided spring and damper: real end stops yield, and the spring keeps the
//! joint's dynamics within reach of an explicit integrator. Unless the robot file sets its
//! stiffness, the joint's own inertia oscillates against it at `STOP_RATE`, critically damped.

use crate::robot::{DriveMode, Joint, JointKind, Model};
use crate::task::Command;

/// Natural frequency of a joint against its stop, rad/s.
const STOP_RATE: f64 = 300.0;

/// End stop of one joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointStop {
    stiffness: f64,
    damping: f64,
}

impl JointStop {
    /// The stop of the robot file, or the default stop for a joint with `inertia` (kg m^2 or kg).
    pub fn new(joint: &Joint, inertia: f64) -> Self {
        let (stiffness, damping) = joint.stop.unwrap_or((inertia * STOP_RATE * STOP_RATE, 2.0 * inertia * STOP_RATE));
        JointStop { stiffness, damping }
    }

    /// Effort at position `q` and velocity `qd`.
    #[inline]
    pub fn effort(&self, joint: &Joint, q: f64, qd: f64) -> f64 {
        if joint.kind == JointKind::Continuous {
            0.0
        } else if q > joint.upper {
            -(self.stiffness * (q - joint.upper) + self.damping * qd).max(0.0)
        } else if q < joint.lower {
            (self.stiffness * (joint.lower - q) - self.damping * qd).max(0.0)
        } else {
            0.0
        }
    }
}

/// Servo effort before the effort limit.
#[inline]
pub fn desired_effort(j: usize, q: f64, qd: f64, command: &Command) -> f64 {
    match command.mode[j] {
        DriveMode::Position => {
            command.kp[j] * (command.position[j] - q) + command.kd[j] * (command.velocity[j] - qd) + command.effort[j]
        }
        DriveMode::Velocity => command.kd[j] * (command.velocity[j] - qd) + command.effort[j],
        DriveMode::Force => command.effort[j],
        // The effort of a kinematic joint follows from its motion.
        DriveMode::Passive | DriveMode::Kinematic => 0.0,
    }
}

/// Bound of the rounding error of [`desired_effort`] and of its mean over a step, whose terms are of the
/// same size: 16 roundings of each.
#[inline]
pub fn effort_rounding(j: usize, q: f64, qd: f64, command: &Command) -> f64 {
    let position = command.kp[j] * (command.position[j].abs() + q.abs());
    let velocity = command.kd[j] * (command.velocity[j].abs() + qd.abs());
    16.0 * f64::EPSILON * (position + velocity + command.effort[j].abs())
}

/// Servo effort, and whether the limit clips it.
#[inline]
pub fn servo(joint: &Joint, j: usize, q: f64, qd: f64, command: &Command) -> (f64, bool) {
    let desired = desired_effort(j, q, qd, command);
    let clipped = desired.clamp(-joint.effort_limit, joint.effort_limit);
    (clipped, clipped != desired)
}

/// Implicit terms of an unclipped servo in a velocity-level step of size `dt`: the effort from the
/// position that the present velocity leads to, and `dt` times the decrease of the effort per
/// change of velocity.
#[inline]
pub fn implicit_servo(j: usize, qd: f64, command: &Command, dt: f64) -> (f64, f64) {
    match command.mode[j] {
        DriveMode::Position => (-command.kp[j] * dt * qd, dt * command.kd[j] + dt * dt * command.kp[j]),
        DriveMode::Velocity => (0.0, dt * command.kd[j]),
        _ => (0.0, 0.0),
    }
}

/// Adds the passive efforts of all joints: friction and, if given, stops. `q`, `qd` and `tau` have
/// one entry per joint.
pub fn passive(model: &Model, stops: Option<&[JointStop]>, q: &[f64], qd: &[f64], tau: &mut [f64]) {
    for (j, joint) in model.joints.iter().enumerate() {
        tau[j] += joint.friction_law().effort(qd[j]);
        if let Some(stops) = stops {
            tau[j] += stops[j].effort(joint, q[j], qd[j]);
        }
    }
}

/// Adds the passive efforts of a velocity-level step of size `dt`, at the position that the present
/// velocity leads to. Writes `dt` times their decrease per change of velocity to `implicit`.
///
/// Friction enters by its secant, so its slope has no limit. A stop acts if it would act at the
/// position that the present velocity leads to.
pub fn passive_implicit(
    model: &Model,
    stops: Option<&[JointStop]>,
    q: &[f64],
    qd: &[f64],
    dt: f64,
    tau: &mut [f64],
    implicit: &mut [f64],
) {
    for (j, joint) in model.joints.iter().enumerate() {
        let friction = joint.friction_law();
        tau[j] += friction.effort(qd[j]);
        implicit[j] = dt * friction.secant(qd[j]);
        let Some(stop) = stops.map(|s| &s[j]) else { continue };
        let effort = stop.effort(joint, q[j] + dt * qd[j], qd[j]);
        if effort != 0.0 {
            tau[j] += effort;
            implicit[j] += dt * stop.damping + dt * dt * stop.stiffness;
        }
    }
}
