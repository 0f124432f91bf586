//! Calls of the external force models: preparation, corners of their time courses, evaluation. Each model
//! acts on one mechanism, the robot or an object.

use super::Plant;
use crate::force::{AppliedForces, Force, ForceContext, ForceError, ReportEvent, Slope};

/// The context of the force models of a mechanism: the plant's fields other than the models. The last
/// arguments are the time of forces that depend on it, s, and one inside the smooth piece.
macro_rules! context {
    ($plant:ident, $mechanism:expr, $time:expr, $within:expr) => {{
        let (model, state, kinematics) = match $mechanism.checked_sub(1) {
            None => (&*$plant.model, &$plant.state, &$plant.ws),
            Some(o) => {
                let object = &$plant.objects.list[o];
                (&*object.model, &object.state, &$plant.objects.ws[o])
            }
        };
        ForceContext { model, state, kinematics, gravity: $plant.gravity, time: $time, within: $within }
    }};
}

impl Plant {
    /// Reserves memory for all forces that the models may list at one instant.
    pub(super) fn reserve_forces(&mut self) {
        let number = self.forces.iter().map(|force| force.arrows()).sum();
        self.arrows.reserve(number);
        self.dampers.reserve(number);
        self.objects.reserve_dampers(number);
    }

    /// Evaluates all models at the present state, over a velocity-level step of size `dt` if given.
    pub(super) fn evaluate_forces(&mut self, dt: Option<f64>) {
        self.external.fill(0.0);
        self.arrows.clear();
        self.dampers.clear();
        if dt.is_some() {
            self.implicit_external.fill(0.0);
        }
        self.objects.clear_forces();
        // A velocity-level step evaluates forces that depend on time at its middle.
        let time = if dt.is_some() { self.within } else { self.state.time };
        for force in &mut self.forces {
            let Some(o) = force.mechanism().checked_sub(1) else {
                let context = context!(self, 0_usize, time, self.within);
                force.evaluate(&context, &mut AppliedForces::new(&mut self.external, &mut self.arrows));
                if let Some(dt) = dt {
                    force.damping(&context, &mut self.implicit_external);
                    self.dampers.gather(&**force, &context, dt);
                }
                continue;
            };
            let (object, kinematics) = (&mut self.objects.list[o], &self.objects.ws[o]);
            let (model, state) = (&*object.model, &object.state);
            let context = ForceContext { model, state, kinematics, gravity: self.gravity, time, within: self.within };
            object.external.add(&mut **force, &context, &mut self.arrows, dt);
        }
        if let Some(dt) = dt {
            self.implicit_external.iter_mut().for_each(|term| *term *= dt);
            self.objects.scale_damping(dt);
        }
    }

    /// Calls `each` with number and mechanism of the model for each slope of the forces at the last evaluation.
    pub(super) fn force_slopes(&self, each: &mut dyn FnMut(usize, usize, Slope)) {
        for (number, force) in self.forces.iter().enumerate() {
            let mechanism = force.mechanism();
            let context = context!(self, mechanism, self.state.time, self.within);
            force.slopes(&context, &mut |slope| each(number, mechanism, slope));
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
        let force = &mut self.forces[i];
        let context = context!(self, force.mechanism(), self.state.time, self.within);
        force.init(&context)
    }

    /// Calls every force model's `pass` at the present state, whose kinematics it updates.
    pub fn pass_forces(&mut self, report: &mut ReportEvent) {
        self.update_kinematics();
        for force in &mut self.forces {
            // Selects the smooth piece that begins here.
            let context = context!(self, force.mechanism(), self.state.time, self.state.time);
            force.on_corner(&context, report);
        }
    }
}
