//! The one-step method: no trial states (`contact.md` section 10, the paper's section III.B). [`crate::contact::methods::decision`] decides
//! from present quantities, then there is one solve.

use crate::contact::methods::decision;
use crate::contact::methods::method::{Manner, Method, Question};
use crate::contact::model::problem::{Level, Problem};
use crate::contact::model::solution::Solution;
use crate::contact::model::state::{SoleState, States};
use crate::contact::search::candidate::{Kernel, share_static};
use crate::contact::search::judge::judge;
use crate::contact::search::select::Selection;

/// See the module.
pub struct OneStep {
    kernel: Kernel,
}

impl OneStep {
    /// For problems of this size.
    pub fn new(p: &Problem) -> Self {
        OneStep { kernel: Kernel::new(p) }
    }
}

impl OneStep {
    fn decide(p: &mut Problem, question: &Question, last: &Solution) -> States {
        let rules = question.rules;
        let mut states = States::default();
        for s in 0..p.soles.len() {
            let before = rules.previous[s];
            let pattern = decision::pattern(p, s, before, last, &rules.tolerances);
            states[s] = decision::mode(p, s, pattern, &rules.previous, last, &rules.tolerances);
            if !(question.allowed)(s, states[s]) {
                let k = p.soles[s].vertices.len();
                states[s] = SoleState::all(k).find(|&x| (question.allowed)(s, x)).unwrap_or(states[s]);
                // What was decided about sliding was not about this state.
                decision::oppose(&mut p.soles[s], rules.tolerances.rest);
            }
        }
        states
    }

    fn answer(&mut self, p: &mut Problem, question: &Question, out: &mut Solution) -> Selection {
        let states = Self::decide(p, question, out);
        self.kernel.solve(p, &states, out);
        share_static(p, &states, out);
        let verdict = judge(p, &states, out, true, question.rules);
        // It does not claim validity, so it is never inconsistent: its errors show in the residuals.
        Selection { states, tested: 1, consistent: true, verdict }
    }
}

impl Method for OneStep {
    fn manner(&self) -> Manner {
        Manner::Deciding
    }

    fn select(&mut self, p: &mut Problem, question: &Question, out: &mut Solution) -> Selection {
        debug_assert_eq!(p.level, Level::Acceleration);
        self.answer(p, question, out)
    }

    fn impulse(&mut self, p: &mut Problem, question: &Question, out: &mut Solution) -> Selection {
        self.answer(p, question, out)
    }

    fn respond(&mut self, p: &Problem, states: &States, out: &mut Solution) {
        self.kernel.solve(p, states, out);
    }
}
