//! Stepping a simulation by hand and reading its state: the part of [`Simulation`] that programs
//! use.

use super::report::{Observer, Outcome};
use super::run_error::RunError;
use super::simulation::Simulation;
use crate::contact::model::state::SoleState;
use crate::dynamics::State;
use crate::robot::Model;
use std::sync::atomic::{AtomicBool, Ordering};

impl Simulation {
    /// Advances to the first end of a step at or after `time` (s), or to the end of the run.
    /// Control ticks, corners of forces and located events end steps.
    ///
    /// # Errors
    /// Why the run ended early. It cannot be continued then.
    pub fn advance_to(&mut self, time: f64, observer: &mut dyn Observer) -> Result<(), RunError> {
        if !self.run.started {
            self.begin(observer)?;
        }
        while self.time() < time.min(self.run.duration) {
            if self.run.cancel.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed)) {
                return Err(RunError::new(Outcome::Cancelled, "interrupted"));
            }
            self.step(observer)?;
        }
        Ok(())
    }

    /// Runs to the end and completes the metrics; continues a run that was advanced by hand.
    ///
    /// # Errors
    /// Why the run ended early. The metrics describe it up to there.
    pub fn run_to_end(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
        match self.run(observer, &AtomicBool::new(false)) {
            (Outcome::Passed, _) => Ok(()),
            (outcome, message) => Err(RunError::new(outcome, message)),
        }
    }

    /// Simulated time, s.
    pub fn time(&self) -> f64 {
        self.run.plant.state.time
    }

    /// The robot as simulated.
    pub fn model(&self) -> &Model {
        &self.run.plant.model
    }

    /// Positions and velocities of base and joints.
    pub fn state(&self) -> &State {
        &self.run.plant.state
    }

    /// Contact state of each sole, in the order of the model's soles.
    pub fn contact_states(&self) -> impl Iterator<Item = SoleState> + '_ {
        (0..self.run.plant.model.soles.len()).map(|sole| self.run.plant.states[sole])
    }
}
