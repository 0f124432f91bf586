//! Semi-implicit Euler at the velocity level.
//!
//! ```text
//! (M + dt D + dt^2 K) v+ = (M + dt D + dt^2 K) v + dt (tau - h) + J^T p        q+ = q (+) dt v+
//! ```
//!
//! with D and K the joint damping and servo gains, tau referred to the velocity v (see
//! [`Plant::evaluate_implicit`](crate::sim::plant::Plant::evaluate_implicit)), and p the contact
//! impulses over the step. Contact states are chosen by the same search as impacts, on the
//! velocities at the end of the step: a vertex may close its gap but not enter the floor,
//! `v+_n >= -gap / dt`. First order in dt.

use crate::contact::hybrid::projection::fit_gaps;
use crate::contact::methods::contact_method::Scheme;
use crate::contact::model::problem::Level;
use crate::dynamics::reduced;
use crate::sim::plant::pair_vertices::fastest_side;
use crate::sim::report::Observer;
use crate::sim::run::RunState;
use crate::sim::run_error::RunError;
use crate::sim::termination::{check_finite, diverged};
use nalgebra::Vector3;

/// The semi-implicit Euler stepper of one run.
#[derive(Clone)]
pub struct SemiImplicitStepper {
    dt: f64,
    /// End of the last shortened step, s, and the number of full steps since: their instants are
    /// multiples, not sums.
    full_steps: (f64, u32),
}

impl SemiImplicitStepper {
    /// Steps of `dt` seconds.
    pub fn new(dt: f64) -> Self {
        SemiImplicitStepper { dt, full_steps: (0.0, 0) }
    }

    /// Prepares a run with a method that has forces only within steps: its states and forces at the
    /// start are those of the first step.
    pub fn begin(&mut self, sim: &mut RunState, observer: &mut dyn Observer) -> Result<(), RunError> {
        sim.plant.within = sim.plant.state.time + 0.5 * self.dt;
        self.solve_contact(sim, self.dt, observer)?;
        show_forces(sim, self.dt);
        Ok(())
    }

    /// One step, shortened only to end at `until`.
    pub fn step(&mut self, sim: &mut RunState, until: f64, observer: &mut dyn Observer) -> Result<(), RunError> {
        let t = sim.plant.state.time;
        let remaining = until - t;
        let dt = if remaining < 1.01 * self.dt { remaining } else { self.dt };
        // These contain the forces of the last step and the new commands.
        sim.emit_due_snapshots(t, observer)?;
        if let Some(sampler) = &mut sim.sampler {
            sampler.begin_step(&sim.plant);
        }
        if dt < SHORTEST * self.dt {
            coast(sim, dt, until);
            return Ok(());
        }
        sim.plant.within = t + 0.5 * dt;
        let stored = sim.plant.stored().energy;
        self.solve_contact(sim, dt, observer)?;
        let end = if dt == remaining { until } else { self.instant(t) };
        apply_step(sim, dt, end);
        // Energy stored in the springs is not lost.
        sim.energy.jump_work += sim.plant.stored().energy - stored;
        sim.metrics.steps += 1;
        check_finite(&sim.plant)?;
        if sim.plant.is_compliant() {
            sim.measure_creep();
        }
        sim.measure_step();
        sim.sampler.as_mut().map_or(Ok(()), |sampler| sampler.sample_step(&sim.plant, observer))
    }

    /// The end of a step of full length from `t`.
    fn instant(&mut self, t: f64) -> f64 {
        let of = |(from, count): (f64, u32)| from + f64::from(count) * self.dt;
        if of(self.full_steps) != t || self.full_steps.1 == u32::MAX {
            self.full_steps = (t, 0);
        }
        self.full_steps.1 += 1;
        of(self.full_steps)
    }

    /// Sets up the contact problem of a step at the present state and solves it.
    fn solve_contact(&self, sim: &mut RunState, dt: f64, observer: &mut dyn Observer) -> Result<(), RunError> {
        sim.update_polygons(Some(dt));
        evaluate_step(sim, dt)?;
        sim.update_friction(observer)?;
        sim.measure_energy();
        set_velocity_problem(sim, dt);
        if sim.plant.is_compliant() { sim.compliant_impulse(observer) } else { sim.choose_impulse(observer) }
    }
}

/// Part of a step below which velocities stay as they are. Two instants that differ by rounding, such as the
/// end of a force and a control tick, leave such a remainder: the speeds that close gaps of rounding within it,
/// `gap / dt`, would be those of a real motion.
const SHORTEST: f64 = 1e-6;

/// Moves the plant with its present velocities.
fn coast(sim: &mut RunState, dt: f64, end: f64) {
    let plant = &mut sim.plant;
    plant.write_velocities_times(dt, &mut sim.displacement);
    plant.displace(&sim.displacement);
    plant.state.time = end;
    plant.objects.set_time(end);
    plant.apply_prescribed_positions();
    plant.close_conditions();
    plant.refresh();
}

/// Evaluates a step of size `dt` from the present state.
pub(super) fn evaluate_step(sim: &mut RunState, dt: f64) -> Result<(), RunError> {
    sim.plant.evaluate_implicit(dt);
    match &sim.plant.failure {
        Some(failure) => Err(diverged(&sim.plant, &failure.to_string())),
        None => Ok(()),
    }
}

