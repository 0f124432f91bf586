//! Sliding modes: contact states that alternate faster than steps resolve, and instants at which none
//! is found.
//!
//! Several states may each drive the motion out of themselves and into the next, so that none is
//! valid for longer than some microseconds; the motion is then a sliding mode [Filippov 1988]. It
//! is detected by events in a row, as many as one of [`EVENTS`], that take at most [`FAST`] each, return to
//! the same states, at most half as many, and include no impact faster than v_t. Where bodies slide by at most [`CREEP`],
//! [`EVENTS_OF_CREEP`] that take at most [`FAST_OF_CREEP`] suffice: bodies that come to rest slide ever
//! slower, until errors of steps stop them and turn them round. The run then advances by
//! velocity-level steps ([`super::semi_implicit`], [Moreau 1988]), which need no state that is valid at
//! every instant: the contact laws hold for the velocities at the end of a step and the impulses over it.
//!
//! With `y1` the result of one step of size h and `y2` that of two steps of half the size,
//!
//! ```text
//! y = 2 y2 - y1         e = y2 - y1
//! ```
//!
//! A velocity-level step is of order 1, so y is of order 2. With a local error of e = O(h^2), that of
//! y is O(h^3), in units of the motion some |e|^(3/2). The size is chosen so that this meets the
//! tolerances of the integrator. The energy flows are extrapolated likewise. A step that contains an
//! impact misses the tolerances at any size: the shortest is then accepted with y = y2, as a
//! combination across a jump of velocities would not conserve energy. Where bodies rattle, most steps
//! contain impacts, and the shortest size grows: smaller steps would not be more accurate. It stays where e
//! grows with it: vertices that slide and stop in turn make e = O(h). Then the drift of clamped vertices is
//! removed, as after every step.
//!
//! The run also advances so where the direct search finds no valid state at an instant, instead of
//! searching all states: near jams, or where a vertex about which a sole turns begins to slip.
//!
//! After some time in the mode the changes of states since its start are reported, the states are chosen
//! again and located events resume. If the states still alternate, the mode returns after fewer events, and
//! stays for twice as long. Changes are not reported if polygons have come or gone since its start.

use super::semi_implicit::{apply_step, evaluate_step, set_velocity_problem, show_forces};
use super::step_size::StepSize;
use crate::contact::model::state::States;
use crate::integrate::{StepControl, error_norm};
use crate::math;
use crate::sim::event_kind::EventKind;
use crate::sim::plant::{Polygon, StateLayout};
use crate::sim::report::Observer;
use crate::sim::run::{Deferral, RunState};
use crate::sim::run_error::RunError;
use crate::sim::termination::check_finite;
use nalgebra::{Vector2, Vector3};

/// Events by which the states must alternate, of few soles and of many, and after the mode was left for a trial.
const EVENTS: [usize; 2] = [16, MOST_EVENTS];
const MOST_EVENTS: usize = 64;
const EVENTS_AGAIN: usize = 6;
/// Events by which bodies that creep must alternate.
const EVENTS_OF_CREEP: usize = 64;
/// Time between two such events, on average, s; the same where bodies creep.
const FAST: f64 = 2e-5;
const FAST_OF_CREEP: f64 = 5e-4;
/// Speed of contacts, m/s, up to which they creep.
const CREEP: f64 = 1e-6;
/// First and longest time in the mode before a trial, s; where no state was found; where bodies creep.
const STAYS: (f64, f64) = (5e-4, 2e-2);
const STAYS_WITHOUT_STATE: (f64, f64) = (1e-4, 2e-2);
const STAYS_OF_CREEP: (f64, f64) = (2e-2, 0.5);
/// Size of the first velocity-level step, s.
const FIRST_STEP: f64 = 2e-5;
/// Steps that may miss the tolerances before the shortest becomes longer, and its greatest size, s.
const MISSES: i32 = 8;
const LONGEST_LEAST: f64 = 1e-4;
/// Growth of errors with twice the size from which it is no longer used: they are the same for impacts, twice as
/// large where accelerations jump.
const GROWS: f64 = 1.5;
/// Size of fixed-step integrators' velocity-level steps, relative to their step.
const OF_FIXED: f64 = 0.1;

