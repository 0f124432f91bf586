//! From what joints are asked into a motion: their difference when it begins fades along a quintic.
//!
//! ```text
//! command(t) = motion(t) + e(t),   e = q_command - motion, e' likewise, e'' = 0 at t = 0;   e = e' = e'' = 0 at t = T
//! ```
//!
//! Position and velocity asked go on from where they were. A motion that begins where the joint is asked to be, with the
//! velocity it is asked for, is not changed at all.

use super::{Command, has_elapsed};
use crate::motion::spline::{TrajectoryPoint, quintic};
use crate::robot::JointId;

/// Fades of the joints of one task.
#[derive(Clone, Debug)]
pub struct BlendIn {
    duration: f64,
    from: Vec<TrajectoryPoint>,
}

impl BlendIn {
    /// Fades of `duration` seconds (0: none) for so many joints.
    pub fn new(duration: f64, joints: usize) -> Self {
        BlendIn { duration, from: vec![TrajectoryPoint::default(); joints] }
    }

    /// Joint number `i` of the task is `joint`, its motion begins at `motion`.
    pub fn begin(&mut self, i: usize, joint: JointId, command: &Command, motion: &TrajectoryPoint) {
        let (q, v) = (command.position[joint.0], command.velocity[joint.0]);
        self.from[i] = TrajectoryPoint { q: q - motion.q, v: v - motion.v, a: 0.0 };
    }

    /// Is it over `t` seconds after the beginning?
    pub fn is_over(&self, t: f64) -> bool {
        has_elapsed(t, self.duration)
    }

    /// What joint number `i` of the task is asked `t` seconds after the beginning, its motion being at `motion`.
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
