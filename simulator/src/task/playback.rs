//! `playback`: joints follow curves through the postures of a motion.
//!
//! ```text
//! q(t) = m(s) + e(t),   q'(t) = s' m'(s) + e'(t),   s' = speed
//! ```
//!
//! m: minimum-jerk curves ([`crate::motion::spline`]); s: the motion's time, the integral of a
//! speed that changes without a jump; e: the decaying difference from the previous command
//! ([`super::blend_in`]).

use super::blend_in::BlendIn;
use super::{Command, Context, Foresight, Status, Task, TaskResult, has_elapsed};
use crate::motion::minimum_jerk::SmoothTransition;
use crate::motion::spline::{Spline, TrajectoryPoint};
use crate::robot::JointId;

/// Task that plays a motion.
#[derive(Clone, Debug)]
pub struct Playback {
    joints: Vec<(JointId, Spline)>,
    cursors: Vec<usize>,
    /// First and last time of the motion, s.
    span: (f64, f64),
    repeat: bool,
    blend: f64,
    times: Vec<f64>,
    speeds: Vec<f64>,
    start: f64,
    speed: SmoothTransition,
    /// The motion's time at the last change of speed, s.
    elapsed: f64,
    offsets: BlendIn,
}

impl Playback {
    /// Plays at `speed` (seconds of the motion per second), with `changes` of the speed by
    /// ascending time, and loops if `repeat`. `blend`: time to blend in from the command and from
    /// one speed to the next, s.
    pub fn new(joints: Vec<(JointId, Spline)>, speed: f64, repeat: bool, blend: f64, changes: Vec<(f64, f64)>) -> Self {
        let ends = || joints.iter().map(|(_, spline)| spline.span());
        let first = ends().map(|s| s.0).fold(f64::INFINITY, f64::min);
        let last = ends().map(|s| s.1).fold(0.0, f64::max);
        let (times, speeds) = changes.into_iter().unzip();
        Playback {
            cursors: vec![0; joints.len()],
            span: (first, last),
            repeat: repeat && last > first,
            offsets: BlendIn::new(blend, joints.len()),
            joints,
            blend,
            times,
            speeds,
            start: 0.0,
            speed: SmoothTransition::constant(speed, 0.0),
            elapsed: 0.0,
        }
    }

    /// The motion's time; in a loop, that of the first repetition, also before its first posture.
    fn motion_time(&self, time: f64) -> f64 {
        let s = self.elapsed + self.speed.integral(time);
        let (first, last) = self.span;
        if self.repeat && !(first..=last).contains(&s) { first + (s - first).rem_euclid(last - first) } else { s }
    }

    /// Joint number `i` at the motion's time `s`, with rates in simulated time.
    fn point(&mut self, i: usize, s: f64, time: f64) -> TrajectoryPoint {
        let m = self.joints[i].1.at(s, &mut self.cursors[i]);
        TrajectoryPoint { v: self.speed.value(time) * m.v, ..m }
    }
}

impl Task for Playback {
    fn init(&mut self, context: &Context, command: &Command) -> TaskResult {
        self.start = context.start;
        self.speed = SmoothTransition::constant(self.speed.value(0.0), self.start);
        for i in 0..self.joints.len() {
            let point = self.point(i, 0.0, self.start);
            self.offsets.begin(i, self.joints[i].0, command, &point);
        }
        Ok(Status::Running)
    }

    fn run(&mut self, context: &Context, command: &mut Command) -> TaskResult {
        let t = context.time - self.start;
        let s = self.motion_time(context.time);
        let is_over = !self.repeat && has_elapsed(s, self.span.1) && self.offsets.is_over(t);
        for i in 0..self.joints.len() {
            let joint = self.joints[i].0;
            let point = self.point(i, if is_over { self.span.1 } else { s }, context.time);
            self.offsets.apply(i, joint, t, &point, command);
            if is_over {
                command.velocity[joint.0] = 0.0;
            }
        }
        Ok(if is_over { Status::Done } else { Status::Running })
    }

    fn change(&mut self, context: &Context, number: usize) -> TaskResult {
        self.elapsed += self.speed.integral(context.time);
        self.speed.change(self.speeds[number], context.time, self.blend);
        Ok(Status::Running)
    }

    fn adopt_changes(&mut self, newer: Box<dyn Task>) {
        if let Some(newer) = super::of_type::<Self>(newer) {
            self.times = newer.times;
            self.speeds = newer.speeds;
        }
    }

    fn changes(&self) -> &[f64] {
        &self.times
    }

    fn foresight(&self, now: f64) -> Foresight {
        // A motion's time that changes its speed, pauses or is over.
        let (s, speed) = (self.motion_time(now), self.speed.value(now));
        if now < self.speed.end() || speed <= 0.0 || (!self.repeat && s >= self.span.1) {
            return Foresight::NONE;
        }
        let at = |motion: f64| now + (motion - s) / speed;
        let (until, length) =
            if self.repeat { (f64::INFINITY, self.span.1 - self.span.0) } else { (at(self.span.1), f64::INFINITY) };
        // The next knots of this repetition and of the one after it.
        let knots = [0.0, length].into_iter().flat_map(|lap| {
            let after = s - lap + 1e-9 * speed;
            self.joints.iter().filter_map(move |(_, spline)| Some(spline.knot_after(after)? + lap))
        });
        Foresight::new(now, until, knots.map(at).chain([self.start + self.blend]))
    }

    fn command_at(&mut self, time: f64, command: &mut Command) {
        let (t, s) = (time - self.start, self.motion_time(time));
        for i in 0..self.joints.len() {
            let point = self.point(i, s, time);
            self.offsets.apply(i, self.joints[i].0, t, &point, command);
        }
    }

    fn name(&self) -> &str {
        "playback"
    }
}
