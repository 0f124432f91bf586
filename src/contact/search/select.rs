//! Selects the contact state (`docs/contact.md`, section 4).
//!
//! A search tests candidates: it solves each with its modes ([`candidate`](super::candidate)) and
//! judges it ([`judge`](super::judge)). Candidates wait in a priority queue ordered by
//! [`Assessment::compare`]. The best is expanded by the local [`moves`](super::moves) that its faults
//! suggest; no candidate is tested twice. A search ends at the first valid candidate that none of its
//! smaller neighbours beats, or without one after its limit. In the order `direct` neighbours of a
//! valid candidate that [`neighbour_screen`](super::neighbour_screen) excludes are not tested.
//!
//! The order `direct` searches
//!
//! 1. near the state that continuity suggests;
//! 2. near the states of the contact problem solved with every vertex as a point
//!    ([`point_forces`](super::point_forces)): first briefly, with the slips of that solution as the
//!    only guess, then on parts of the carrying vertices, then thoroughly;
//! 3. near those of the same with vertices sliding whose slow normal motion is about to be settled;
//! 4. near those of the same without vertices that leave the floor, with slow hops allowed, if any
//!    vertex hops;
//! 5. as the order `paper`, if [`Rules::exhaustive`]; a fixed step takes the point solution itself
//!    instead, if it is accurate.
//!
//! The order `paper` is the best-first search of [Hale 2008], section III.A, without limit, from the
//! state that continuity suggests. If the queue empties first:
//!
//! 1. the search is repeated over clamped patterns, with modes from
//!    [`regularized_modes`](super::regularized_modes);
//! 2. both are repeated with slow hops allowed;
//! 3. all states of all soles are tried;
//! 4. the least violating candidate is returned, marked as inconsistent.

use crate::contact::model::problem::{Level, Problem, Vertex};
use crate::contact::model::solution::Solution;
use crate::contact::model::state::{MAX_SOLES, Mode, SoleState, States};
use crate::contact::search::candidate::{CandidateSolver, share_static};
use crate::contact::search::judge::{Assessment, MOST_ROUNDING, Rules, SUSPECT_FRICTION, judge, margin, onset};
use crate::contact::search::moves::Moves;
use crate::contact::search::neighbour_screen::NeighbourScreen;
use crate::contact::search::point_forces::{LEAST_SLIPS, PointForces, SLIPS};
use crate::contact::search::sliding_directions::{self, DirectionFinder, Onset, Slips};
use nalgebra::{Vector2, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;

/// More combinations than this are not enumerated when the local search fails.
const ENUMERABLE: usize = 20_000;

/// Candidates tested near the previous states at an event. In a fixed step the contact problem,
/// solved from the forces of the last step, finds changed states sooner.
const NEAR: usize = 4;

/// Candidates tested near each solution of the contact problem.
const NEAR_SOLUTION: usize = 4;

/// Candidates tested again because only their sliding directions were not found.
const RETESTED: usize = 3;

/// Parts of a sole's carrying vertices that are tested.
const PARTS: usize = 8;

/// Iterations of the contact problem between two readings of its states.
const BETWEEN_READINGS: usize = 20;

/// Candidates tested before the contact problem is solved to its accuracy.
const EARLY: usize = 4;

/// Relative residual up to which the solution of a fixed step stands without a valid state.
const SOLVED: f64 = 1e-8;

/// Relative residuals at which the solution of a contact problem is taken as it is: at once, after
/// [`MANY`] iterations, and at all. Forces are within their cones in any case; error control sees
/// what the residual does to the motion.
const TAKEN: f64 = 1e-7;
const TAKEN_LATE: f64 = 1e-5;
const TAKEN_LAST: f64 = 1e-3;
const MANY: usize = 200;

/// Force of a vertex that carries, relative to the greatest.
const CARRIES: f64 = 1e-6;

#[derive(Clone, Copy, Debug)]
struct Entry {
    states: States,
    assessment: Assessment,
    /// Slips of its soles, from which its directions are found again.
    slips: Slips,
    /// Whether its sliding directions are consistent.
    slides: bool,
    /// Whether its directions were found from a regularized start.
    guessed: bool,
    /// Whether they were only sought near the first guess.
    brief: bool,
    expanded: bool,
}

/// Outcome of a selection. Wrenches and forces are in the solution passed in.
#[derive(Clone, Copy, Debug)]
pub struct Selection {
    /// The states chosen.
    pub states: States,
    /// Candidates tested.
    pub tested: usize,
    /// Whether the search through all states was needed as a last resort.
    pub full: bool,
    /// False when no candidate was valid.
    pub consistent: bool,
    /// False when not all states were searched: [`Rules::exhaustive`] may find a valid one.
    pub exhausted: bool,
    /// Assessment of the chosen states.
    pub assessment: Assessment,
}

impl Selection {
    /// Selection of a method that tries no candidates and claims no validity: its errors show in
    /// the residuals.
    pub fn unchecked(states: States) -> Self {
        Selection {
            states,
            tested: 0,
            full: false,
            consistent: true,
            exhausted: true,
            assessment: Assessment::default(),
        }
    }
}

/// How the states are found.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum SearchOrder {
    /// Near the previous states, then near those of the solved contact problem.
    #[default]
    Direct,
    /// Best-first from the previous states alone, as in the paper.
    Paper,
}

