//! Reports each contact problem and its solution to the observer.

use crate::contact::methods::contact_method::SelectionInput;
use crate::contact::model::per_sole::PerSole;
use crate::contact::model::state::SoleState;
use crate::contact::search::select::Selection;
use crate::contact::selection_record::SelectionRecord;
use crate::sim::event_kind::EventKind;
use crate::sim::report::{Observer, Problems};
use crate::sim::run::RunState;
use crate::sim::run_error::RunError;

impl RunState {
    /// Records the present problem, before the method solves it, if the observer receives problems.
    pub(in crate::sim) fn record_problem(
        &mut self,
        observer: &dyn Observer,
        input: &SelectionInput,
        forced: &PerSole<Option<SoleState>>,
    ) {
        self.recorded_problem = (observer.problems() != Problems::None).then(|| {
            let (time, plant) = (self.plant.state.time, &self.plant);
            let method = (self.contact.method.name(), &self.contact.method.parameters());
            let mut record =
                SelectionRecord::from_problem(time, method, &plant.problem, input, forced, &plant.solution);
            for (s, sole) in record.soles.iter_mut().enumerate() {
                plant.polygons[s].name().clone_into(&mut sole.name);
                sole.reference_m = plant.sole_origin(s).into();
            }
            Box::new(record)
        });
    }

    /// Adds the plant's solution to the recorded problem. Reports the record to an observer of all
    /// problems.
    pub(in crate::sim) fn record_solution(
        &mut self,
        observer: &mut dyn Observer,
        selection: &Selection,
    ) -> Result<(), RunError> {
        let Some(record) = &mut self.recorded_problem else { return Ok(()) };
        record.set_answer(selection, &self.plant.solution);
        if observer.problems() == Problems::All {
            observer.problem(record).map_err(RunError::internal)?;
            self.recorded_problem = None;
        }
        Ok(())
    }

    /// Counts and reports a selection that found no valid state.
    pub(in crate::sim) fn report_inconsistent(
        &mut self,
        observer: &mut dyn Observer,
        message: &str,
    ) -> Result<(), RunError> {
        self.metrics.inconsistent += 1;
        if let Some(record) = self.recorded_problem.take() {
            observer.problem(&record).map_err(RunError::internal)?;
        }
        self.event(observer, EventKind::Inconsistent, "", message)
    }
}