/// Detector and integrator of sliding modes of one run.
#[derive(Clone)]
pub struct SlidingMode {
    /// The last events: time and states chosen.
    recent: [(f64, States); MOST_EVENTS],
    count: usize,
    is_active: bool,
    /// Number of the last events at which contacts slid by at most [`CREEP`].
    creeping: usize,
    /// Must the mode end when contacts slide faster?
    only_creep: bool,
    /// Did the last one begin with creep?
    has_crept: bool,
    /// States in which it began, with the names of their polygons.
    entered: (Vec<String>, States),
    /// Start of the present mode, s, and instant of the next trial.
    since: f64,
    trial: f64,
    /// Time in the mode before a trial, s, and instant at which the last trial counts as passed.
    stay: f64,
    passed: f64,
    /// Size of the next step, s, and its control.
    h: f64,
    control: StepControl,
    /// Size of the shortest step, s, and how many steps more have missed the tolerances since than have met them.
    least: f64,
    misses: i32,
    /// Sum of the errors of those that have missed them, and their number; their mean at half the size; the size up
    /// to which the shortest may grow, s.
    missed: (f64, u32),
    missed_before: f64,
    longest_least: f64,
    /// The integrator's vector at the start of a step, after one step, and after two halves.
    start: Vec<f64>,
    whole: Vec<f64>,
    halves: Vec<f64>,
    /// Sliding directions at the start of a step.
    directions: Vec<Vec<Vector2<f64>>>,
    /// Forces on the soles over the first half, N.
    sole_forces: Vec<Vector3<f64>>,
}

/// Names of the polygons.
fn names(sim: &RunState) -> impl Iterator<Item = &str> {
    sim.plant.polygons.iter().map(Polygon::name)
}

impl SlidingMode {
    /// Shortest step, s: an impact within a step has an error at any size.
    pub const SHORTEST: f64 = 1e-6;

    /// For vectors of length `n`.
    pub fn new(n: usize) -> Self {
        SlidingMode {
            recent: std::array::from_fn(|_| (f64::NEG_INFINITY, States::default())),
            count: 0,
            is_active: false,
            creeping: 0,
            only_creep: false,
            has_crept: false,
            entered: Default::default(),
            since: 0.0,
            trial: 0.0,
            stay: STAYS.0,
            passed: f64::NEG_INFINITY,
            h: FIRST_STEP,
            control: StepControl::new(2),
            least: Self::SHORTEST,
            misses: 0,
            missed: (0.0, 0),
            missed_before: f64::INFINITY,
            longest_least: LONGEST_LEAST,
            start: vec![0.0; n],
            whole: vec![0.0; n],
            halves: vec![0.0; n],
            directions: Vec::new(),
            sole_forces: Vec::new(),
        }
    }

    /// Whether the run is in a sliding mode.
    pub fn is_active(&self) -> bool {
        self.is_active
    }

    /// Forgets events and mode, after a jump of the equations.
    pub fn reset(&mut self) {
        (self.count, self.creeping) = (0, 0);
        (self.is_active, self.only_creep) = (false, false);
    }

