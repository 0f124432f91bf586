//! What to do when the way to where the tasks want the joints is not free: the four methods of the paper's Table I.
//!
//! 1. All joints stop, each on the path that was proven before.
//! 2. Only joints between the bodies in question stop. Then one side of each pair at a time is let go again where that is
//!    free.
//! 3. As 2; then random postures of the stopped joints are tried, and what brings them nearer to the goal g is kept:
//!    less of `sum (q_k - g_k)^2` over them.
//! 4. As 2; then a detour around the obstacle is looked for ([`super::around`]), and then as 3.
//!
//! Joints that are where the tasks want them are stopped, but never moved by 3 and 4: the robot may be standing on them.

use super::Limits;
use super::avoider::Avoider;
use super::candidate::Robot;
use super::joint_path::JointPath;
use crate::motion::spline::TrajectoryPoint;

/// A joint this near to its goal is there, rad or m.
pub(super) const AT_GOAL: f64 = 1e-3;

/// Random postures that methods 3 and 4 look at in a cycle.
const DRAWS: usize = 24;

/// Of these, at most so many are proven: the others are no improvement, or come too late.
const PROOFS: usize = 10;

/// What is left of the sum after an improvement that is worth a motion, relative, and the least that is one, rad^2.
const WORTH: (f64, f64) = (0.98, 1e-6);

/// Durations tried for a path grow by this factor up to this length, s.
const LONGER: (f64, f64) = (1.2, 30.0);

/// The path with the shortest of a series of durations from `shortest` on that keeps the limits; `target` says where it leads
/// after a duration.
pub(super) fn soonest(
    here: TrajectoryPoint,
    begin: f64,
    shortest: f64,
    limits: &Limits,
    target: impl Fn(f64) -> TrajectoryPoint,
) -> Option<JointPath> {
    // From rest to rest over x the jerk is 54 x / T^3; none much shorter keeps its limit.
    let way = (target(shortest).q - here.q).abs();
    let mut duration = shortest.max(0.5 * (54.0 * way / limits.jerk).cbrt());
    while duration <= LONGER.1.max(2.0 * shortest) {
        let path = JointPath::go(here, begin, target(duration), duration, limits);
        if path.is_some() {
            return path;
        }
        duration *= LONGER.0;
    }
    None
}

/// Leaves a proven set of paths in the candidate. True when it leads where the tasks want the joints.
pub(super) fn decide(avoider: &mut Avoider, robot: Robot) -> bool {
    if avoider.candidate.succeeds(robot) {
        avoider.detour.end();
        return true;
    }
    match avoider.settings.method {
        1 => {
            (0..avoider.stopped.len()).for_each(|j| {
                avoider.stopped[j] = !avoider.candidate.uncontrolled[j];
                avoider.candidate.reset(j);
            });
        }
        method => {
            let first = avoider.candidate.colliding[0];
            avoider.stop_involved(robot);
            avoider.release_sides(robot);
            if method == 4 {
                avoider.go_around(robot, first);
            }
            if method >= 3 && !avoider.detour.is_on() {
                avoider.perturb(robot);
            }
        }
    }
    false
}

impl Avoider {
    /// Stops the joints between bodies that would touch, until nothing does.
    fn stop_involved(&mut self, robot: Robot) {
        self.blocking.clear();
        while !self.candidate.colliding.is_empty() {
            for i in 0..self.candidate.colliding.len() {
                let pair = self.candidate.colliding[i];
                self.blocking.push(pair);
                for lever in robot.levers.of(pair) {
                    self.stopped[lever.joint] = !self.candidate.uncontrolled[lever.joint];
                    self.candidate.reset(lever.joint);
                }
            }
            // Each round stops at least one joint more: a pair of which all have stopped is not in question.
            self.candidate.succeeds(robot);
        }
    }

    /// Lets the stopped joints on one side of the pairs in question go again, if that is free: of all pairs at once, or else of
    /// one after the other.
    fn release_sides(&mut self, robot: Robot) {
        for second in [false, true] {
            let all = self.blocking.len();
            if self.release(robot, second, 0..all) || all == 1 {
                continue;
            }
            for k in 0..all {
                self.release(robot, second, k..k + 1);
            }
        }
    }

    /// Lets one side of some of the pairs in question go, if that is free.
    fn release(&mut self, robot: Robot, second: bool, blocking: std::ops::Range<usize>) -> bool {
        self.marked.fill(false);
        for k in blocking {
            let side = robot.levers.of(self.blocking[k]).iter().filter(|l| l.second == second);
            side.for_each(|l| self.marked[l.joint] = true);
        }
        if !self.mark_only_movable() {
            return true;
        }
        if !self.try_marked(robot, |avoider, j| Some(avoider.proposed[j])) {
            self.undo_marked();
            return false;
        }
        (0..self.marked.len()).for_each(|j| self.stopped[j] &= !self.marked[j]);
        true
    }

