//! `posture`: move some joints to given angles along minimum-jerk paths.
//!
//! ```text
//! q(s) = q0 + (q1 - q0) (10 s^3 - 15 s^4 + 6 s^5),   s = (t - t0) / T
//! ```
//!
//! the quintic that starts and ends at rest without acceleration; source: Flash and Hogan, The coordination of arm
//! movements, J. Neuroscience 5 (1985), equation A9.

use super::{Command, Context, Status, Task, TaskResult, over};
use crate::robot::JointId;

/// See the module.
#[derive(Clone, Debug)]
pub struct Posture {
    /// Joints and where they go, rad or m.
    targets: Vec<(JointId, f64)>,
    /// Time T the move takes, s.
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
}

/// Progress and its rate (1/s) of a minimum-jerk move of length `duration` at time `t` after its start.
pub fn minimum_jerk(t: f64, duration: f64) -> (f64, f64) {
    if t >= duration {
        return (1.0, 0.0);
    }
    let s = (t / duration).max(0.0);
    (s * s * s * (10.0 + s * (6.0 * s - 15.0)), 30.0 * s * s * (1.0 - s) * (1.0 - s) / duration)
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
        let done = over(t, self.duration);
        let (progress, rate) = if done { (1.0, 0.0) } else { minimum_jerk(t, self.duration) };
        for (from, (joint, to)) in self.from.iter().zip(&self.targets) {
            command.position[joint.0] = if progress == 1.0 { *to } else { from + (to - from) * progress };
            command.velocity[joint.0] = (to - from) * rate;
        }
        Ok(if done { Status::Done } else { Status::Running })
    }

    fn name(&self) -> &str {
        "posture"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn minimum_jerk_has_its_closed_form() {
        assert_eq!(minimum_jerk(0.0, 2.0), (0.0, 0.0));
        assert_eq!(minimum_jerk(2.0, 2.0), (1.0, 0.0));
        let (half, peak) = minimum_jerk(1.0, 2.0);
        // Half way at half time; the greatest rate is 15/8 of the mean.
        assert!((half - 0.5).abs() < 1e-15 && (peak - 15.0 / 16.0).abs() < 1e-15);
        // The rate is the derivative: central difference, error of order h^2 times the third derivative (60 / T^3).
        let h = 1e-5;
        let slope = (minimum_jerk(0.7 + h, 2.0).0 - minimum_jerk(0.7 - h, 2.0).0) / (2.0 * h);
        assert!((slope - minimum_jerk(0.7, 2.0).1).abs() < 1e-9);
    }
}
