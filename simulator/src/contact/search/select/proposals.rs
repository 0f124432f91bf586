//! Candidates that the contact problem solved with every vertex as a point suggests.

use super::{Selection, Selector, Task, all_states};
use crate::contact::model::problem::{Level, Problem, Vertex};
use crate::contact::model::solution::Solution;
use crate::contact::model::state::{SoleState, States};
use crate::contact::search::judge::Assessment;
use crate::contact::search::load_split::LoadSplit;
use crate::contact::search::point_forces::{LEAST_SLIPS, SLIPS};
use crate::contact::search::slips;
use nalgebra::{Vector2, Vector3};

/// Candidates tested near each solution of the contact problem.
const NEAR_SOLUTION: usize = 4;

/// Candidates tested again because only their sliding directions were not found.
const RETESTED: usize = 3;

/// Parts of a sole's carrying vertices that are tested.
const PARTS: usize = 8;

/// Candidates tested in one selection before velocity-level steps follow or, in a fixed step or an
/// impact, the point solution itself is taken.
const MOST: usize = 32;

/// Iterations of the contact problem between two readings of its states.
const BETWEEN_READINGS: usize = 20;

/// Candidates tested before the contact problem is solved to its accuracy.
const EARLY: usize = 4;

/// Relative residual up to which the solution of a fixed step stands without a valid state.
const SOLVED: f64 = 1e-8;

/// The same before other first guesses and regularized modes are tried.
const CONVERGED: f64 = 1e-9;

/// Relative residuals at which the solution of a contact problem is taken as it is: at once, after
/// [`MANY`] iterations, and at all. Forces are within their cones in any case; error control sees
/// what the residual does to the motion.
const TAKEN: f64 = 1e-7;
const TAKEN_LATE: f64 = 1e-5;
const TAKEN_LAST: f64 = 1e-3;
const MANY: usize = 200;

/// Shares of their friction within which splits of an indeterminate load are sought.
const INSIDE: [f64; 9] = [0.5, 0.8, 0.95, 0.99, 1.0 - 1e-3, 1.0 - 1e-4, 1.0 - 1e-5, 1.0 - 1e-6, 1.0 - 1e-7];

/// Force of a vertex that carries, relative to the greatest.
const CARRIES: f64 = 1e-6;

impl Selector {
    /// Solves a velocity-level step with every vertex as a point. Returns the states that the
    /// solution indicates, or none if it is not accurate.
    pub fn solve_points(&mut self, p: &Problem, out: &mut Solution) -> Option<States> {
        let near = |s: usize, i: usize| p.soles[s].vertices[i].near;
        self.points.begin(p, near, Some((out, p.step)));
        let mut iterations = 0;
        let mut has_solved = false;
        loop {
            while !self.points.is_done() && self.points.residual() > if iterations < MANY { TAKEN } else { TAKEN_LATE }
            {
                self.points.advance(p, BETWEEN_READINGS);
                iterations += BETWEEN_READINGS;
            }
            // Once: `solve` gives all vertices their static friction again.
            if self.points.residual() > TAKEN_LAST {
                if has_solved || self.points.solve(p, near) > TAKEN_LAST {
                    return None;
                }
                has_solved = true;
            }
            // Each round gives vertices their kinetic friction for good.
            if !self.points.let_slip(p) {
                return Some(self.take_points(p, out, SLIPS));
            }
        }
    }

    /// Leaves the forces of the last point solution in `out`. Returns the states that it indicates.
    fn take_points(&self, p: &Problem, out: &mut Solution, slips: f64) -> States {
        out.normal.iter_mut().for_each(|normal| normal.fill(0.0));
        out.tangent.iter_mut().for_each(|tangent| tangent.fill(Vector2::zeros()));
        self.points.forces().for_each(|(s, i, force)| out.set_vertex_force(s, i, force));
        out.gather_vertex_forces(p);
        out.inside.fill(true);
        self.points.states(p, 0.0, slips)
    }