    /// Records the states chosen at an event. Begins a mode if the states alternate.
    pub fn record(&mut self, sim: &mut RunState, observer: &mut dyn Observer) -> Result<(), RunError> {
        let t = sim.plant.state.time;
        self.recent.rotate_right(1);
        self.recent[0].0 = t;
        self.recent[0].1.clone_from(&sim.plant.states);
        self.count = if sim.last_collision == t { 0 } else { self.count + 1 };
        self.creeping = if sim.creeps(CREEP) { self.creeping + 1 } else { 0 };
        let again = (t < self.passed).then_some(EVENTS_AGAIN);
        let found = again.into_iter().chain(EVENTS).find_map(|needed| {
            let (span, distinct) = self.alternation(needed)?;
            let only_creep = span > FAST * needed as f64;
            let creeping = if again.is_some() && self.has_crept { EVENTS_AGAIN } else { EVENTS_OF_CREEP };
            let is_slow = span > FAST_OF_CREEP * needed as f64 || self.creeping < creeping;
            (!only_creep || !is_slow).then_some((needed, distinct, span, only_creep))
        });
        let Some((needed, distinct, span, only_creep)) = found else { return Ok(()) };
        self.begin(sim, if only_creep { STAYS_OF_CREEP } else { STAYS });
        self.only_creep = only_creep;
        let message = format!("begins: {needed} events between {distinct} states within {span:.3e} s");
        sim.event(observer, EventKind::SlidingMode, "", &message)
    }

    /// Time in which the last `needed` events took place, s, and the number of their states, if that is at most half
    /// theirs.
    fn alternation(&self, needed: usize) -> Option<(f64, usize)> {
        if self.count < needed {
            return None;
        }
        let recent = &self.recent[..needed];
        let distinct = (0..needed).filter(|&i| recent[..i].iter().all(|(_, states)| *states != recent[i].1)).count();
        (2 * distinct <= needed).then(|| (recent[0].0 - recent[needed - 1].0, distinct))
    }

    /// Begins a mode if the last choice of states has found none. Returns whether it has.
    pub fn begin_deferred(&mut self, sim: &mut RunState, observer: &mut dyn Observer) -> Result<bool, RunError> {
        if sim.deferral != Deferral::Due {
            return Ok(false);
        }
        sim.deferral = Deferral::Allowed;
        self.begin(sim, STAYS_WITHOUT_STATE);
        sim.event(observer, EventKind::SlidingMode, "", "begins: no valid state near the solved contact problem")?;
        // States and forces at this instant are those of a first step.
        let states = sim.plant.states.clone();
        sim.plant.within = sim.plant.state.time + 0.5 * self.h;
        evaluate_step(sim, self.h)?;
        set_velocity_problem(sim, self.h);
        sim.choose_unreported_impulse(observer)?;
        show_forces(sim, self.h);
        sim.anchor_changed(&states);
        Ok(true)
    }

    /// Begins a mode. The first of several in a row lasts for `first`.
    fn begin(&mut self, sim: &RunState, (first, longest): (f64, f64)) {
        let t = sim.plant.state.time;
        self.entered = (names(sim).map(str::to_owned).collect(), sim.plant.states.clone());
        self.stay = if t < self.passed { (2.0 * self.stay).clamp(first, longest) } else { first };
        (self.is_active, self.since, self.trial, self.h) = (true, t, t + self.stay, FIRST_STEP);
        self.control = StepControl::new(2);
        (self.misses, self.least, self.longest_least) = (0, Self::SHORTEST, LONGEST_LEAST);
        (self.missed, self.missed_before) = ((0.0, 0), f64::INFINITY);
    }

    /// Ends the mode: chooses states for located events.
    pub fn leave(&mut self, sim: &mut RunState, observer: &mut dyn Observer) -> Result<(), RunError> {
        let t = sim.plant.state.time;
        self.has_crept = self.only_creep;
        self.reset();
        self.passed = t + self.stay;
        let message = format!("ends after {:.6e} s", t - self.since);
        sim.event(observer, EventKind::SlidingMode, "", &message)?;
        let (polygons, states) = std::mem::take(&mut self.entered);
        if names(sim).eq(polygons.iter().map(String::as_str)) {
            for s in 0..polygons.len() {
                let (old, new) = (states[s], sim.plant.states[s]);
                if old != new {
                    sim.report_change(s, old, new, observer)?;
                }
            }
        }
        sim.choose_states(observer)?;
        self.begin_deferred(sim, observer)?;
        Ok(())
    }

