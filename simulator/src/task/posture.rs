//! `posture`: moves joints to given positions along minimum-jerk paths.
//!
//! ```text
//! q(s) = q0 + (q1 - q0) (10 s^3 - 15 s^4 + 6 s^5),   s = (t - t0) / T
//! ```
//!
//! the quintic that starts and ends at rest without acceleration [Flash 1985, equation A9].

use super::{Command, Context, Foresight, Status, Task, TaskResult, has_elapsed};
use crate::motion::minimum_jerk::minimum_jerk;
use crate::robot::JointId;

/// Task that moves joints to given positions.
#[derive(Clone, Debug)]
pub struct Posture {
    /// Joints and their target positions, rad or m.
    targets: Vec<(JointId, f64)>,
    /// Duration T of the move, s.
    duration: f64,
    start: f64,
    from: Vec<f64>,
}

impl Posture {
    /// A move of `duration` seconds (0: at once).
    pub fn new(targets: Vec<(JointId, f64)>, duration: f64) -> Self {
        let from = vec![0.0; targets.len()];
        Posture { targets, duration, start: 0.0, from }
    }

    /// Commands all joints at `t` seconds after the start.
    fn move_to(&self, t: f64, command: &mut Command) {
        let (progress, rate) = if has_elapsed(t, self.duration) { (1.0, 0.0) } else { minimum_jerk(t, self.duration) };
        for (from, (joint, to)) in self.from.iter().zip(&self.targets) {
            command.position[joint.0] = if progress == 1.0 { *to } else { from + (to - from) * progress };
            command.velocity[joint.0] = (to - from) * rate;
        }
    }
}

impl Task for Posture {
    fn init(&mut self, context: &Context, command: &Command) -> TaskResult {
        self.start = context.start;
        for (from, (joint, _)) in self.from.iter_mut().zip(&self.targets) {
            *from = command.position[joint.0];
        }
        Ok(Status::Running)
    }

    fn run(&mut self, context: &Context, command: &mut Command) -> TaskResult {
        let t = context.time - self.start;
        self.move_to(t, command);
        Ok(if has_elapsed(t, self.duration) { Status::Done } else { Status::Running })
    }

    fn foresight(&self, now: f64) -> Foresight {
        Foresight::new(now, self.start + self.duration, [])
    }

    fn command_at(&mut self, time: f64, command: &mut Command) {
        self.move_to(time - self.start, command);
    }

    fn name(&self) -> &str {
        "posture"
    }
}
