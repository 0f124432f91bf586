//! Proof that a motion comes nowhere nearer than the margin, at any time of it and not only at samples.
//!
//! On an interval of time let m be the posture in its middle and t_k the greatest distance of joint k from there. By the
//! levers L_k and r_k of [`super::bound`] a pair whose distance d at m obeys
//!
//! ```text
//! d > margin + sum over k of min(L_k, r_k) t_k
//! ```
//!
//! stays farther apart than the margin all through the interval. Where that fails the interval is halved, for the pairs in
//! question alone, until it holds, or d <= margin, or the sum is below [`RESOLUTION`], or [`MOST_POSTURES`] were tested: then the pair
//! is taken as colliding.
//! Whole levels of halves are looked at before smaller ones, so that a collision is soon found.

use super::joint_path::JointPath;
use super::levers::Levers;
use crate::collision::kinematics::{LinkPose, link_poses};
use crate::collision::{CollisionModel, Detector};
use crate::robot::Model;

/// Motion within which a pair that is not proven to be clear of the margin counts as colliding, m.
const RESOLUTION: f64 = 2e-4;

/// Postures after which what is not proven counts as colliding.
const MOST_POSTURES: usize = 256;

struct Interval {
    from: f64,
    to: f64,
    /// Its part of the pairs in question.
    first: usize,
    last: usize,
}

/// Workspace. Nothing is allocated after construction.
pub(super) struct Prover {
    poses: Vec<LinkPose>,
    posture: Vec<f64>,
    travel: Vec<f64>,
    radii: Vec<f64>,
    /// Intervals of this level and the next, and the pairs in question in them.
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

    /// Puts the robot into a posture for questions to `detector`.
    pub fn set_posture(&mut self, model: &Model, collision: &CollisionModel, detector: &mut Detector, q: &[f64]) {
        link_poses(model, q, &mut self.poses);
        detector.set_poses(collision, &self.poses);
    }

    /// Poses of the links where the robot was last put.
    pub fn poses(&self) -> &[LinkPose] {
        &self.poses
    }

    /// Are `pairs` proven to stay farther apart than `margin` along `paths` from `begin` on? If not, the first ones found
    /// that are not come into `colliding`, ascending.
    #[allow(clippy::too_many_arguments)]
    pub fn prove(
        &mut self,
        (model, collision, levers): (&Model, &CollisionModel, &Levers),
        detector: &mut Detector,
        paths: &[JointPath],
        begin: f64,
        margin: f64,
        pairs: &[usize],
        colliding: &mut Vec<usize>,
    ) -> bool {
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