    /// Takes one step of the mode towards `until`, with the tolerances of `size`. Returns whether
    /// the mode is due to end.
    pub fn step(
        &mut self,
        sim: &mut RunState,
        size: &StepSize,
        until: f64,
        observer: &mut dyn Observer,
    ) -> Result<bool, RunError> {
        let t0 = sim.plant.state.time;
        sim.update_polygons(Some(self.h));
        sim.emit_due_snapshots(t0, observer)?;
        if let Some(sampler) = &mut sim.sampler {
            sampler.begin_step(&sim.plant);
        }
        let logged = sim.log.next().filter(|&t| t >= t0 + Self::SHORTEST);
        let end = logged.map_or(until, |t| t.min(until));
        let remaining = end - t0;
        let layout = sim.plant.layout.clone();
        let states = sim.plant.states.clone();
        let jumps = sim.energy.jump_work;
        let impulses = sim.plant.impulses.take();
        sim.plant.pack(&sim.energy.flows, &mut self.start);
        self.directions.clone_from(&sim.plant.directions);
        // Grows no more after a rejection.
        let mut most = f64::INFINITY;
        let mut h = match *size {
            StepSize::Controlled { max_step, .. } => self.h.min(max_step),
            StepSize::Fixed(step) => OF_FIXED * step,
        };
        let jump = loop {
            // Leaves no sliver before the end.
            h = if remaining - h < 0.01 * h { remaining } else { h };
            self.advance(sim, h, t0 + h, observer)?;
            sim.plant.pack(&sim.energy.flows, &mut self.whole);
            let jump_of_whole = sim.energy.jump_work - jumps;
            self.restore(sim, t0, jumps, &states);
            self.advance(sim, 0.5 * h, t0 + 0.5 * h, observer)?;
            if impulses.is_some() {
                sim.plant.sole_forces(&sim.plant.solution.wrench, &mut self.sole_forces);
            }
            self.advance(sim, 0.5 * h, t0 + h, observer)?;
            sim.plant.pack(&sim.energy.flows, &mut self.halves);
            let jump_of_halves = sim.energy.jump_work - jumps;
            let (error, factor) = match *size {
                StepSize::Controlled { relative, absolute, .. } => {
                    let error = self.error(relative, absolute, &layout);
                    (error, self.control.factor(error).min(most))
                }
                StepSize::Fixed(_) => (0.0, 1.0),
            };
            // The shortest step may be stretched to the end.
            let is_shortest = h <= self.least || h == remaining && remaining - self.least < 0.01 * self.least;
            if error <= 1.0 || is_shortest {
                self.adapt_least(error);
                if h < remaining || factor < 1.0 {
                    self.h = (h * factor).max(self.least);
                }
                if error <= 1.0 {
                    self.halves.iter_mut().zip(&self.whole).for_each(|(y, whole)| *y = 2.0 * *y - whole);
                    break 2.0 * jump_of_halves - jump_of_whole;
                }
                break jump_of_halves;
            }
            sim.metrics.rejected_steps += 1;
            most = 1.0;
            self.restore(sim, t0, jumps, &states);
            h = (h * factor).max(self.least);
        };
        sim.energy.jump_work = jumps + jump;
        let t1 = if h == remaining { end } else { t0 + h };
        sim.plant.unpack(t1, &self.halves);
        sim.energy.flows = layout.flows(&self.halves);
        sim.plant.apply_prescribed_positions();
        sim.plant.close_conditions();
        check_finite(&sim.plant)?;
        sim.plant.evaluate_free();
        sim.anchor_changed(&states);
        sim.stop_and_project_drift();
        sim.plant.refresh();
        sim.plant.impulses = impulses;
        if let Some(impulses) = &mut sim.plant.impulses {
            // Two halves of equal length: the mean of their forces over the step.
            impulses.add(&self.sole_forces, 0.5 * h);
        }
        sim.plant.add_present_forces(0.5 * h);
        sim.metrics.steps += 1;
        sim.metrics.sliding_mode_s += t1 - t0;
        sim.measure_energy();
        sim.measure_step();
        sim.sampler.as_mut().map_or(Ok(()), |sampler| sampler.sample_step(&sim.plant, observer))?;
        Ok(t1 >= self.trial || self.only_creep && !sim.creeps(2.0 * CREEP))
    }

