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
//! A stop is a stiff one-sided spring and damper: real end stops yield, and the spring keeps the joint's dynamics
//! within reach of an explicit integrator. Unless the robot says otherwise its stiffness makes the joint's own inertia swing
//! at `STOP_RATE`, critically damped.

use crate::robot::{DriveMode, Joint, JointKind, Model};
use crate::task::Command;

/// Natural frequency of a joint against its stop, rad/s.
const STOP_RATE: f64 = 300.0;

/// Stop of one joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stop {
    stiffness: f64,
    damping: f64,
}

impl Stop {
    /// The joint's own, or one for a joint that feels `inertia` (kg m^2 or kg).
    pub fn new(joint: &Joint, inertia: f64) -> Self {
        let (stiffness, damping) = joint.stop.unwrap_or((inertia * STOP_RATE * STOP_RATE, 2.0 * inertia * STOP_RATE));
        Stop { stiffness, damping }
    }

    /// Effort at position `q` and velocity `qd`.
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

/// Servo effort before clipping.
pub fn wanted(j: usize, q: f64, qd: f64, command: &Command) -> f64 {
    match command.mode[j] {
        DriveMode::Position => {
            command.kp[j] * (command.position[j] - q) + command.kd[j] * (command.velocity[j] - qd) + command.effort[j]
        }
        DriveMode::Velocity => command.kd[j] * (command.velocity[j] - qd) + command.effort[j],
        DriveMode::Force => command.effort[j],
        // What moves a kinematic joint follows from its motion.
        DriveMode::Passive | DriveMode::Kinematic => 0.0,
    }
}

/// Servo effort, and whether the limit clips it.
pub fn servo(joint: &Joint, j: usize, q: f64, qd: f64, command: &Command) -> (f64, bool) {
    let wanted = wanted(j, q, qd, command);
    let clipped = wanted.clamp(-joint.effort_limit, joint.effort_limit);
    (clipped, clipped != wanted)
}

/// What a servo that is not clipped gives over a velocity-level step of size `dt`, beside its effort at the present state:
/// the part that follows from the position which the present velocity leads to, and how much less it gives per change of
/// the velocity, times `dt`.
pub fn implicit(j: usize, qd: f64, command: &Command, dt: f64) -> (f64, f64) {
    match command.mode[j] {
        DriveMode::Position => (-command.kp[j] * dt * qd, dt * command.kd[j] + dt * dt * command.kp[j]),
        DriveMode::Velocity => (0.0, dt * command.kd[j]),
        _ => (0.0, 0.0),
    }
}

/// Adds the passive efforts of all joints: friction and, if wanted, stops. `q` and `qd` per joint, `tau` per joint.
pub fn passive(model: &Model, stops: Option<&[Stop]>, q: &[f64], qd: &[f64], tau: &mut [f64]) {
    for (j, joint) in model.joints.iter().enumerate() {
        tau[j] += joint.friction_law().effort(qd[j]);
        if let Some(stops) = stops {
            tau[j] += stops[j].effort(joint, q[j], qd[j]);
        }
    }
}

/// The same over a velocity-level step of size `dt`: referred to the position that the present velocity leads to, and by
/// how much they fall per change of the velocity, times `dt`, into `give`.
///
/// Friction is taken by its secant at the velocity of the step's end, so it may be as steep as it likes; a stop acts if
/// it would with the present velocity.
pub fn passive_implicit(
    model: &Model,
    stops: Option<&[Stop]>,
    q: &[f64],
    qd: &[f64],
    dt: f64,
    tau: &mut [f64],
    give: &mut [f64],
) {
    for (j, joint) in model.joints.iter().enumerate() {
        let friction = joint.friction_law();
        tau[j] += friction.effort(qd[j]);
        give[j] = dt * friction.secant(qd[j]);
        let Some(stop) = stops.map(|s| &s[j]) else { continue };
        let effort = stop.effort(joint, q[j] + dt * qd[j], qd[j]);
        if effort != 0.0 {
            tau[j] += effort;
            give[j] += dt * stop.damping + dt * dt * stop.stiffness;
        }
    }
}
