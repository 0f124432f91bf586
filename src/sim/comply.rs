//! Compliant methods in a run: forces follow places and velocities by themselves, so states are only read off them.
//!
//! Nothing is settled, projected or looked out for. What the states say is for the log: the pattern of the vertices that
//! carry load, static while they slip slower than the method can hold.

use super::error::Stop;
use super::report::Observer;
use super::simulation::Simulation;
use crate::contact::methods::contact_method::SelectionInput;

impl Simulation {
    /// Looks friction up and reads the states off the forces at the plant's present state, which must be evaluated.
    pub(super) fn comply(&mut self, observer: &mut dyn Observer) -> Result<(), Stop> {
        if !self.plant.floor.patches.is_empty() {
            self.find_friction(observer)?;
            self.plant.evaluate();
        }
        let rules = self.rules();
        let input = SelectionInput { rules: &rules, event: true, allowed: &|_, _| true };
        let plant = &mut self.plant;
        let selection = plant.method.select(&mut plant.problem, &input, &mut plant.solution);
        self.adopt(selection.states, observer)?;
        self.creep();
        Ok(())
    }

    /// Impulses of a step, from the velocity-level problem at hand.
    pub(super) fn comply_for_step(&mut self, observer: &mut dyn Observer) -> Result<(), Stop> {
        let rules = self.rules();
        let input = SelectionInput { rules: &rules, event: false, allowed: &|_, _| true };
        let plant = &mut self.plant;
        let selection = plant.method.impulse(&mut plant.problem, &input, &mut plant.solution);
        self.adopt(selection.states, observer)
    }

    /// Takes down how far vertices that are said to stick have crept along the floor.
    pub(super) fn creep(&mut self) {
        for (s, sole) in self.plant.problem.soles.iter().enumerate().filter(|(s, _)| self.plant.states[*s].is_static())
        {
            let (origin, k) = (self.plant.sole_origin(s), sole.vertices.len());
            for (i, v) in sole.vertices.iter().enumerate().filter(|(i, _)| self.plant.states[s].clamps(*i, k)) {
                let crept = (origin + v.r - self.anchors[s][i]).xy().norm();
                self.metrics.max_static_creep_m = self.metrics.max_static_creep_m.max(crept);
            }
        }
    }
}
