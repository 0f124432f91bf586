//! Semi-implicit Euler at the velocity level.
//!
//! ```text
//! (M + dt D + dt^2 K) v+ = (M + dt D + dt^2 K) v + dt (tau - h) + J^T p        q+ = q (+) dt v+
//! ```
//!
//! with D and K the joint damping and servo gains, tau referred to the velocity v (see
//! [`super::plant::Plant::evaluate_implicit`]), and p the contact impulses over the step. Contact states are chosen by
//! the same kernel as impacts, on the velocities that the step would end with: a vertex may close its gap but not
//! enter the floor, `v+_n >= -gap / dt`. First order in dt.

use super::error::Stop;

use super::report::Observer;
use super::simulation::Simulation;
use crate::contact::hybrid::projection::fit_plane;
use crate::contact::methods::contact_method::{Scheme, SelectionInput};
use crate::contact::model::problem::Level;
use crate::contact::model::state::SoleState;
use crate::dynamics::reduced;
use nalgebra::Vector3;

/// See the module.
pub struct Fixed {
    dt: f64,
    /// Where the steps since the last one that was shortened began, s, and how many they are: their instants are multiples, not
    /// sums.
    run: (f64, u32),
}

impl Fixed {
    /// Steps of `dt` seconds.
    pub fn new(dt: f64) -> Self {
        Fixed { dt, run: (0.0, 0) }
    }

    /// Prepares the run of a method that has no forces outside a step: its states and forces at the start are those of
    /// the first step.
    pub fn look_ahead(&mut self, sim: &mut Simulation, observer: &mut dyn Observer) -> Result<(), Stop> {
        sim.plant.within = sim.plant.state.time + 0.5 * self.dt;
        self.decide(sim, self.dt, observer)?;
        self.displace(sim, self.dt);
        sim.plant.react_to_step(&sim.displacement, self.dt);
        sim.plant.solution.scale(1.0 / self.dt);
        sim.plant.refresh();
        Ok(())
    }

    /// One step, shortened only to end at `until`.
    pub fn step(&mut self, sim: &mut Simulation, until: f64, observer: &mut dyn Observer) -> Result<(), Stop> {
        let t = sim.plant.state.time;
        let remaining = until - t;
        let dt = if remaining < 1.01 * self.dt { remaining } else { self.dt };
        // With the forces of the step that led here and what the joints are asked from now on.
        sim.snapshot_now(t, observer)?;
        sim.begin_samples();
        sim.plant.within = t + 0.5 * dt;
        let stored = sim.plant.stored().energy;
        self.decide(sim, dt, observer)?;
        self.displace(sim, dt);
        let plant = &mut sim.plant;
        plant.state.v.iter_mut().zip(&sim.displacement).for_each(|(v, dv)| *v += dv);
        plant.share_forces();
        plant.take_step_impulse();
        plant.drive_over(&sim.displacement, dt);
        plant.react_to_step(&sim.displacement, dt);
        let (flows, jumps) = plant.step_flows(&sim.displacement, dt);
        sim.flows.add(&flows);
        sim.work += jumps;
        plant.lag_over(&sim.displacement, dt);
        plant.solution.scale(1.0 / dt);
        plant.state.v.iter().zip(&mut sim.displacement).for_each(|(v, d)| *d = v * dt);
        plant.state.displace(&sim.displacement);
        plant.state.time = if dt == remaining { until } else { self.instant(t) };
        plant.arrive();
        plant.refresh();
        // What the springs have taken is not lost.
        sim.work += plant.stored().energy - stored;
        sim.metrics.steps += 1;
        sim.check_finite()?;
        if sim.plant.is_compliant() {
            sim.creep();
        }
        sim.measure();
        sim.sample_step(observer)
    }

    /// The end of a step of full length from `t`.
    fn instant(&mut self, t: f64) -> f64 {
        let of = |(from, count): (f64, u32)| from + f64::from(count) * self.dt;
        if of(self.run) != t || self.run.1 == u32::MAX {
            self.run = (t, 0);
        }
        self.run.1 += 1;
        of(self.run)
    }

