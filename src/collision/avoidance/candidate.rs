//! One set of paths under proof, beside the paths that the joints follow fallback.

use super::Limits;
use super::joint_path::JointPath;
use super::levers::Levers;
use super::prover::Prover;
use crate::collision::{CollisionModel, Detector, Proximity};
use crate::motion::spline::TrajectoryPoint;
use crate::robot::Model;

/// What a candidate is about: robot, bodies, levers.
#[derive(Clone, Copy)]
pub(super) struct Robot<'a> {
    pub model: &'a Model,
    pub collision: &'a CollisionModel,
    pub levers: &'a Levers,
    pub margin: f64,
}

/// How much farther than it has to a distance is looked at, relative and in m, so that the motions of the ticks to come find room.
const MORE: (f64, f64) = (1.5, 0.02);

/// Samples of a path that leads out of an overlap.
const SAMPLES: usize = 32;

/// How much nearer a pair within the margin may come on its way out of it, m: for the proof to have room.
const LEAVING: f64 = 5e-4;

/// Workspace of a cycle.
pub(super) struct CandidatePaths {
    pub detector: Detector,
    pub prover: Prover,
    /// The beginning of all paths, s.
    pub begin: f64,
    /// The posture there.
    pub anchor: Vec<f64>,
    /// Lower bounds of the pairs' distances there, m.
    pub clearance: Vec<f64>,
    /// Distances of the bodies from the joints' axes there.
    radii: Vec<f64>,
    /// What the joints do fallback: proven before.
    pub fallback: Vec<JointPath>,
    /// What is tried.
    pub paths: Vec<JointPath>,
    /// Greatest distance of each from the anchor.
    pub reach: Vec<f64>,
    /// Is the path another than `fallback`?
    pub changed: Vec<bool>,
    /// Does the joint follow nothing? Its path is what is known of it, and not to be chosen.
    pub uncontrolled: Vec<bool>,
    /// Pairs for which the last candidate failed, ascending.
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

    /// Lets a joint try a path.
    pub fn set(&mut self, joint: usize, path: JointPath) {
        debug_assert!(!self.uncontrolled[joint]);
        self.paths[joint] = path;
        self.reach[joint] = path.reach(self.anchor[joint], self.begin);
        self.changed[joint] = true;
    }

    /// Lets it do what it does fallback.
    pub fn reset(&mut self, joint: usize) {
        self.paths[joint] = self.fallback[joint];
        self.reach[joint] = self.paths[joint].reach(self.anchor[joint], self.begin);
        self.changed[joint] = false;
    }

    /// Measures the distances at the anchor, as far as the present reaches ask for them.
    pub fn measure(&mut self, robot: Robot) {
        self.prover.set_posture(robot.model, robot.collision, &mut self.detector, &self.anchor);
        for (pair, clearance) in self.clearance.iter_mut().enumerate() {
            let need = robot.margin + robot.levers.change(pair, &self.reach);
            *clearance = self.detector.clearance(robot.collision, pair, MORE.0 * need + MORE.1);
            robot.levers.measure(pair, self.prover.poses(), &mut self.radii);
        }
    }

    /// Does the test at the anchor alone prove that a pair is free?
    pub fn is_clear(&self, robot: Robot, pair: usize) -> bool {
        self.stays_clear(robot, pair, &self.reach)
    }

    /// Does it prove that wherever the joints are, if within `travel` of the anchor?
    pub fn stays_clear(&self, robot: Robot, pair: usize, travel: &[f64]) -> bool {
        self.clearance[pair] - robot.levers.change_from(pair, &self.radii, travel) > robot.margin
    }

    /// Is the candidate proven to be free? If not, `colliding` holds pairs that are not.
    pub fn succeeds(&mut self, robot: Robot) -> bool {
        self.open.clear();
        self.colliding.clear();
        let mut leaving = false;
        for pair in 0..self.clearance.len() {
            let moves = robot.levers.of(pair).iter().any(|lever| self.changed[lever.joint]);
            if !moves || self.is_clear(robot, pair) {
                continue;
            }
            // What is too near from the start is none of the prover's business.
            let near = self.clearance[pair] <= robot.margin;
            leaving |= near;
            if !near {
                self.open.push(pair);
            }
        }
        if !self.open.is_empty() {
            let parts = (robot.model, robot.collision, robot.levers);
            let (paths, pairs, found) = (&self.paths, &self.open, &mut self.colliding);
            self.prover.prove(parts, &mut self.detector, paths, self.begin, robot.margin, pairs, found);
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

    /// Does a pair that is within the margin at the anchor get farther apart, and come hardly nearer on the way? This can
    /// only be where a joint that does not follow its command has moved, or a motion was changed from outside.
    fn leaves(&mut self, robot: Robot, pair: usize) -> bool {
        let own = robot.levers.of(pair).iter().map(|lever| self.paths[lever.joint].end());
        let end = own.fold(self.begin, f64::max);
        let first = self.distance_at(robot, pair, self.begin);
        let last = self.distance_at(robot, pair, end);
        if !(last > first) {
            return false;
        }
        let floor = first - LEAVING;
        if floor > 0.0 {
            let parts = (robot.model, robot.collision, robot.levers);
            return self.prover.prove(
                parts,
                &mut self.detector,
                &self.paths,
                self.begin,
                floor,
                &[pair],
                &mut self.open,
            );
        }
        // Overlapping, or nearly: there is no margin to prove, and depths are looked at.
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
        self.prover.set_posture(robot.model, robot.collision, &mut self.detector, &self.posture);
        self.detector.proximity(robot.collision, pair).distance
    }

    /// Where a joint that follows nothing has come in the way of what the others do fallback, makes these brake, if they run
    /// into nothing else so. `here` has their motion at the beginning.
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
        let parts = (robot.model, robot.collision, robot.levers);
        let (detector, found) = (&mut self.detector, &mut self.colliding);
        let proven = self.prover.prove(parts, detector, &self.fallback, self.begin, robot.margin, &self.open, found);
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
            if self.changed[j] && (braked || !self.hits_followed(robot)) {
                self.fallback[j] = self.paths[j];
            }
        }
        for j in 0..self.changed.len() {
            self.reset(j);
        }
        self.colliding.clear();
    }

    /// Is one of the colliding pairs without joints that follow nothing?
    fn hits_followed(&self, robot: Robot) -> bool {
        self.colliding.iter().any(|pair| robot.levers.of(*pair).iter().all(|l| !self.uncontrolled[l.joint]))
    }

    /// Nearest points of a pair at time `t` of `paths`, in which the prover's poses then are.
    pub fn proximity_at(&mut self, robot: Robot, paths: &[JointPath], t: f64, pair: usize) -> Proximity {
        self.posture.iter_mut().zip(paths).for_each(|(q, path)| *q = path.at(t).q);
        self.prover.set_posture(robot.model, robot.collision, &mut self.detector, &self.posture);
        self.detector.proximity(robot.collision, pair)
    }

    /// Is everything free on `paths`, wherever they begin?
    pub fn is_free(&mut self, robot: Robot, paths: &[JointPath]) -> bool {
        self.open.clear();
        self.open.extend(0..self.clearance.len());
        let parts = (robot.model, robot.collision, robot.levers);
        let (begin, pairs, found) = (self.begin, &self.open, &mut self.colliding);
        self.prover.prove(parts, &mut self.detector, paths, begin, robot.margin, pairs, found);
        let free = self.colliding.is_empty();
        self.colliding.clear();
        free
    }
}