/// One selection: problem, rules, and the number of candidates tested so far.
struct Task<'a> {
    p: &'a mut Problem,
    rules: Rules,
    allowed: &'a dyn Fn(usize, SoleState) -> bool,
    out: &'a mut Solution,
    tested: usize,
}

impl Task<'_> {
    /// Lets vertices whose motion is to be settled slide, or rest again. Returns whether there are
    /// any.
    fn slide_settling(&mut self, slide: bool) -> bool {
        let settling = self.p.soles.iter_mut().flat_map(|sole| &mut sole.vertices).filter(|v| v.settles);
        settling.fold(false, |_, v| {
            v.moving = slide;
            v.direction = if slide { v.velocity.xy().normalize() } else { Vector2::zeros() };
            true
        })
    }
}

/// The state search, with its scratch.
#[derive(Clone, Debug)]
pub struct Selector {
    order: SearchOrder,
    solver: CandidateSolver,
    finder: DirectionFinder,
    points: PointForces,
    screen: NeighbourScreen,
    /// Solution of the previous states, and the factor that makes forces of its loads.
    last: Solution,
    last_factor: f64,
    /// First guess of the slips, in addition to those that the loads suggest.
    guess: Option<Slips>,
    /// Slip onset of soles whose load an event has put at its limit.
    onset: Vec<Onset>,
    queue: Vec<Entry>,
    /// The candidate whose sliding directions are in the problem.
    in_place: Option<States>,
    /// Whether the sliding directions of the candidate just tested are consistent.
    slides: bool,
    /// The best candidate so far, with its directions and its solution.
    kept: Option<States>,
    kept_directions: Vec<Vector2<f64>>,
    kept_solution: Solution,
    /// Clamped patterns whose modes have been solved for.
    patterns: Vec<States>,
    /// States of one sole on parts of its carrying vertices.
    parts: Vec<SoleState>,
}

impl Selector {
    /// A selector for problems of this size.
    pub fn new(order: SearchOrder, p: &Problem) -> Self {
        Selector {
            order,
            solver: CandidateSolver::new(p),
            finder: DirectionFinder::new(p),
            points: PointForces::new(p),
            screen: NeighbourScreen::new(p),
            last: Solution::new(p),
            last_factor: 0.0,
            guess: None,
            onset: vec![Onset::default(); p.soles.len()],
            queue: Vec::with_capacity(1024),
            in_place: None,
            slides: true,
            kept: None,
            kept_directions: Vec::with_capacity(p.vertex_indices().count()),
            kept_solution: Solution::new(p),
            patterns: Vec::with_capacity(256),
            parts: Vec::with_capacity(3 * 64),
        }
    }

