//! The search through all states: best-first, then over clamped patterns, then by enumeration.

use super::{Selector, Task};
use crate::contact::model::per_sole::INLINE;
use crate::contact::model::problem::{Level, Problem};
use crate::contact::model::state::{SoleState, States};
use smallvec::SmallVec;

/// More combinations than this are not enumerated when the local search fails.
const ENUMERABLE: usize = 20_000;

/// Candidates after which the search through more combinations ends: a few seconds with a dozen links
/// on the floor.
const MOST: usize = 5_000;

/// Number of combinations of the states of all soles, and its factors; the greatest number if it
/// overflows.
fn combinations(p: &Problem) -> (usize, SmallVec<[usize; INLINE]>) {
    let sizes: SmallVec<_> = p.soles.iter().map(|sole| SoleState::refined(sole.vertices.len()).count()).collect();
    (sizes.iter().try_fold(1usize, |n, &k| n.checked_mul(k)).unwrap_or(usize::MAX), sizes)
}

/// Candidates after which a search through all states ends. Few combinations bound it themselves.
fn most_tested(p: &Problem) -> usize {
    if can_enumerate(p) { usize::MAX } else { MOST }
}

/// Whether all combinations can be tried.
pub(super) fn can_enumerate(p: &Problem) -> bool {
    combinations(p).0 <= ENUMERABLE
}

impl Selector {
    /// Searches all states, best-first from the previous ones.
    pub(super) fn search_all(&mut self, task: &mut Task, start: &States, unchanged: bool) {
        let all = usize::MAX;
        task.most = most_tested(task.p);
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

    /// Repeats the search from the best candidate over clamped patterns.
    pub(super) fn explore_patterns(&mut self, task: &mut Task) {
        let best = self.best();
        self.queue.iter_mut().for_each(|e| e.expanded = true);
        self.complete(task, &best.states);
        self.explore(task, false, true, usize::MAX);
    }

    /// Tests the patterns of `states` with the modes that regularized friction gives them.
    pub(super) fn complete(&mut self, task: &mut Task, states: &States) {
        let soles = task.p.soles.len();
        let mut patterns = states.clone();
        (0..soles).for_each(|s| patterns[s] = SoleState::fixed(patterns[s].pattern));
        if self.patterns.contains(&patterns) {
            return;
        }
        self.patterns.push(patterns.clone());
        task.tested += 1;
        self.in_place = None;
        let regularized = self.finder.regularized_modes(&mut self.solver, task.p, &patterns, task.out);
        let Some(regularized) = regularized else { return };
        // Only a trial distinguishes a slip that has just begun from viscous creep.
        for threshold in [10.0, 1e3, 1e6] {
            let states = regularized.modes(task.p, threshold);
            if (0..soles).all(|s| (task.allowed)(s, states[s])) {
                self.forget(&states);
                self.guess = Some(regularized.slips.clone());
                self.push(task, &states);
                self.guess = None;
            }
        }
    }

    /// Tests all states of all soles.
    pub(super) fn enumerate(&mut self, task: &mut Task) {
        let (total, sizes) = combinations(task.p);
        if total > ENUMERABLE {
            return;
        }
        for code in 0..total {
            if task.is_ended() {
                return;
            }
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
