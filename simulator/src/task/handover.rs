//! Hands joints back when a task ends, without jumps and without residues in the commands of later
//! tasks.
//!
//! - **Modes and efforts** of a *temporary* task ([`super::Task::is_temporary`]) apply while it
//!   runs. Each tick starts from the base layer: the modes and efforts set by the robot or a
//!   script.
//! - **Efforts** that an ended temporary task has set on a joint that follows positions or
//!   velocities decay to those of the base layer within [`RELEASE_TIME`] seconds. On other joints
//!   the effort of the base layer applies at once.
//! - **Positions**: if a task that ends releases a joint to an earlier task that is still running,
//!   their difference decays within [`RELEASE_TIME`] seconds on top of the commanded position. A joint
//!   that no other task moves holds its last position: its commanded velocity becomes zero, except in
//!   mode `velocity`.
//!
//! Both differences decay along the quintic of [`super::blend_in`].

use super::Command;
use super::has_elapsed;
use crate::motion::spline::{TrajectoryPoint, quintic};
use crate::robot::DriveMode;

/// Time in which the offsets of an ended task decay, s.
pub const RELEASE_TIME: f64 = 0.5;

/// A difference that decays.
#[derive(Clone, Copy, Debug)]
struct ReleaseOffset {
    from: TrajectoryPoint,
    since: f64,
}

impl ReleaseOffset {
    const NONE: ReleaseOffset =
        ReleaseOffset { from: TrajectoryPoint { q: 0.0, v: 0.0, a: 0.0 }, since: f64::NEG_INFINITY };

    /// The remaining difference; none once it has decayed.
    fn at(&self, time: f64) -> Option<TrajectoryPoint> {
        let t = time - self.since;
        (!has_elapsed(t, RELEASE_TIME)).then(|| quintic(&self.from, &TrajectoryPoint::default(), RELEASE_TIME, t))
    }
}

/// Efforts that one temporary task has set.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TemporaryEfforts {
    /// By joint: its last effort, if it has set the joint's effort or mode.
    efforts: Vec<Option<f64>>,
}

impl TemporaryEfforts {
    /// For a robot with `joints` joints.
    pub fn new(joints: usize) -> Self {
        TemporaryEfforts { efforts: vec![None; joints] }
    }
}

/// Positions and velocities that one task has commanded.
#[derive(Clone, Debug)]
pub struct LastCommand {
    /// By joint; none where the command is that of another task.
    joints: Vec<Option<(f64, f64)>>,
}

impl LastCommand {
    /// For a robot with `joints` joints.
    pub fn new(joints: usize) -> Self {
        LastCommand { joints: vec![None; joints] }
    }
}

/// Position and velocity without a task that has just ended, and the offset of the task from them.
#[derive(Clone, Copy, Debug)]
struct ReleasedJoint {
    underlying: (f64, f64),
    offset: TrajectoryPoint,
}

/// Base layer of the command, and the differences that decay on top of it.
#[derive(Clone, Debug)]
pub struct Handover {
    mode: Vec<DriveMode>,
    effort: Vec<f64>,
    efforts: Vec<ReleaseOffset>,
    positions: Vec<ReleaseOffset>,
    /// Position and velocity without decaying differences, for joints that have any.
    plain: Vec<Option<(f64, f64)>>,
    /// The command before the current task was called.
    before: Command,
    /// Joints that a task of this tick has moved.
    moved: Vec<bool>,
    released: Vec<Option<ReleasedJoint>>,
    /// Time at which all differences have decayed, s.
    until: f64,
}

impl Handover {
    /// `command` becomes the base layer.
    pub fn new(command: &Command) -> Self {
        let n = command.position.len();
        Handover {
            mode: command.mode.clone(),
            effort: command.effort.clone(),
            efforts: vec![ReleaseOffset::NONE; n],
            positions: vec![ReleaseOffset::NONE; n],
            plain: vec![None; n],
            before: command.clone(),
            moved: vec![false; n],
            released: vec![None; n],
            until: f64::NEG_INFINITY,
        }
    }

    /// Time at which all differences have decayed, s.
    pub fn until(&self) -> f64 {
        self.until
    }

    /// Starts a tick: sets `command` to the base layer.
    pub fn begin(&mut self, time: f64, command: &mut Command) {
        self.moved.fill(false);
        command.mode.copy_from_slice(&self.mode);
        for j in 0..self.mode.len() {
            command.effort[j] = self.base_effort(j, time);
            if let Some(plain) = self.plain[j].take() {
                (command.position[j], command.velocity[j]) = plain;
            }
        }
    }