    /// The candidate solver, which has solved the chosen states.
    pub fn solver(&mut self) -> &mut CandidateSolver {
        &mut self.solver
    }

    /// Solves and judges one candidate.
    pub fn test(&mut self, p: &mut Problem, states: &States, rules: &Rules, out: &mut Solution) -> Assessment {
        let mut slides = false;
        if let Some(guess) = self.guess {
            slides = self.finder.solve(&mut self.solver, p, states, &[guess], &self.onset, out);
        }
        if !slides && (self.finder.thorough || self.guess.is_none()) {
            let hint = self.slip_of_static_load(p, states, out);
            slides = self.finder.solve(&mut self.solver, p, states, &[hint], &self.onset, out);
        }
        share_static(p, states, out);
        (self.in_place, self.slides) = (Some(*states), slides);
        judge(p, states, out, slides, rules)
    }

    /// Slips in which the static loads of soles with undetermined sliding directions exceed their
    /// capacity.
    fn slip_of_static_load(&mut self, p: &Problem, states: &States, out: &mut Solution) -> Slips {
        let mut hint = [Vector3::zeros(); MAX_SOLES];
        let mut stuck = *states;
        let implicit = |s: &usize| sliding_directions::is_implicit(p, states, *s);
        (0..p.soles.len()).filter(implicit).for_each(|s| stuck[s].mode = Mode::Static);
        if stuck != *states {
            self.solver.solve(p, &stuck, out);
            share_static(p, &stuck, out);
            for s in (0..p.soles.len()).filter(|&s| stuck[s] != states[s]) {
                hint[s] = margin(p, &stuck, s, out).slip;
            }
        }
        hint
    }

    /// Selects the states. `starts` are tried first, in order. Smaller neighbours of a valid
    /// candidate are tried too, unless `unchanged` is set: no event since the first of `starts` was
    /// chosen. `out` holds the solution of the previous states. `allowed` restricts the states of
    /// each sole (forced states).
    pub fn select(
        &mut self,
        p: &mut Problem,
        starts: &[States],
        unchanged: bool,
        rules: &Rules,
        allowed: &dyn Fn(usize, SoleState) -> bool,
        out: &mut Solution,
    ) -> Selection {
        for (s, limit) in self.onset.iter_mut().enumerate() {
            limit.vertices = 0;
            if rules.suspect(p, s) & SUSPECT_FRICTION != 0 {
                onset(p, &rules.previous, s, out, limit);
            }
        }
        // Loads of velocity-level steps are kept as forces.
        self.last_factor = match p.level {
            Level::Acceleration => 1.0,
            Level::Velocity => p.step,
        };
        self.last.copy_from(out);
        let mut task = Task { p, rules: *rules, allowed, out, tested: 0 };
        let direct = self.order == SearchOrder::Direct;
        let found = direct && self.search_near(&mut task, starts, unchanged);
        if direct
            && !found
            && let Some(states) = self.point_solution(&mut task)
        {
            let assessment = Assessment::default();
            return Selection {
                states,
                tested: task.tested,
                full: false,
                consistent: true,
                exhausted: true,
                assessment,
            };
        }
        let exhausted = found || !direct || rules.exhaustive;
        if !found && exhausted {
            // From rest, as in the paper.
            let slides = |states: &&States| (0..task.p.soles.len()).filter(|&s| states[s].is_dynamic()).count();
            let start = *starts.iter().rev().min_by_key(slides).expect("at least one start");
            self.search_all(&mut task, &start, unchanged);
        }
        let best = self.best();
        // Leave the chosen candidate's solution and directions in place.
        self.restore(&mut task, &best);
        let (assessment, full) = (best.assessment, direct && !found && exhausted);
        let consistent = assessment.valid();
        Selection { states: best.states, tested: task.tested, full, consistent, exhausted, assessment }
    }