    /// The change of velocity over the step: v+ - v = dt M^-1 (tau - h) + M^-1 J^T p, in `sim.displacement`.
    fn displace(&self, sim: &mut Simulation, dt: f64) {
        let plant = &mut sim.plant;
        sim.displacement.iter_mut().zip(&plant.acceleration).for_each(|(d, a)| *d = dt * a);
        reduced::apply(&plant.model, &plant.ws, &mut plant.reduced, &plant.solution.wrench, &mut sim.displacement);
    }

    /// Poses the problem of a step at the present state and solves it.
    fn decide(&self, sim: &mut Simulation, dt: f64, observer: &mut dyn Observer) -> Result<(), Stop> {
        sim.plant.evaluate_implicit(dt);
        if let Some(failure) = sim.plant.failure {
            return Err(sim.diverged(&failure.to_string()));
        }
        sim.find_friction(observer)?;
        sim.audit();
        self.pose(sim, dt);
        if sim.plant.is_compliant() { sim.comply_for_step(observer) } else { sim.choose_impulse(observer) }
    }

    /// Turns the reduced problem into the velocity-level one of this step.
    fn pose(&self, sim: &mut Simulation, dt: f64) {
        let plant = &mut sim.plant;
        let manner = plant.method.scheme();
        let p = &mut plant.problem;
        (p.level, p.step) = (Level::Velocity, dt);
        for ((b, a), v) in p.b.iter_mut().zip(&plant.reduced.a0).zip(&plant.reduced.velocity) {
            *b = v + dt * a;
        }
        for s in 0..p.soles.len() {
            for v in &mut p.soles[s].vertices {
                v.bias = Vector3::zeros();
            }
            // Only a method that looks where the step leads clamps just what closes its gap within it. One that decides
            // from heights may clamp a vertex a whole distance tolerance up, and stops it there.
            let closes = matches!(manner, Scheme::EventDriven | Scheme::TimeStepping);
            let gap = fit_plane(&p.soles[s], |i| match manner {
                Scheme::EventDriven => p.soles[s].vertices[i].height.max(0.0),
                Scheme::DecidedPerStep | Scheme::Compliant => 0.0,
                // What is below the floor comes up again.
                Scheme::TimeStepping => p.soles[s].vertices[i].height,
            });
            p.soles[s].target = gap * (-1.0 / dt);
            let fastest = p.soles[s].vertices.iter().map(|v| v.velocity.norm()).fold(0.0, f64::max);
            for i in 0..p.soles[s].vertices.len() {
                let free = p.vertex_motion(&p.b, s, i).z;
                let v = &mut p.soles[s].vertices[i];
                // Near: what this step could bring to the floor, be it because the impulses on the other vertices turn it there
                // as fast as they came.
                v.near = v.height + dt * free.min(0.0) <= dt * fastest || v.height <= 0.0;
                v.moving = false;
                // The gap is in the target now, and what meets the floor does so on the floor: with all points of a sole at
                // one height its tilting has no tangential part.
                if v.near && closes {
                    v.r.z -= v.height;
                }
                v.height = if v.near && closes { v.height.min(0.0) } else { v.height };
            }
        }
    }
}

impl Simulation {
    /// Snapshots due up to `t`; fixed steps log the first state at or after the instant.
    pub(super) fn snapshot_now(&mut self, t: f64, observer: &mut dyn Observer) -> Result<(), Stop> {
        while self.next_snapshot().is_some_and(|due| due <= t + 1e-12) {
            self.tell(observer)?;
        }
        Ok(())
    }

    /// Chooses states and impulses of this step.
    fn choose_impulse(&mut self, observer: &mut dyn Observer) -> Result<(), Stop> {
        let rules = self.rules();
        let forced = self.forced(self.plant.state.time);
        let allowed = |s: usize, state: SoleState| forced[s].is_none_or(|f: SoleState| f.pattern == state.pattern);
        let input = SelectionInput { rules: &rules, event: false, allowed: &allowed };
        self.freeze(observer, &input, &forced);
        let plant = &mut self.plant;
        let selection = plant.method.impulse(&mut plant.problem, &input, &mut plant.solution);
        self.freeze_answer(observer, &selection)?;
        self.count(&selection);
        if !selection.consistent && !self.all_imposed(&selection.verdict) {
            let message = format!("no contact state is valid; least violations {:?}", selection.verdict.levels);
            self.inconsistent(observer, &message)?;
        }
        self.adopt(selection.states, observer)
    }
}