    /// The point solution of a fixed step or of an impact, and its states, if it is accurate: it obeys
    /// the contact laws at every vertex, whatever the states that tests found invalid. An impact with a
    /// rebound needs a state, whose restitution is that of the whole sole. Where an impact has more states
    /// than can be tried, a less accurate solution is taken: what it leaves of the approach is another impact.
    pub(super) fn point_solution(&mut self, task: &mut Task) -> Option<Selection> {
        let is_impact = task.p.step == 0.0;
        let accuracy = if is_impact && !all_states::can_enumerate(task.p) { TAKEN_LAST } else { SOLVED };
        if !self.is_posed(task) || self.points.residual() > accuracy {
            return None;
        }
        let states = self.take_points(task.p, task.out, LEAST_SLIPS);
        if !(0..task.p.soles.len()).all(|s| (task.allowed)(s, states[s])) {
            return None;
        }
        for s in 0..task.p.soles.len() {
            for i in 0..task.p.soles[s].vertices.len() {
                let t = task.p.vertex_motion(&task.out.motion, s, i).xy();
                task.p.soles[s].vertices[i].direction = t.try_normalize(0.0).unwrap_or_default();
            }
        }
        // A point carries no moment.
        task.p.free_turning();
        let consistent = !lacks_moments(task.p, &states, task.out, task.rules.tolerances.rest);
        let assessment = Assessment::default();
        Some(Selection { states, tested: task.tested, full: false, consistent, exhausted: true, assessment })
    }

    /// Tests the states that the solution with every vertex as a point indicates: as soon as two
    /// readings agree, then in all readings, and their neighbours.
    pub(super) fn propose(&mut self, task: &mut Task, touches: impl Fn(&Vertex) -> bool) {
        let mut early = 0;
        // Forces of the last solution may lead to where the iterations do not converge.
        let from_last = self.last_factor > 0.0;
        for from_last in [from_last, false] {
            let start = from_last.then_some((&self.last, self.last_factor));
            self.points.begin(task.p, |s, i| touches(&task.p.soles[s].vertices[i]), start);
            let mut last = None;
            while !self.points.is_done() && !self.is_found() {
                self.points.advance(task.p, BETWEEN_READINGS);
                let states = self.points.states(task.p, self.carries(), SLIPS);
                let is_new = || !self.queue.iter().any(|e| e.states == states && e.guessed);
                if early < EARLY && last.as_ref() == Some(&states) && is_new() {
                    early += 1;
                    self.push_solution(task, &states, true);
                }
                last = Some(states);
            }
            if !from_last || self.is_found() || self.points.residual() <= SOLVED {
                break;
            }
        }
        if !self.is_found() {
            self.read_solution(task);
        }
        let ends = !self.is_found() && (self.has_tried_enough(task) || self.is_step_solved(task));
        if !self.queue.is_empty() && !ends {
            self.explore(task, false, false, task.tested + NEAR_SOLUTION);
        }
    }

    /// Whether a point solution may take the place of a state. A trial of jams wants a state.
    fn is_posed(&self, task: &Task) -> bool {
        let p = &task.p;
        let rebounds = || p.soles.iter().any(|sole| sole.target != Vector3::zeros());
        p.level == Level::Velocity && (p.step > 0.0 || task.rules.exhaustive && !rebounds())
    }

    /// Whether there is such a solution of full accuracy.
    fn has_point_solution(&self, task: &Task) -> bool {
        self.is_posed(task) && self.points.residual() <= SOLVED
    }

    /// Whether enough candidates were tested where the run can continue without a valid state.
    fn has_tried_enough(&self, task: &Task) -> bool {
        let defers = task.p.level == Level::Acceleration && !task.rules.exhaustive;
        task.tested >= MOST && (defers || self.has_point_solution(task))
    }

