//! The one-step method, without trial states (`docs/contact.md` section 10; [Hale 2008], III.B).
//! [`super::decision`] decides from present quantities; one solve follows.

use crate::contact::methods::contact_method::{ContactSolver, Scheme, SelectionInput};
use crate::contact::methods::decision;
use crate::contact::methods::registry::MethodDescriptor;
use crate::contact::methods::turning_decision;
use crate::contact::model::problem::{Level, Problem};
use crate::contact::model::solution::Solution;
use crate::contact::model::state::{SoleState, States};
use crate::contact::search::candidate::CandidateSolver;
use crate::contact::search::judge::judge;
use crate::contact::search::select::Selection;
use crate::contact::search::static_loads::share_static;

/// Descriptor for scenarios and reports.
pub const DESCRIPTOR: MethodDescriptor = MethodDescriptor {
    name: "one-step",
    doc: "One decision per vertex from the present quantities, without trials.",
    only_semi_implicit: None,
    restitution: false,
    unforced: None,
    momentless: None,
    colour: "#D55E00",
    is_configured: |_| false,
    unknowns: None,
    solver: |_, p| Box::new(OneStep::new(p)),
};

/// Solver of the method.
#[derive(Clone)]
pub struct OneStep {
    solver: CandidateSolver,
}

impl OneStep {
    /// For problems of this size.
    pub fn new(p: &Problem) -> Self {
        OneStep { solver: CandidateSolver::new(p) }
    }

    fn decide(p: &mut Problem, input: &SelectionInput, last: &Solution) -> States {
        let rules = input.rules;
        let mut states = States::default();
        for s in 0..p.soles.len() {
            let before = rules.previous[s];
            let pattern = decision::pattern(p, s, before, last, &rules.tolerances);
            states[s] = decision::mode(p, s, pattern, &rules.previous, last, &rules.tolerances);
            if !(input.allowed)(s, states[s]) {
                let k = p.soles[s].vertices.len();
                states[s] = SoleState::all(k).find(|&x| (input.allowed)(s, x)).unwrap_or(states[s]);
                // The decided sliding directions belong to another state.
                decision::set_directions(&mut p.soles[s], rules.tolerances.rest);
            }
            turning_decision::decide(p, s, [before, states[s]], last, &rules.tolerances);
        }
        states
    }

    fn decide_and_solve(&mut self, p: &mut Problem, input: &SelectionInput, out: &mut Solution) -> Selection {
        let states = Self::decide(p, input, out);
        self.solver.solve(p, &states, out);
        share_static(p, &states, out);
        let assessment = judge(p, &states, out, true, input.rules);
        // The method claims no validity, so it is never inconsistent: its errors show in the
        // residuals.
        Selection { states, tested: 1, full: false, consistent: true, exhausted: true, assessment }
    }
}

impl ContactSolver for OneStep {
    fn copy(&self) -> Option<Box<dyn ContactSolver>> {
        Some(Box::new(self.clone()))
    }

    fn scheme(&self) -> Scheme {
        Scheme::DecidedPerStep
    }

    fn select(&mut self, p: &mut Problem, input: &SelectionInput, out: &mut Solution) -> Selection {
        debug_assert_eq!(p.level, Level::Acceleration);
        self.decide_and_solve(p, input, out)
    }

    fn impulse(&mut self, p: &mut Problem, input: &SelectionInput, out: &mut Solution) -> Selection {
        self.decide_and_solve(p, input, out)
    }

    fn respond(&mut self, p: &Problem, states: &States, out: &mut Solution) {
        self.solver.solve(p, states, out);
    }
}