    /// Solves a velocity-level step with every vertex as a point. Returns the states that the
    /// solution indicates, or none if it is not accurate.
    pub fn solve_points(&mut self, p: &Problem, out: &mut Solution) -> Option<States> {
        let near = |s: usize, i: usize| p.soles[s].vertices[i].near;
        self.points.begin(p, near, Some((out, p.step)));
        let mut iterations = 0;
        while !self.points.is_done() && self.points.residual() > if iterations < MANY { TAKEN } else { TAKEN_LATE } {
            self.points.advance(p, BETWEEN_READINGS);
            iterations += BETWEEN_READINGS;
        }
        if self.points.residual() > TAKEN_LAST && self.points.solve(p, near) > TAKEN_LAST {
            return None;
        }
        Some(self.take_points(p, out, SLIPS))
    }

    /// Leaves the forces of the last point solution in `out`. Returns the states that it indicates.
    fn take_points(&self, p: &Problem, out: &mut Solution, slips: f64) -> States {
        out.normal.iter_mut().for_each(|normal| normal.fill(0.0));
        out.tangent.iter_mut().for_each(|tangent| tangent.fill(Vector2::zeros()));
        self.points.forces().for_each(|(s, i, force)| out.set_vertex_force(s, i, force));
        out.gather_vertex_forces(p);
        out.inside = [true; MAX_SOLES];
        self.points.states(p, 0.0, slips)
    }

