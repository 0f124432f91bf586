//! Stepping with located events by the methods of [`super::step_methods`], in steps sized by error control or fixed.
//!
//! A step integrates with the contact states held. Event functions, all positive while those states are valid, are
//! evaluated at the end of the step. When one has changed sign, event location finds the first crossing on the dense
//! output, the step is repeated to that instant, and the states are chosen again. After every step the drift of
//! couplings, loops and clamped soles is removed. After steps with implicit forces this is done before the end is
//! evaluated, where there are no couplings and loops, so that the next step need not evaluate its start.

use super::Discontinuity;
use super::sliding_mode::SlidingMode;
use super::step_methods::{StepMethods, StepStart};
use super::step_size::StepSize;
use crate::contact::hybrid::events::USUAL_FUNCTIONS;
use crate::contact::model::solution::Solution;
use crate::contact::search::judge::CLEAR;
use crate::integrate::Tableau;
use crate::integrate::event_location::first_crossing;
use crate::sim::contact_states::event_functions::StepEventFunctions;
use crate::sim::plant::Plant;
use crate::sim::report::Observer;
use crate::sim::run::{Deferral, RunState};
use crate::sim::run_error::RunError;
use crate::sim::setup::ImplicitSteps;
use crate::sim::termination::{check_finite, diverged};
use nalgebra::Vector2;

/// Width to which an event is located, relative to its step.
const LOCATE: f64 = 1e-13;
/// Size of the first step over a jump, relative to the time scale of the run, s.
const FIRST_HOP: f64 = 1e-13;
/// Greatest size of a step over a jump, s.
const MAX_HOP: f64 = 1e-9;
/// How far beyond an event a step is repeated to end, relative to its size.
const BEYOND: &[f64] = &[1e-4, 1e-7, 0.0];
/// The same for implicit steps, whose dense output is of lower order.
const STIFF_BEYOND: &[f64] = &[1e-2, 1e-4, 1e-7, 0.0];
/// How long before an event the directions of vertices that come to rest are read, relative to the
/// step.
const BEFORE: f64 = 1e-3;
/// Smallest step relative to the time scale of the run, s.
const SMALLEST: f64 = 1e-13;

/// Speed of a sliding vertex, m/s, below which its turning direction may collapse the step size:
/// ten times the speed below which the direction is held.
const CRAWL: f64 = 1e-6;

/// Limit on shortening a step to end where a vertex crosses a narrow patch.
const MOST_CROSSINGS: usize = 8;

/// The explicit integrator of one run.
#[derive(Clone)]
pub struct ExplicitStepper {
    methods: StepMethods,
    size: StepSize,
    sliding_mode: SlidingMode,
    /// Have the states been chosen at the start of the next step?
    fresh: bool,
    /// On a compliant floor: has the last step ended without an event?
    is_smooth: bool,
    /// Instant at which the step size has last collapsed, s.
    collapse: Option<f64>,
    /// Size of the next step, s, if it must step over a jump of the forces at its start.
    hop: Option<f64>,
    /// Instant at which the last step has left the plant evaluated, without drift and without an event, s.
    settled: Option<f64>,
    /// The integrator's vector.
    y: Vec<f64>,
    dense: Vec<f64>,
    functions: StepEventFunctions,
    /// Reference directions at the start of the step.
    directions: Vec<Vec<Vector2<f64>>>,
    /// The solution before evaluations for the log.
    held: Solution,
    /// Event functions at the start of the step, at the ends of the bracket, and scratch.
    start: Vec<f64>,
    left: Vec<f64>,
    right: Vec<f64>,
    scratch: Vec<f64>,
}

impl ExplicitStepper {
    /// For a plant.
    pub fn new(method: &'static Tableau, plant: &Plant, size: StepSize, implicit: ImplicitSteps) -> Self {
        let n = plant.layout.size();
        ExplicitStepper {
            methods: StepMethods::new(method, plant, &size, implicit),
            size,
            sliding_mode: SlidingMode::new(n),
            fresh: true,
            is_smooth: false,
            collapse: None,
            hop: None,
            settled: None,
            y: vec![0.0; n],
            dense: vec![0.0; n],
            functions: StepEventFunctions::new(),
            directions: Vec::new(),
            held: plant.solution.clone(),
            start: Vec::with_capacity(USUAL_FUNCTIONS),
            left: Vec::with_capacity(USUAL_FUNCTIONS),
            right: Vec::with_capacity(USUAL_FUNCTIONS),
            scratch: Vec::with_capacity(USUAL_FUNCTIONS),
        }
    }

