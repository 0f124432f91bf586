//! Checks at each tick whether free joints may follow the desired motion unchanged.
//!
//! Let c be the posture of the last test, d its distances, and t_k the greatest distance of joint k
//! from c on its remaining motion: for a free joint its position and its stop from there, for other
//! joints the rest of their paths. No pair touches as long as
//!
//! ```text
//! d_p - sum over k of min(L_k, r_k) t_k > margin         for every pair p with a free joint ([`super::levers`])
//! ```
//!
//! and the limits hold.

use super::Limits;
use super::candidate::{CandidatePaths, Robot};
use super::desired_motion::{DesiredMotion, PositionHistory};
use super::joint_path::JointPath;
use crate::math;
use crate::motion::spline::{TrajectoryPoint, quintic};

/// Shortest and longest decay of the difference between a path and the desired motion, s.
const DECAY: (f64, f64) = (0.05, 0.5);

/// Fraction of the limits of acceleration and jerk that a decay may use.
const DECAY_SHARE: f64 = 0.5;

/// An uncontrolled joint that moves this much farther than its last test assumed triggers an early
/// cycle, rad or m.
const UNTESTED: f64 = 2e-3;

/// How a joint is commanded.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum JointMode {
    /// It follows the desired motion.
    Free,
    /// It follows its proven path.
    OnPath,
    /// It does not follow position commands; its position is measured.
    Uncontrolled,
}

/// An offset from the desired motion that decays along a quintic.
#[derive(Clone, Copy, Debug)]
pub(super) struct DecayingOffset {
    from: TrajectoryPoint,
    since: f64,
    length: f64,
}

impl DecayingOffset {
    pub const NONE: DecayingOffset =
        DecayingOffset { from: TrajectoryPoint { q: 0.0, v: 0.0, a: 0.0 }, since: f64::NEG_INFINITY, length: 1.0 };

    /// For a joint at `here` whose desired motion is at `desired`; none if the decay exceeds its
    /// share of the limits.
    pub fn new(
        here: &TrajectoryPoint,
        desired: &TrajectoryPoint,
        since: f64,
        period: f64,
        limits: &Limits,
    ) -> Option<Self> {
        let from = TrajectoryPoint { q: here.q - desired.q, v: here.v - desired.v, a: here.a - desired.a };
        let length = period.clamp(DECAY.0, DECAY.1);
        let (q, v, a) = (from.q.abs(), from.v.abs(), from.a.abs());
        // The quintic's jerk is greatest at its start or end; its acceleration is less than the sum
        // of those of its parts.
        let jerk = 60.0 * q / math::powi(length, 3) + 36.0 * v / math::powi(length, 2) + 9.0 * a / length;
        let acceleration = 5.8 * q / math::powi(length, 2) + 4.0 * v / length + a;
        let fits = jerk <= DECAY_SHARE * limits.jerk && acceleration <= DECAY_SHARE * limits.acceleration;
        fits.then_some(DecayingOffset { from, since, length })
    }

    /// The remaining offset at time `t`.
    pub fn at(&self, t: f64) -> TrajectoryPoint {
        let s = t - self.since;
        if s >= self.length {
            TrajectoryPoint::default()
        } else {
            quintic(&self.from, &TrajectoryPoint::default(), self.length, s)
        }
    }
}

/// Modes and offsets of the joints, and the check of a tick.
pub(super) struct TickCheck {
    pub mode: Vec<JointMode>,
    pub offset: Vec<DecayingOffset>,
    /// Joints that were refused for their limits and are not free again.
    pub late: Vec<bool>,
    /// Greatest distance of each joint from the anchor on its remaining motion.
    travel: Vec<f64>,
}

impl TickCheck {
    pub fn new(joints: usize) -> Self {
        TickCheck {
            mode: vec![JointMode::Free; joints],
            offset: vec![DecayingOffset::NONE; joints],
            late: vec![false; joints],
            travel: vec![0.0; joints],
        }
    }

    /// Command of a free joint at time `t` for the desired motion `desired`.
    pub fn command(&self, joint: usize, desired: &TrajectoryPoint, t: f64) -> TrajectoryPoint {
        let e = self.offset[joint].at(t);
        TrajectoryPoint { q: desired.q + e.q, v: desired.v + e.v, a: desired.a + e.a }
    }

    /// The stop of a free joint from time `t`, for the desired motion `desired`.
    pub fn stop(&self, joint: usize, desired: &TrajectoryPoint, t: f64, limits: &Limits) -> JointPath {
        let mut here = self.command(joint, desired, t);
        here.v = here.v.clamp(-limits.speed, limits.speed);
        here.a = here.a.clamp(-limits.acceleration, limits.acceleration);
        JointPath::stop(here, t, limits)
    }

    /// Whether the free joints may follow the desired motion now. `paths` are those of the other
    /// joints. Marks joints that may not in `refused`.
    pub fn allows(
        &mut self,
        robot: Robot,
        candidate: &CandidatePaths,
        (desired, commanded): (&DesiredMotion, &PositionHistory),
        paths: &[JointPath],
        limits: &[Limits],
        (now, refused): (f64, &mut [bool]),
    ) -> bool {
        refused.fill(false);
        let mut safe = true;
        for (j, limit) in limits.iter().enumerate() {
            if self.mode[j] == JointMode::Uncontrolled {
                // Its position now, and the motion that the last test covered.
                let tested = candidate.reach[j];
                self.travel[j] = tested.max((paths[j].rest() - candidate.anchor[j]).abs());
                safe &= self.travel[j] <= tested + UNTESTED;
                continue;
            }
            if self.mode[j] != JointMode::Free {
                self.travel[j] = paths[j].reach(candidate.anchor[j], now);
                continue;
            }
            let offset = self.offset[j].at(now) != TrajectoryPoint::default();
            let command = self.command(j, &desired.now(j), now);
            let stop = self.stop(j, &desired.now(j), now, limit);
            let jerk = if offset { (1.0 - DECAY_SHARE) * limit.jerk } else { limit.jerk };
            // Rounding of differences at a limit.
            let more = 1.0 + 1e-6;
            let keeps = desired.jerk(j).abs() <= jerk * more
                && command.a.abs() <= limit.acceleration * more
                && command.v.abs() <= limit.speed * more
                && (desired.has_velocity(j) || commanded.may_be_followed_by(j, command.q, limit))
                && stop.keeps(limit);
            if !keeps {
                self.late[j] = true;
                refused[j] = true;
                safe = false;
            }
            self.travel[j] = stop.reach(candidate.anchor[j], now).max((command.q - candidate.anchor[j]).abs());
        }
        for pair in 0..candidate.clearance.len() {
            let levers = robot.levers.of(pair);
            let free = levers.iter().any(|lever| self.mode[lever.joint] == JointMode::Free);
            if free && !candidate.stays_clear(robot, pair, &self.travel) {
                safe = false;
                levers.iter().filter(|l| self.mode[l.joint] == JointMode::Free).for_each(|l| refused[l.joint] = true);
            }
        }
        safe
    }
}
