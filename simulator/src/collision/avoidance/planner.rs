//! One planning cycle: the goals of the joints, the paths proposed to reach them, and the candidate
//! under test.

use super::Limits;
use super::candidate::{CandidatePaths, Robot};
use super::joint_path::JointPath;
use crate::math;
use crate::motion::spline::TrajectoryPoint;

/// How collisions are avoided.
#[derive(Clone, Debug)]
pub struct Settings {
    /// 1 to 4 as in the paper's Table I.
    pub method: u8,
    /// Cycles per second.
    pub rate: f64,
    /// Distance to keep, m.
    pub margin: f64,
    /// Limits by joint.
    pub limits: Vec<Limits>,
    /// Seed of the random postures.
    pub seed: u64,
}

/// A joint this near to its goal has reached it, rad or m.
pub(super) const AT_GOAL: f64 = 1e-3;

/// State of a cycle and scratch of the methods. Allocates nothing after construction.
pub(super) struct Planner {
    pub settings: Settings,
    pub candidate: CandidatePaths,
    /// Joints that the method keeps from their goals.
    pub stopped: Vec<bool>,
    /// Desired positions one cycle ahead.
    pub goal: Vec<f64>,
    /// Paths to the goals; the fallback where no path keeps the limits.
    pub proposed: Vec<JointPath>,
    /// Joints that the next trial moves.
    pub marked: Vec<bool>,
    /// Time of the current tick, s.
    pub now: f64,
    /// Paths of the marked joints before the last trial.
    previous: Vec<JointPath>,
    /// Paths from the end of the candidate to the goals.
    continuation: Vec<JointPath>,
}

impl Planner {
    /// For a robot at rest at `start` at time `now`.
    pub fn new(settings: Settings, robot: Robot, start: &[f64], now: f64) -> Self {
        let resting: Vec<JointPath> = start.iter().map(|&q| JointPath::resting(q)).collect();
        Planner {
            settings,
            candidate: CandidatePaths::new(robot, start),
            stopped: vec![false; start.len()],
            goal: start.to_vec(),
            proposed: resting.clone(),
            marked: vec![false; start.len()],
            now,
            previous: resting.clone(),
            continuation: resting,
        }
    }

    /// Marks the joints that methods 3 and 4 may move: stopped, and not at their goals.
    pub fn mark_movable(&mut self) {
        for j in 0..self.marked.len() {
            self.marked[j] = self.stopped[j] && (self.goal[j] - self.candidate.anchor[j]).abs() > AT_GOAL;
        }
    }

    /// Saves the paths of the marked joints and tries others; a joint for which `path` gives none
    /// keeps its own. Returns whether the candidate is then proven free.
    pub fn try_marked(&mut self, robot: Robot, path: impl Fn(&Self, usize) -> Option<JointPath>) -> bool {
        for j in 0..self.marked.len() {
            if !self.marked[j] {
                continue;
            }
            self.previous[j] = self.candidate.paths[j];
            if let Some(path) = path(self, j) {
                self.candidate.set(j, path);
            }
        }
        self.candidate.succeeds(robot)
    }

    /// Restores the paths saved by the last trial.
    pub fn undo_marked(&mut self) {
        for j in 0..self.marked.len() {
            if self.marked[j] {
                let path = self.previous[j];
                self.candidate.set(j, path);
                if path == self.candidate.fallback[j] {
                    self.candidate.reset(j);
                }
            }
        }
        self.candidate.colliding.clear();
    }

    /// A path of a joint to rest at `q`.
    pub fn path_to_rest(&self, j: usize, q: f64) -> Option<JointPath> {
        let limits = &self.settings.limits[j];
        let here = self.candidate.fallback[j].at(self.candidate.begin);
        let target = TrajectoryPoint { q: q.clamp(limits.lower, limits.upper), v: 0.0, a: 0.0 };
        let shortest = self.now - self.candidate.begin + 1.0 / self.settings.rate;
        JointPath::soonest(here, self.candidate.begin, shortest, limits, |_| target)
    }

    /// Sum of squared distances of the stopped joints from their goals at the ends of their paths.
    pub fn goal_error(&self) -> f64 {
        let error = |j: &usize| math::powi(self.candidate.paths[*j].rest() - self.goal[*j], 2);
        (0..self.stopped.len()).filter(|j| self.stopped[*j]).map(|j| error(&j)).sum()
    }

    /// Whether the goals can be reached from the end of the candidate.
    pub fn goal_is_reachable(&mut self, robot: Robot) -> bool {
        let (period, begin) = (1.0 / self.settings.rate, self.candidate.begin);
        for (j, limits) in self.settings.limits.iter().enumerate() {
            let from = TrajectoryPoint { q: self.candidate.paths[j].rest(), v: 0.0, a: 0.0 };
            if self.candidate.uncontrolled[j] {
                self.continuation[j] = JointPath::resting(from.q);
                continue;
            }
            let target = TrajectoryPoint { q: self.goal[j], v: 0.0, a: 0.0 };
            let path = JointPath::soonest(from, begin, period, limits, |_| target);
            self.continuation[j] = path.unwrap_or(JointPath::resting(from.q));
        }
        self.candidate.is_free(robot, &self.continuation)
    }
}