    /// Resets the step size after a jump of the equations.
    pub fn restart(&mut self) {
        self.size.restart();
        self.methods.restart();
        self.is_smooth = false;
        self.sliding_mode.reset();
    }

    /// Takes one step towards `until`, or to the first event before it. After a discontinuity the
    /// states are first chosen again.
    pub fn step(
        &mut self,
        sim: &mut RunState,
        until: f64,
        discontinuity: Discontinuity,
        observer: &mut dyn Observer,
    ) -> Result<(), RunError> {
        let t0 = sim.plant.state.time;
        let layout = sim.plant.layout.clone();
        let remaining = until - t0;
        let suffices = remaining >= SlidingMode::SHORTEST;
        sim.deferral = if suffices { Deferral::Allowed } else { Deferral::Refused };
        if self.sliding_mode.is_active() && (discontinuity == Discontinuity::Corner || !suffices) {
            self.sliding_mode.leave(sim, observer)?;
        }
        if self.sliding_mode.is_active() {
            return self.step_in_sliding_mode(sim, until, observer);
        }
        let mut hop = self.hop.take().filter(|_| discontinuity == Discontinuity::None);
        let is_evaluated = self.settled.take() == Some(t0) && discontinuity == Discontinuity::None;
        let mut h = hop.unwrap_or_else(|| self.size.next(remaining)).min(remaining);
        sim.plant.within = t0 + 0.5 * h;
        // What touches is part of the state of springs too.
        if (sim.locates_events() || sim.plant.is_compliant()) && discontinuity == Discontinuity::Corner {
            sim.choose_states(observer)?;
            if self.sliding_mode.begin_deferred(sim, observer)? {
                return self.step_in_sliding_mode(sim, until, observer);
            }
            self.fresh = true;
        }
        self.begin(sim, t0, is_evaluated);
        // A load that has jumped beyond what its state carries, or drift projection over a border.
        let invalid = self.start.iter().any(|g| *g < 0.0) && (!self.fresh || discontinuity == Discontinuity::Tick);
        if sim.locates_events() && invalid {
            sim.choose_states(observer)?;
            if self.sliding_mode.begin_deferred(sim, observer)? {
                return self.step_in_sliding_mode(sim, until, observer);
            }
            self.methods.interrupt();
            self.begin(sim, t0, false);
        }
        sim.measure_energy();
        sim.plant.begin_sole_impulses();
        let doubtful = self.functions.overlook(&mut self.start, sim.tolerances.rest);
        if hop.is_none() && (sim.locates_events() || self.methods.has_implicit_forces()) {
            let start = StepStart::new(discontinuity, self.fresh, self.is_smooth, &sim.plant);
            h = self.methods.select(&mut sim.plant, &self.y, h, remaining, start);
        } else {
            self.methods.interrupt();
        }
        self.left.resize(self.start.len(), 0.0);
        self.scratch.resize(self.start.len(), 0.0);
        self.directions.clone_from(&sim.plant.directions);
        let drift = (sim.metrics.max_static_creep_m, sim.metrics.max_projection_m);
        let (mut event, mut located, mut settled);
        loop {
            let Some(size) = self.accept(sim, t0, h, &mut hop, remaining) else {
                return self.resolve_collapse(sim, t0, until, observer);
            };
            h = size;
            settled = self.settle(sim, if h == remaining { until } else { t0 + h });
            if let Some(factor) = self.methods.shorten_unsolved(&sim.plant) {
                sim.metrics.rejected_steps += 1;
                (sim.metrics.max_static_creep_m, sim.metrics.max_projection_m) = drift;
                h *= factor;
                continue;
            }
            self.functions.values(sim, &mut self.right);
            // Bodies stay where their terrain is known.
            while let Some(part) = sim.pairs.part_inside(&sim.plant) {
                h *= part;
                settled = false;
                self.attempt_to_end(sim, t0, h);
                self.functions.values(sim, &mut self.right);
            }
            for _ in 0..MOST_CROSSINGS {
                let Some(part) = self.functions.passed_over(sim, &self.right).filter(|_| sim.locates_events()) else {
                    break;
                };
                h *= part;
                settled = false;
                self.attempt_to_end(sim, t0, h);
                self.functions.values(sim, &mut self.right);
            }
            event = self.right.iter().any(|g| *g < 0.0);
            located = event && hop.is_none() && (sim.locates_events() || sim.locates_surface());
            if !located {
                break;
            }
            settled = false;
            h = self.locate(sim, t0, h);
            event = self.hop.is_none();
            // The longer step met the tolerances with the equations continued beyond the event. Where
            // a vertex almost stops and turns, these are smoother than those before the event.
            let Some(factor) = self.methods.shorten_located(&self.size, &layout).filter(|_| h > MAX_HOP) else {
                break;
            };
            sim.metrics.rejected_steps += 1;
            sim.plant.directions.clone_from(&self.directions);
            self.hop = None;
            h *= factor;
        }
        if let Some(size) = hop.filter(|size| !event && *size < MAX_HOP) {
            self.hop = Some(2.0 * size);
        }
        if !settled {
            // Of attempts that were repeated.
            (sim.metrics.max_static_creep_m, sim.metrics.max_projection_m) = drift;
        }
        sim.metrics.steps += 1;
        let t1 = if h == remaining { until } else { t0 + h };
        self.emit_dense_output(sim, t0, t1, h, observer)?;
        sim.plant.unpack(t1, self.methods.end());
        sim.energy.flows = layout.flows(self.methods.end());
        // Event location may end with the plant anywhere in the step.
        if sim.plant.close_conditions() | located {
            sim.plant.evaluate();
        }
        sim.plant.end_sole_impulses(h);
        check_finite(&sim.plant)?;
        if sim.plant.is_compliant() {
            if located {
                sim.metrics.events += 1;
                sim.stall_guard.count_at_instant(sim.plant.state.time)?;
            }
            self.is_smooth = !(located || event);
            if sim.update_polygons(None) {
                sim.plant.evaluate();
                (settled, self.is_smooth) = (false, false);
            }
            self.settled = settled.then_some(t1);
            sim.read_compliant_states(observer)?;
            sim.measure_step();
            return Ok(());
        }
        // Both read accelerations of vertices, whose biases drift projection clears. None is set to rest
        // if no state was found: another selection would find none either.
        let stops = if doubtful { 0.0 } else { sim.slow_to_rest() };
        event |= doubtful || !sim.locates_events() || self.functions.tolerated_too_much(sim) || stops > 0.0;
        event |= !settled && !sim.project_drift();
        self.settled = (settled && !event).then_some(t1);
        if event {
            sim.metrics.events += u64::from(sim.locates_events());
            self.functions.suspects(&self.right, &mut sim.suspect);
            sim.choose_states_with_rest(stops, observer)?;
            if sim.locates_events() && !self.sliding_mode.begin_deferred(sim, observer)? {
                self.sliding_mode.record(sim, observer)?;
            }
        } else {
            // Without an event the present states are the only candidate, which the event functions
            // have confirmed.
            sim.metrics.confirmed += 1;
        }
        self.fresh = event;
        sim.measure_step();
        Ok(())
    }

