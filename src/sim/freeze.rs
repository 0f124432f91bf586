//! Telling the observer of contact problems, as they were posed and with the answer given.

use super::error::Stop;
use super::report::{Observer, Outcome, Problems};
use super::simulation::Simulation;
use crate::contact::methods::contact_method::SelectionInput;
use crate::contact::model::state::{MAX_SOLES, SoleState};
use crate::contact::search::select::Selection;
use crate::contact::selection_record::SelectionRecord;

impl Simulation {
    /// Freezes the problem at hand, before the method sees it, if the observer wants to hear of any.
    pub(super) fn freeze(
        &mut self,
        observer: &dyn Observer,
        input: &SelectionInput,
        forced: &[Option<SoleState>; MAX_SOLES],
    ) {
        self.frozen = (observer.problems() != Problems::None).then(|| {
            let (time, plant) = (self.plant.state.time, &self.plant);
            let told = (self.contact.method.name(), &self.contact.method.parameters());
            let mut frozen = SelectionRecord::from_problem(time, told, &plant.problem, input, forced, &plant.solution);
            for (s, sole) in frozen.soles.iter_mut().enumerate() {
                sole.name.clone_from(&plant.model.soles[s].name);
                sole.reference_m = plant.sole_origin(s).into();
            }
            Box::new(frozen)
        });
    }

    /// Adds the answer, still in the plant's solution, to the problem frozen before, and tells an observer that wants
    /// to hear of every selection.
    pub(super) fn freeze_answer(&mut self, observer: &mut dyn Observer, selection: &Selection) -> Result<(), Stop> {
        let Some(frozen) = &mut self.frozen else { return Ok(()) };
        frozen.set_answer(selection, &self.plant.solution);
        if observer.problems() == Problems::All {
            observer.problem(frozen).map_err(|m| Stop::new(Outcome::Error, m))?;
            self.frozen = None;
        }
        Ok(())
    }

    /// Counts and reports a selection that found no valid state.
    pub(super) fn inconsistent(&mut self, observer: &mut dyn Observer, message: &str) -> Result<(), Stop> {
        self.metrics.inconsistent += 1;
        if let Some(frozen) = self.frozen.take() {
            observer.problem(&frozen).map_err(|m| Stop::new(Outcome::Error, m))?;
        }
        self.event(observer, "inconsistent", "", message)
    }
}
