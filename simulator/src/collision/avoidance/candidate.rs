//! A set of candidate paths to be proven free, with the fallback paths that the joints follow
//! otherwise.

use super::Limits;
use super::joint_path::JointPath;
use super::levers::Levers;
use super::prover::Prover;
use crate::collision::{CollisionModel, Detector, Proximity};
use crate::motion::spline::TrajectoryPoint;
use crate::robot::Model;

/// Robot, bodies, levers and margin (m) of a proof.
#[derive(Clone, Copy)]
pub(super) struct Robot<'a> {
    pub model: &'a Model,
    pub collision: &'a CollisionModel,
    pub levers: &'a Levers,
    pub margin: f64,
}

/// Excess of the measured over the needed distance, relative and in m, for the motions of the
/// following ticks.
const EXCESS: (f64, f64) = (1.5, 0.02);

/// Samples of a path that leads out of an overlap.
const SAMPLES: usize = 32;

/// Approach allowed to a pair that leaves the margin, m: the proof needs this tolerance.
const APPROACH: f64 = 5e-4;

/// Candidate paths and the workspace of a cycle.
pub(super) struct CandidatePaths {
    pub detector: Detector,
    pub prover: Prover,
    /// Start time of all paths, s.
    pub begin: f64,
    /// The posture at that time.
    pub anchor: Vec<f64>,
    /// Lower bounds of the pairs' distances in that posture, m.
    pub clearance: Vec<f64>,
    /// Distances of the bodies from the joints' axes in that posture.
    radii: Vec<f64>,
    /// Fallback paths of the joints, proven earlier.
    pub fallback: Vec<JointPath>,
    /// The candidate paths.
    pub paths: Vec<JointPath>,
    /// Greatest distance of each joint from the anchor.
    pub reach: Vec<f64>,
    /// True where the path differs from the fallback.
    pub changed: Vec<bool>,
    /// True for joints that follow no command. Their path is predicted, not chosen.
    pub uncontrolled: Vec<bool>,
    /// Pairs for which the last test failed, ascending.
    pub colliding: Vec<usize>,
    open: Vec<usize>,
    posture: Vec<f64>,
}

impl CandidatePaths {
    pub fn new(robot: Robot, start: &[f64]) -> Self {
        let n = robot.collision.pairs.len();
        CandidatePaths {
            detector: Detector::new(robot.collision),
            prover: Prover::new(robot.model, robot.levers, n),
            radii: vec![0.0; robot.levers.count()],
            begin: 0.0,
            anchor: start.to_vec(),
            clearance: vec![0.0; n],
            fallback: start.iter().map(|&q| JointPath::resting(q)).collect(),
            paths: start.iter().map(|&q| JointPath::resting(q)).collect(),
            reach: vec![0.0; start.len()],
            changed: vec![false; start.len()],
            uncontrolled: vec![false; start.len()],
            colliding: Vec::with_capacity(n),
            open: Vec::with_capacity(n),
            posture: start.to_vec(),
        }
    }

    /// Sets a candidate path.
    pub fn set(&mut self, joint: usize, path: JointPath) {
        debug_assert!(!self.uncontrolled[joint]);
        self.paths[joint] = path;
        self.reach[joint] = path.reach(self.anchor[joint], self.begin);
        self.changed[joint] = true;
    }

    /// Returns a joint to its fallback path.
    pub fn reset(&mut self, joint: usize) {
        self.paths[joint] = self.fallback[joint];
        self.reach[joint] = self.paths[joint].reach(self.anchor[joint], self.begin);
        self.changed[joint] = false;
    }

    /// Measures the distances at the anchor as far as the present reaches require.
    pub fn measure(&mut self, robot: Robot) {
        self.prover.set_posture(robot, &mut self.detector, &self.anchor);
        for (pair, clearance) in self.clearance.iter_mut().enumerate() {
            let need = robot.margin + robot.levers.change(pair, &self.reach);
            *clearance = self.detector.clearance(robot.collision, pair, EXCESS.0 * need + EXCESS.1);
            robot.levers.measure(pair, self.prover.poses(), &mut self.radii);
        }
    }

    /// Whether the test at the anchor alone proves that a pair is free.
    pub fn is_clear(&self, robot: Robot, pair: usize) -> bool {
        self.stays_clear(robot, pair, &self.reach)
    }

    /// Whether it proves that for all joint positions within `travel` of the anchor.
    pub fn stays_clear(&self, robot: Robot, pair: usize, travel: &[f64]) -> bool {
        self.clearance[pair] - robot.levers.change_from(pair, &self.radii, travel) > robot.margin
    }

