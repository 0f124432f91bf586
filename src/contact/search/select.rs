//! Selects the contact state by a best-first search over candidates (`docs/contact.md`, section 4;
//! [Hale 2008], section III.A).
//!
//! The search starts from the state that continuity suggests. Candidates wait in a priority queue
//! ordered by [`Assessment::compare`]. The best is expanded by the local moves that its faults
//! suggest; no candidate is tested twice. The search ends at the first valid candidate that none of
//! its smaller neighbours beats. If the queue empties first:
//!
//! 1. the search is repeated over clamped patterns, with modes from
//!    [`crate::contact::search::regularized_modes`];
//! 2. both are repeated with slow hops allowed;
//! 3. all states of all soles are tried;
//! 4. the least violating candidate is returned, marked as inconsistent.

use crate::contact::model::problem::{Level, Problem};
use crate::contact::model::solution::Solution;
use crate::contact::model::state::{MAX_SOLES, Mode, Pattern, SoleState, States};
use crate::contact::search::candidate::{CandidateSolver, share_static};
use crate::contact::search::judge::{Assessment, Faults, Rules, SUSPECT_FRICTION, judge, margin, onset};
use crate::contact::search::sliding_directions::{self, DirectionFinder, Onset, Slips};
use nalgebra::Vector3;
use std::cmp::Ordering;

/// More combinations than this are not enumerated when the local search fails.
const ENUMERABLE: usize = 20_000;

#[derive(Clone, Copy, Debug)]
struct Entry {
    states: States,
    assessment: Assessment,
    /// Slips of its soles, from which its directions are found again.
    slips: Slips,
    /// Whether its directions were found from a regularized start.
    guessed: bool,
    expanded: bool,
}

/// Outcome of a selection. Wrenches and forces are in the solution passed in.
#[derive(Clone, Copy, Debug)]
pub struct Selection {
    /// The states chosen.
    pub states: States,
    /// Candidates tested.
    pub tested: usize,
    /// False when no candidate was valid.
    pub consistent: bool,
    /// Assessment of the chosen states.
    pub assessment: Assessment,
}

impl Selection {
    /// Selection of a method that tries no candidates and claims no validity: its errors show in
    /// the residuals.
    pub fn unchecked(states: States) -> Self {
        Selection { states, tested: 0, consistent: true, assessment: Assessment::default() }
    }
}

/// The state search, with its scratch.
#[derive(Clone, Debug)]
pub struct Selector {
    solver: CandidateSolver,
    finder: DirectionFinder,
    /// First guess of the slips, in addition to those that the loads suggest.
    guess: Option<Slips>,
    /// Slip onset of soles whose load an event has put at its limit.
    onset: Vec<Onset>,
    queue: Vec<Entry>,
    /// Clamped patterns whose modes have been solved for.
    patterns: Vec<States>,
}

impl Selector {
    /// A selector for problems of this size.
    pub fn new(p: &Problem) -> Self {
        Selector {
            solver: CandidateSolver::new(p),
            finder: DirectionFinder::new(p),
            guess: None,
            onset: vec![Onset::default(); p.soles.len()],
            queue: Vec::with_capacity(1024),
            patterns: Vec::with_capacity(256),
        }
    }

    /// The candidate solver, which has solved the chosen states.
    pub fn solver(&mut self) -> &mut CandidateSolver {
        &mut self.solver
    }

    /// Solves and judges one candidate.
    pub fn test(&mut self, p: &mut Problem, states: &States, rules: &Rules, out: &mut Solution) -> Assessment {
        // A static load beyond its capacity gives the direction of slip.
        let mut hint = [Vector3::zeros(); MAX_SOLES];
        if (0..p.soles.len()).any(|s| sliding_directions::is_implicit(p, states, s)) {
            let mut stuck = *states;
            (0..p.soles.len())
                .filter(|&s| sliding_directions::is_implicit(p, states, s))
                .for_each(|s| stuck[s].mode = Mode::Static);
            self.solver.solve(p, &stuck, out);
            share_static(p, &stuck, out);
            for s in (0..p.soles.len()).filter(|&s| stuck[s] != states[s]) {
                hint[s] = margin(p, &stuck, s, out).slip;
            }
        }
        let hints = [self.guess.unwrap_or(hint), hint];
        let hints = if self.guess.is_some() { &hints[..] } else { &hints[..1] };
        let slides = self.finder.solve(&mut self.solver, p, states, hints, &self.onset, out);
        share_static(p, states, out);
        judge(p, states, out, slides, rules)
    }

