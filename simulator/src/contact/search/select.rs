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
//! 1. near the state that continuity suggests, first with an indeterminate load split inside the friction cones;
//! 2. near the states of the contact problem solved with every vertex as a point
//!    ([`point_forces`](super::point_forces)): first briefly, with the slips of that solution as the
//!    only guess, then on parts of the carrying vertices, then thoroughly;
//! 3. near those of the same with vertices sliding whose slow normal motion is about to be settled;
//! 4. near those of the same without vertices that leave the floor, with slow hops allowed, if any
//!    vertex hops;
//! 5. as the order `paper`, if [`Rules::exhaustive`]; a fixed step, or an impact without restitution,
//!    takes the point solution itself instead, if it is accurate.
//!
//! The order `paper` is the best-first search of [Hale 2008], section III.A, without limit, from the
//! state that continuity suggests. If the queue empties first:
//!
//! 1. the search is repeated over clamped patterns, with modes from
//!    [`regularized_modes`](super::regularized_modes);
//! 2. both are repeated with slow hops allowed;
//! 3. all states of all soles are tried;
//! 4. the least violating candidate is returned, marked as inconsistent.
//!
//! Problems with too many states to try all end this search after a number of candidates
//! (`MOST` in `all_states`). Cancellation ends it after the present candidate.
//!
//! `trial` solves and judges a candidate, `explore` tests its neighbours, `proposals` what the point solution
//! suggests, `all_states` searches all states.

mod all_states;
mod explore;
mod proposals;
mod trial;

use crate::contact::model::problem::{Level, Problem, Vertex};
use crate::contact::model::solution::Solution;
use crate::contact::model::state::{SoleState, States};
use crate::contact::model::turning::TurningMode;
use crate::contact::search::candidate::CandidateSolver;
use crate::contact::search::judge::{Assessment, MOST_ROUNDING, Rules, SUSPECT_FRICTION, judge, onset};
use crate::contact::search::neighbour_screen::NeighbourScreen;
use crate::contact::search::point_forces::PointForces;
use crate::contact::search::sliding_directions::{DirectionFinder, Onset};
use crate::contact::search::slips::{self, Slips};
use nalgebra::Vector2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;
use std::sync::atomic::{self, AtomicBool};

/// Candidates tested near the previous states at an event. In a fixed step the contact problem,
/// solved from the forces of the last step, finds changed states sooner.
const NEAR: usize = 4;

#[derive(Clone, Debug)]
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
#[derive(Clone, Debug)]
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

/// Input of a selection of states.
#[derive(Clone, Copy)]
pub struct SelectionInput<'a> {
    /// Tolerances, the previous states, and which of them an event has put in doubt.
    pub rules: &'a Rules,
    /// Whether an event has occurred since the previous states were selected.
    pub event: bool,
    /// Which states each sole may take (forced states of a scenario).
    pub allowed: &'a dyn Fn(usize, SoleState) -> bool,
    /// Once set, a search ends early and its selection is discarded.
    pub cancel: Option<&'a AtomicBool>,
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
    /// Candidates after which a search through all states ends.
    most: usize,
    cancel: Option<&'a AtomicBool>,
}

impl Task<'_> {
    /// Whether the search ends without a valid state: it has tested enough, or is cancelled.
    fn is_ended(&self) -> bool {
        self.tested >= self.most || self.cancel.is_some_and(|cancel| cancel.load(atomic::Ordering::Relaxed))
    }

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
    /// Loads inside the friction cones.
    inside: PointForces,
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
    kept_turning: Vec<TurningMode>,
    kept_solution: Solution,
    /// Clamped patterns whose modes have been solved for.
    patterns: Vec<States>,
    /// States of one sole on parts of its carrying vertices.
    parts: Vec<SoleState>,
    /// Scratch of the modes of torsional and rolling friction.
    turning_motion: Vec<f64>,
}

impl Selector {
    /// A selector for problems of this size.
    pub fn new(order: SearchOrder, p: &Problem) -> Self {
        Selector {
            order,
            solver: CandidateSolver::new(p),
            finder: DirectionFinder::new(p),
            points: PointForces::new(p),
            inside: PointForces::new(p),
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
            kept_turning: Vec::with_capacity(p.soles.len()),
            turning_motion: vec![0.0; p.dim()],
            kept_solution: Solution::new(p),
            patterns: Vec::with_capacity(256),
            parts: Vec::with_capacity(3 * 64),
        }
    }

    /// The candidate solver, which has solved the chosen states.
    pub fn solver(&mut self) -> &mut CandidateSolver {
        &mut self.solver
    }

