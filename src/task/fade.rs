//! From what joints are asked into a motion: their difference when it begins fades along a quintic.
//!
//! ```text
//! command(t) = motion(t) + e(t),   e = q_command - motion, e' likewise, e'' = 0 at t = 0;   e = e' = e'' = 0 at t = T
//! ```
//!
//! Position and velocity asked go on from where they were. A motion that begins where the joint is asked to be, with the
//! velocity it is asked for, is not changed at all.

use super::{Command, over};
use crate::motion::spline::{Point, quintic};
use crate::robot::JointId;

/// Fades of the joints of one task.
#[derive(Clone, Debug)]
pub struct Fade {
    duration: f64,
    from: Vec<Point>,
}

impl Fade {
    /// Fades of `duration` seconds (0: none) for so many joints.
    pub fn new(duration: f64, joints: usize) -> Self {
        Fade { duration, from: vec![Point::default(); joints] }
    }

    /// Joint number `i` of the task is `joint`, its motion begins at `motion`.
    pub fn begin(&mut self, i: usize, joint: JointId, command: &Command, motion: &Point) {
        let (q, v) = (command.position[joint.0], command.velocity[joint.0]);
        self.from[i] = Point { q: q - motion.q, v: v - motion.v, a: 0.0 };
    }

    /// Is it over `t` seconds after the beginning?
    pub fn is_over(&self, t: f64) -> bool {
        over(t, self.duration)
    }

    /// What joint number `i` of the task is asked `t` seconds after the beginning, its motion being at `motion`.
    pub fn apply(&self, i: usize, joint: JointId, t: f64, motion: &Point, command: &mut Command) {
        let e = if self.is_over(t) {
            Point::default()
        } else {
            quintic(&self.from[i], &Point::default(), self.duration, t)
        };
        command.position[joint.0] = motion.q + e.q;
        command.velocity[joint.0] = motion.v + e.v;
    }
}
