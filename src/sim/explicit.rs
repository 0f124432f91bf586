//! Explicit Runge-Kutta stepping with located events, in steps sized by error control or fixed.
//!
//! A step integrates with the contact states held. Event functions, all positive while those states stay true, are
//! watched at the end of the step; when one has changed sign, the first crossing is located on the dense output, the
//! step is taken again to that instant, and the states are chosen anew. After every step the drift of clamped soles is
//! projected out.

use super::error::Stop;
use super::simulation::{Jump, Simulation};
use super::watch::{MAX_WATCHED, Watch};
use crate::contact::search::judge::CLEAR;
use crate::integrate::event_location::first_crossing;
use crate::integrate::{RungeKutta, StepControl, Tableau};
use crate::sim::Observer;

/// Width to which an event is located, relative to its step.
const LOCATE: f64 = 1e-13;
/// Size beyond which a step over a jump has found none, s.
const FARTHEST: f64 = 1e-9;
/// Smallest step relative to the time scale of the run, s.
const SMALLEST: f64 = 1e-13;

/// Speed of a sliding vertex, m/s, at which steps may collapse over the turning of its direction: ten times that from which
/// on the direction is no longer followed.
const CRAWL: f64 = 1e-6;

/// Times a step is shortened to end where a vertex has gone over a narrow patch.
const PASSAGES: usize = 8;

/// How long steps are.
pub enum Sizes {
    /// As long as the error of each allows.
    Controlled {
        /// Chooses the next size.
        control: StepControl,
        /// Relative tolerance.
        relative: f64,
        /// Absolute tolerance.
        absolute: f64,
        /// Longest step, s.
        max_step: f64,
        /// The next step, s.
        h: f64,
    },
    /// All of this length, s, but where they are shortened to end at an instant.
    Fixed(f64),
}

impl Sizes {
    /// Size of the next step, with so much time left before a stop.
    fn next(&self, remaining: f64) -> f64 {
        let h = match self {
            Sizes::Controlled { max_step, h, .. } => h.min(*max_step),
            Sizes::Fixed(step) => *step,
        };
        let h = h.min(remaining);
        // Do not leave a sliver before the stop.
        if remaining - h < 0.01 * h { remaining } else { h }
    }

    /// None if the step of size `h` just tried is good enough; else what to multiply its size with.
    fn shorten(&mut self, rk: &RungeKutta, controlled: usize, h: f64, remaining: f64) -> Option<f64> {
        let Sizes::Controlled { control, relative, absolute, h: next, .. } = self else { return None };
        let error = rk.error(*relative, *absolute, controlled);
        let factor = control.factor(error);
        if error <= 1.0 {
            if h < remaining || factor < 1.0 {
                *next = h * factor;
            }
            return None;
        }
        Some(factor)
    }

    /// Forgets how long the last step was.
    fn restart(&mut self) {
        if let Sizes::Controlled { max_step, h, .. } = self {
            *h = max_step.min(1e-3);
        }
    }
}

/// The explicit integrator of one run.
pub struct Explicit {
    rk: RungeKutta,
    sizes: Sizes,
    /// Have the states been chosen at the time where the next step starts?
    fresh: bool,
    /// Size of the next step, s, where it has to go over a jump of the forces to which the last one led.
    hop: Option<f64>,
    /// The integrator's vector.
    y: Vec<f64>,
    dense: Vec<f64>,
    watch: Watch,
    /// Event functions at the start of the step, at the ends of the bracket, and scratch.
    start: Vec<f64>,
    left: Vec<f64>,
    right: Vec<f64>,
    scratch: Vec<f64>,
}

impl Explicit {
    /// For vectors of length `n`.
    pub fn new(method: &'static Tableau, n: usize, sizes: Sizes) -> Self {
        Explicit {
            rk: RungeKutta::new(method, n),
            sizes,
            fresh: true,
            hop: None,
            y: vec![0.0; n],
            dense: vec![0.0; n],
            watch: Watch::new(),
            start: Vec::with_capacity(MAX_WATCHED),
            left: Vec::with_capacity(MAX_WATCHED),
            right: Vec::with_capacity(MAX_WATCHED),
            scratch: Vec::with_capacity(MAX_WATCHED),
        }
    }

    /// Forgets how long the last step was: what it rested on has jumped.
    pub fn restart(&mut self) {
        self.sizes.restart();
    }

