//! Application of scenario events to a run.

use super::RunState;
use crate::sim::event_kind::EventKind;
use crate::sim::report::Observer;
use crate::sim::run_error::RunError;
use crate::sim::scenario_event::ScenarioEvent;

impl RunState {
    /// Applies the events that are due. Returns whether there were any.
    pub(in crate::sim) fn apply_due_events(&mut self, observer: &mut dyn Observer) -> Result<bool, RunError> {
        let mut any = false;
        while self.events.get(self.events_done).is_some_and(|e| e.at <= self.plant.state.time) {
            let mut event = std::mem::take(&mut self.events[self.events_done]);
            self.events_done += 1;
            any = true;
            self.apply_event(&mut event)?;
            self.events[self.events_done - 1].save = event.save;
            self.event(observer, EventKind::Scenario, "", &event.message)?;
        }
        Ok(any)
    }

    fn apply_event(&mut self, event: &mut ScenarioEvent) -> Result<(), RunError> {
        self.plant.refresh();
        let before = self.plant.energy();
        if let Some(slot) = event.save {
            self.save(slot);
        }
        if let Some(slot) = event.restore {
            let (links, pairs) = self.saved[slot].polygons();
            // Patches that remain would keep their present anchors.
            self.set_polygons(links, Some(Vec::new()));
            self.set_polygons(None, Some(pairs));
            self.saved[slot].restore(&mut self.plant, &mut self.anchors, &mut self.suspect);
            self.sensors.restart();
            self.estimator.restart();
        }
        let new_model = event.model.is_some();
        self.plant.set_parameters(event.model.take(), event.gravity, event.floor.take());
        self.plant.replace_forces(event.forces.drain(..)).map_err(RunError::internal)?;
        if new_model {
            self.carried.reattach(&mut self.plant);
        }
        for command in [&mut self.tasks.command, &mut self.plant.command] {
            for &(j, kp, kd) in &event.gains {
                (command.kp[j], command.kd[j]) = (kp, kd);
            }
        }
        event.end_tasks.iter().for_each(|number| self.tasks.end(*number));
        self.contact.restitution = event.restitution.unwrap_or(self.contact.restitution);
        self.plant.refresh();
        self.plant.reset_friction();
        self.energy.flows.add_external(self.plant.energy() - before);
        self.milestones.restart(event.restore.is_some());
        Ok(())
    }

    /// Saves the present state.
    pub(in crate::sim) fn save(&mut self, slot: usize) {
        self.saved[slot].save(&self.plant, &self.anchors, &self.suspect, self.links.as_deref());
    }
}
