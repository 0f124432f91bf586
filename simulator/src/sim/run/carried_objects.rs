//! Attachment and release of carried objects in a run.

use super::RunState;
use crate::contact::model::state::SoleState;
use crate::sim::event_kind::EventKind;
use crate::sim::plant::kinematic_joints::JumpWork;
use crate::sim::report::Observer;
use crate::sim::run_error::RunError;
use crate::sim::termination::diverged;

impl RunState {
    /// Attaches and releases the objects that are due.
    pub(in crate::sim) fn update_carried_objects(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
        let t = self.plant.state.time;
        let mut next = 0;
        while let Some((i, attach)) = self.carried.due(next, t) {
            if attach {
                self.attach(i, observer)?
            } else {
                self.release(i, observer)?
            }
            next = i + 1;
        }
        Ok(())
    }

    fn attach(&mut self, i: usize, observer: &mut dyn Observer) -> Result<(), RunError> {
        let (object, total) = self.carried.set_held(i, true);
        let Some(velocity) = object.velocity else {
            let change = self.plant.replace_inertia(object.link, &total);
            self.add_object_energy(change);
            return self.event(observer, EventKind::Object, &object.name, &format!("{} kg taken", object.body.mass));
        };
        let caught = self.plant.catch(object.link, &object.body, &velocity, &total);
        let caught = caught.map_err(|e| diverged(&self.plant, &e.to_string()))?;
        self.add_object_energy(caught.brought);
        self.energy.add_jump(JumpWork { contact: -caught.lost, drives: caught.drives });
        let message = format!("{} kg taken, energy lost {:.6e} J", object.body.mass, caught.lost);
        self.event(observer, EventKind::Object, &object.name, &message)?;
        if self.started { self.floor_impulse(observer) } else { Ok(()) }
    }

    fn release(&mut self, i: usize, observer: &mut dyn Observer) -> Result<(), RunError> {
        let (object, total) = self.carried.set_held(i, false);
        let change = self.plant.replace_inertia(object.link, &total);
        self.add_object_energy(change);
        self.event(observer, EventKind::Object, &object.name, &format!("{} kg released", object.body.mass))
    }

    /// Adds the energy of an object to the balance. Objects held from the start belong to the
    /// initial energy.
    fn add_object_energy(&mut self, energy: f64) {
        self.milestones.restart(false);
        if self.started { self.energy.flows.add_external(energy) } else { self.energy.start += energy }
    }

    /// Applies the impulse of the floor after a jump of the velocities, at the same instant.
    fn floor_impulse(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
        let touches = (0..self.plant.problem.soles.len()).any(|s| self.plant.states[s] != SoleState::FREE);
        // Springs respond in time; a velocity-level step contains the impulses of its instant.
        if !touches || self.plant.is_compliant() || self.velocity_level {
            return Ok(());
        }
        if !self.plant.method.locates_events() {
            return self.choose_states(observer);
        }
        self.plant.evaluate_free();
        self.update_friction(observer)?;
        self.plant.update_directions();
        self.impact(observer)
    }
}
