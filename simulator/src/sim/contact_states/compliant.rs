//! Compliant methods in a run: forces follow from positions and velocities, and contact states from
//! the forces.
//!
//! There are no impacts, projections or event functions. The states serve the log only: the pattern
//! of the vertices that carry load, static while they slip slower than the method can hold.

use crate::contact::methods::contact_method::SelectionInput;
use crate::sim::plant::Polygon;
use crate::sim::report::Observer;
use crate::sim::run::RunState;
use crate::sim::run_error::RunError;

impl RunState {
    /// Updates friction and derives the states from the forces at the plant's present state, which
    /// must be evaluated.
    pub(in crate::sim) fn read_compliant_states(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
        if !self.plant.floor.patches.is_empty() {
            self.update_friction(observer)?;
            self.plant.evaluate();
        }
        let rules = self.rules();
        let input = SelectionInput { rules: &rules, event: true, allowed: &|_, _| true, cancel: None };
        let plant = &mut self.plant;
        let selection = plant.method.select(&mut plant.problem, &input, &mut plant.solution);
        self.adopt(selection.states, observer)?;
        self.measure_creep();
        Ok(())
    }

    /// Computes the impulses of a step from its velocity-level problem.
    pub(in crate::sim) fn compliant_impulse(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
        let rules = self.rules();
        let input = SelectionInput { rules: &rules, event: false, allowed: &|_, _| true, cancel: None };
        let plant = &mut self.plant;
        let selection = plant.method.impulse(&mut plant.problem, &input, &mut plant.solution);
        self.adopt(selection.states, observer)
    }

    /// Measures how far static vertices have crept along the floor.
    pub(in crate::sim) fn measure_creep(&mut self) {
        for (s, sole) in self.plant.problem.soles.iter().enumerate().filter(|(s, _)| self.plant.states[*s].is_static())
        {
            let (origin, k) = (self.plant.sole_origin(s), sole.vertices.len());
            for (i, v) in sole.vertices.iter().enumerate().filter(|(i, _)| self.plant.states[s].clamps(*i, k)) {
                let error = match &self.plant.polygons[s] {
                    Polygon::Floor(_) => origin + v.r - self.anchors[s][i],
                    Polygon::Pair(patch) => patch.error(i),
                };
                let creep = error.xy().norm();
                self.metrics.max_static_creep_m = self.metrics.max_static_creep_m.max(creep);
            }
        }
    }
}
