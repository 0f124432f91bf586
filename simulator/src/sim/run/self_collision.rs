//! Self-collision in a run: safe commands, and the check after each step.

use super::RunState;
use crate::sim::event_kind::EventKind;
use crate::sim::report::{Observer, SimEvent};
use crate::sim::run_error::RunError;

impl RunState {
    /// Passes the tasks' commands to the plant, after self-collision avoidance if configured.
    pub(in crate::sim) fn pass_command(&mut self) {
        self.plant.command.copy_from(&self.tasks.command);
        if let Some(monitor) = &mut self.self_collision {
            let plant = &mut self.plant;
            monitor.avoid(&plant.model, &plant.state, &mut plant.command);
        }
    }

    /// Checks the posture after a step for self-collision.
    pub(in crate::sim) fn check_self_collision(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
        let Some(monitor) = &mut self.self_collision else { return Ok(()) };
        let mut failure = None;
        let state = &self.plant.state;
        monitor.check(&self.plant.model, state, |change, pair, collision| {
            let [a, b] = collision.pairs[pair].bodies.map(|b| collision.bodies[b].name.as_str());
            let (subject, message) = (format!("{a}/{b}"), format!("overlap of `{a}` and `{b}` {change}"));
            let event = SimEvent { time: state.time, kind: EventKind::SelfCollision, subject, message };
            failure = failure.take().or(observer.event(&event).err());
        });
        failure.map_or(Ok(()), |e| Err(RunError::internal(e)))
    }
}
