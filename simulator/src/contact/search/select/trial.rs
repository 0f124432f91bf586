//! Solves and judges one candidate, with its sliding directions and the modes of torsional and rolling friction.

use super::Selector;
use crate::contact::model::problem::Problem;
use crate::contact::model::solution::Solution;
use crate::contact::model::state::{Mode, States};
use crate::contact::search::judge::{Assessment, Rules, judge, margin};
use crate::contact::search::sliding_directions;
use crate::contact::search::slips::Slips;
use crate::contact::search::static_loads::share_static;
use crate::contact::search::turning_modes;
use std::slice;

impl Selector {
    /// Solves and judges one candidate.
    pub fn test(&mut self, p: &mut Problem, states: &States, rules: &Rules, out: &mut Solution) -> Assessment {
        let has_turning = p.has_turning();
        if has_turning {
            turning_modes::begin(p);
        }
        let mut rounds = turning_modes::Rounds::default();
        let slides = loop {
            let slides = self.solve_candidate(p, states, out);
            share_static(p, states, out);
            let (solver, motion) = (&mut self.solver, &mut self.turning_motion);
            if !has_turning || !rounds.update(solver, p, states, rules, out, motion) {
                break slides;
            }
        };
        (self.in_place, self.slides) = (Some(states.clone()), slides);
        judge(p, states, out, slides, rules)
    }

    /// Solves one candidate with its sliding directions. Returns whether these are consistent.
    fn solve_candidate(&mut self, p: &mut Problem, states: &States, out: &mut Solution) -> bool {
        let mut slides = false;
        if let Some(guess) = &self.guess {
            slides = self.finder.solve(&mut self.solver, p, states, slice::from_ref(guess), &self.onset, out);
        }
        if !slides && (self.finder.thorough || self.guess.is_none()) {
            let hint = self.slip_of_static_load(p, states, out);
            slides = self.finder.solve(&mut self.solver, p, states, &[hint], &self.onset, out);
        }
        slides
    }

    /// Slips in which the static loads of soles with undetermined sliding directions exceed their
    /// capacity.
    fn slip_of_static_load(&mut self, p: &Problem, states: &States, out: &mut Solution) -> Slips {
        let mut hint = Slips::default();
        let mut stuck = states.clone();
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
}
