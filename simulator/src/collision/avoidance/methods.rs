//! The four methods of the paper's Table I for cycles in which the direct paths to the goals are
//! not free.
//!
//! 1. All joints stop, each on its last proven path.
//! 2. Only joints between the bodies of colliding pairs stop. Then one side of each pair at a time
//!    is released if that is free.
//! 3. As 2; then random postures of the stopped joints are tried. A posture is accepted if it
//!    brings them nearer to the goal g: a smaller `sum (q_k - g_k)^2` over them.
//! 4. As 2; then a detour around the obstacle is searched ([`super::detour`]), and then as 3.
//!
//! Joints at their goals are stopped but never moved by 3 and 4: the robot may be standing on them.

use super::candidate::Robot;
use super::detour::Detour;
use super::planner::Planner;
use crate::math;
use crate::random::Stream;

/// Random postures that methods 3 and 4 draw in a cycle.
const DRAWS: usize = 24;

/// Limit on the drawn postures that are tested per cycle.
const PROOFS: usize = 10;

/// A posture must reduce the sum to this fraction, less this many rad^2, to be accepted.
const IMPROVEMENT: (f64, f64) = (0.98, 1e-6);

/// The methods with their state from cycle to cycle.
pub(super) struct Methods {
    detour: Detour,
    random: Stream,
    /// Pairs for which joints were stopped.
    blocking: Vec<usize>,
    /// The posture drawn last.
    posture: Vec<f64>,
}

impl Methods {
    /// For a robot with `joints` joints and `pairs` pairs.
    pub fn new(seed: u64, joints: usize, pairs: usize) -> Self {
        Methods {
            detour: Detour::new(joints),
            random: Stream::new(seed, &["self-collision"]),
            blocking: Vec::with_capacity(2 * pairs),
            posture: vec![0.0; joints],
        }
    }

    /// Leaves a proven set of paths in the candidate. Returns whether it leads to the goals.
    pub fn decide(&mut self, planner: &mut Planner, robot: Robot) -> bool {
        if planner.candidate.succeeds(robot) {
            self.detour.end();
            return true;
        }
        match planner.settings.method {
            1 => {
                (0..planner.stopped.len()).for_each(|j| {
                    planner.stopped[j] = !planner.candidate.uncontrolled[j];
                    planner.candidate.reset(j);
                });
            }
            method => {
                let first = planner.candidate.colliding[0];
                self.stop_involved(planner, robot);
                self.release_sides(planner, robot);
                if method == 4 {
                    self.detour.pursue(planner, robot, first);
                }
                if method >= 3 && !self.detour.is_active() {
                    self.perturb(planner, robot);
                }
            }
        }
        false
    }

    /// Stops the joints between colliding pairs until no pair collides.
    fn stop_involved(&mut self, planner: &mut Planner, robot: Robot) {
        self.blocking.clear();
        while !planner.candidate.colliding.is_empty() {
            for i in 0..planner.candidate.colliding.len() {
                let pair = planner.candidate.colliding[i];
                self.blocking.push(pair);
                for lever in robot.levers.of(pair) {
                    planner.stopped[lever.joint] = !planner.candidate.uncontrolled[lever.joint];
                    planner.candidate.reset(lever.joint);
                }
            }
            // Each round stops at least one more joint: a pair whose joints have all stopped is not
            // tested again.
            planner.candidate.succeeds(robot);
        }
    }

    /// Releases the stopped joints on one side of the blocking pairs if that is free: for all pairs
    /// at once, or else for one pair after the other.
    fn release_sides(&self, planner: &mut Planner, robot: Robot) {
        for second in [false, true] {
            let all = &self.blocking[..];
            if release(planner, robot, second, all) || all.len() == 1 {
                continue;
            }
            for pair in all {
                release(planner, robot, second, std::slice::from_ref(pair));
            }
        }
    }

    /// Method 3: tries random postures of the stopped joints.
    fn perturb(&mut self, planner: &mut Planner, robot: Robot) {
        planner.mark_movable();
        let count = planner.marked.iter().filter(|m| **m).count();
        if count == 0 {
            return;
        }
        let (mut proofs, mut least) = (0, planner.goal_error());
        for _ in 0..DRAWS {
            let error = self.draw(planner, count);
            if error > IMPROVEMENT.0 * least - IMPROVEMENT.1 {
                continue;
            }
            proofs += 1;
            let posture = &self.posture;
            let free = planner.try_marked(robot, |planner, j| planner.path_to_rest(j, posture[j]));
            // A joint without a path does not move, so the error may exceed that of the posture.
            let error = planner.goal_error();
            if free && error <= IMPROVEMENT.0 * least - IMPROVEMENT.1 {
                least = error;
            } else {
                planner.undo_marked();
            }
            if proofs == PROOFS {
                return;
            }
        }
    }

    /// Draws a posture of the marked joints and returns its goal error. Moves one joint a fraction
    /// of its way, each joint a fraction of its own way, or all joints to random positions nearby.
    fn draw(&mut self, planner: &Planner, count: usize) -> f64 {
        let kind = self.random.below(3);
        let one = self.random.below(count as u64) as usize;
        let (mut k, mut error) = (0, 0.0);
        for j in 0..planner.marked.len() {
            if !planner.marked[j] {
                continue;
            }
            let here = planner.candidate.paths[j].rest();
            let distance = planner.goal[j] - here;
            let to = match kind {
                0 if k != one => here,
                0 | 1 => here + self.random.unit() * distance,
                _ => here + 0.5 * distance + (0.1 + 0.5 * distance.abs()) * self.random.normal(),
            };
            let limits = &planner.settings.limits[j];
            self.posture[j] = to.clamp(limits.lower, limits.upper);
            error += math::powi(self.posture[j] - planner.goal[j], 2);
            k += 1;
        }
        error
    }
}

/// Releases one side of `pairs` if that is free. Returns false if it is not.
fn release(planner: &mut Planner, robot: Robot, second: bool, pairs: &[usize]) -> bool {
    planner.marked.fill(false);
    for pair in pairs {
        let side = robot.levers.of(*pair).iter().filter(|l| l.second == second);
        side.for_each(|l| planner.marked[l.joint] = true);
    }
    // A joint without another path than its fallback cannot be released.
    for j in 0..planner.marked.len() {
        planner.marked[j] &= planner.stopped[j] && planner.proposed[j] != planner.candidate.fallback[j];
    }
    if !planner.marked.contains(&true) {
        return true;
    }
    if !planner.try_marked(robot, |planner, j| Some(planner.proposed[j])) {
        planner.undo_marked();
        return false;
    }
    (0..planner.marked.len()).for_each(|j| planner.stopped[j] &= !planner.marked[j]);
    true
}
