//! `mocap`: joints follow captured motion, resampled to the control ticks and limited in range and
//! speed beforehand ([`crate::motion::limit`]).
//!
//! Velocities are central differences of the samples, so none exceeds the greatest step between two
//! samples over the time between them.

use super::blend_in::BlendIn;
use super::{Command, Context, Status, Task, TaskResult};
use crate::motion::spline::TrajectoryPoint;
use crate::robot::JointId;

/// Task that follows captured motion.
#[derive(Clone, Debug)]
pub struct Mocap {
    /// Joints with their positions, rad or m; all lists have the same length, at least 1.
    joints: Vec<(JointId, Vec<f64>)>,
    /// Samples per second.
    rate: f64,
    start: f64,
    /// Time of the first sample: the first tick.
    first: f64,
    offsets: BlendIn,
}

impl Mocap {
    /// Follows samples at `rate` per second from the first tick on; `blend`: time to blend in from
    /// the command, s.
    pub fn new(joints: Vec<(JointId, Vec<f64>)>, rate: f64, blend: f64) -> Self {
        Mocap { offsets: BlendIn::new(blend, joints.len()), joints, rate, start: 0.0, first: 0.0 }
    }

    fn point(&self, i: usize, at: usize) -> TrajectoryPoint {
        let samples = &self.joints[i].1;
        let sample = |k: usize| samples[k.min(samples.len() - 1)];
        let (before, after) = (sample(at.saturating_sub(1)), sample(at + 1));
        TrajectoryPoint { q: sample(at), v: 0.5 * (after - before) * self.rate, a: 0.0 }
    }
}

impl Task for Mocap {
    fn init(&mut self, context: &Context, command: &Command) -> TaskResult {
        (self.start, self.first) = (context.start, context.time);
        for i in 0..self.joints.len() {
            let point = self.point(i, 0);
            self.offsets.begin(i, self.joints[i].0, command, &point);
        }
        Ok(Status::Running)
    }

    fn run(&mut self, context: &Context, command: &mut Command) -> TaskResult {
        let t = context.time - self.start;
        let at = ((context.time - self.first) * self.rate).round() as usize;
        let last = self.joints.first().map_or(0, |(_, samples)| samples.len() - 1);
        let is_over = at >= last && self.offsets.is_over(t);
        for i in 0..self.joints.len() {
            let joint = self.joints[i].0;
            self.offsets.apply(i, joint, t, &self.point(i, at), command);
            if is_over {
                command.velocity[joint.0] = 0.0;
            }
        }
        Ok(if is_over { Status::Done } else { Status::Running })
    }

    fn name(&self) -> &str {
        "mocap"
    }
}
