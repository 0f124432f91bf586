//! Drift: what rounding and integration error leave in the clamped directions is projected out after every step.
//!
//! Errors of velocity and position in the clamped directions are removed by the mass-weighted least change
//! `dq = M^-1 J^T w` with `R (J dq + e) = 0` (`contact.md` section 8): the candidate solve at the velocity level, without
//! friction, with the errors in the place of the free motion. A static sole is tied to the place of its vertices when
//! it was clamped, a sliding one to their heights.

use super::simulation::Simulation;
use crate::contact::model::problem::{Level, SoleProblem};
use crate::dynamics::reduced;
use nalgebra::{Matrix2, Vector2, Vector3};

/// Least-squares plane through values at the vertices: value at the reference point and the small rotation (about x and
/// y) whose normal motion `t_x r_y - t_y r_x` follows the rest.
pub fn fit_plane(sole: &SoleProblem, value: impl Fn(usize) -> f64) -> Vector3<f64> {
    let k = sole.vertices.len();
    let mean = (0..k).map(&value).sum::<f64>() / k as f64;
    let (mut a, mut b) = (Matrix2::zeros(), Vector2::zeros());
    for (i, v) in sole.vertices.iter().enumerate() {
        let row = Vector2::new(v.r.y, -v.r.x);
        a += row * row.transpose();
        b += row * (value(i) - mean);
    }
    let tilt = if k > 2 { a.try_inverse().map_or(Vector2::zeros(), |a| a * b) } else { Vector2::zeros() };
    Vector3::new(mean, tilt.x, tilt.y)
}

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
        p.level = Level::Velocity;
        p.b.copy_from_slice(&plant.reduced.velocity);
        for sole in &mut p.soles {
            sole.target = Vector3::zeros();
            for v in &mut sole.vertices {
                v.bias = Vector3::zeros();
                v.direction = Vector2::zeros();
            }
        }
        plant.method.respond(p, &plant.states, &mut self.projection);
        reduced::apply(&plant.model, &plant.ws, &mut plant.reduced, &self.projection.wrench, &mut plant.state.v);
    }

    fn project_position(&mut self) {
        let plant = &mut self.plant;
        let p = &mut plant.problem;
        p.b.fill(0.0);
        let mut drift: f64 = 0.0;
        for s in 0..p.soles.len() {
            let state = plant.states[s];
            if state.normal_rows() == 0 {
                continue;
            }
            let origin = plant.floor.to_floor(&(plant.reduced.reference[s] - plant.floor.point));
            let k = p.soles[s].vertices.len();
            let mut error = [Vector3::zeros(); 64];
            for (i, error) in error.iter_mut().enumerate().take(k) {
                *error = origin + p.soles[s].vertices[i].r - self.anchors[s][i];
                if state.is_dynamic() {
                    *error = Vector3::new(0.0, 0.0, error.z);
                }
                if state.clamps(i, k) {
                    drift = drift.max(error.norm());
                    if state.is_static() {
                        self.metrics.max_static_creep_m = self.metrics.max_static_creep_m.max(error.norm());
                    }
                }
            }
            let sole = &mut p.soles[s];
            if state.normal_rows() == 3 {
                let normal = fit_plane(sole, |i| error[i].z);
                let mean: Vector2<f64> = error[..k].iter().map(|e| e.xy()).sum::<Vector2<f64>>() / k as f64;
                let inertia: f64 = sole.vertices.iter().map(|v| v.r.xy().norm_squared()).sum();
                let yaw: f64 =
                    sole.vertices.iter().zip(&error).map(|(v, e)| v.r.xy().perp(&e.xy())).sum::<f64>() / inertia;
                p.b[6 * s..6 * s + 6].copy_from_slice(&[mean.x, mean.y, normal.x, normal.y, normal.z, yaw]);
            } else {
                sole.vertices.iter_mut().zip(&error).for_each(|(v, e)| v.bias = *e);
            }
        }
        self.metrics.max_projection_m = self.metrics.max_projection_m.max(drift);
        if drift == 0.0 {
            return;
        }
        plant.method.respond(p, &plant.states, &mut self.projection);
        self.displacement.fill(0.0);
        reduced::apply(&plant.model, &plant.ws, &mut plant.reduced, &self.projection.wrench, &mut self.displacement);
        plant.state.displace(&self.displacement);
    }
}