    /// Selects the states. `start` is tried first. Smaller neighbours of a valid candidate are
    /// tried too, unless `unchanged` is set: no event since `start` was chosen. `out` holds the
    /// solution of the previous states. `allowed` restricts the states of each sole (forced
    /// states).
    pub fn select(
        &mut self,
        p: &mut Problem,
        start: &States,
        unchanged: bool,
        rules: &Rules,
        allowed: &dyn Fn(usize, SoleState) -> bool,
        out: &mut Solution,
    ) -> Selection {
        self.queue.clear();
        self.patterns.clear();
        for (s, limit) in self.onset.iter_mut().enumerate() {
            limit.vertices = 0;
            if rules.suspect[s] & SUSPECT_FRICTION != 0 {
                onset(p, &rules.previous, s, out, limit);
            }
        }
        let (mut tested, mut hops) = (0, rules.hops);
        self.push(p, start, rules, &mut tested, out);
        self.explore(p, unchanged, false, rules, allowed, &mut tested, out);
        let mut best = self.best();
        if !best.assessment.valid() {
            // Search again from the best candidate over patterns only; the modes are solved for.
            self.queue.iter_mut().for_each(|e| e.expanded = true);
            self.complete(p, &best.states, rules, allowed, &mut tested, out);
            self.explore(p, false, true, rules, allowed, &mut tested, out);
            best = self.best();
            if !best.assessment.valid() && p.level == Level::Acceleration {
                let lenient = Rules { hops: true, ..*rules };
                self.queue.clear();
                self.patterns.clear();
                self.push(p, start, &lenient, &mut tested, out);
                self.explore(p, false, false, &lenient, allowed, &mut tested, out);
                best = self.best();
                if !best.assessment.valid() {
                    self.queue.iter_mut().for_each(|e| e.expanded = true);
                    self.complete(p, &best.states, &lenient, allowed, &mut tested, out);
                    self.explore(p, false, true, &lenient, allowed, &mut tested, out);
                    best = self.best();
                }
                hops = best.assessment.valid();
            }
            if !best.assessment.valid() {
                self.queue.clear();
                self.push(p, start, rules, &mut tested, out);
                self.enumerate(p, rules, allowed, &mut tested, out);
                best = self.best();
            }
        }
        let rules = &Rules { hops, ..*rules };
        // Leave the chosen candidate's solution and directions in place.
        self.guess = Some(best.slips);
        let assessment = self.test(p, &best.states, rules, out);
        self.guess = None;
        Selection { states: best.states, tested, consistent: assessment.valid(), assessment }
    }

    /// Expands the best candidates until one is valid and none of its smaller neighbours beats it.
    #[expect(clippy::too_many_arguments)]
    fn explore(
        &mut self,
        p: &mut Problem,
        unchanged: bool,
        completing: bool,
        rules: &Rules,
        allowed: &dyn Fn(usize, SoleState) -> bool,
        tested: &mut usize,
        out: &mut Solution,
    ) {
        loop {
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
            for s in 0..p.soles.len() {
                let faults = entry.assessment.faults[s];
                let mut moves = Moves::default();
                moves.suggest(p, s, entry.states[s], faults, entry.assessment.valid());
                for &state in &moves.list[..moves.count] {
                    let mut next = entry.states;
                    next[s] = state;
                    if completing {
                        self.complete(p, &next, rules, allowed, tested, out);
                    } else if allowed(s, state) {
                        self.push(p, &next, rules, tested, out);
                    }
                }
                // Soles of one body start and stop slipping together.
                let others = (0..p.soles.len()).filter(|&t| t != s && p.soles[t].body == p.soles[s].body);
                if faults.friction && !completing && others.clone().any(|t| entry.states[t] != SoleState::FREE) {
                    let mut next = entry.states;
                    let mode = if entry.states[s].is_static() { Mode::Sliding } else { Mode::Static };
                    for t in others.chain([s]).filter(|&t| entry.states[t] != SoleState::FREE) {
                        next[t].mode = mode;
                    }
                    if (0..p.soles.len()).all(|t| allowed(t, next[t])) {
                        self.push(p, &next, rules, tested, out);
                    }
                }
            }
        }
    }

    /// Tests the patterns of `states` with the modes that regularized friction gives them.
    fn complete(
        &mut self,
        p: &mut Problem,
        states: &States,
        rules: &Rules,
        allowed: &dyn Fn(usize, SoleState) -> bool,
        tested: &mut usize,
        out: &mut Solution,
    ) {
        let mut patterns = *states;
        (0..p.soles.len()).for_each(|s| patterns[s] = SoleState::fixed(patterns[s].pattern));
        if self.patterns.contains(&patterns) {
            return;
        }
        self.patterns.push(patterns);
        *tested += 1;
        let Some(regularized) = self.finder.regularized_modes(&mut self.solver, p, &patterns, out) else { return };
        // Only a trial distinguishes a slip that has just begun from viscous creep.
        for threshold in [10.0, 1e3, 1e6] {
            let states = regularized.modes(p, threshold);
            if (0..p.soles.len()).all(|s| allowed(s, states[s])) {
                // Candidates that failed without a good first guess are tried again.
                self.queue.retain(|e| e.states != states || e.assessment.valid() || e.guessed);
                self.guess = Some(regularized.slips);
                self.push(p, &states, rules, tested, out);
                self.guess = None;
            }
        }
    }