    /// The point solution of a fixed step and its states, if it is accurate: it obeys the contact laws
    /// at every vertex, whatever the states that tests found invalid. Impacts need a state, whose
    /// restitution is that of the whole sole.
    fn point_solution(&mut self, task: &mut Task) -> Option<States> {
        if task.p.level == Level::Acceleration || task.p.step == 0.0 || self.points.residual() > SOLVED {
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
        Some(states)
    }

    /// Searches near the previous states, then near those of the solved contact problem. Returns
    /// whether a valid state was found.
    fn search_near(&mut self, task: &mut Task, starts: &[States], unchanged: bool) -> bool {
        let level = task.p.level;
        let tol = task.rules.tolerances;
        self.restart();
        for start in starts {
            // Vertices of a fixed step slide on in their direction.
            let slides = level == Level::Velocity && (0..task.p.soles.len()).any(|s| start[s].is_dynamic());
            self.guess = slides.then(|| sliding_directions::slips_of_velocities(task.p, start));
            if slides {
                self.push_briefly(task, start)
            } else {
                self.push(task, start)
            }
            self.guess = None;
            // Velocities are no solution: another guess may succeed.
            self.queue.iter_mut().for_each(|e| e.guessed = false);
            if unchanged && self.is_found() {
                return true;
            }
        }
        let near = if level == Level::Acceleration { NEAR } else { 0 };
        self.explore(task, unchanged, false, near);
        if self.is_found() {
            return true;
        }
        self.propose(task, |v| if level == Level::Velocity { v.near } else { v.is_in_band(&tol) });
        if self.is_found() || self.accept_at_limit(task) || level == Level::Velocity {
            return self.is_found();
        }
        if task.slide_settling(true) {
            self.restart();
            self.propose(task, |v| v.is_in_band(&tol));
            if self.is_found() {
                return true;
            }
            task.slide_settling(false);
        }
        let start = &starts[starts.len() - 1];
        let hops = |v: &Vertex| v.is_in_band(&tol) && v.velocity.z > tol.rest;
        if !task.p.soles.iter().flat_map(|sole| &sole.vertices).any(hops) {
            self.push(task, start);
            return self.is_found();
        }
        task.rules.hops = true;
        self.restart();
        self.push(task, start);
        self.propose(task, |v| v.is_in_band(&tol) && v.velocity.z <= tol.rest);
        if !self.is_found() {
            task.rules.hops = false;
        }
        self.is_found()
    }

    /// Allows more rounding in the best candidate. Returns whether it is valid then.
    fn accept_at_limit(&mut self, task: &mut Task) -> bool {
        let best = self.best();
        self.restore(task, &best);
        let rules = Rules { rounding: MOST_ROUNDING, ..task.rules };
        // Its sliding directions are consistent if friction is what more rounding clears.
        let assessment = judge(task.p, &best.states, task.out, best.slides, &rules);
        if let Some(entry) = self.queue.iter_mut().find(|e| e.states == best.states).filter(|_| assessment.valid()) {
            entry.assessment = assessment;
        }
        assessment.valid()
    }

    /// Searches all states, best-first from the previous ones.
    fn search_all(&mut self, task: &mut Task, start: &States, unchanged: bool) {
        let all = usize::MAX;
        self.restart();
        self.push(task, start);
        self.explore(task, unchanged, false, all);
        if self.is_found() {
            return;
        }
        // Search again from the best candidate over patterns only; the modes are solved for.
        self.explore_patterns(task);
        if self.is_found() {
            return;
        }
        if task.p.level == Level::Acceleration {
            task.rules.hops = true;
            self.restart();
            self.push(task, start);
            self.explore(task, false, false, all);
            if !self.is_found() {
                self.explore_patterns(task);
            }
            if self.is_found() {
                return;
            }
            task.rules.hops = false;
        }
        self.restart();
        self.push(task, start);
        self.enumerate(task);
    }

    fn restart(&mut self) {
        (self.in_place, self.kept) = (None, None);
        self.queue.clear();
        self.patterns.clear();
    }

    /// Removes a candidate that failed without a good first guess or briefly, so that it is tested
    /// again.
    fn forget(&mut self, states: &States) {
        let count = self.queue.len();
        self.queue.retain(|e| e.states != *states || e.assessment.valid() || (e.guessed && !e.brief));
        if self.queue.len() < count && self.kept == Some(*states) {
            self.kept = None;
        }
    }

    fn is_found(&self) -> bool {
        self.queue.iter().any(|e| e.assessment.valid())
    }

    /// Tests the states that the solution with every vertex as a point indicates: as soon as two
    /// readings agree, then in all readings, and their neighbours.
    fn propose(&mut self, task: &mut Task, touches: impl Fn(&Vertex) -> bool) {
        let start = (self.last_factor > 0.0).then_some((&self.last, self.last_factor));
        self.points.begin(task.p, |s, i| touches(&task.p.soles[s].vertices[i]), start);
        let mut last = None;
        let mut early = 0;
        while !self.points.is_done() && !self.is_found() {
            self.points.advance(task.p, BETWEEN_READINGS);
            let states = self.points.states(task.p, self.carries(), SLIPS);
            if early < EARLY && last == Some(states) && !self.queue.iter().any(|e| e.states == states && e.guessed) {
                early += 1;
                self.push_solution(task, &states, true);
            }
            last = Some(states);
        }
        if !self.is_found() {
            self.read_solution(task);
        }
        if !self.queue.is_empty() {
            self.explore(task, false, false, task.tested + NEAR_SOLUTION);
        }
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
            // What is at its limit slips; as far as the solution is inaccurate, what moves clearly.
            for slips in [0.0, self.carries()] {
                self.push_parts(task, &states[i], slips);
                if self.is_found() {
                    return;
                }
            }
        }
        // Where only the directions were not found from the first guess, others may succeed.
        let mut lacking = self.queue.iter().filter(|e| e.brief && e.assessment.levels[..2] == [0.0; 2]);
        let lacking: [Option<States>; RETESTED] = std::array::from_fn(|_| lacking.next().map(|e| e.states));
        for states in lacking.iter().flatten() {
            self.push_solution(task, states, false);
            if self.is_found() {
                return;
            }
        }
        for i in (0..readings.len()).filter(new) {
            self.push_solution(task, &states[i], false);
            if !self.is_found() {
                self.complete(task, &states[i]);
            }
            if self.is_found() {
                return;
            }
        }
    }

    /// Tests states that the solved contact problem indicates, with its slips.
    fn push_solution(&mut self, task: &mut Task, states: &States, briefly: bool) {
        if (0..task.p.soles.len()).all(|s| (task.allowed)(s, states[s])) {
            self.guess = Some(sliding_directions::slips(task.p, states, self.points.motion(task.p)));
            if briefly {
                self.push_briefly(task, states);
            } else {
                self.forget(states);
                self.push(task, states);
            }
            self.guess = None;
        }
    }

