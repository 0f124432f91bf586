//! A control tick: sensors, estimator, and who decides what the joints are asked.

use super::error::Stop;
use super::report::{Observer, Outcome, SimEvent};
use super::simulation::Simulation;
use crate::task::Needs;
use crate::task::server::TickInput;

impl Simulation {
    /// A control tick: reads the sensors, has it decided what the joints are asked, and passes that on.
    pub(super) fn run_tasks(&mut self, observer: &mut dyn Observer) -> Result<(), Stop> {
        let time = self.plant.state.time;
        let elsewhere = self.commander.is_some();
        let loads = elsewhere || self.snapshot.estimate.is_some() || self.tasks.needs(time).contains(Needs::LOADS);
        self.sensors.read(&mut self.plant, loads);
        self.estimator.update(&self.plant.model, &self.sensors.readings);
        self.take_estimate();
        let decided = if elsewhere { self.obey() } else { self.call_tasks(observer) };
        self.pass_command();
        self.plant.plan(self.tasks.period(), self.tasks.next_tick());
        decided
    }

    /// Has the joints asked what somebody else wants.
    fn obey(&mut self) -> Result<(), Stop> {
        let Some(commander) = &mut self.commander else { return Ok(()) };
        let next = commander.exchange(&self.sensors.readings, &mut self.tasks.command)?;
        self.tasks.set_remote_tick(self.sensors.readings.time, next);
        Ok(())
    }

    /// Tells who decides somewhere else how it ended.
    pub(super) fn dismiss(&mut self) -> Result<(), Stop> {
        if self.commander.is_some() {
            self.sensors.read(&mut self.plant, true);
        }
        self.commander.as_mut().map_or(Ok(()), |commander| commander.finish(&self.sensors.readings))
    }

    fn call_tasks(&mut self, observer: &mut dyn Observer) -> Result<(), Stop> {
        let time = self.plant.state.time;
        let plant = &self.plant;
        let situation = TickInput {
            model: &plant.model,
            gravity: plant.gravity,
            floor: plant.floor.plane(),
            state: &self.estimator.state,
            sensed: &self.sensors.readings,
        };
        let mut failure = None;
        let ran = self.tasks.run(&situation, |what, name| {
            let message = format!("task {name} {what}");
            let event = SimEvent { time, kind: "task", subject: name.to_string(), message };
            failure = observer.event(&event).err().or(failure.take());
        });
        failure.map_or(ran.map_err(|e| e.to_string()), Err).map_err(|m| Stop::new(Outcome::Error, m))
    }

    /// Keeps what was estimated for the log, and how far it is from the truth.
    fn take_estimate(&mut self) {
        let Some(out) = &mut self.snapshot.estimate else { return };
        super::observe::fill_estimate(&self.estimator, &self.sensors.readings, out);
        if self.estimator.estimates() {
            let (position, angle) = self.estimator.error(&self.plant.state);
            let m = &mut self.metrics;
            m.max_estimate_error_m = Some(m.max_estimate_error_m.unwrap_or(0.0).max(position));
            m.max_estimate_error_rad = Some(m.max_estimate_error_rad.unwrap_or(0.0).max(angle));
            (m.final_estimate_error_m, m.final_estimate_error_rad) = (Some(position), Some(angle));
        }
    }
}
