//! `sine`: joints oscillate sinusoidally.
//!
//! ```text
//! q(t)  = q0 + r (c + A sin theta - q0),        theta' = 2 pi f,  theta(t0) = phase
//! q'(t) = r' (c + A sin theta - q0) + r (c' + A' sin theta + A theta' cos theta)
//! ```
//!
//! q0 is the commanded position at the start t0. r rises from 0 to 1 within the ramp along a
//! minimum-jerk path, and falls again at the end. Amplitude A, centre c and frequency f change to
//! new values within the ramp likewise. The phase is the integral of the frequency, in closed form,
//! and therefore continuous through every change.

use super::{Command, Context, Foresight, Status, Task, TaskError, TaskResult, has_elapsed};
use crate::math;
use crate::motion::minimum_jerk::{SmoothTransition, minimum_jerk};
use crate::robot::{JointId, JointKind};
use std::f64::consts::TAU;

/// Oscillation of one joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swing {
    /// Amplitude, rad or m.
    pub amplitude: f64,
    /// Frequency, Hz.
    pub frequency: f64,
    /// Phase at the start, rad.
    pub phase: f64,
    /// Centre of the oscillation, rad or m; none: the commanded position at the start.
    pub offset: Option<f64>,
}

/// Change of the oscillation of one joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SwingChange {
    /// Number of the joint in the task.
    pub joint: usize,
    /// Amplitude, rad or m.
    pub amplitude: Option<f64>,
    /// Frequency, Hz.
    pub frequency: Option<f64>,
    /// Centre of the oscillation, rad or m.
    pub offset: Option<f64>,
}

/// Task that oscillates joints.
#[derive(Clone, Debug)]
pub struct Sine {
    joints: Vec<(JointId, Swing)>,
    duration: f64,
    ramp: f64,
    times: Vec<f64>,
    changes: Vec<Vec<SwingChange>>,
    /// Whether joints have end stops.
    limited: bool,
    start: f64,
    present: Vec<PresentSwing>,
}

/// Present parameters of one joint.
#[derive(Clone, Copy, Debug)]
struct PresentSwing {
    from: f64,
    amplitude: SmoothTransition,
    frequency: SmoothTransition,
    offset: SmoothTransition,
    /// Phase at the last change of the frequency, rad.
    phase: f64,
}

impl Sine {
    /// Oscillates for `duration` seconds (infinite: without end) with ramps of `ramp` seconds;
    /// `changes` by ascending time. If joints are `limited`, an oscillation about the initial
    /// position that leaves the joint's range is an error.
    pub fn new(
        joints: Vec<(JointId, Swing)>,
        duration: f64,
        ramp: f64,
        changes: Vec<(f64, Vec<SwingChange>)>,
        limited: bool,
    ) -> Self {
        let still = SmoothTransition::constant(0.0, 0.0);
        let blank = PresentSwing { from: 0.0, amplitude: still, frequency: still, offset: still, phase: 0.0 };
        let present = vec![blank; joints.len()];
        let (times, changes) = changes.into_iter().unzip();
        Sine { joints, duration, ramp, times, changes, limited, start: 0.0, present }
    }

    /// r and r' at `t` seconds after the start.
    fn rise(&self, t: f64) -> (f64, f64) {
        let remaining = self.duration - t;
        if remaining < self.ramp {
            let (down, rate) = minimum_jerk(remaining.max(0.0), self.ramp);
            return (down, -rate);
        }
        minimum_jerk(t, self.ramp)
    }

    /// Commands all joints at a time.
    fn swing(&self, time: f64, command: &mut Command) {
        let rise = self.rise(time - self.start);
        for ((joint, _), now) in self.joints.iter().zip(&self.present) {
            (command.position[joint.0], command.velocity[joint.0]) = now.at(time, rise);
        }
    }
}

impl PresentSwing {
    /// Position and velocity at a time, with r and r'.
    fn at(&self, time: f64, (r, r_rate): (f64, f64)) -> (f64, f64) {
        let theta = self.phase + TAU * self.frequency.integral(time);
        let (sin, cos) = math::sin_cos(theta);
        let (amplitude, offset) = (self.amplitude.value(time), self.offset.value(time));
        let away = offset + amplitude * sin - self.from;
        let turning = TAU * self.frequency.value(time) * amplitude * cos;
        let swing = self.offset.rate(time) + self.amplitude.rate(time) * sin + turning;
        (self.from + r * away, r_rate * away + r * swing)
    }
}

impl Task for Sine {
    fn init(&mut self, context: &Context, command: &Command) -> TaskResult {
        self.start = context.start;
        for ((joint, swing), now) in self.joints.iter().zip(&mut self.present) {
            let from = command.position[joint.0];
            let j = &context.model.joints[joint.0];
            let reach = swing.amplitude.abs() - 1e-9;
            let leaves = from - reach < j.lower || from + reach > j.upper;
            if self.limited && j.kind != JointKind::Continuous && swing.offset.is_none() && leaves {
                let (name, lower, upper) = (&j.name, j.lower, j.upper);
                let swing = format!("{:.4} about {from:.4}", swing.amplitude);
                return Err(TaskError::SwingOutOfRange { joint: name.clone(), swing, lower, upper });
            }
            let constant = |value| SmoothTransition::constant(value, self.start);
            *now = PresentSwing {
                from,
                amplitude: constant(swing.amplitude),
                frequency: constant(swing.frequency),
                offset: constant(swing.offset.unwrap_or(from)),
                phase: swing.phase,
            };
        }
        Ok(Status::Running)
    }

    fn run(&mut self, context: &Context, command: &mut Command) -> TaskResult {
        let is_over = has_elapsed(context.time - self.start, self.duration);
        self.swing(context.time, command);
        if is_over {
            self.joints.iter().for_each(|(joint, _)| command.velocity[joint.0] = 0.0);
        }
        Ok(if is_over { Status::Done } else { Status::Running })
    }

    fn change(&mut self, context: &Context, number: usize) -> TaskResult {
        let time = context.time;
        for change in &self.changes[number] {
            let now = &mut self.present[change.joint];
            if let Some(amplitude) = change.amplitude {
                now.amplitude.change(amplitude, time, self.ramp);
            }
            if let Some(frequency) = change.frequency {
                now.phase += TAU * now.frequency.integral(time);
                now.frequency.change(frequency, time, self.ramp);
            }
            if let Some(offset) = change.offset {
                now.offset.change(offset, time, self.ramp);
            }
        }
        Ok(Status::Running)
    }

    fn adopt_changes(&mut self, newer: Box<dyn Task>) {
        if let Some(newer) = super::of_type::<Self>(newer) {
            self.times = newer.times;
            self.changes = newer.changes;
        }
    }

    fn changes(&self) -> &[f64] {
        &self.times
    }

    fn foresight(&self, now: f64) -> Foresight {
        let end = self.start + self.duration;
        let changes = self.present.iter().flat_map(|p| [p.amplitude.end(), p.frequency.end(), p.offset.end()]);
        Foresight::new(now, end, changes.chain([self.start + self.ramp, end - self.ramp]))
    }

    fn command_at(&mut self, time: f64, command: &mut Command) {
        self.swing(time, command);
    }

    fn name(&self) -> &str {
        "sine"
    }
}