    /// Tests states in which a sole at fault rests on a part of the vertices that carry it as points:
    /// its pressure may follow another rule there, and more vertices lift off.
    fn push_parts(&mut self, task: &mut Task, states: &States, slips: f64) {
        let Some(entry) = self.queue.iter().find(|e| e.states == *states) else { return };
        let faults = entry.assessment.faults;
        let mut parts = std::mem::take(&mut self.parts);
        for s in (0..task.p.soles.len()).filter(|&s| faults[s].pulling || faults[s].friction) {
            parts.clear();
            self.points.parts(task.p, s, slips, PARTS, &mut parts);
            for &part in &parts {
                let mut next = *states;
                next[s] = part;
                self.push_solution(task, &next, true);
                if self.is_found() {
                    break;
                }
            }
        }
        self.parts = parts;
    }

    /// Tests a candidate with its first guess alone.
    fn push_briefly(&mut self, task: &mut Task, states: &States) {
        (self.solver.thorough, self.finder.thorough) = (false, false);
        self.push(task, states);
        (self.solver.thorough, self.finder.thorough) = (true, true);
    }

    /// Expands the best candidates until one is valid and none of its smaller neighbours beats it,
    /// or until `limit` candidates were tested without success.
    fn explore(&mut self, task: &mut Task, unchanged: bool, completing: bool, limit: usize) {
        loop {
            if task.tested >= limit && !self.is_found() {
                break;
            }
            let best = (0..self.queue.len())
                .filter(|&i| !self.queue[i].expanded)
                .min_by(|&a, &b| order(&self.queue[a], &self.queue[b]));
            let Some(best) = best else { break };
            let entry = self.queue[best];
            if self.queue.iter().any(|e| e.expanded && e.assessment.valid() && order(e, &entry).is_le()) {
                break;
            }
            self.queue[best].expanded = true;
            if entry.assessment.valid() && unchanged {
                break;
            }
            let soles = task.p.soles.len();
            let screens = self.order == SearchOrder::Direct && entry.assessment.valid() && !completing;
            for s in 0..soles {
                let faults = entry.assessment.faults[s];
                let mut moves = Moves::default();
                moves.suggest(task.p, s, entry.states[s], faults, entry.assessment.valid());
                if screens && !moves.states().is_empty() {
                    self.restore(task, &entry);
                    self.screen.condense(&mut self.solver, task.p, &entry.states, s);
                    let (screen, solver) = (&mut self.screen, &mut self.solver);
                    moves.retain(|state| !screen.excludes(solver, task.p, state, &task.rules));
                }
                for &state in moves.states() {
                    if task.tested >= limit && !self.is_found() {
                        return;
                    }
                    let mut next = entry.states;
                    next[s] = state;
                    if completing {
                        self.complete(task, &next);
                    } else if (task.allowed)(s, state) {
                        self.push(task, &next);
                    }
                }
                // Soles of one body start and stop slipping together.
                let body = task.p.soles[s].body;
                let clamped = |t: usize| entry.states[t] != SoleState::FREE;
                let group = |t: &usize| task.p.soles[*t].body == body;
                if faults.friction && !completing && (0..soles).filter(group).any(|t| t != s && clamped(t)) {
                    let mut next = entry.states;
                    let mode = if entry.states[s].is_static() { Mode::Sliding } else { Mode::Static };
                    for t in (0..soles).filter(group).filter(|&t| clamped(t)) {
                        next[t].mode = mode;
                    }
                    if (0..soles).all(|t| (task.allowed)(t, next[t])) {
                        self.push(task, &next);
                    }
                }
            }
        }
    }

    /// Repeats the search from the best candidate over clamped patterns.
    fn explore_patterns(&mut self, task: &mut Task) {
        let best = self.best();
        self.queue.iter_mut().for_each(|e| e.expanded = true);
        self.complete(task, &best.states);
        self.explore(task, false, true, usize::MAX);
    }

