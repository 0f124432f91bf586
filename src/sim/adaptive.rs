//! Adaptive stepping with located events.
//!
//! A step integrates with the contact states held. Event functions, all positive while those states stay true, are
//! watched at the end of the step; when one has changed sign, the first crossing is located on the dense output, the
//! step is taken again to that instant, and the states are chosen anew. After every step the drift of clamped soles is
//! projected out.

use super::error::Stop;
use super::simulation::Simulation;
use super::watch::{MAX_WATCHED, Watch};
use crate::integrate::event::first_crossing;
use crate::integrate::{Dopri5, StepControl};
use crate::sim::Observer;

/// Width to which an event is located, relative to its step.
const LOCATE: f64 = 1e-13;
/// Smallest step relative to the time scale of the run, s.
const SMALLEST: f64 = 1e-13;

/// The adaptive integrator of one run.
pub struct Adaptive {
    rk: Dopri5,
    control: StepControl,
    relative: f64,
    absolute: f64,
    max_step: f64,
    h: f64,
    /// The integrator's vector.
    y: Vec<f64>,
    dense: Vec<f64>,
    watch: Watch,
    left: Vec<f64>,
    right: Vec<f64>,
    scratch: Vec<f64>,
}

impl Adaptive {
    /// For vectors of this length.
    pub fn new(n: usize, relative: f64, absolute: f64, max_step: f64) -> Self {
        Adaptive {
            rk: Dopri5::new(n),
            control: StepControl::new(5),
            relative,
            absolute,
            max_step,
            h: max_step.min(1e-3),
            y: vec![0.0; n],
            dense: vec![0.0; n],
            watch: Watch::default(),
            left: Vec::with_capacity(MAX_WATCHED),
            right: Vec::with_capacity(MAX_WATCHED),
            scratch: Vec::with_capacity(MAX_WATCHED),
        }
    }

    /// Takes one step towards `until` (never beyond), with whatever event it meets.
    pub fn step(&mut self, sim: &mut Simulation, until: f64, observer: &mut dyn Observer) -> Result<(), Stop> {
        let t0 = sim.plant.state.time;
        let layout = sim.plant.layout;
        layout.pack(&sim.plant.state, &mut self.y);
        self.y[layout.work()] = sim.work;
        let remaining = until - t0;
        let mut h = self.h.min(self.max_step).min(remaining);
        // Do not leave a sliver before the stop.
        if remaining - h < 0.01 * h {
            h = remaining;
        }
        sim.plant.within = t0 + 0.5 * h;
        self.rk.begin(&mut sim.plant, t0, &self.y);
        self.watch.begin(sim);
        self.watch.values(sim, &mut self.left);
        loop {
            sim.plant.within = t0 + 0.5 * h;
            let error = self.rk.attempt(&mut sim.plant, t0, h, self.relative, self.absolute, layout.controlled());
            let factor = self.control.factor(error);
            if error <= 1.0 {
                if h < remaining || factor < 1.0 {
                    self.h = h * factor;
                }
                break;
            }
            sim.metrics.rejected_steps += 1;
            h *= factor;
            if !(h > SMALLEST * (1.0 + t0)) {
                return Err(sim.diverged("the step size collapsed"));
            }
        }
        // The last stage was evaluated at the end of the step, so the plant stands there.
        self.watch.values(sim, &mut self.right);
        let mut event = self.right.iter().any(|g| *g < 0.0);
        if event && sim.locates() {
            let (rk, dense, watch) = (&self.rk, &mut self.dense, &self.watch);
            self.scratch.resize(self.right.len(), 0.0);
            let theta =
                first_crossing(0.0, 1.0, &mut self.left, &mut self.right, &mut self.scratch, LOCATE, |theta, g| {
                    rk.interpolate(theta, dense);
                    sim.plant.layout.unpack(t0 + theta * h, dense, &mut sim.plant.state);
                    sim.plant.evaluate();
                    watch.fill(sim, g);
                });
            if theta < 1.0 {
                h *= theta;
                self.rk.attempt(&mut sim.plant, t0, h, self.relative, self.absolute, layout.controlled());
            } else {
                sim.plant.layout.unpack(t0 + h, &self.rk.end, &mut sim.plant.state);
                sim.plant.evaluate();
            }
        }
        sim.metrics.steps += 1;
        let t1 = if h == remaining { until } else { t0 + h };
        self.snapshots(sim, t0, t1, h, observer)?;
        layout.unpack(t1, &self.rk.end, &mut sim.plant.state);
        sim.work = self.rk.end[layout.work()];
        sim.check_finite()?;
        sim.project();
        event |= !sim.locates() || self.watch.tolerated_too_much(sim);
        if event {
            sim.metrics.events += u64::from(sim.locates());
            self.watch.suspects(&self.right, &mut sim.suspect);
            sim.decide(observer)?;
        }
        sim.measure();
        Ok(())
    }

    /// Logged instants inside the step, from the dense output; physics never waits for the log.
    fn snapshots(
        &mut self,
        sim: &mut Simulation,
        t0: f64,
        t1: f64,
        h: f64,
        observer: &mut dyn Observer,
    ) -> Result<(), Stop> {
        let mut moved = false;
        while let Some(t) = sim.next_snapshot().filter(|&t| t < t1) {
            self.rk.interpolate(((t - t0) / h).clamp(0.0, 1.0), &mut self.dense);
            sim.plant.layout.unpack(t, &self.dense, &mut sim.plant.state);
            sim.plant.evaluate();
            sim.tell(observer)?;
            moved = true;
        }
        if moved {
            // Put the plant back to the end of the step.
            sim.plant.layout.unpack(t1, &self.rk.end, &mut sim.plant.state);
            sim.plant.evaluate();
        }
        Ok(())
    }
}
