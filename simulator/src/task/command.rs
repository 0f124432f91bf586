//! Joint commands.

use crate::robot::{DriveMode, Model};

/// Commands of all joints, held until the next control tick; one entry per joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Command {
    /// Quantity that each drive follows.
    pub mode: Vec<DriveMode>,
    /// Desired positions, rad or m.
    pub position: Vec<f64>,
    /// Desired velocities.
    pub velocity: Vec<f64>,
    /// Desired efforts in mode `force`, feed-forward efforts in the others, N m or N.
    pub effort: Vec<f64>,
    /// Position gains, N m/rad or N/m.
    pub kp: Vec<f64>,
    /// Velocity gains, N m s/rad or N s/m.
    pub kd: Vec<f64>,
}

impl Command {
    /// Holds this posture with the drives of the robot.
    pub fn hold(model: &Model, position: &[f64]) -> Self {
        let zero = vec![0.0; position.len()];
        Command {
            mode: model.joints.iter().map(|j| j.drive.mode).collect(),
            position: position.to_vec(),
            velocity: zero.clone(),
            effort: zero,
            kp: model.joints.iter().map(|j| j.drive.kp).collect(),
            kd: model.joints.iter().map(|j| j.drive.kd).collect(),
        }
    }

    /// Copies `other` without allocating.
    pub fn copy_from(&mut self, other: &Command) {
        self.mode.copy_from_slice(&other.mode);
        self.position.copy_from_slice(&other.position);
        self.velocity.copy_from_slice(&other.velocity);
        self.effort.copy_from_slice(&other.effort);
        self.kp.copy_from_slice(&other.kp);
        self.kd.copy_from_slice(&other.kd);
    }
}