    /// Attempts steps, the first of size `h`, until the error of one is acceptable. Returns its size;
    /// none if that collapses. Clears `hop` if the step needs error control.
    fn accept(
        &mut self,
        sim: &mut RunState,
        t0: f64,
        mut h: f64,
        hop: &mut Option<f64>,
        remaining: f64,
    ) -> Option<f64> {
        let layout = sim.plant.layout.clone();
        loop {
            sim.plant.within = t0 + 0.5 * h;
            self.methods.attempt(&mut sim.plant, t0, h);
            let is_accurate = || self.methods.shorten_located(&self.size, &layout).is_none();
            if hop.is_some() && (h <= FIRST_HOP * (1.0 + t0) || is_accurate()) {
                return Some(h);
            }
            // Forces that grow without bound are no jump.
            *hop = None;
            let Some(factor) = self.methods.shorten(&mut self.size, &layout, h, remaining) else { return Some(h) };
            sim.metrics.rejected_steps += 1;
            h *= factor;
            if !(h > SMALLEST * (1.0 + t0)) {
                return None;
            }
        }
    }

    /// Ends a force without bound, or the slip of a vertex that crawls, at the start of a step whose size has
    /// collapsed. Where this is not the cause, or has not helped, velocity-level steps follow if a sole slides.
    fn resolve_collapse(
        &mut self,
        sim: &mut RunState,
        t0: f64,
        until: f64,
        observer: &mut dyn Observer,
    ) -> Result<(), RunError> {
        sim.plant.unpack(t0, &self.y);
        sim.plant.evaluate_free();
        // An impulse that has ended the force at this instant once will not do so again.
        let again = self.collapse.replace(t0) == Some(t0);
        let unbounded = !again && sim.locates_events() && sim.resolve_unbounded_force(observer)?;
        let ends = unbounded || !again && sim.locates_events() && sim.crawls(CRAWL);
        if !ends {
            if !sim.defers() || !sim.is_sliding() {
                return Err(diverged(&sim.plant, "the step size collapsed"));
            }
            sim.deferral = Deferral::Due;
            self.restart();
            self.sliding_mode.begin_deferred(sim, observer)?;
            return self.step_in_sliding_mode(sim, until, observer);
        }
        // A crawling vertex has come to rest: its direction turns faster than steps resolve.
        sim.choose_states_with_rest(if unbounded { 0.0 } else { CRAWL }, observer)?;
        self.fresh = true;
        self.restart();
        self.sliding_mode.begin_deferred(sim, observer)?;
        sim.measure_step();
        Ok(())
    }

