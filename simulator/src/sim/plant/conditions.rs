//! Couplings and closed loops of the plant's mechanisms: drift out of the state, and their forces.
//!
//! Accelerations obey `c'' = 0`; the errors of integration are removed after each step
//! ([`crate::dynamics::closing`]), as is the drift of clamped contacts.

use super::Plant;
use crate::dynamics::{closing, reduced};
use nalgebra::Vector3;

impl Plant {
    /// Has a mechanism couplings or loops?
    pub fn has_conditions(&self) -> bool {
        let number = |m: usize| self.objects.mechanisms(&self.ws).get(m).constraints.number();
        (0..=self.objects.list.len()).any(|m| number(m) > 0)
    }

    /// May the conditions of several contacts contradict each other? So they may where motions are prescribed or
    /// links coupled.
    pub fn may_contradict(&self) -> bool {
        !self.reduced.prescribed.is_empty() || self.has_conditions()
    }

    /// Removes from the state the errors of couplings and loops. Returns whether there are any conditions:
    /// the last evaluation then belongs to another state.
    pub fn close_conditions(&mut self) -> bool {
        let mut any = false;
        if self.ws.constraints.number() > 0 {
            let (model, prescribed) = (&self.model, &self.reduced.prescribed);
            let closed = closing::project(model, &mut self.state, prescribed, &mut self.ws);
            self.failure = closed.err().or(self.failure.take());
            self.kinematics_state.copy_from(&self.state);
            any = true;
        }
        match self.objects.close() {
            Ok(of_objects) => any |= of_objects,
            Err(failure) => self.failure = Some(failure),
        }
        self.refreshed &= !any;
        any
    }

    /// Greatest error of a coupling or loop at the kinematics in the workspaces, m or rad.
    pub fn condition_error(&self) -> f64 {
        let mechanisms = self.objects.mechanisms(&self.ws);
        (0..mechanisms.number()).map(|m| mechanisms.get(m).constraints.greatest_error()).fold(0.0, f64::max)
    }

    /// Solves for the multipliers of the robot's couplings and loops at the wrenches of the solution, of the
    /// last evaluation or velocity-level step.
    pub fn update_multipliers(&mut self) {
        if self.ws.constraints.number() > 0 {
            let mechanisms = self.objects.mechanisms(&self.ws);
            let (reduced, wrench) = (&mut self.reduced, &self.solution.wrench);
            reduced::multipliers(mechanisms, reduced, 0, wrench, &mut self.multipliers);
        }
    }

    /// The same within a velocity-level step of size `dt`, while the solution holds impulses.
    pub fn update_multipliers_over_step(&mut self, dt: f64) {
        if self.ws.constraints.number() > 0 {
            self.solution.scale(1.0 / dt);
            self.update_multipliers();
            self.solution.scale(dt);
        }
    }

    /// Force and moment, world, of each loop on its first link at its first frame's origin, with the greatest
    /// error of its conditions; those of the last [`update_multipliers`](Self::update_multipliers).
    pub fn loop_loads(&self) -> impl Iterator<Item = ([Vector3<f64>; 2], f64)> {
        self.model.loop_conditions().map(|(_, rows)| {
            let (constraints, lambda) = (&self.ws.constraints, &self.multipliers[rows.clone()]);
            (constraints.loop_load(rows.start, lambda), constraints.greatest_error_of(rows))
        })
    }

    /// Effort that each coupling has on its following joint, and its error.
    pub fn coupling_efforts(&self) -> impl Iterator<Item = (f64, f64)> {
        let errors = &self.ws.constraints.error;
        self.multipliers.iter().zip(errors).take(self.model.couplings.len()).map(|(lambda, error)| (*lambda, *error))
    }
}
