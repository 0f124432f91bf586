//! Joints that are asked exactly what the tasks want, between two tests.
//!
//! With c the posture of the last test, d its distances, and t_k the greatest distance of joint k from c on what it can still
//! do (a free joint: where it is, and its stop from there; another one: the rest of its path), nothing touches as long as
//!
//! ```text
//! d_p - sum over k of min(L_k, r_k) t_k > margin         for every pair p with a free joint ([`super::bound`])
//! ```
//!
//! and the limits hold. That is asked of every tick before it is passed on.

use super::Limits;
use super::candidate::{CandidatePaths, Robot};
use super::desired_motion::{DesiredMotion, PositionHistory};
use super::joint_path::JointPath;
use crate::motion::spline::{TrajectoryPoint, quintic};

/// Shortest and longest time in which the difference between a path and the wanted motion fades, s.
const FADE: (f64, f64) = (0.05, 0.5);

/// Part of the limits of acceleration and jerk that a offset may take.
const PART: f64 = 0.5;

/// A joint that follows nothing and goes this much farther than its last test foresaw makes a cycle come early, rad or m.
const UNFORESEEN: f64 = 2e-3;

/// How a joint is treated.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum JointMode {
    /// It is asked what the tasks want.
    Free,
    /// It follows its path.
    OnPath,
    /// It follows no positions, or is passive: where it is, is measured.
    Uncontrolled,
}

/// A difference from the wanted motion that fades.
#[derive(Clone, Copy, Debug)]
pub(super) struct DecayingOffset {
    from: TrajectoryPoint,
    since: f64,
    length: f64,
}

impl DecayingOffset {
    pub const NONE: DecayingOffset =
        DecayingOffset { from: TrajectoryPoint { q: 0.0, v: 0.0, a: 0.0 }, since: f64::NEG_INFINITY, length: 1.0 };

    /// Of a joint that is at `here` where `wanted` is wanted; none when that would take more than its part of the limits.
    pub fn new(
        here: &TrajectoryPoint,
        wanted: &TrajectoryPoint,
        since: f64,
        period: f64,
        limits: &Limits,
    ) -> Option<Self> {
        let from = TrajectoryPoint { q: here.q - wanted.q, v: here.v - wanted.v, a: here.a - wanted.a };
        let length = period.clamp(FADE.0, FADE.1);
        let (q, v, a) = (from.q.abs(), from.v.abs(), from.a.abs());
        // The quintic's jerk is greatest at its start or end, its acceleration less than the sum of those of its parts.
        let jerk = 60.0 * q / length.powi(3) + 36.0 * v / length.powi(2) + 9.0 * a / length;
        let acceleration = 5.8 * q / length.powi(2) + 4.0 * v / length + a;
        let fits = jerk <= PART * limits.jerk && acceleration <= PART * limits.acceleration;
        fits.then_some(DecayingOffset { from, since, length })
    }

    /// What is left at time `t`.
    pub fn at(&self, t: f64) -> TrajectoryPoint {
        let s = t - self.since;
        if s >= self.length {
            TrajectoryPoint::default()
        } else {
            quintic(&self.from, &TrajectoryPoint::default(), self.length, s)
        }
    }
}

/// What the free joints are asked at a tick.
pub(super) struct TickCheck {
    pub mode: Vec<JointMode>,
    pub offset: Vec<DecayingOffset>,
    /// Was the joint refused for its limits, and is not free again?
    pub late: Vec<bool>,
    /// Greatest distance of each joint from the anchor in what it can still do.
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

    /// What a free joint is asked at time `t` where `wanted` is wanted.
    pub fn asked(&self, joint: usize, wanted: &TrajectoryPoint, t: f64) -> TrajectoryPoint {
        let e = self.offset[joint].at(t);
        TrajectoryPoint { q: wanted.q + e.q, v: wanted.v + e.v, a: wanted.a + e.a }
    }

    /// The stop of a free joint from time `t`, where `wanted` is wanted.
    pub fn stop(&self, joint: usize, wanted: &TrajectoryPoint, t: f64, limits: &Limits) -> JointPath {
        let mut here = self.asked(joint, wanted, t);
        here.v = here.v.clamp(-limits.speed, limits.speed);
        here.a = here.a.clamp(-limits.acceleration, limits.acceleration);
        JointPath::stop(here, t, limits)
    }

    /// May the free joints be asked what is wanted now? `held` has the paths of the others. Marks those that may not in
    /// `refused`.
    pub fn allows(
        &mut self,
        robot: Robot,
        candidate: &CandidatePaths,
        (wanted, asked_before): (&DesiredMotion, &PositionHistory),
        held: &[JointPath],
        limits: &[Limits],
        (now, refused): (f64, &mut [bool]),
    ) -> bool {
        refused.fill(false);
        let mut fine = true;
        for (j, limit) in limits.iter().enumerate() {
            if self.mode[j] == JointMode::Uncontrolled {
                // Where it is now, and what was taken into account of its motion.
                let foreseen = candidate.reach[j];
                self.travel[j] = foreseen.max((held[j].rest() - candidate.anchor[j]).abs());
                fine &= self.travel[j] <= foreseen + UNFORESEEN;
                continue;
            }
            if self.mode[j] != JointMode::Free {
                self.travel[j] = held[j].reach(candidate.anchor[j], now);
                continue;
            }
            let offset = self.offset[j].at(now) != TrajectoryPoint::default();
            let asked = self.asked(j, &wanted.now(j), now);
            let stop = self.stop(j, &wanted.now(j), now, limit);
            let jerk = if offset { (1.0 - PART) * limit.jerk } else { limit.jerk };
            // Rounding of differences of a limit that is met exactly.
            let more = 1.0 + 1e-6;
            let keeps = wanted.jerk(j).abs() <= jerk * more
                && asked.a.abs() <= limit.acceleration * more
                && asked.v.abs() <= limit.speed * more
                && (wanted.has_velocity(j) || asked_before.may_be_followed_by(j, asked.q, limit))
                && stop.keeps(limit);
            if !keeps {
                self.late[j] = true;
                refused[j] = true;
                fine = false;
            }
            self.travel[j] = stop.reach(candidate.anchor[j], now).max((asked.q - candidate.anchor[j]).abs());
        }
        for pair in 0..candidate.clearance.len() {
            let levers = robot.levers.of(pair);
            let free = levers.iter().any(|lever| self.mode[lever.joint] == JointMode::Free);
            if free && !candidate.stays_clear(robot, pair, &self.travel) {
                fine = false;
                levers.iter().filter(|l| self.mode[l.joint] == JointMode::Free).for_each(|l| refused[l.joint] = true);
            }
        }
        fine
    }
}