    /// Doubles the shortest size after [`MISSES`] more steps that have missed the tolerances than have met them, and
    /// halves it after as many the other way round, or if the errors have grown with it: it is no impact then that
    /// misses them.
    fn adapt_least(&mut self, error: f64) {
        self.misses += if error <= 1.0 { -1 } else { 1 };
        if error > 1.0 {
            self.missed = (self.missed.0 + error, self.missed.1 + 1);
        }
        if self.misses.abs() < MISSES {
            return;
        }
        let mean = self.missed.0 / f64::from(self.missed.1.max(1));
        let has_grown = self.misses > 0 && mean > GROWS * self.missed_before;
        let factor = if self.misses > 0 && !has_grown { 2.0 } else { 0.5 };
        if has_grown {
            self.longest_least = 0.5 * self.least;
        }
        self.missed_before = if factor > 1.0 { mean } else { f64::INFINITY };
        self.least = (factor * self.least).min(self.longest_least).max(Self::SHORTEST);
        (self.misses, self.missed) = (0, (0.0, 0));
    }

    /// One velocity-level step of size `h` to the time `end`, with its contact states and without
    /// events.
    fn advance(&self, sim: &mut RunState, h: f64, end: f64, observer: &mut dyn Observer) -> Result<(), RunError> {
        sim.plant.within = end - 0.5 * h;
        evaluate_step(sim, h)?;
        set_velocity_problem(sim, h);
        sim.choose_unreported_impulse(observer)?;
        apply_step(sim, h, end);
        Ok(())
    }

    /// Returns the run to the start of the step.
    fn restore(&self, sim: &mut RunState, t0: f64, jumps: f64, states: &States) {
        sim.plant.unpack(t0, &self.start);
        sim.energy.flows = sim.plant.layout.flows(&self.start);
        sim.energy.jump_work = jumps;
        sim.plant.states.clone_from(states);
        sim.plant.directions.clone_from(&self.directions);
    }

    /// Norm of the difference between the results of one step and of two halves, by the tolerances
    /// to the power of 2/3.
    fn error(&self, relative: f64, absolute: f64, layout: &StateLayout) -> f64 {
        let two_thirds = |tolerance: f64| math::cbrt(tolerance) * math::cbrt(tolerance);
        let tolerances = (two_thirds(relative), two_thirds(absolute));
        let difference = |i: usize| self.halves[i] - self.whole[i];
        error_norm(layout.error_groups(), tolerances, [&self.start, &self.halves], difference)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::model::state::{Pattern, SoleState};

    /// Of cycles of five and of twenty states only the first returns to half of 16 events.
    #[test]
    fn the_states_of_many_soles_alternate_in_longer_cycles() {
        for (cycle, expected) in [(5, [Some(5), Some(5)]), (20, [None, Some(20)]), (40, [None, None])] {
            let mut mode = SlidingMode::new(0);
            for k in 0..MOST_EVENTS {
                let states = States::filled(SoleState::fixed(Pattern::Vertex((k % cycle) as u8)));
                mode.recent.rotate_right(1);
                mode.recent[0] = (1e-6 * k as f64, states);
                mode.count += 1;
            }
            let found = EVENTS.map(|needed| mode.alternation(needed));
            assert_eq!(found.map(|found| found.map(|(_, distinct)| distinct)), expected, "{cycle}");
            let spans = found.into_iter().zip(EVENTS).filter_map(|(found, needed)| Some((found?.0, needed)));
            // Rounding of the instants.
            assert!(spans.into_iter().all(|(span, needed)| (span - 1e-6 * (needed - 1) as f64).abs() < 1e-18));
        }
    }
}
