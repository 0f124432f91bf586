//! Removal of drift from a run's state, see [`crate::contact::hybrid::projection`].
//!
//! Where the conditions of the clamped vertices are almost redundant, such as those of dominoes that lean on
//! each other, the change that removes an error may be larger than it by many orders. An error is then left
//! until the bodies have moved on; so is slow motion that a new state does not allow.

use crate::contact::hybrid::projection;
use crate::contact::model::problem::{Problem, SoleProblem};
use crate::contact::model::state::{Mode, States};
use crate::dynamics::reduced;
use crate::sim::plant::Polygon;
use crate::sim::run::RunState;
use nalgebra::Vector3;

/// Greatest change of a contact frame, relative to the error that it removes, beyond rounding, m or m/s.
const MOST_CHANGE: f64 = 1e4;
const ROUNDING: f64 = 1e-12;
/// Greatest velocity error that counts as drift where events are located, m/s. Steps leave less by orders; more is left
/// where the plane of a patch has turned within a step, as that of two almost parallel edges may.
const MOST_DRIFT: f64 = 1e-3;
/// Greatest shift, m, beyond `MOST_SHIFT` times the error.
const SMALL_SHIFT: f64 = 1e-4;
const MOST_SHIFT: f64 = 10.0;

/// Stores the positions of the vertices of sole `s`. Where events are located, touching vertices
/// are placed on the floor itself.
pub fn anchor(sim: &mut RunState, s: usize) {
    (0..sim.anchors[s].len()).for_each(|i| anchor_vertex(sim, s, i));
}

/// Stores the position of one vertex.
pub fn anchor_vertex(sim: &mut RunState, s: usize, i: usize) {
    if let Polygon::Pair(patch) = &mut sim.plant.polygons[s] {
        patch.anchor(i);
        return;
    }
    let on_floor = if sim.locates_events() { 2.0 * sim.tolerances.distance } else { 0.0 };
    let mut anchor = sim.plant.sole_origin(s) + sim.plant.problem.soles[s].vertices[i].r;
    if anchor.z.abs() <= on_floor {
        anchor.z = 0.0;
    }
    sim.anchors[s][i] = anchor;
}

impl RunState {
    /// Projects velocity and position errors of the clamped soles out of the plant's state. Needs
    /// an evaluation at it. Returns false, and leaves the state, if the velocities are not drift: contact states are to
    /// be chosen again.
    pub(in crate::sim) fn project_drift(&mut self) -> bool {
        if self.is_clamped() {
            self.solve_velocity_errors();
            let error = self.velocity_error(&self.plant.states);
            if self.is_projectable(error) {
                if self.locates_events() && error > MOST_DRIFT {
                    return false;
                }
                self.plant.add_impulses(&self.projection.wrench);
            }
            self.project_position();
        }
        true
    }

    /// The same after a step of a sliding mode, which may leave a vertex closing its gap: stopping it is
    /// an impact, whose energy enters the balance.
    pub(in crate::sim) fn stop_and_project_drift(&mut self) {
        if self.is_clamped() {
            self.solve_velocity_errors();
            if self.is_projectable(self.velocity_error(&self.plant.states)) {
                let jump = self.plant.apply_impulses(&self.projection.wrench);
                self.energy.add_jump(jump);
            }
            self.project_position();
        }
    }

    fn is_clamped(&self) -> bool {
        (0..self.plant.problem.soles.len()).any(|s| self.plant.states[s].normal_rows() > 0)
    }

    /// Solves for the impulses that remove velocity errors, in `self.projection`.
    fn solve_velocity_errors(&mut self) {
        let plant = &mut self.plant;
        projection::set_velocity_errors(&mut plant.problem, &plant.reduced.velocity);
        plant.method.respond(&plant.problem, &plant.states, &mut self.projection);
    }

    /// The greatest velocity in a direction that these states clamp, m/s.
    pub(super) fn velocity_error(&self, states: &States) -> f64 {
        let p = &self.plant.problem;
        let error = |(s, i): (usize, usize)| {
            let v = p.vertex_motion(&p.b, s, i);
            match states[s].clamps(i, p.soles[s].vertices.len()) {
                false => 0.0,
                true if states[s].is_static() || states[s].mode == Mode::Pivoting(i as u8) => v.norm(),
                true => v.z.abs(),
            }
        };
        // At a lever of a metre.
        let turning = p.turning(states).map(|(s, turning)| {
            let motion = p.turning_motion(&p.b, s);
            let held = |holds: bool, speed: f64| if holds { speed } else { 0.0 };
            held(turning.holds_roll(), motion.xy().norm()).max(held(turning.holds_spin(), motion.z.abs()))
        });
        p.vertex_indices().map(error).chain(turning).fold(0.0, f64::max)
    }

    /// Whether the change in `self.projection` is in proportion to the error that it removes. Always without
    /// located events: steps then leave errors, and impacts, of any size.
    pub(super) fn is_projectable(&self, error: f64) -> bool {
        !self.locates_events() || self.greatest_change() <= MOST_CHANGE * error + ROUNDING
    }

    /// The same of a change of positions.
    fn is_shift_projectable(&self, error: f64) -> bool {
        let is_small = || self.greatest_change() <= SMALL_SHIFT.max(MOST_SHIFT * error);
        self.is_projectable(error) && (!self.locates_events() || is_small())
    }

    /// Greatest change of a contact frame in `self.projection`, m or m/s.
    fn greatest_change(&self) -> f64 {
        let p = &self.plant.problem;
        let frames = self.projection.motion.chunks_exact(6).zip(p.b.chunks_exact(6)).zip(&p.soles);
        let change = |((m, b), sole): ((&[f64], &[f64]), &SoleProblem)| {
            let part = |k: usize| Vector3::from_fn(|i, _| m[k + i] - b[k + i]).norm();
            part(0) + sole.radius * part(3)
        };
        frames.map(change).fold(0.0, f64::max)
    }

    fn project_position(&mut self) {
        let plant = &mut self.plant;
        let p = &mut plant.problem;
        let (floor, reference) = (&plant.floor, &plant.reduced.reference);
        let (polygons, anchors) = (&plant.polygons, &self.anchors);
        let error = |p: &Problem, s: usize, i: usize| match &polygons[s] {
            Polygon::Floor(_) => {
                floor.to_floor(&(reference[s] - floor.point)) + p.soles[s].vertices[i].r - anchors[s][i]
            }
            Polygon::Pair(patch) => patch.error(i),
        };
        let drift = projection::set_position_errors(p, &plant.states, error);
        self.metrics.max_static_creep_m = self.metrics.max_static_creep_m.max(drift.of_static);
        self.metrics.max_projection_m = self.metrics.max_projection_m.max(drift.greatest);
        if drift.greatest == 0.0 {
            return;
        }
        plant.method.respond(p, &plant.states, &mut self.projection);
        if !self.is_shift_projectable(drift.greatest) {
            return;
        }
        let plant = &mut self.plant;
        let mechanisms = plant.objects.mechanisms(&plant.ws);
        reduced::apply(mechanisms, &mut plant.reduced, &self.projection.wrench, &mut self.displacement);
        plant.displace(&self.displacement);
        // The displacement is along the conditions of couplings and loops; what they curve away is left.
        plant.close_conditions();
    }
}