    /// Takes one step towards `until` (never beyond), with whatever event it meets. Where something has jumped the states
    /// are asked again first.
    pub fn step(
        &mut self,
        sim: &mut Simulation,
        until: f64,
        jump: Jump,
        observer: &mut dyn Observer,
    ) -> Result<(), Stop> {
        let t0 = sim.plant.state.time;
        let layout = sim.plant.layout;
        let remaining = until - t0;
        let hop = self.hop.take().filter(|_| jump == Jump::None);
        let mut h = hop.unwrap_or_else(|| self.sizes.next(remaining)).min(remaining);
        sim.plant.within = t0 + 0.5 * h;
        if sim.locates() && jump == Jump::Corner {
            sim.decide(observer)?;
            self.fresh = true;
        }
        self.begin(sim, t0);
        // A load that has jumped beyond what its state carries, or drift projected out over a border.
        let spoiled = self.start.iter().any(|g| *g < 0.0) && (!self.fresh || jump == Jump::Tick);
        if sim.locates() && spoiled {
            sim.decide(observer)?;
            self.begin(sim, t0);
        }
        sim.audit();
        sim.plant.begin_impulse();
        let doubtful = self.watch.overlook(&mut self.start, sim.tolerances.rest);
        self.left.resize(self.start.len(), 0.0);
        self.scratch.resize(self.start.len(), 0.0);
        loop {
            sim.plant.within = t0 + 0.5 * h;
            self.rk.attempt(&mut sim.plant, t0, h);
            if hop.is_some() {
                break;
            }
            let Some(factor) = self.sizes.shorten(&self.rk, layout.controlled(), h, remaining) else { break };
            sim.metrics.rejected_steps += 1;
            h *= factor;
            if !(h > SMALLEST * (1.0 + t0)) {
                sim.plant.unpack(t0, &self.y);
                sim.plant.evaluate_free();
                let burst = sim.locates() && sim.burst(observer)?;
                if burst || sim.locates() && sim.crawls(CRAWL) {
                    // Whatever crawls has come to rest: its direction turns faster than it can be followed.
                    let rest = if burst { 0.0 } else { CRAWL };
                    sim.decide_with_rest(rest, observer)?;
                    self.fresh = true;
                    self.sizes.restart();
                    sim.measure();
                    return Ok(());
                }
                return Err(sim.diverged("the step size collapsed"));
            }
        }
        // The last stage was evaluated at the end of the step, so the plant stands there.
        self.watch.values(sim, &mut self.right);
        for _ in 0..PASSAGES {
            let Some(part) = self.watch.passed_over(sim, &self.right).filter(|_| sim.locates()) else { break };
            h *= part;
            self.rk.attempt(&mut sim.plant, t0, h);
            self.watch.values(sim, &mut self.right);
        }
        let mut event = self.right.iter().any(|g| *g < 0.0);
        let located = event && hop.is_none() && (sim.locates() || sim.locates_surface());
        if located {
            h = self.locate(sim, t0, h);
            event = self.hop.is_none();
        }
        if let Some(size) = hop.filter(|size| !event && *size < FARTHEST) {
            self.hop = Some(2.0 * size);
        }
        sim.metrics.steps += 1;
        let t1 = if h == remaining { until } else { t0 + h };
        self.snapshots(sim, t0, t1, h, observer)?;
        sim.plant.unpack(t1, &self.rk.end);
        sim.flows = layout.flows(&self.rk.end);
        if located {
            // The search may have ended with the plant anywhere in the step.
            sim.plant.evaluate();
        }
        sim.plant.end_impulse(h);
        sim.check_finite()?;
        if sim.plant.is_compliant() {
            if located {
                sim.metrics.events += 1;
                sim.count_in_place()?;
            }
            sim.comply(observer)?;
            sim.measure();
            return Ok(());
        }
        sim.project();
        // Not where no state was found: asking would give the same again.
        let stops = if doubtful { 0.0 } else { sim.slow_to_rest() };
        event |= doubtful || !sim.locates() || self.watch.tolerated_too_much(sim) || stops > 0.0;
        if event {
            sim.metrics.events += u64::from(sim.locates());
            self.watch.suspects(&self.right, &mut sim.suspect);
            sim.decide_with_rest(stops, observer)?;
        } else {
            // Nothing happened: the states held are the one candidate, and the events watched have confirmed it.
            sim.metrics.confirmed += 1;
        }
        self.fresh = event;
        sim.measure();
        Ok(())
    }