    /// Whether a fixed step has a point solution: thorough tests would cost many times what the step does.
    pub(super) fn is_step_solved(&self, task: &Task) -> bool {
        task.p.step > 0.0 && self.points.residual() <= CONVERGED && self.has_point_solution(task)
    }

    /// Least share of the greatest force with which a vertex of the solved contact problem carries.
    fn carries(&self) -> f64 {
        CARRIES.max(10.0 * self.points.residual())
    }

    /// Tests all readings of the solved contact problem: with its slips alone, then on parts of the
    /// carrying vertices of soles whose pressure fails, then from other first guesses and with the
    /// modes of regularized friction. Ends at the first valid candidate.
    fn read_solution(&mut self, task: &mut Task) {
        let (some, many) = (self.carries(), 1e3 * CARRIES.max(self.points.residual()));
        let readings = [(some, SLIPS), (some, LEAST_SLIPS), (some, 0.0), (some, some), (many, SLIPS)];
        let states = readings.map(|(least, slips)| self.points.states(task.p, least, slips));
        let new = |i: &usize| !states[..*i].contains(&states[*i]);
        for i in (0..readings.len()).filter(new) {
            self.push_solution(task, &states[i], true);
            if self.is_found() {
                return;
            }
        }
        for i in (0..readings.len()).filter(new) {
            self.push_split(task, &states[i]);
            if self.is_found() || self.push_inside(task, &states[i]) {
                return;
            }
        }
        for i in (0..readings.len()).filter(new) {
            // What is at its limit slips; as far as the solution is inaccurate, what moves clearly.
            for slips in [0.0, self.carries()] {
                self.push_parts(task, &states[i], slips);
                if self.is_found() {
                    return;
                }
            }
        }
        if self.is_step_solved(task) {
            return;
        }
        // Where only the directions were not found from the first guess, others may succeed.
        let mut lacking = self.queue.iter().filter(|e| e.brief && e.assessment.levels[..2] == [0.0; 2]);
        let lacking: [Option<States>; RETESTED] = std::array::from_fn(|_| lacking.next().map(|e| e.states.clone()));
        for states in lacking.iter().flatten() {
            self.push_solution(task, states, false);
            if self.is_found() {
                return;
            }
        }
        for i in (0..readings.len()).filter(new) {
            self.push_solution(task, &states[i], false);
            if !self.is_found() && !self.has_tried_enough(task) {
                self.complete(task, &states[i]);
            }
            if self.is_found() {
                return;
            }
        }
    }

    /// Tests states that the solved contact problem indicates, with its slips.
    fn push_solution(&mut self, task: &mut Task, states: &States, briefly: bool) {
        if !self.has_tried_enough(task) && (0..task.p.soles.len()).all(|s| (task.allowed)(s, states[s])) {
            self.guess = Some(slips::slips(task.p, states, self.points.motion(task.p)));
            if briefly {
                self.push_briefly(task, states);
            } else {
                self.forget(states);
                self.push(task, states);
            }
            self.guess = None;
        }
    }

    /// Tests states of which static soles failed again, with the split of their loads that the solved contact
    /// problem has.
    fn push_split(&mut self, task: &mut Task, states: &States) {
        if !LoadSplit::may_apply(task.p, states) || !self.fails_static(task.p, states) || self.has_tried_enough(task) {
            return;
        }
        self.solver.split.set(task.p, states, self.points.forces());
        self.forget(states);
        self.push_solution(task, states, true);
        if self.loosens(task.p, states) {
            self.forget(states);
            self.push_solution(task, states, true);
        }
        if !self.is_found() {
            self.solver.split.clear();
        }
    }

