//! Calls of the external force models: preparation, corners of their time courses, evaluation.

use super::Plant;
use crate::force::{AppliedForces, Force, ForceContext, ForceError, ReportEvent};

/// The context of force models: the plant's fields other than the models. The second argument is the
/// time of forces that depend on it, s; the third is inside the smooth piece.
macro_rules! context {
    ($plant:ident, $time:expr, $within:expr) => {
        ForceContext {
            model: &$plant.model,
            state: &$plant.state,
            kinematics: &$plant.ws,
            gravity: $plant.gravity,
            time: $time,
            within: $within,
        }
    };
}

impl Plant {
    /// Reserves memory for all forces that the models may list at one instant.
    pub(super) fn reserve_forces(&mut self) {
        let number = self.forces.iter().map(|force| force.arrows()).sum();
        self.arrows.reserve(number);
        self.dampers.reserve(number);
    }

    /// Evaluates all models at the present state, over a velocity-level step of size `dt` if given.
    pub(super) fn evaluate_forces(&mut self, dt: Option<f64>) {
        self.external.fill(0.0);
        self.arrows.clear();
        self.dampers.clear();
        // A velocity-level step evaluates forces that depend on time at its middle.
        let time = if dt.is_some() { self.within } else { self.state.time };
        let context = context!(self, time, self.within);
        let mut applied = AppliedForces::new(&mut self.external, &mut self.arrows);
        for force in &mut self.forces {
            force.evaluate(&context, &mut applied);
        }
        if let Some(dt) = dt {
            self.implicit_external.fill(0.0);
            self.forces.iter().for_each(|force| force.damping(&context, &mut self.implicit_external));
            self.implicit_external.iter_mut().for_each(|term| *term *= dt);
            self.dampers.gather(&self.forces, &context, dt);
        }
    }

    /// Calls every force model's `init` at the present state.
    pub fn init_forces(&mut self) -> Result<(), ForceError> {
        (0..self.forces.len()).try_for_each(|i| self.init_force(i))
    }

    /// Adds a force model and reserves memory for its forces.
    pub fn add_force(&mut self, force: Box<dyn Force>) -> Result<(), ForceError> {
        self.forces.push(force);
        self.reserve_forces();
        self.init_force(self.forces.len() - 1)
    }

    /// Calls `init` of one force model at the present state, whose kinematics it updates.
    pub(super) fn init_force(&mut self, i: usize) -> Result<(), ForceError> {
        self.update_kinematics();
        let context = context!(self, self.state.time, self.within);
        self.forces[i].init(&context)
    }

    /// Calls every force model's `pass` at the present state, whose kinematics it updates.
    pub fn pass_forces(&mut self, report: &mut ReportEvent) {
        self.update_kinematics();
        // Selects the smooth piece that begins here.
        let context = context!(self, self.state.time, self.state.time);
        self.forces.iter_mut().for_each(|force| force.on_corner(&context, report));
    }
}