    /// Takes a step of a sliding mode, and ends the mode where it is due to end.
    fn step_in_sliding_mode(
        &mut self,
        sim: &mut RunState,
        until: f64,
        observer: &mut dyn Observer,
    ) -> Result<(), RunError> {
        self.methods.interrupt();
        if self.sliding_mode.step(sim, &self.size, until, observer)? {
            self.sliding_mode.leave(sim, observer)?;
            self.size.restart();
            self.methods.restart();
            self.fresh = true;
        }
        Ok(())
    }

    /// Leaves the plant evaluated at the end of an acceptable attempt. Returns whether the next step can begin with
    /// this evaluation: its drift has been removed, or there is none.
    ///
    /// Drift is removed with the responses of the last stage, at almost the same configuration.
    fn settle(&mut self, sim: &mut RunState, t1: f64) -> bool {
        if !self.methods.is_stiff() {
            return false;
        }
        sim.plant.unpack(t1, self.methods.end());
        let is_exact = sim.locates_events() || sim.plant.is_compliant();
        let mut settles = is_exact && self.methods.has_implicit_forces() && !sim.plant.has_conditions();
        if settles && !sim.plant.is_compliant() {
            sim.plant.refresh();
            settles = sim.project_drift();
            self.methods.move_end(&sim.plant);
            sim.plant.unpack(t1, self.methods.end());
        }
        sim.plant.evaluate();
        settles
    }

    /// Attempts a step of size `h` and leaves the plant at its end.
    fn attempt_to_end(&mut self, sim: &mut RunState, t0: f64, h: f64) {
        self.methods.attempt(&mut sim.plant, t0, h);
        if self.methods.is_stiff() {
            sim.plant.unpack(t0 + h, self.methods.end());
            sim.plant.evaluate();
        }
    }

    /// Evaluates the start of a step, unless the plant is evaluated there, and selects its event functions.
    fn begin(&mut self, sim: &mut RunState, t0: f64, is_evaluated: bool) {
        sim.plant.pack(&sim.energy.flows, &mut self.y);
        match is_evaluated {
            true => self.methods.begin_evaluated(&sim.plant, &self.y),
            false => self.methods.begin(&mut sim.plant, t0, &self.y),
        }
        sim.plant.update_reference_directions();
        sim.pairs.update_terrain(&mut sim.plant, None);
        self.functions.begin(sim, &mut self.start, is_evaluated.then_some(&self.right));
    }

