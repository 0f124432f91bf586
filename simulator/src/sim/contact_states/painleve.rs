//! Painleve's paradox in a run: an impulse ends sliding that no finite force can continue, see
//! [`crate::contact::hybrid::painleve`].

use crate::contact::hybrid::copositivity::{SlidingLoad, least_sliding_load};
use crate::contact::hybrid::painleve;
use crate::contact::methods::contact_method::SelectionInput;
use crate::contact::model::state::{Mode, Pattern, SoleState, States};
use crate::contact::search::judge::Rules;
use crate::sim::event_kind::EventKind;
use crate::sim::report::Observer;
use crate::sim::run::RunState;
use crate::sim::run_error::RunError;

/// Acceleration away from the floor, relative to the greatest, with which a vertex leaves it.
const LEAVES: f64 = 1e-11;

/// Slip, m/s, up to which a jam that the impact law does not resolve ends in rest, and the factor by
/// which the rest speed exceeds it.
const SLOW: f64 = 1e-2;
const ABOVE: f64 = 1.01;

impl RunState {
    /// Applies an impulse that ends sliding which no finite force can continue. Returns false if
    /// there is no such sliding. Needs a free evaluation at the plant's state, for which no valid
    /// contact state was found.
    pub(in crate::sim) fn resolve_jam(&mut self, observer: &mut dyn Observer) -> Result<bool, RunError> {
        // Fixed steps solve the velocity-level problem anyway, and methods without a search report
        // no inconsistency.
        if !self.plant.method.locates_events() {
            return Ok(false);
        }
        let Some(load) = self.jamming_load() else { return Ok(false) };
        // Without a jam the run continues with the solution of the search.
        let saved = (self.plant.problem.clone(), self.plant.solution.clone());
        let resolved = self.apply_jam(&load, observer)?;
        if !resolved {
            (self.plant.problem, self.plant.solution) = saved;
        }
        Ok(resolved)
    }

    /// Speed, m/s, up to which to set vertices to rest because the slip of one of them jams, but is
    /// too slow for the impact law to resolve its end: the approach that stands for a vanishing one
    /// is no longer small. With `within_error` only a slip that the error of a step may have caused:
    /// that needs no search through all states before. Reports the jam. Needs a free evaluation for which
    /// no valid state was found.
    pub(in crate::sim) fn slow_jamming_slip(
        &mut self,
        within_error: bool,
        observer: &mut dyn Observer,
    ) -> Result<Option<f64>, RunError> {
        if !self.locates_events() {
            return Ok(None);
        }
        let Some(load) = self.jamming_load() else { return Ok(None) };
        let (s, i) = load.at;
        let slip = self.plant.problem.soles[s].vertices[i].velocity.xy().norm();
        let most = if within_error { self.plant.direction_speed(s) } else { SLOW };
        if slip > most || slip <= self.plant.rest {
            return Ok(None);
        }
        self.report_jam(&load, &format!("slip of {slip:.3e} m/s set to rest"), observer)?;
        Ok(Some(ABOVE * slip))
    }

    /// Applies the impulse of a jam, if there is one.
    fn apply_jam(&mut self, load: &SlidingLoad, observer: &mut dyn Observer) -> Result<bool, RunError> {
        let Some(states) = self.jam_states(load) else { return Ok(false) };
        let jump = self.plant.apply_impulses(&self.projection.wrench);
        let loss = -jump.contact;
        self.energy.add_jump(jump);
        let result = format!("no finite force; slip ended by an impulse, energy lost {loss:.6e} J");
        self.report_jam(load, &result, observer)?;
        self.adopt(states, observer)?;
        self.plant.evaluate_free();
        Ok(true)
    }

    fn report_jam(&mut self, load: &SlidingLoad, result: &str, observer: &mut dyn Observer) -> Result<(), RunError> {
        self.metrics.jams += 1;
        let (s, i) = load.at;
        let message = format!("vertex {i}: normal coefficient {:.6e} 1/kg, {result}", load.value);
        let sole = self.plant.polygons[s].name().to_owned();
        self.event(observer, EventKind::Jam, &sole, &message)
    }

