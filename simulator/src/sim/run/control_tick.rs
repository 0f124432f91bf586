//! A control tick: sensors, estimator, tasks or another command source, and the joint commands.

use super::RunState;
use crate::math;
use crate::sim::event_kind::EventKind;
use crate::sim::measure::snapshot;
use crate::sim::report::{Observer, SimEvent};
use crate::sim::run_error::RunError;
use crate::task::server::TickInput;
use crate::task::{Needs, TaskServer};

/// Runs the tasks of a tick and reports their events.
pub(in crate::sim) fn run_tasks(
    tasks: &mut TaskServer,
    input: &TickInput,
    observer: &mut dyn Observer,
) -> Result<(), RunError> {
    let time = input.state.time;
    let mut failure = None;
    let result = tasks.run(input, |change, name| {
        let message = format!("task {name} {change}");
        let event = SimEvent { time, kind: EventKind::Task, subject: name.to_string(), message };
        failure = observer.event(&event).err().or(failure.take());
    });
    failure.map_or(result.map_err(RunError::internal), |e| Err(RunError::internal(e)))
}

impl RunState {
    /// Runs a control tick: reads the sensors, computes joint commands, and passes them to the
    /// plant.
    pub(in crate::sim) fn control_tick(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
        let time = self.plant.state.time;
        let external = self.command_source.is_some();
        let estimates = self.log.snapshot.estimate.is_some();
        let loads = external || estimates || self.tasks.needs(time).contains(Needs::LOADS);
        self.sensors.read(&mut self.plant, loads);
        self.estimator.update(&self.plant.model, &self.sensors.readings);
        self.record_estimate();
        let result = if external { self.exchange_commands() } else { self.run_tasks(observer) };
        self.pass_command();
        if !(result.is_ok() && self.plan_ahead()) {
            self.plant.plan_paths(self.tasks.period(), self.tasks.next_tick());
        }
        result
    }

    /// Gets the joint commands from the command source.
    fn exchange_commands(&mut self) -> Result<(), RunError> {
        let Some(source) = &mut self.command_source else { return Ok(()) };
        let next = source.exchange(&self.sensors.readings, &mut self.tasks.command)?;
        self.tasks.set_remote_tick(self.sensors.readings.time, next);
        Ok(())
    }

    /// Sends the final readings to the command source.
    pub(in crate::sim) fn finish_command_source(&mut self) -> Result<(), RunError> {
        if self.command_source.is_some() {
            self.sensors.read(&mut self.plant, true);
        }
        self.command_source.as_mut().map_or(Ok(()), |source| source.finish(&self.sensors.readings))
    }

    fn run_tasks(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
        let plant = &self.plant;
        let input = TickInput {
            model: &plant.model,
            gravity: plant.gravity,
            floor: plant.floor.plane(),
            state: &self.estimator.state,
            sensed: &self.sensors.readings,
        };
        run_tasks(&mut self.tasks, &input, observer)
    }

    /// Records the estimate for the log, and its error.
    fn record_estimate(&mut self) {
        let Some(out) = &mut self.log.snapshot.estimate else { return };
        snapshot::fill_estimate(&self.estimator, &self.sensors.readings, out);
        if self.estimator.estimates() {
            let (position, angle) = self.estimator.error(&self.plant.state);
            let m = &mut self.metrics;
            m.max_estimate_error_m = Some(math::greater(m.max_estimate_error_m.unwrap_or(0.0), position));
            m.max_estimate_error_rad = Some(math::greater(m.max_estimate_error_rad.unwrap_or(0.0), angle));
            (m.final_estimate_error_m, m.final_estimate_error_rad) = (Some(position), Some(angle));
        }
    }
}