    /// Tests the patterns of `states` with the modes that regularized friction gives them.
    fn complete(&mut self, task: &mut Task, states: &States) {
        let soles = task.p.soles.len();
        let mut patterns = *states;
        (0..soles).for_each(|s| patterns[s] = SoleState::fixed(patterns[s].pattern));
        if self.patterns.contains(&patterns) {
            return;
        }
        self.patterns.push(patterns);
        task.tested += 1;
        self.in_place = None;
        let regularized = self.finder.regularized_modes(&mut self.solver, task.p, &patterns, task.out);
        let Some(regularized) = regularized else { return };
        // Only a trial distinguishes a slip that has just begun from viscous creep.
        for threshold in [10.0, 1e3, 1e6] {
            let states = regularized.modes(task.p, threshold);
            if (0..soles).all(|s| (task.allowed)(s, states[s])) {
                self.forget(&states);
                self.guess = Some(regularized.slips);
                self.push(task, &states);
                self.guess = None;
            }
        }
    }

    /// Leaves the sliding directions and the solution of a tested candidate in place.
    fn restore(&mut self, task: &mut Task, entry: &Entry) {
        if self.in_place == Some(entry.states) {
            return;
        }
        if self.kept == Some(entry.states) {
            let vertices = task.p.soles.iter_mut().flat_map(|sole| &mut sole.vertices);
            vertices.zip(&self.kept_directions).for_each(|(v, d)| v.direction = *d);
            task.out.copy_from(&self.kept_solution);
            self.in_place = self.kept;
            return;
        }
        self.guess = Some(entry.slips);
        self.test(task.p, &entry.states, &task.rules, task.out);
        self.guess = None;
    }

    /// Keeps directions and solution of the candidate just tested.
    fn keep(&mut self, task: &Task, states: &States) {
        let vertices = task.p.soles.iter().flat_map(|sole| &sole.vertices);
        self.kept_directions.clear();
        self.kept_directions.extend(vertices.map(|v| v.direction));
        self.kept_solution.copy_from(task.out);
        self.kept = Some(*states);
    }

    fn best(&self) -> Entry {
        *self.queue.iter().min_by(|a, b| order(a, b)).expect("the start was pushed")
    }

    fn push(&mut self, task: &mut Task, states: &States) {
        if self.queue.iter().any(|e| e.states == *states) {
            return;
        }
        let assessment = self.test(task.p, states, &task.rules, task.out);
        task.tested += 1;
        let slips = sliding_directions::slips(task.p, states, &task.out.motion);
        let entry = Entry {
            states: *states,
            assessment,
            slips,
            slides: self.slides,
            guessed: self.guess.is_some(),
            brief: !self.finder.thorough,
            expanded: false,
        };
        if self.queue.iter().all(|other| order(&entry, other).is_lt()) {
            self.keep(task, states);
        }
        self.queue.push(entry);
    }

    /// Tests all states of all soles.
    fn enumerate(&mut self, task: &mut Task) {
        let states_of = |s: usize| SoleState::refined(task.p.soles[s].vertices.len());
        let mut sizes = [1; MAX_SOLES];
        (0..task.p.soles.len()).for_each(|s| sizes[s] = states_of(s).count());
        let total = sizes.iter().try_fold(1usize, |n, &k| n.checked_mul(k)).unwrap_or(usize::MAX);
        if total > ENUMERABLE {
            return;
        }
        for code in 0..total {
            let mut states = States::default();
            let mut rest = code;
            for s in 0..task.p.soles.len() {
                let k = task.p.soles[s].vertices.len();
                states[s] = SoleState::refined(k).nth(rest % sizes[s]).unwrap_or_default();
                rest /= sizes[s];
            }
            if (0..task.p.soles.len()).all(|s| (task.allowed)(s, states[s])) {
                self.push(task, &states);
            }
        }
    }
}

/// Orders by assessment, then by a fixed order of the states: the outcome is deterministic.
fn order(a: &Entry, b: &Entry) -> Ordering {
    a.assessment.compare(&b.assessment).then_with(|| a.states.cmp(&b.states))
}
