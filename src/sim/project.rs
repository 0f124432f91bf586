//! Projection of drift out of a run's state, see [`crate::contact::hybrid::projection`].

use super::simulation::Simulation;
use crate::contact::hybrid::projection;
use crate::dynamics::reduced;

/// Remembers where the vertices of sole `s` are. Where events are located, those that touch belong on the floor itself.
pub fn anchor(sim: &mut Simulation, s: usize) {
    let on_floor = if sim.locates() { 2.0 * sim.tolerances.distance } else { 0.0 };
    let sole = &sim.plant.problem.soles[s];
    let origin = sim.plant.sole_origin(s);
    for (place, v) in sim.anchors[s].iter_mut().zip(&sole.vertices) {
        *place = origin + v.r;
        if place.z.abs() <= on_floor {
            place.z = 0.0;
        }
    }
}

impl Simulation {
    /// Projects velocity and position errors of the clamped soles out of the plant's state. Needs an evaluation at it.
    pub fn project(&mut self) {
        if (0..self.plant.problem.soles.len()).all(|s| self.plant.states[s].normal_rows() == 0) {
            return;
        }
        self.project_velocity();
        self.project_position();
    }

    fn project_velocity(&mut self) {
        let plant = &mut self.plant;
        let p = &mut plant.problem;
        projection::set_velocity_errors(p, &plant.reduced.velocity);
        plant.method.respond(p, &plant.states, &mut self.projection);
        reduced::apply(&plant.model, &plant.ws, &mut plant.reduced, &self.projection.wrench, &mut plant.state.v);
    }

    fn project_position(&mut self) {
        let plant = &mut self.plant;
        let p = &mut plant.problem;
        let (floor, reference) = (&plant.floor, &plant.reduced.reference);
        let origin = |s: usize| floor.to_floor(&(reference[s] - floor.point));
        let drift = projection::set_position_errors(p, &plant.states, origin, &self.anchors);
        self.metrics.max_static_creep_m = self.metrics.max_static_creep_m.max(drift.of_static);
        self.metrics.max_projection_m = self.metrics.max_projection_m.max(drift.greatest);
        if drift.greatest == 0.0 {
            return;
        }
        plant.method.respond(p, &plant.states, &mut self.projection);
        self.displacement.fill(0.0);
        reduced::apply(&plant.model, &plant.ws, &mut plant.reduced, &self.projection.wrench, &mut self.displacement);
        plant.state.displace(&self.displacement);
    }
}
