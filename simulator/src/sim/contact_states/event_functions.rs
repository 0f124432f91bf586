//! Event functions of a run's contact, see [`crate::contact::hybrid::events`].

use super::link_contacts::LinkContacts;
use super::pair_contacts::PairContacts;
use crate::contact::hybrid::events::{ContactGaps, ContactInForce, EventFunctions, FrictionBorders, sinks};
use crate::contact::model::per_sole::PerSole;
use crate::sim::bodies::PairPatch;
use crate::sim::plant::Plant;
use crate::sim::run::RunState;
use nalgebra::Vector2;

impl FrictionBorders for Plant {
    fn seen_from_above(&self, s: usize, i: usize) -> Vector2<f64> {
        Plant::seen_from_above(self, s, i)
    }

    fn rolls(&self, s: usize) -> bool {
        self.polygons[s].pair().is_some_and(PairPatch::rolls)
    }

    fn border(&self, s: usize, i: usize) -> f64 {
        Plant::border(self, s, i)
    }

    fn crossing(&self, s: usize, i: usize, from: &Vector2<f64>) -> Option<f64> {
        let to = Plant::seen_from_above(self, s, i);
        self.floor.exit_from(self.region(s, i), from, &to).filter(|_| self.has_region(s, i))
    }
}

/// Links of a plant that may touch the floor, then its pairs of bodies.
struct Touching<'a> {
    plant: &'a Plant,
    links: Option<&'a LinkContacts>,
    pairs: &'a PairContacts,
}

impl ContactGaps for Touching<'_> {
    fn number(&self) -> usize {
        self.links.map_or(0, LinkContacts::number) + self.pairs.number()
    }

    fn gap(&self, i: usize) -> f64 {
        match self.links {
            Some(links) if i < links.number() => links.gap(self.plant, i),
            links => self.pairs.gap(self.plant, i - links.map_or(0, LinkContacts::number)),
        }
    }
}

/// Calls `f` with the present contact of a run.
fn with_contact<T>(sim: &RunState, f: impl FnOnce(&ContactInForce) -> T) -> T {
    let plant = &sim.plant;
    let touching = Touching { plant, links: sim.links.as_deref(), pairs: &sim.pairs };
    f(&ContactInForce {
        problem: &plant.problem,
        states: &plant.states,
        solution: &plant.solution,
        directions: &plant.directions,
        turning: &plant.turning,
        tolerances: &sim.tolerances,
        is_compliant: plant.is_compliant(),
        regions: (!plant.floor.patches.is_empty()).then_some(plant),
        touching: &touching,
        may_contradict: plant.may_contradict(),
        is_imposed: &|s| sim.is_imposed(s),
    })
}

/// The event functions of one step of a run.
#[derive(Clone)]
pub struct StepEventFunctions(EventFunctions);

impl StepEventFunctions {
    /// Reserves memory for the functions of a usual step.
    pub fn new() -> Self {
        StepEventFunctions(EventFunctions::new())
    }

    /// Selects the functions of a step at its start, and gives their values there. `known` are those of the step before
    /// at the same evaluation.
    pub fn begin(&mut self, sim: &mut RunState, start: &mut Vec<f64>, known: Option<&[f64]>) {
        sim.pairs.begin_step(&sim.plant);
        with_contact(sim, |now| self.0.begin(now));
        start.resize(self.0.len(), 0.0);
        if let Some(known) = known.filter(|_| self.0.are_known()) {
            start.copy_from_slice(known);
            return;
        }
        sim.plant.share_forces();
        with_contact(sim, |now| self.0.fill(now, start));
    }

    /// Values at the plant's present evaluation.
    pub fn values(&self, sim: &mut RunState, out: &mut Vec<f64>) {
        out.resize(self.0.len(), 0.0);
        self.fill(sim, out);
    }

    /// See [`EventFunctions::overlook`].
    pub fn overlook(&mut self, start: &mut [f64], rest: f64) -> bool {
        self.0.overlook(start, rest)
    }

    /// As [`values`](Self::values), into a slice of the right length.
    pub fn fill(&self, sim: &mut RunState, out: &mut [f64]) {
        sim.plant.share_forces();
        sim.pairs.update_ways(&sim.plant);
        with_contact(sim, |now| self.0.fill(now, out));
    }

    /// See [`EventFunctions::passed_over`].
    pub fn passed_over(&self, sim: &RunState, values: &[f64]) -> Option<f64> {
        with_contact(sim, |now| self.0.passed_over(now, values))
    }

    /// See [`EventFunctions::suspects`].
    pub fn suspects(&self, values: &[f64], suspect: &mut PerSole<u8>) {
        self.0.suspects(values, suspect);
    }

    /// See [`sinks`].
    pub fn tolerated_too_much(&self, sim: &RunState) -> bool {
        with_contact(sim, sinks)
    }
}