    /// Of the marked joints keeps those that are stopped and could go somewhere.
    fn mark_only_movable(&mut self) -> bool {
        for j in 0..self.marked.len() {
            self.marked[j] &= self.stopped[j] && self.proposed[j] != self.candidate.fallback[j];
        }
        self.marked.contains(&true)
    }

    /// Keeps the present paths of the marked joints in mind, and tries others; a joint without another keeps its own.
    pub(super) fn try_marked(&mut self, robot: Robot, path: impl Fn(&Self, usize) -> Option<JointPath>) -> bool {
        for j in 0..self.marked.len() {
            if !self.marked[j] {
                continue;
            }
            self.best[j] = self.candidate.paths[j];
            if let Some(path) = path(self, j) {
                self.candidate.set(j, path);
            }
        }
        self.candidate.succeeds(robot)
    }

    /// Takes back what was tried last.
    pub(super) fn undo_marked(&mut self) {
        for j in 0..self.marked.len() {
            if self.marked[j] {
                let path = self.best[j];
                self.candidate.set(j, path);
                if path == self.candidate.fallback[j] {
                    self.candidate.reset(j);
                }
            }
        }
        self.candidate.colliding.clear();
    }

    /// A path of a joint to rest at `q`.
    pub(super) fn path_to_rest(&self, j: usize, q: f64) -> Option<JointPath> {
        let limits = &self.settings.limits[j];
        let here = self.candidate.fallback[j].at(self.candidate.begin);
        let target = TrajectoryPoint { q: q.clamp(limits.lower, limits.upper), v: 0.0, a: 0.0 };
        let shortest = self.now - self.candidate.begin + 1.0 / self.settings.rate;
        soonest(here, self.candidate.begin, shortest, limits, |_| target)
    }

    /// Sum of the squares of what the stopped joints miss of their goals where their present paths end.
    pub(super) fn goal_error(&self) -> f64 {
        let missed = |j: &usize| (self.candidate.paths[*j].rest() - self.goal[*j]).powi(2);
        (0..self.stopped.len()).filter(|j| self.stopped[*j]).map(|j| missed(&j)).sum()
    }

    /// Marks the joints that methods 3 and 4 may move: stopped, and not where they are wanted.
    pub(super) fn mark_movable(&mut self) {
        for j in 0..self.marked.len() {
            self.marked[j] = self.stopped[j] && (self.goal[j] - self.candidate.anchor[j]).abs() > AT_GOAL;
        }
    }

    /// Method 3: random postures of the stopped joints.
    fn perturb(&mut self, robot: Robot) {
        self.mark_movable();
        let count = self.marked.iter().filter(|m| **m).count();
        if count == 0 {
            return;
        }
        let (mut proofs, mut least) = (0, self.goal_error());
        for _ in 0..DRAWS {
            let goal_error = self.draw(count);
            if goal_error > WORTH.0 * least - WORTH.1 {
                continue;
            }
            proofs += 1;
            let free = self.try_marked(robot, |avoider, j| avoider.path_to_rest(j, avoider.posture[j]));
            // Less is reached where a joint has no path to there.
            let goal_error = self.goal_error();
            if free && goal_error <= WORTH.0 * least - WORTH.1 {
                least = goal_error;
            } else {
                self.undo_marked();
            }
            if proofs == PROOFS {
                return;
            }
        }
    }

    /// A random posture of the marked joints, and what it misses: one joint part of its way, all of them each a part of its
    /// own, or all anywhere near.
    fn draw(&mut self, count: usize) -> f64 {
        let kind = self.random.below(3);
        let one = self.random.below(count as u64) as usize;
        let (mut k, mut goal_error) = (0, 0.0);
        for j in 0..self.marked.len() {
            if !self.marked[j] {
                continue;
            }
            let here = self.candidate.paths[j].rest();
            let way = self.goal[j] - here;
            let to = match kind {
                0 if k != one => here,
                0 | 1 => here + self.random.unit() * way,
                _ => here + 0.5 * way + (0.1 + 0.5 * way.abs()) * self.random.normal(),
            };
            let limits = &self.settings.limits[j];
            self.posture[j] = to.clamp(limits.lower, limits.upper);
            goal_error += (self.posture[j] - self.goal[j]).powi(2);
            k += 1;
        }
        goal_error
    }
}