    fn best(&self) -> Entry {
        *self.queue.iter().min_by(|a, b| order(a, b)).expect("the start was pushed")
    }

    fn push(&mut self, p: &mut Problem, states: &States, rules: &Rules, tested: &mut usize, out: &mut Solution) {
        if self.queue.iter().any(|e| e.states == *states) {
            return;
        }
        let assessment = self.test(p, states, rules, out);
        *tested += 1;
        let slips = sliding_directions::slips(p, states, &out.motion);
        let guessed = self.guess.is_some();
        self.queue.push(Entry { states: *states, assessment, slips, guessed, expanded: false });
    }

    fn enumerate(
        &mut self,
        p: &mut Problem,
        rules: &Rules,
        allowed: &dyn Fn(usize, SoleState) -> bool,
        tested: &mut usize,
        out: &mut Solution,
    ) {
        let sizes: [usize; MAX_SOLES] =
            std::array::from_fn(|s| p.soles.get(s).map_or(1, |sole| SoleState::refined(sole.vertices.len()).count()));
        let total = sizes.iter().try_fold(1usize, |n, &k| n.checked_mul(k)).unwrap_or(usize::MAX);
        if total > ENUMERABLE {
            return;
        }
        for code in 0..total {
            let mut states = States::default();
            let mut rest = code;
            for (s, sole) in p.soles.iter().enumerate() {
                states[s] = SoleState::refined(sole.vertices.len()).nth(rest % sizes[s]).unwrap_or_default();
                rest /= sizes[s];
            }
            if (0..p.soles.len()).all(|s| allowed(s, states[s])) {
                self.push(p, &states, rules, tested, out);
            }
        }
    }
}

/// Orders by assessment, then by a fixed order of the states: the outcome is deterministic.
fn order(a: &Entry, b: &Entry) -> Ordering {
    a.assessment.compare(&b.assessment).then_with(|| a.states.cmp(&b.states))
}

/// First mode to try for a pattern: sliding if one of its vertices moves, else static.
pub fn first_mode(p: &Problem, s: usize, pattern: Pattern) -> SoleState {
    let sole = &p.soles[s];
    let k = sole.vertices.len();
    let state = SoleState::fixed(pattern);
    let slides = (0..k).any(|i| state.clamps(i, k) && sole.vertices[i].moving);
    if slides { SoleState::sliding(pattern) } else { state }
}

/// Local moves of one sole, on the stack. At most 64 vertices give at most 64 + 64 + 1 patterns.
struct Moves {
    list: [SoleState; 200],
    count: usize,
}

impl Default for Moves {
    fn default() -> Self {
        Moves { list: [SoleState::FREE; 200], count: 0 }
    }
}

impl Moves {
    fn add(&mut self, state: SoleState) {
        if self.count < self.list.len() {
            self.list[self.count] = state;
            self.count += 1;
        }
    }

    fn suggest(&mut self, p: &Problem, s: usize, state: SoleState, faults: Faults, valid: bool) {
        let k = p.soles[s].vertices.len();
        let rows = state.normal_rows();
        for pattern in SoleState::patterns(k) {
            let next = SoleState::fixed(pattern);
            let to_clamp = faults.penetrating | if valid { faults.resting } else { 0 };
            let clamps_fault = (0..k).any(|i| to_clamp >> i & 1 == 1 && next.clamps(i, k));
            let nested = |a: SoleState, b: SoleState| (0..k).all(|i| !a.clamps(i, k) || b.clamps(i, k));
            // Clamp a vertex that enters the floor, keeping or replacing clamped vertices.
            let clamp = clamps_fault && next.normal_rows() >= rows;
            // Release a pulling vertex; for a valid candidate, try smaller patterns.
            let release = (faults.pulling || valid) && next.normal_rows() < rows && nested(next, state);
            // A pulling edge may have to be replaced by its neighbour.
            let shift = faults.pulling && faults.penetrating != 0 && clamps_fault;
            if pattern != state.pattern && (clamp || release || shift) {
                self.add(first_mode(p, s, pattern));
                if valid && state.is_dynamic() {
                    self.add(SoleState::sliding(pattern));
                }
            }
        }
        if state.pattern == Pattern::Free {
            return;
        }
        if faults.pulling || valid {
            self.add(SoleState::FREE);
        }
        if faults.friction {
            let with = |mode| SoleState { pattern: state.pattern, mode };
            match state.mode {
                Mode::Static => self.add(with(Mode::Sliding)),
                Mode::Sliding | Mode::Pivoting(_) => {
                    self.add(with(Mode::Static));
                    self.add(with(Mode::Sliding));
                    for i in (0..k).filter(|&i| rows > 1 && state.clamps(i, k) && !p.soles[s].vertices[i].moving) {
                        self.add(with(Mode::Pivoting(i as u8)));
                    }
                }
            }
        }
    }
}