    /// Effort of the base layer with its decaying difference.
    fn base_effort(&self, j: usize, time: f64) -> f64 {
        self.effort[j] + self.efforts[j].at(time).map_or(0.0, |p| p.q)
    }

    /// Saves the command before a task is called.
    pub fn before(&mut self, command: &Command) {
        self.before.copy_from(command);
    }

    /// Processes the command after a task was called, or has ended without a call. A temporary task passes its
    /// `temporary` efforts; `ended` when it is done.
    pub fn after(
        &mut self,
        temporary: Option<&mut TemporaryEfforts>,
        last: &mut LastCommand,
        ended: bool,
        time: f64,
        command: &mut Command,
    ) {
        match temporary {
            None => self.store(command),
            Some(temporary) => self.store_temporary(temporary, ended, time, command),
        }
        self.note(last, ended, command);
        for (j, last) in last.joints.iter().enumerate() {
            let Some(of_task) = *last else { continue };
            let before = (self.before.position[j], self.before.velocity[j]);
            if ended && self.moved[j] {
                // Another task that has ended in this tick is not what the joint returns to.
                let underlying = self.released[j].map_or(before, |released| released.underlying);
                let offset = TrajectoryPoint { q: of_task.0 - underlying.0, v: of_task.1 - underlying.1, a: 0.0 };
                self.released[j] = Some(ReleasedJoint { underlying, offset });
                continue;
            }
            self.released[j] = None;
            self.moved[j] |= !ended;
            if ended {
                let turns = self.mode[j] == DriveMode::Velocity;
                (command.position[j], command.velocity[j]) = (of_task.0, if turns { of_task.1 } else { 0.0 });
            }
        }
    }

    /// Sets `last` to what a task has commanded. Of a task that has `ended`, joints that it has not commanded this time
    /// keep what they have, and so does a joint that still has the same command.
    pub fn note(&self, last: &mut LastCommand, ended: bool, command: &Command) {
        for (j, last) in last.joints.iter_mut().enumerate() {
            let now = (command.position[j], command.velocity[j]);
            let set = now != (self.before.position[j], self.before.velocity[j]);
            *last = if set { Some(now) } else { last.filter(|last| ended || *last == now) };
        }
    }

    /// Stores the modes and efforts set by a lasting task in the base layer.
    fn store(&mut self, command: &Command) {
        for j in 0..self.mode.len() {
            if command.mode[j] != self.before.mode[j] {
                self.mode[j] = command.mode[j];
            }
            if command.effort[j] != self.before.effort[j] {
                self.effort[j] = command.effort[j];
                self.efforts[j] = ReleaseOffset::NONE;
            }
        }
    }

    /// Records the efforts set by a temporary task; starts their decay when it has ended.
    fn store_temporary(&mut self, temporary: &mut TemporaryEfforts, ended: bool, time: f64, command: &mut Command) {
        for j in 0..self.mode.len() {
            let set = command.effort[j] != self.before.effort[j] || command.mode[j] != self.before.mode[j];
            if set {
                temporary.efforts[j] = Some(command.effort[j]);
            }
            let Some(last) = temporary.efforts[j].filter(|_| ended) else { continue };
            // Whether no earlier running task sets this joint.
            let is_lowest = self.before.mode[j] == self.mode[j] && self.before.effort[j] == self.base_effort(j, time);
            let decays = matches!(self.mode[j], DriveMode::Position | DriveMode::Velocity);
            self.efforts[j] = ReleaseOffset::NONE;
            if decays {
                self.efforts[j] =
                    ReleaseOffset { from: TrajectoryPoint { q: last - self.effort[j], v: 0.0, a: 0.0 }, since: time };
                self.until = time + RELEASE_TIME;
            }
            if is_lowest {
                command.effort[j] = self.base_effort(j, time);
            }
        }
    }

    /// Ends a tick: adds the decaying differences of positions to `command`.
    pub fn end(&mut self, time: f64, command: &mut Command) {
        for j in 0..self.mode.len() {
            let decaying = self.positions[j].at(time);
            if let Some(ReleasedJoint { underlying, offset }) = self.released[j].take() {
                (command.position[j], command.velocity[j]) = underlying;
                let e = decaying.unwrap_or_default();
                self.positions[j] = ReleaseOffset {
                    from: TrajectoryPoint { q: e.q + offset.q, v: e.v + offset.v, a: e.a },
                    since: time,
                };
                self.until = time + RELEASE_TIME;
            }
            if let Some(e) = self.positions[j].at(time) {
                self.plain[j] = Some((command.position[j], command.velocity[j]));
                command.position[j] += e.q;
                command.velocity[j] += e.v;
            }
        }
    }
}