    /// Ends sliding whose contact force grows without bound, after the step size has collapsed.
    /// Returns false if that is not the cause. Needs a free evaluation.
    pub(in crate::sim) fn resolve_unbounded_force(&mut self, observer: &mut dyn Observer) -> Result<bool, RunError> {
        let states = self.plant.states.clone();
        let Some(load) = self.least_sliding_load(&states).filter(SlidingLoad::is_at_limit) else { return Ok(false) };
        let (s, i) = load.at;
        let start = self.plant.velocities();
        let slip = self.plant.problem.soles[s].vertices[i].velocity.xy();
        // Without a jam, although the slip turns that way, the force ends as in a plane.
        if self.turns_into_floor(&load) && self.apply_jam(&load, observer)? {
            return Ok(true);
        }
        let mut after_impulse = |size: f64| {
            let plant = &mut self.plant;
            plant.set_velocities(&start);
            plant.evaluate_free();
            let jump = plant.apply_impulses(&scaled(&load.wrench, size));
            plant.evaluate_free();
            // The acceleration must exceed rounding, or sliding with K nearly zero is found again.
            let size = plant.problem.b.iter().fold(0.0, |m: f64, b| m.max(b.abs()));
            let leaves = plant.problem.vertex_motion(&plant.problem.b, s, i).z >= LEAVES * size;
            (leaves, plant.problem.soles[s].vertices[i].velocity.xy().dot(&slip) > 0.0, jump)
        };
        // The impulse that would stop the slip bounds the search.
        let mut most = self.tolerances.rest;
        while after_impulse(most).1 && !after_impulse(most).0 {
            most *= 2.0;
        }
        let (mut low, mut high) = (0.0, most);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            let (leaves, slips, _) = after_impulse(middle);
            if leaves || !slips { high = middle } else { low = middle }
        }
        let (leaves, _, jump) = after_impulse(high);
        self.energy.add_jump(jump);
        let end = if leaves { "until it lets go" } else { "until it stops" };
        let result =
            format!("force without bound; an impulse of {high:.6e} N s {end}, energy lost {:.6e} J", -jump.contact);
        self.report_jam(&load, &result, observer)?;
        if leaves {
            // Near the singular point sliding with a great load is valid too, and would be found again.
            let mut states = self.plant.states.clone();
            states[s] = without(states[s], i, self.plant.problem.soles[s].vertices.len());
            self.adopt(states, observer)?;
        }
        Ok(true)
    }

    /// The normal load with the least `x . K x` on sliding vertices, with the sticking soles of
    /// `states` held.
    fn least_sliding_load(&mut self, states: &States) -> Option<SlidingLoad> {
        let plant = &mut self.plant;
        let (p, method) = (&mut plant.problem, plant.method.as_mut());
        least_sliding_load(p, method, states, &self.tolerances, &mut self.projection)
    }

    /// The load of sliding vertices that drives them into the floor; none if there is none.
    fn jamming_load(&mut self) -> Option<SlidingLoad> {
        let mut states = self.plant.states.clone();
        if let Some(load) = self.least_sliding_load(&states).filter(SlidingLoad::drives_into_floor) {
            return Some(load);
        }
        // A sole that has just stopped may stick, which lets another jam.
        for (s, sole) in self.plant.problem.soles.iter().enumerate() {
            let (state, k) = (states[s], sole.vertices.len());
            let stands = |i: usize| sole.vertices[i].velocity.xy().norm() <= self.tolerances.rest;
            if state.is_dynamic() && (0..k).all(|i| !state.clamps(i, k) || stands(i)) {
                states[s] = SoleState::fixed(state.pattern);
            }
        }
        if states == self.plant.states {
            return None;
        }
        self.least_sliding_load(&states).filter(SlidingLoad::drives_into_floor)
    }

    /// The states after the jam of a load, with its impulses in `self.projection`; none if there is
    /// no jam.
    fn jam_states(&mut self, load: &SlidingLoad) -> Option<States> {
        let rules = Rules { exhaustive: !self.defers(), ..self.rules() };
        let forced = self.forced(self.plant.state.time);
        let allowed = |s: usize, state: SoleState| forced[s].is_none_or(|f: SoleState| f.pattern == state.pattern);
        let input = SelectionInput { rules: &rules, event: true, allowed: &allowed, cancel: self.cancel.as_deref() };
        let plant = &mut self.plant;
        let (p, method) = (&mut plant.problem, plant.method.as_mut());
        let out = (&mut plant.solution, &mut self.projection);
        let (states, selection) = painleve::jam(p, method, &plant.reduced.velocity, load, &input, out);
        let selection = selection?;
        self.count(&selection);
        if states.is_none() {
            self.plant.evaluate_free();
        }
        states
    }

    /// Does an impulse along this load turn the slip of its vertex so that K decreases further?
    fn turns_into_floor(&mut self, load: &SlidingLoad) -> bool {
        let (s, i) = load.at;
        let start = self.plant.velocities();
        let slip = |sim: &Self| sim.plant.problem.soles[s].vertices[i].velocity.xy();
        let before = slip(self);
        let falls = |sim: &mut Self, size: f64| {
            sim.plant.apply_impulses(&scaled(&load.wrench, size));
            sim.plant.evaluate_free();
            let states = sim.plant.states.clone();
            let found = ((slip(sim) - before).norm(), sim.least_sliding_load(&states));
            sim.plant.set_velocities(&start);
            sim.plant.evaluate_free();
            found
        };
        // By a hundredth of the slip.
        let size = self.tolerances.rest;
        let size = 0.01 * before.norm() * size / falls(self, size).0;
        falls(self, size).1.is_some_and(|after| load.falls_to(&after))
    }
}

fn scaled(wrench: &[f64], factor: f64) -> Vec<f64> {
    wrench.iter().map(|w| w * factor).collect()
}

/// The state of a sole of `k` vertices whose vertex `i` has left the floor. What remains of a face is
/// left to the selection.
fn without(state: SoleState, i: usize, k: usize) -> SoleState {
    match state.pattern {
        Pattern::Vertex(_) => SoleState::FREE,
        Pattern::Edge(first) => {
            let first = first as usize;
            let other = if i == first { (first + 1) % k } else { first } as u8;
            let mode = if state.mode == Mode::Pivoting(other) { Mode::Static } else { Mode::Sliding };
            SoleState { pattern: Pattern::Vertex(other), mode }
        }
        _ => state,
    }
}