    /// Evaluates the start of a step and chooses what to watch in it.
    fn begin(&mut self, sim: &mut Simulation, t0: f64) {
        sim.plant.layout.pack(&sim.plant.state, &sim.flows, &mut self.y);
        self.rk.begin(&mut sim.plant, t0, &self.y);
        sim.plant.follow_directions();
        self.watch.begin(sim);
        self.watch.values(sim, &mut self.start);
    }

    /// Shortens the step just tried to its first event; returns its new size. The plant is left at the event.
    ///
    /// The dense output is of lower order than the step itself (4 and 5, 3 and 4) or another solution of the same, so an
    /// event located on it is missed by the step taken to it. A second step that ends just beyond the event, where its dense output is as good as its
    /// end, settles the difference.
    fn locate(&mut self, sim: &mut Simulation, t0: f64, full: f64) -> f64 {
        let mut h = full;
        let mut near = false;
        for beyond in [1e-4, 1e-7, 0.0] {
            let found = h * self.crossing(sim, t0, h);
            let next = (found * (1.0 + beyond)).min(full);
            if next == h {
                break;
            }
            near = !self.attempt(sim, t0, next);
            h = next;
            if beyond > 0.0 && self.right.iter().all(|g| *g >= 0.0) {
                // The event has moved beyond the new end by more than thought: fall back on the whole step once.
                self.attempt(sim, t0, full);
                h = full;
                near = false;
            }
        }
        // Where a force jumps with the state (a joint meets its stop) the end may lie on the near side of the jump, where
        // nothing has happened yet and nothing would be chosen.
        self.hop = near.then_some(LOCATE * (1.0 + t0));
        h
    }

    /// Tries a step of size `h`. Has an event function reached zero at its end?
    fn attempt(&mut self, sim: &mut Simulation, t0: f64, h: f64) -> bool {
        self.rk.attempt(&mut sim.plant, t0, h);
        self.watch.values(sim, &mut self.scratch);
        // At the final step the values only tell which functions fired, so those located stay.
        if self.scratch.iter().any(|g| *g < 0.0) {
            self.right.copy_from_slice(&self.scratch);
        }
        self.scratch.iter().any(|g| *g <= CLEAR)
    }

    /// First crossing within the step of size `h` just tried, as a fraction of it.
    fn crossing(&mut self, sim: &mut Simulation, t0: f64, h: f64) -> f64 {
        let (rk, dense, watch) = (&self.rk, &mut self.dense, &self.watch);
        self.scratch.copy_from_slice(&self.start);
        self.left.copy_from_slice(&self.start);
        first_crossing(0.0, 1.0, &mut self.left, &mut self.right, &mut self.scratch, LOCATE, |theta, g| {
            rk.interpolate(theta, dense);
            sim.plant.unpack(t0 + theta * h, dense);
            sim.plant.evaluate();
            watch.fill(sim, g);
        })
    }

    /// Logged and sampled instants inside the step, from the dense output; physics never waits for the log.
    fn snapshots(
        &mut self,
        sim: &mut Simulation,
        t0: f64,
        t1: f64,
        h: f64,
        observer: &mut dyn Observer,
    ) -> Result<(), Stop> {
        // What the log asks for is not part of the run's cost.
        let evaluations = sim.plant.evaluations;
        let mut moved = false;
        let due = |next: Option<f64>| next.filter(|&t| t < t1);
        while let Some(t) = due(sim.next_snapshot()).into_iter().chain(due(sim.next_sample())).reduce(f64::min) {
            self.rk.interpolate(((t - t0) / h).clamp(0.0, 1.0), &mut self.dense);
            sim.plant.unpack(t, &self.dense);
            sim.plant.evaluate();
            sim.flows = sim.plant.layout.flows(&self.dense);
            if sim.next_sample() == Some(t) {
                sim.sample_here(observer)?;
            }
            if sim.next_snapshot() == Some(t) {
                sim.tell(observer)?;
            }
            moved = true;
        }
        if moved {
            // Put the plant back to the end of the step.
            sim.plant.unpack(t1, &self.rk.end);
            sim.plant.evaluate();
        }
        sim.plant.evaluations = evaluations;
        Ok(())
    }
}
