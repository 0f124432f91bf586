//! Continuation of a run with another setup, and snapshots between two steps, for callers such as
//! the console.

use super::measure::snapshot;
use super::report::Snapshot;
use super::run_error::RunError;
use super::saved_state::SavedState;
use super::setup::Setup;
use super::simulation::Simulation;
use crate::task::{Task, TaskServer};

impl Simulation {
    /// Continues as the run of `setup`, which may differ from the present one only in the future:
    /// events not before the present time, and tasks, changes of tasks, forces and objects at the
    /// end of their lists that are not active before it. Settings outside these lists stay as they
    /// are.
    ///
    /// Further steps are equal to the last bit to those of a run of `setup` from the start if steps
    /// end at every tick ([`TaskServer::tick_always`]) and this is called at a tick.
    ///
    /// # Errors
    /// A new force that cannot be initialised.
    pub fn continue_as(&mut self, setup: Setup) -> Result<(), RunError> {
        let run = &mut self.run;
        run.corners = setup.corners();
        let known = run.plant.forces.len();
        for force in setup.forces.into_iter().skip(known) {
            run.plant.add_force(force).map_err(RunError::internal)?;
        }
        let known = run.carried.count();
        run.carried.extend(setup.carried_objects.into_iter().skip(known));
        run.tasks.extend_with(setup.tasks);
        run.tasks.resume_ticks(run.plant.state.time);
        run.events.truncate(run.events_done);
        run.events.extend(setup.events.into_iter().skip(run.events_done));
        run.saved.resize_with(setup.saved_states, || SavedState::new(&run.plant, &run.anchors));
        run.log.snapshot.points = snapshot::blank_points(&run.tasks);
        run.log.snapshot.external.reserve(run.plant.arrows.capacity());
        Ok(())
    }

    /// Is a snapshot due at the present time?
    pub fn snapshot_due(&self) -> bool {
        self.run.log.next().is_some_and(|due| due <= self.run.plant.state.time + 1e-12)
    }

    /// A snapshot of the present state as the log would contain it, also at the end of the run, with the
    /// forces that act if no event happens now. Does not influence the run.
    pub fn snapshot(&mut self) -> Snapshot {
        let run = &mut self.run;
        let mut snapshot = run.log.snapshot.clone();
        let saved = (run.plant.solution.clone(), run.plant.within, run.plant.evaluations);
        // The forces of velocity-level steps are those of the last step.
        if !(run.started && run.velocity_level) {
            run.plant.evaluate();
        }
        run.fill_snapshot(&mut snapshot);
        (run.plant.solution, run.plant.within, run.plant.evaluations) = saved;
        snapshot
    }

    /// Adds a task that begins at the first tick at or after `start`, s. Its commands override those of
    /// the tasks before it. Then steps end at every tick.
    pub fn add_task(&mut self, start: f64, task: Box<dyn Task>) {
        self.run.tasks.add(start, task);
        self.run.tasks.tick_always();
        self.run.tasks.resume_ticks(self.run.plant.state.time);
        self.run.log.snapshot.points = snapshot::blank_points(&self.run.tasks);
    }

    /// The tasks and their state.
    pub fn tasks(&self) -> &TaskServer {
        &self.run.tasks
    }

    /// Time of the next control tick, s; none if there is no further command.
    pub fn next_tick(&self) -> Option<f64> {
        self.run.tasks.next_tick()
    }

    /// Has the first step been prepared?
    pub fn has_begun(&self) -> bool {
        self.run.started
    }

    /// End of the run, s.
    pub fn end(&self) -> f64 {
        self.run.duration
    }
}