    /// Event location: shortens the attempted step to its first event and returns its new size. The
    /// plant is left at the event.
    ///
    /// The dense output is of lower order than the step itself (4 and 5, 3 and 4) or another solution of the same
    /// order, so a step to an event located on it misses the event. A second step that ends just beyond the event,
    /// where its dense output is as accurate as its end, removes the difference. Vertices that come to rest there
    /// have turned since the start of the step, so further steps take their directions just before the event as
    /// references. The first step cannot give these: where a vertex is that slow, its dense output may be error.
    fn locate(&mut self, sim: &mut RunState, t0: f64, full: f64) -> f64 {
        let mut h = full;
        let mut near = false;
        let passes = if self.methods.is_stiff() { STIFF_BEYOND } else { BEYOND };
        for (pass, &beyond) in passes.iter().enumerate() {
            let event = h * self.crossing(sim, t0, h);
            if pass == 1 && h < full {
                self.methods.interpolate((1.0 - BEFORE) * event / h, &mut self.dense);
                sim.plant.unpack(t0 + (1.0 - BEFORE) * event, &self.dense);
                sim.plant.refresh();
                sim.plant.update_reference_directions();
            }
            let next = (event * (1.0 + beyond)).min(full);
            if next == h {
                // It ends as it should; the next passes end nearer.
                continue;
            }
            near = !self.attempt(sim, t0, next);
            h = next;
            if beyond > 0.0 && self.right.iter().all(|g| *g >= 0.0) {
                // The event has moved beyond the new end by more than expected: fall back on the
                // whole step once.
                self.attempt(sim, t0, full);
                h = full;
                near = false;
            }
        }
        // If a force jumps with the state (a joint meets its stop), the end may be before the jump,
        // where the states are still valid.
        self.hop = near.then_some(FIRST_HOP * (1.0 + t0));
        h
    }

    /// Attempts a step of size `h`. Returns whether an event function has reached zero at its end.
    fn attempt(&mut self, sim: &mut RunState, t0: f64, h: f64) -> bool {
        self.attempt_to_end(sim, t0, h);
        self.functions.values(sim, &mut self.scratch);
        // The final values only show which functions fired, so located negative values are kept.
        if self.scratch.iter().any(|g| *g < 0.0) {
            self.right.copy_from_slice(&self.scratch);
        }
        self.scratch.iter().any(|g| *g <= CLEAR)
    }

    /// First crossing within the attempted step of size `h`, as a fraction of it.
    fn crossing(&mut self, sim: &mut RunState, t0: f64, h: f64) -> f64 {
        let (methods, dense, functions) = (&self.methods, &mut self.dense, &self.functions);
        self.scratch.copy_from_slice(&self.start);
        self.left.copy_from_slice(&self.start);
        first_crossing(0.0, 1.0, &mut self.left, &mut self.right, &mut self.scratch, LOCATE, |theta, g| {
            methods.interpolate(theta, dense);
            sim.plant.unpack(t0 + theta * h, dense);
            sim.plant.evaluate();
            functions.fill(sim, g);
        })
    }

    /// Emits the logged and sampled instants inside the step, from the dense output; the log does
    /// not influence steps.
    fn emit_dense_output(
        &mut self,
        sim: &mut RunState,
        t0: f64,
        t1: f64,
        h: f64,
        observer: &mut dyn Observer,
    ) -> Result<(), RunError> {
        let due = |next: Option<f64>| next.filter(|&t| t < t1);
        if due(sim.log.next()).or(due(sim.next_sample())).is_none() {
            return Ok(());
        }
        // Evaluations for the log are not part of the run's cost.
        let evaluations = sim.plant.evaluations;
        // Vertex forces of static soles are those of the last step, from which the next choice of
        // states begins.
        self.held.copy_from(&sim.plant.solution);
        while let Some(t) = due(sim.log.next()).into_iter().chain(due(sim.next_sample())).reduce(f64::min) {
            self.methods.interpolate(((t - t0) / h).clamp(0.0, 1.0), &mut self.dense);
            sim.plant.unpack(t, &self.dense);
            sim.plant.close_conditions();
            sim.plant.evaluate();
            sim.energy.flows = sim.plant.layout.flows(&self.dense);
            if sim.next_sample() == Some(t) {
                sim.sample_state(observer)?;
            }
            if sim.log.next() == Some(t) {
                sim.plant.update_multipliers();
                sim.emit_snapshot(observer)?;
            }
        }
        // Returns the plant to the end of the step.
        sim.plant.unpack(t1, self.methods.end());
        sim.plant.evaluate();
        sim.plant.solution.copy_from(&self.held);
        sim.plant.evaluations = evaluations;
        Ok(())
    }
}
