//! A run that goes on as another scenario's, and a look at it between two steps. For whoever steps it by hand, such as a console.

use super::change::Saved;
use super::error::Stop;
use super::report::{Outcome, Snapshot};
use super::setup::Setup;
use super::simulation::Simulation;
use crate::task::TaskServer;

impl Simulation {
    /// Goes on as the run of `setup`, which differs from the one it is only in what comes from now on: events not before the
    /// present time, and at the end of their lists tasks, their changes, forces and objects that are not active before it.
    /// The steps to come are then those of a run that was `setup` from the start, to the last bit, if steps end at every tick
    /// ([`TaskServer::tick_always`]) and this is called at one. Everything that is in no list stays as it is.
    ///
    /// # Errors
    /// A new force that cannot begin.
    pub fn go_on_as(&mut self, setup: Setup) -> Result<(), Stop> {
        self.corners = setup.corners();
        let has = self.plant.forces.len();
        for force in setup.forces.into_iter().skip(has) {
            self.plant.add_force(force).map_err(|m| Stop::new(Outcome::Error, m))?;
        }
        let has = self.loads.len();
        self.loads.add(setup.loads.into_iter().skip(has));
        self.tasks.extend_with(setup.tasks);
        self.changes.truncate(self.happened);
        self.changes.extend(setup.changes.into_iter().skip(self.happened));
        self.saved.resize_with(setup.saved_states, || Saved::new(&self.plant, &self.anchors));
        self.snapshot.points = super::observe::blank_points(&self.tasks);
        self.snapshot.external.reserve(self.plant.arrows.capacity());
        Ok(())
    }

    /// Is the present an instant of the log that was not told yet?
    pub fn logs_now(&self) -> bool {
        self.next_snapshot().is_some_and(|due| due <= self.plant.state.time + 1e-12)
    }

    /// The present state as the log would have it, with the forces that act if nothing jumps now. Changes nothing of the run.
    pub fn look(&mut self) -> Snapshot {
        // The forces of velocity-level steps are those of the last step.
        self.look_at(!(self.started && self.steps_velocities()))
    }

    /// The present state as the log would have it if the run ended here.
    pub fn look_last(&mut self) -> Snapshot {
        self.look_at(!(self.steps_velocities() && self.logs_now()))
    }

    fn look_at(&mut self, evaluate: bool) -> Snapshot {
        let mut snapshot = self.snapshot.clone();
        let kept = (self.plant.solution.clone(), self.plant.within, self.plant.evaluations);
        if evaluate {
            self.plant.evaluate();
        }
        super::observe::fill(&mut self.plant, &mut self.edges, &mut snapshot);
        snapshot.energy = self.balance();
        for (to, (_, position)) in snapshot.points.iter_mut().zip(self.tasks.points()) {
            to.position = position;
        }
        if let (Some(own), Some(out)) = (&mut self.self_contact, &mut snapshot.self_contact) {
            own.fill(&self.plant.model, &self.plant.state, &self.plant.ws, out);
        }
        (self.plant.solution, self.plant.within, self.plant.evaluations) = kept;
        snapshot
    }

    /// The tasks and how they stand.
    pub fn tasks(&self) -> &TaskServer {
        &self.tasks
    }

    /// The time of the next control tick, s; none when nothing more is decided.
    pub fn next_tick(&self) -> Option<f64> {
        self.tasks.next_tick()
    }

    /// Has the first step been prepared?
    pub fn has_begun(&self) -> bool {
        self.started
    }

    /// When the run ends, s.
    pub fn end(&self) -> f64 {
        self.duration
    }
}
