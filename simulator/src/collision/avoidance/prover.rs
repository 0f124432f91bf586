//! Proves that a motion keeps the margin at all times, not only at samples.
//!
//! On a time interval let m be the posture at its middle and t_k the greatest distance of joint k
//! from m. By the levers L_k and r_k of [`super::levers`] a pair whose distance d at m obeys
//!
//! ```text
//! d > margin + sum over k of min(L_k, r_k) t_k
//! ```
//!
//! keeps the margin throughout the interval. Otherwise the interval is bisected for the remaining
//! pairs only. A pair counts as colliding when d <= margin, when the sum is below [`RESOLUTION`],
//! or when [`MOST_POSTURES`] were tested. Bisection is breadth first, so that a collision is found
//! early.
//!
//! Joints are assumed to move linearly between ticks. At 50 rad/s^2 and ticks of 2 ms the
//! difference is 25 microrad.

use super::candidate::Robot;
use super::joint_path::JointPath;
use super::levers::Levers;
use crate::collision::Detector;
use crate::collision::kinematics::{LinkPose, link_poses};
use crate::robot::Model;

/// Motion within which a pair not proven to keep the margin counts as colliding, m.
const RESOLUTION: f64 = 2e-4;

/// Number of tests after which a pair not yet proven counts as colliding.
const MOST_POSTURES: usize = 256;

struct Interval {
    from: f64,
    to: f64,
    /// Range of its remaining pairs.
    first: usize,
    last: usize,
}

/// Workspace of the proof. Allocates nothing after construction.
pub(super) struct Prover {
    poses: Vec<LinkPose>,
    posture: Vec<f64>,
    travel: Vec<f64>,
    radii: Vec<f64>,
    /// Intervals of this level and the next, and their remaining pairs.
    level: Vec<Interval>,
    next: Vec<Interval>,
    pairs: Vec<usize>,
    next_pairs: Vec<usize>,
}

impl Prover {
    pub fn new(model: &Model, levers: &Levers, pairs: usize) -> Self {
        let list = || Vec::with_capacity(MOST_POSTURES * pairs);
        Prover {
            poses: vec![LinkPose::IDENTITY; model.links.len()],
            posture: vec![0.0; model.nj()],
            travel: vec![0.0; model.nj()],
            radii: vec![0.0; levers.count()],
            level: Vec::with_capacity(2 * MOST_POSTURES),
            next: Vec::with_capacity(2 * MOST_POSTURES),
            pairs: list(),
            next_pairs: list(),
        }
    }

    /// Sets the robot's posture for queries to `detector`.
    pub fn set_posture(&mut self, robot: Robot, detector: &mut Detector, q: &[f64]) {
        link_poses(robot.model, q, &mut self.poses);
        detector.set_poses(robot.collision, &self.poses);
    }

    /// Link poses of the last posture.
    pub fn poses(&self) -> &[LinkPose] {
        &self.poses
    }

    /// Proves that `pairs` stay farther apart than the margin along `paths` from `begin` on. If
    /// not, the first failures found are in `colliding`, ascending.
    pub fn prove(
        &mut self,
        robot: Robot,
        detector: &mut Detector,
        paths: &[JointPath],
        begin: f64,
        pairs: &[usize],
        colliding: &mut Vec<usize>,
    ) -> bool {
        let Robot { model, collision, levers, margin } = robot;
        colliding.clear();
        let end = paths.iter().map(JointPath::end).fold(begin, f64::max);
        self.pairs.clear();
        self.pairs.extend_from_slice(pairs);
        self.level.clear();
        self.level.push(Interval { from: begin, to: end, first: 0, last: pairs.len() });
        let mut postures = 0;
        while !self.level.is_empty() {
            self.next.clear();
            self.next_pairs.clear();
            for Interval { from, to, first, last } in self.level.drain(..) {
                let middle = 0.5 * (from + to);
                for (j, path) in paths.iter().enumerate() {
                    let q = path.at(middle).q;
                    let [low, high] = path.range(from, to);
                    self.posture[j] = q;
                    self.travel[j] = (high - q).max(q - low);
                }
                link_poses(model, &self.posture, &mut self.poses);
                detector.set_poses(collision, &self.poses);
                postures += 1;
                let start = self.next_pairs.len();
                for &pair in &self.pairs[first..last] {
                    let change = levers.change(pair, &self.travel);
                    if !detector.is_within(collision, pair, margin + change) {
                        continue;
                    }
                    levers.measure(pair, &self.poses, &mut self.radii);
                    let change = levers.change_from(pair, &self.radii, &self.travel);
                    if !detector.is_within(collision, pair, margin + change) {
                        continue;
                    }
                    if change < RESOLUTION || postures >= MOST_POSTURES || detector.is_within(collision, pair, margin) {
                        colliding.push(pair);
                    } else {
                        self.next_pairs.push(pair);
                    }
                }
                if !colliding.is_empty() {
                    colliding.sort_unstable();
                    return false;
                }
                let last = self.next_pairs.len();
                if last > start {
                    self.next.push(Interval { from, to: middle, first: start, last });
                    self.next.push(Interval { from: middle, to, first: start, last });
                }
            }
            std::mem::swap(&mut self.level, &mut self.next);
            std::mem::swap(&mut self.pairs, &mut self.next_pairs);
        }
        true
    }
}