    /// Selects the states. `starts` are tried first, in order. Smaller neighbours of a valid
    /// candidate are tried too if an event has occurred since the first of `starts` was chosen.
    /// `out` holds the solution of the previous states.
    pub fn select(
        &mut self,
        p: &mut Problem,
        starts: &[States],
        input: &SelectionInput,
        out: &mut Solution,
    ) -> Selection {
        let SelectionInput { rules, event, allowed, cancel } = *input;
        let unchanged = !event;
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
        let mut task = Task { p, rules: rules.clone(), allowed, out, tested: 0, most: usize::MAX, cancel };
        let direct = self.order == SearchOrder::Direct;
        let found = direct && self.search_near(&mut task, starts, unchanged);
        if direct
            && !found
            && let Some(selection) = self.point_solution(&mut task)
        {
            return selection;
        }
        let exhausted = found || !direct || rules.exhaustive;
        if !found && exhausted {
            // From rest, as in the paper.
            let slides = |states: &&States| (0..task.p.soles.len()).filter(|&s| states[s].is_dynamic()).count();
            let start = starts.iter().rev().min_by_key(slides).expect("at least one start");
            self.search_all(&mut task, start, unchanged);
        }
        let best = self.best();
        // Leave the chosen candidate's solution and directions in place.
        self.restore(&mut task, &best);
        let (assessment, full) = (best.assessment, direct && !found && exhausted);
        let consistent = assessment.valid();
        let exhausted = exhausted && (consistent || !task.is_ended());
        Selection { states: best.states, tested: task.tested, full, consistent, exhausted, assessment }
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
            self.guess = slides.then(|| slips::slips_of_velocities(task.p, start));
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
        if level == Level::Acceleration && self.push_inside(task, &starts[starts.len() - 1]) {
            return true;
        }
        let near = if level == Level::Acceleration { NEAR } else { 0 };
        self.explore(task, unchanged, false, near);
        if self.is_found() {
            return true;
        }
        self.propose(task, |v| if level == Level::Velocity { v.near } else { v.is_in_band(&tol) });
        if self.is_found() {
            return true;
        }
        if self.is_step_solved(task) {
            // Its forces are within their cones, unlike those of a margin that is short.
            return false;
        }
        if self.accept_at_limit(task) || level == Level::Velocity {
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
        let rules = Rules { rounding: MOST_ROUNDING, ..task.rules.clone() };
        // Its sliding directions are consistent if friction is what more rounding clears.
        let assessment = judge(task.p, &best.states, task.out, best.slides, &rules);
        let valid = assessment.valid();
        if let Some(entry) = self.queue.iter_mut().find(|e| e.states == best.states).filter(|_| valid) {
            entry.assessment = assessment;
        }
        valid
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
        if self.queue.len() < count && self.kept.as_ref() == Some(states) {
            self.kept = None;
        }
    }

    fn is_found(&self) -> bool {
        self.queue.iter().any(|e| e.assessment.valid())
    }

    /// Leaves the sliding directions and the solution of a tested candidate in place.
    fn restore(&mut self, task: &mut Task, entry: &Entry) {
        if self.in_place.as_ref() == Some(&entry.states) {
            return;
        }
        if self.kept.as_ref() == Some(&entry.states) {
            let vertices = task.p.soles.iter_mut().flat_map(|sole| &mut sole.vertices);
            vertices.zip(&self.kept_directions).for_each(|(v, d)| v.direction = *d);
            task.p.set_turning_modes(&self.kept_turning);
            task.out.copy_from(&self.kept_solution);
            self.in_place.clone_from(&self.kept);
            return;
        }
        self.guess = Some(entry.slips.clone());
        self.test(task.p, &entry.states, &task.rules, task.out);
        self.guess = None;
    }

    /// Keeps directions and solution of the candidate just tested.
    fn keep(&mut self, task: &Task, states: &States) {
        let vertices = task.p.soles.iter().flat_map(|sole| &sole.vertices);
        self.kept_directions.clear();
        self.kept_directions.extend(vertices.map(|v| v.direction));
        self.kept_turning.clear();
        self.kept_turning.extend(task.p.soles.iter().map(|sole| sole.turning.mode));
        self.kept_solution.copy_from(task.out);
        self.kept = Some(states.clone());
    }

    fn best(&self) -> Entry {
        self.queue.iter().min_by(|a, b| order(a, b)).expect("the start was pushed").clone()
    }

    fn push(&mut self, task: &mut Task, states: &States) {
        if self.queue.iter().any(|e| e.states == *states) {
            return;
        }
        let assessment = self.test(task.p, states, &task.rules, task.out);
        task.tested += 1;
        let slips = slips::slips(task.p, states, &task.out.motion);
        let entry = Entry {
            states: states.clone(),
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
}

/// Orders by assessment, then by a fixed order of the states: the outcome is deterministic.
fn order(a: &Entry, b: &Entry) -> Ordering {
    a.assessment.compare(&b.assessment).then_with(|| a.states.cmp(&b.states))
}
