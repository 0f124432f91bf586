//! Blends the commanded motion of a joint into a task's motion: their initial difference decays
//! along a quintic.
//!
//! ```text
//! command(t) = motion(t) + e(t),   e = q_command - motion, e' likewise, e'' = 0 at t = 0;   e = e' = e'' = 0 at t = T
//! ```
//!
//! Commanded position and velocity are continuous. A motion that begins at the commanded position
//! and velocity is not changed.

use super::{Command, has_elapsed};
use crate::motion::spline::{TrajectoryPoint, quintic};
use crate::robot::JointId;

/// Offsets of the joints of one task.
#[derive(Clone, Debug)]
pub struct BlendIn {
    duration: f64,
    from: Vec<TrajectoryPoint>,
}

impl BlendIn {
    /// Blends of `duration` seconds (0: none) for `joints` joints.
    pub fn new(duration: f64, joints: usize) -> Self {
        BlendIn { duration, from: vec![TrajectoryPoint::default(); joints] }
    }

    /// Starts the blend of `joint`, number `i` of the task, whose motion begins at `motion`.
    pub fn begin(&mut self, i: usize, joint: JointId, command: &Command, motion: &TrajectoryPoint) {
        let (q, v) = (command.position[joint.0], command.velocity[joint.0]);
        self.from[i] = TrajectoryPoint { q: q - motion.q, v: v - motion.v, a: 0.0 };
    }

    /// Whether the blend is over `t` seconds after its start.
    pub fn is_over(&self, t: f64) -> bool {
        has_elapsed(t, self.duration)
    }

    /// Sets the command of `joint`, number `i` of the task, `t` seconds after the start, when its
    /// motion is at `motion`.
    pub fn apply(&self, i: usize, joint: JointId, t: f64, motion: &TrajectoryPoint, command: &mut Command) {
        let e = if self.is_over(t) {
            TrajectoryPoint::default()
        } else {
            quintic(&self.from[i], &TrajectoryPoint::default(), self.duration, t)
        };
        command.position[joint.0] = motion.q + e.q;
        command.velocity[joint.0] = motion.v + e.v;
    }
}
