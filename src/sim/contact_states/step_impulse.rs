//! Contact states and impulses of a velocity-level step.

use crate::contact::methods::contact_method::SelectionInput;
use crate::contact::model::state::SoleState;
use crate::sim::report::Observer;
use crate::sim::run::RunState;
use crate::sim::run_error::RunError;

impl RunState {
    /// Chooses states and impulses of this step.
    pub(in crate::sim) fn choose_impulse(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
        let rules = self.rules();
        let forced = self.forced(self.plant.state.time);
        let allowed = |s: usize, state: SoleState| forced[s].is_none_or(|f: SoleState| f.pattern == state.pattern);
        let input = SelectionInput { rules: &rules, event: false, allowed: &allowed };
        self.record_problem(observer, &input, &forced);
        let plant = &mut self.plant;
        let selection = plant.method.impulse(&mut plant.problem, &input, &mut plant.solution);
        self.record_solution(observer, &selection)?;
        self.count(&selection);
        if !selection.consistent && !self.all_imposed(&selection.assessment) {
            let message = format!("no contact state is valid; least violations {:?}", selection.assessment.levels);
            self.report_inconsistent(observer, &message)?;
        }
        self.adopt(selection.states, observer)
    }
}