    /// Whether the candidate is proven free. If not, `colliding` contains pairs that are not.
    pub fn succeeds(&mut self, robot: Robot) -> bool {
        self.open.clear();
        self.colliding.clear();
        let mut leaving = false;
        for pair in 0..self.clearance.len() {
            let moves = robot.levers.of(pair).iter().any(|lever| self.changed[lever.joint]);
            if !moves || self.is_clear(robot, pair) {
                continue;
            }
            // Pairs already within the margin are treated separately below.
            let near = self.clearance[pair] <= robot.margin;
            leaving |= near;
            if !near {
                self.open.push(pair);
            }
        }
        if !self.open.is_empty() {
            let (paths, pairs, found) = (&self.paths, &self.open, &mut self.colliding);
            self.prover.prove(robot, &mut self.detector, paths, self.begin, pairs, found);
        }
        if leaving {
            for pair in 0..self.clearance.len() {
                let moves = robot.levers.of(pair).iter().any(|lever| self.changed[lever.joint]);
                if moves && self.clearance[pair] <= robot.margin && !self.leaves(robot, pair) {
                    self.colliding.push(pair);
                }
            }
            self.colliding.sort_unstable();
        }
        self.colliding.is_empty()
    }

    /// Whether a pair within the margin at the anchor moves apart, and hardly closer before. Such
    /// pairs occur only if an uncontrolled joint has moved, or a motion was changed from outside.
    fn leaves(&mut self, robot: Robot, pair: usize) -> bool {
        let ends = robot.levers.of(pair).iter().map(|lever| self.paths[lever.joint].end());
        let end = ends.fold(self.begin, f64::max);
        let first = self.distance_at(robot, pair, self.begin);
        let last = self.distance_at(robot, pair, end);
        if !(last > first) {
            return false;
        }
        let floor = first - APPROACH;
        if floor > 0.0 {
            let robot = Robot { margin: floor, ..robot };
            return self.prover.prove(robot, &mut self.detector, &self.paths, self.begin, &[pair], &mut self.open);
        }
        // No margin can be proven for overlapping bodies, or nearly so: depths are sampled.
        let mut before = first;
        for k in 1..=SAMPLES {
            let now = self.distance_at(robot, pair, self.begin + (end - self.begin) * k as f64 / SAMPLES as f64);
            if now < before - 1e-9 {
                return false;
            }
            before = now;
        }
        true
    }

    fn distance_at(&mut self, robot: Robot, pair: usize, t: f64) -> f64 {
        self.posture.iter_mut().zip(&self.paths).for_each(|(q, path)| *q = path.at(t).q);
        self.prover.set_posture(robot, &mut self.detector, &self.posture);
        self.detector.proximity(robot.collision, pair).distance
    }

    /// Brakes the joints whose fallback an uncontrolled joint has blocked, if braking causes no
    /// other collision. `here` is their motion at the start.
    pub fn brake(&mut self, robot: Robot, here: &[TrajectoryPoint], limits: &[Limits]) {
        self.open.clear();
        for pair in 0..self.clearance.len() {
            let levers = robot.levers.of(pair);
            let uncontrolled = levers.iter().any(|l| self.uncontrolled[l.joint]);
            let moves = levers.iter().any(|l| !self.uncontrolled[l.joint] && self.fallback[l.joint].end() > self.begin);
            if uncontrolled && moves && !self.is_clear(robot, pair) {
                self.open.push(pair);
            }
        }
        let (detector, found) = (&mut self.detector, &mut self.colliding);
        let proven = self.prover.prove(robot, detector, &self.fallback, self.begin, &self.open, found);
        if self.open.is_empty() || proven {
            return;
        }
        self.open.clone_from(&self.colliding);
        for k in 0..self.open.len() {
            for lever in robot.levers.of(self.open[k]) {
                if !self.uncontrolled[lever.joint] {
                    self.set(lever.joint, JointPath::stop(here[lever.joint], self.begin, &limits[lever.joint]));
                }
            }
        }
        let braked = self.succeeds(robot);
        for j in 0..self.changed.len() {
            if self.changed[j] && (braked || !self.has_controlled_collision(robot)) {
                self.fallback[j] = self.paths[j];
            }
        }
        for j in 0..self.changed.len() {
            self.reset(j);
        }
        self.colliding.clear();
    }

    /// Whether one of the colliding pairs has no uncontrolled joints.
    fn has_controlled_collision(&self, robot: Robot) -> bool {
        self.colliding.iter().any(|pair| robot.levers.of(*pair).iter().all(|l| !self.uncontrolled[l.joint]))
    }

    /// Nearest points of a pair at time `t` of `paths`; leaves the prover's poses at that time.
    pub fn proximity_at(&mut self, robot: Robot, paths: &[JointPath], t: f64, pair: usize) -> Proximity {
        self.posture.iter_mut().zip(paths).for_each(|(q, path)| *q = path.at(t).q);
        self.prover.set_posture(robot, &mut self.detector, &self.posture);
        self.detector.proximity(robot.collision, pair)
    }

    /// Whether all pairs are free on `paths`, from any start.
    pub fn is_free(&mut self, robot: Robot, paths: &[JointPath]) -> bool {
        self.open.clear();
        self.open.extend(0..self.clearance.len());
        let (begin, pairs, found) = (self.begin, &self.open, &mut self.colliding);
        self.prover.prove(robot, &mut self.detector, paths, begin, pairs, found);
        let free = self.colliding.is_empty();
        self.colliding.clear();
        free
    }
}
