//! Joint efforts: servo, passive friction, stops.
//!
//! ```text
//! position  tau = clip(kp (q_des - q) + kd (qd_des - qd) + feed-forward, effort limit)
//! velocity  tau = clip(kd (qd_des - qd) + feed-forward, effort limit)
//! force     tau = clip(feed-forward, effort limit)
//! friction  tau = -d qd - c tanh(qd / v_s)                                 (URDF dynamics)
//! stop      tau = -max(0, k p + b p')   with p the travel beyond the limit
//! ```
//!
//! A stop is a stiff one-sided spring and damper: real end stops yield, and the spring keeps the joint's dynamics
//! within reach of an explicit integrator. Its stiffness makes the joint's own inertia swing at `STOP_RATE`, critically
//! damped.

use crate::force::friction::{SLIP_SPEED, coulomb};
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
    /// For a joint that feels `inertia` (kg m^2 or kg).
    pub fn new(inertia: f64) -> Self {
        Stop { stiffness: inertia * STOP_RATE * STOP_RATE, damping: 2.0 * inertia * STOP_RATE }
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

/// Servo effort before clipping, and whether the limit clips it.
pub fn servo(joint: &Joint, j: usize, q: f64, qd: f64, command: &Command) -> (f64, bool) {
    let wanted = match command.mode[j] {
        DriveMode::Position => {
            command.kp[j] * (command.position[j] - q) + command.kd[j] * (command.velocity[j] - qd) + command.effort[j]
        }
        DriveMode::Velocity => command.kd[j] * (command.velocity[j] - qd) + command.effort[j],
        DriveMode::Force => command.effort[j],
        // What moves a kinematic joint follows from its motion.
        DriveMode::Passive | DriveMode::Kinematic => 0.0,
    };
    let clipped = wanted.clamp(-joint.effort_limit, joint.effort_limit);
    (clipped, clipped != wanted)
}

/// How much less effort a servo gives over a velocity-level step of size `dt` per change of the velocity, times `dt`.
pub fn implicit_gain(joint: &Joint, j: usize, q: f64, qd: f64, command: &Command, dt: f64) -> f64 {
    let gain = match command.mode[j] {
        DriveMode::Position => dt * command.kd[j] + dt * dt * command.kp[j],
        DriveMode::Velocity => dt * command.kd[j],
        _ => return 0.0,
    };
    if servo(joint, j, q, qd, command).1 { 0.0 } else { gain }
}

/// Adds the passive efforts of all joints: URDF friction and, if wanted, stops. `q` and `qd` per joint, `tau` per joint.
pub fn passive(model: &Model, stops: Option<&[Stop]>, q: &[f64], qd: &[f64], tau: &mut [f64]) {
    for (j, joint) in model.joints.iter().enumerate() {
        tau[j] -= joint.damping * qd[j];
        if joint.friction > 0.0 {
            tau[j] += coulomb(joint.friction, qd[j], SLIP_SPEED);
        }
        if let Some(stops) = stops {
            tau[j] += stops[j].effort(joint, q[j], qd[j]);
        }
    }
}
