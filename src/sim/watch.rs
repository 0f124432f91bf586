//! Event functions of a run's contact, see [`crate::contact::hybrid::events`].

use super::plant::Plant;
use super::simulation::Simulation;
use crate::contact::hybrid::events::{ContactInForce, EventFunctions, FrictionBorders, sinks};
use crate::contact::model::state::MAX_SOLES;
use nalgebra::Vector2;

pub(crate) use crate::contact::hybrid::events::MAX_FUNCTIONS as MAX_WATCHED;

impl FrictionBorders for Plant {
    fn seen_from_above(&self, s: usize, i: usize) -> Vector2<f64> {
        Plant::seen_from_above(self, s, i)
    }

    fn border(&self, s: usize, i: usize) -> f64 {
        Plant::border(self, s, i)
    }

    fn crossing(&self, s: usize, i: usize, from: &Vector2<f64>) -> Option<f64> {
        self.floor.strays(self.zone(s, i), from, &Plant::seen_from_above(self, s, i))
    }
}

/// Calls `f` with the contact in force of a run.
fn with_contact<T>(sim: &Simulation, f: impl FnOnce(&ContactInForce) -> T) -> T {
    let plant = &sim.plant;
    f(&ContactInForce {
        problem: &plant.problem,
        states: &plant.states,
        solution: &plant.solution,
        directions: &plant.directions,
        tolerances: &sim.tolerances,
        is_compliant: plant.is_compliant(),
        regions: (!plant.floor.patches.is_empty()).then_some(plant),
        is_imposed: &|s| sim.is_imposed(s),
    })
}

/// The event functions of one step of a run.
pub struct Watch(EventFunctions);

impl Watch {
    /// Room for all functions of any step.
    pub fn new() -> Self {
        Watch(EventFunctions::new())
    }

    /// Selects the functions of a step at its start.
    pub fn begin(&mut self, sim: &Simulation) {
        with_contact(sim, |now| self.0.begin(now));
    }

    /// Values at the plant's present evaluation.
    pub fn values(&self, sim: &mut Simulation, out: &mut Vec<f64>) {
        out.resize(self.0.len(), 0.0);
        self.fill(sim, out);
    }

    /// See [`EventFunctions::overlook`].
    pub fn overlook(&mut self, start: &mut [f64], rest: f64) -> bool {
        self.0.overlook(start, rest)
    }

    /// As [`values`](Self::values), into a slice of the right length.
    pub fn fill(&self, sim: &mut Simulation, out: &mut [f64]) {
        sim.plant.share_forces();
        with_contact(sim, |now| self.0.fill(now, out));
    }

    /// See [`EventFunctions::passed_over`].
    pub fn passed_over(&self, sim: &Simulation, values: &[f64]) -> Option<f64> {
        with_contact(sim, |now| self.0.passed_over(now, values))
    }

    /// See [`EventFunctions::suspects`].
    pub fn suspects(&self, values: &[f64], suspect: &mut [u8; MAX_SOLES]) {
        self.0.suspects(values, suspect);
    }

    /// See [`sinks`].
    pub fn tolerated_too_much(&self, sim: &Simulation) -> bool {
        with_contact(sim, sinks)
    }
}