/// Moves the plant by the step of size `dt` whose contact impulses have been solved for, to the
/// time `end`. The solution then contains forces.
pub(super) fn apply_step(sim: &mut RunState, dt: f64, end: f64) {
    displace(sim, dt);
    let plant = &mut sim.plant;
    plant.add_velocity(&sim.displacement);
    plant.add_present_forces(1.0);
    let nb = plant.model.nb();
    plant.drives.average_over_step(&plant.model, &sim.displacement[nb..], dt);
    plant.update_multipliers_over_step(dt);
    plant.drive_reactions_over_step(&sim.displacement, dt);
    let (flows, jumps) = plant.step_flows(&sim.displacement, dt);
    sim.energy.flows.add(&flows);
    sim.energy.jump_work += jumps;
    plant.drives.advance_lag(&plant.model, &sim.displacement[nb..], dt, &mut plant.state.actuators);
    for object in &mut plant.objects.list {
        object.end_step(&sim.displacement[object.velocities.clone()], dt);
    }
    plant.solution.scale(1.0 / dt);
    plant.evaluate_step_loads(false);
    plant.write_velocities_times(dt, &mut sim.displacement);
    plant.displace(&sim.displacement);
    plant.state.time = end;
    plant.objects.set_time(end);
    plant.apply_prescribed_positions();
    plant.close_conditions();
    plant.refresh();
}

/// Turns the impulses solved for into forces over a step of size `dt`, without moving the plant.
pub(super) fn show_forces(sim: &mut RunState, dt: f64) {
    displace(sim, dt);
    sim.plant.update_multipliers_over_step(dt);
    sim.plant.drive_reactions_over_step(&sim.displacement, dt);
    sim.plant.solution.scale(1.0 / dt);
    sim.plant.evaluate_step_loads(true);
    sim.plant.refresh();
}

/// The change of velocity over the step: v+ - v = dt M^-1 (tau - h) + M^-1 J^T p, in
/// `sim.displacement`.
fn displace(sim: &mut RunState, dt: f64) {
    let plant = &mut sim.plant;
    let mechanisms = plant.objects.mechanisms(&plant.ws);
    reduced::advance(mechanisms, &mut plant.reduced, dt, &plant.solution.wrench, &mut sim.displacement);
}

/// Turns the reduced problem into the velocity-level one of this step.
pub(super) fn set_velocity_problem(sim: &mut RunState, dt: f64) {
    let plant = &mut sim.plant;
    let scheme = plant.method.scheme();
    let mechanisms = plant.objects.mechanisms(&plant.ws);
    let p = &mut plant.problem;
    (p.level, p.step) = (Level::Velocity, dt);
    for ((b, a), v) in p.b.iter_mut().zip(&plant.reduced.a0).zip(&plant.reduced.velocity) {
        *b = v + dt * a;
    }
    for s in 0..p.soles.len() {
        let turning = &mut p.soles[s].turning;
        (turning.bias, turning.spins, turning.rolls) = (Vector3::zeros(), false, false);
        for v in &mut p.soles[s].vertices {
            v.bias = Vector3::zeros();
        }
        // A method that searches at the end of the step clamps only vertices that close their
        // gap within it. One that decides from heights may clamp a vertex up to the distance
        // tolerance above the floor, and stops it there.
        let closes = matches!(scheme, Scheme::EventDriven | Scheme::TimeStepping);
        let fastest = p.soles[s].vertices.iter().map(|v| v.velocity.norm_squared()).fold(0.0, f64::max).sqrt();
        // Impulses elsewhere may stop one of two bodies that move alike, so that the other one reaches it.
        let pair = plant.polygons[s].pair().filter(|_| plant.polygons[s].is_between_mechanisms());
        let speed = pair.map(|patch| fastest_side(patch, mechanisms, &plant.reduced.reference[s]));
        let reach = speed.map_or(0.0, |speed| dt * (speed + dt * plant.gravity.norm()));
        for i in 0..p.soles[s].vertices.len() {
            let free = p.vertex_motion(&p.b, s, i).z;
            let v = &mut p.soles[s].vertices[i];
            // Near: the step may bring the vertex to the floor, possibly because impulses on
            // the other vertices turn the sole as fast as they approached.
            v.near = v.height + dt * free.min(0.0) <= dt * fastest || v.height <= reach;
            v.moving = false;
        }
        let sole = &p.soles[s];
        let gap = match scheme {
            Scheme::EventDriven => fit_gaps(sole, |i| sole.vertices[i].height.max(0.0)),
            Scheme::DecidedPerStep | Scheme::Compliant => Vector3::zeros(),
            // A vertex below the floor is pushed out.
            Scheme::TimeStepping => fit_gaps(sole, |i| sole.vertices[i].height),
        };
        p.soles[s].target = gap * (-1.0 / dt);
        for v in &mut p.soles[s].vertices {
            // The target now contains the gap. Vertices meet the floor at its height: with all
            // points of a sole at one height, tilting has no tangential part.
            if v.near && closes {
                v.r.z -= v.height;
            }
            v.height = if v.near && closes { v.height.min(0.0) } else { v.height };
        }
    }
}