    /// Tests states of which static soles fail with splits of their loads as far inside the friction cones as there
    /// are some, so that they last. Returns whether one is valid. Only indeterminate loads have several.
    pub(super) fn push_inside(&mut self, task: &mut Task, states: &States) -> bool {
        let is_shared = (0..task.p.soles.len()).filter(|&s| states[s] != SoleState::FREE).count() > 1;
        if !is_shared || !self.fails_static(task.p, states) {
            return false;
        }
        self.solver.solve(task.p, states, task.out);
        self.in_place = None;
        if !self.solver.is_indeterminate() {
            return false;
        }
        // The last share is the easiest.
        let mut first = INSIDE.len() - 1;
        if !self.has_inside(task.p, states, INSIDE[first]) {
            return false;
        }
        let mut failed = 0;
        while failed < first {
            let middle = (failed + first) / 2;
            if self.has_inside(task.p, states, INSIDE[middle]) {
                first = middle;
            } else {
                failed = middle + 1;
            }
        }
        for share in &INSIDE[first..] {
            if self.has_inside(task.p, states, *share) {
                self.solver.split.set(task.p, states, self.inside.forces());
                self.forget(states);
                self.guess = Some(slips::slips(task.p, states, self.inside.motion(task.p)));
                self.push_briefly(task, states);
                if self.loosens(task.p, states) {
                    self.forget(states);
                    self.push_briefly(task, states);
                }
                self.guess = None;
                if self.is_found() {
                    return true;
                }
            }
        }
        self.solver.split.clear();
        false
    }

    /// Whether states that failed with a split may hold with the nearly redundant conditions left out, which then
    /// are.
    fn loosens(&mut self, p: &Problem, states: &States) -> bool {
        let loosens = !self.is_found() && self.solver.is_nearly_indeterminate() && self.fails_static(p, states);
        self.solver.split.is_loose |= loosens;
        loosens
    }

    /// Whether static soles rest with loads within this share of their friction, which are then in `inside`.
    fn has_inside(&mut self, p: &Problem, states: &States, share: f64) -> bool {
        self.inside.solve_inside(p, states, share) <= SOLVED && self.inside.rests(states)
    }

    /// Whether the states have failed by the loads of static soles.
    fn fails_static(&self, p: &Problem, states: &States) -> bool {
        let Some(entry) = self.queue.iter().find(|e| e.states == *states) else { return false };
        let Assessment { faults, levels, .. } = &entry.assessment;
        let fails = |s: usize| states[s].is_static() && (faults[s].pulling || faults[s].friction);
        levels[0] == 0.0 && (0..p.soles.len()).any(fails)
    }

    /// Tests states in which a sole at fault rests on a part of the vertices that carry it as points:
    /// its pressure may follow another rule there, and more vertices lift off.
    fn push_parts(&mut self, task: &mut Task, states: &States, slips: f64) {
        let Some(entry) = self.queue.iter().find(|e| e.states == *states) else { return };
        let faults = entry.assessment.faults.clone();
        let mut parts = std::mem::take(&mut self.parts);
        for s in (0..task.p.soles.len()).filter(|&s| faults[s].pulling || faults[s].friction) {
            parts.clear();
            self.points.parts(task.p, s, slips, PARTS, &mut parts);
            for &part in &parts {
                if self.is_found() {
                    break;
                }
                let mut next = states.clone();
                next[s] = part;
                self.push_solution(task, &next, true);
            }
        }
        self.parts = parts;
    }

    /// Tests a candidate with its first guess alone.
    pub(super) fn push_briefly(&mut self, task: &mut Task, states: &States) {
        (self.solver.thorough, self.finder.thorough) = (false, false);
        self.push(task, states);
        (self.solver.thorough, self.finder.thorough) = (true, true);
    }
}

/// Whether a solution with points, which carry no moments, lets a contact turn that torsional or rolling friction
/// would brake. `rest` in rad/s.
fn lacks_moments(p: &Problem, states: &States, out: &Solution, rest: f64) -> bool {
    p.turning(states).any(|(s, turning)| {
        let omega = p.turning_motion(&out.motion, s);
        let (spins, rolls) = (omega.z.abs() > rest, omega.xy().norm() > rest);
        out.normal[s][0] > 0.0 && (turning.torsional > 0.0 && spins || turning.rolling > 0.0 && rolls)
    })
}
