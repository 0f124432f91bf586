//! Stiffness of friction at slow sliding vertices, as the stiff part of a step.
//!
//! Friction `-mu_k N u` of a vertex turns with its direction u, which depends on its tangential
//! velocity `t = J(x) q'`, x the configuration. With theta the angle of u, the acceleration q'' of
//! the robot depends on the state (x, q') through
//!
//! ```text
//! A = sum_i (dq''/dtheta_i) (dtheta_i/dt_i . [dt_i/dx, J_i])       |dtheta/dt| = 1 / |t|  for |t| >= v_d
//! ```
//!
//! The powers of the energy flows depend on theta likewise, as normal forces respond to directions: a
//! column has their derivatives too, without which a stiff step has another order for the flows than
//! for the motion.
//!
//! The eigenvalues are some `-mu_k N / (m |t|)`, m the mass that the vertex feels: 1e7 1/s at 1e-6
//! m/s. Near a jam normal forces respond to directions, and they are a hundred times as high. The
//! derivatives by directions are difference quotients, of contact solves at one configuration.
//!
//! The slope of the solution has, along the rows, the rate at which directions turn,
//!
//! ```text
//! theta' = dtheta/dt . (J q'' + J' q')          J' q' = dt/dx x'
//! ```
//!
//! Stiff friction keeps this near zero: the sum is small, its terms, over |t|, are not. With J alone
//! a step would leave the slow motion by `h J' q'`, which turns a slow vertex far beyond the range
//! in which A is the derivative. The configuration moves along x' to first order in the step, so of
//! dt/dx only its product with x' matters. The rows have the least entries with that product,
//! `(dtheta/dt . J' q') x'^T / |x'|^2`.

use super::Plant;
use super::sliding_directions::direction;
use crate::contact::model::state::Mode;
use crate::dynamics::reduced;
use crate::integrate::StiffPart;
use nalgebra::{Vector2, Vector3};

/// Greatest number of sliding vertices whose friction is in the stiff part.
pub const MOST_VERTICES: usize = 32;

/// Turn of a direction in a difference quotient, rad. Truncation 1e-6 of the derivative; W-methods
/// need no exact derivative.
const TURN: f64 = 1e-6;
/// Change of a velocity in a difference quotient, relative to the velocity.
const SPAN: f64 = 1e-5;

impl Plant {
    /// Estimate of the rate at which friction turns sliding vertices, 1/s, from the last evaluation:
    /// their own normal forces and the responses of their soles alone. Too low near a jam.
    pub fn friction_rate_estimate(&self) -> f64 {
        let n = self.problem.dim();
        let mut estimate: f64 = 0.0;
        for (s, i) in self.sliding_vertices() {
            let v = &self.problem.soles[s].vertices[i];
            let block = |r: usize, c: usize| self.problem.w[(6 * s + r) * n + 6 * s + c];
            // Trace of the response at the vertex to tangential forces there.
            let (x, y) = (v.r.x, v.r.y);
            let linear = block(0, 0) + block(1, 1);
            let response = linear - 2.0 * y * block(0, 5) + 2.0 * x * block(1, 5) + (x * x + y * y) * block(5, 5);
            // Below v_d the direction turns by at most a few 1 / v_d.
            let speed = v.velocity.xy().norm().max(0.5 * self.direction_speed(s));
            estimate += v.mu_k * self.solution.normal[s][i].abs() * response / speed;
        }
        estimate
    }

    /// Sliding vertices but pivots, as sole and vertex; none where friction is regularised.
    fn sliding_vertices(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let polygons = if self.is_compliant() { 0 } else { self.problem.soles.len() };
        self.problem.soles.iter().enumerate().take(polygons).flat_map(move |(s, sole)| {
            let (state, k) = (self.states[s], sole.vertices.len());
            let slides =
                move |i: &usize| state.is_dynamic() && state.clamps(*i, k) && state.mode != Mode::Pivoting(*i as u8);
            (0..k).filter(slides).map(move |i| (s, i))
        })
    }

    /// Adds the stiffness at the last evaluation: a product for each sliding vertex, the first
    /// [`MOST_VERTICES`] if there are more. Leaves the evaluation as it was.
    pub fn friction_stiffness(&mut self, out: &mut StiffPart) {
        let mut vertices = [(0, 0); MOST_VERTICES];
        let mut number = 0;
        for (slot, vertex) in vertices.iter_mut().zip(self.sliding_vertices()) {
            *slot = vertex;
            number += 1;
        }
        let (configuration, velocities) = (self.layout.configuration(), self.layout.velocities());
        let flows = self.layout.controlled()..self.layout.size();
        for &(s, i) in &vertices[..number] {
            let Some((entries, column)) = out.add() else { return };
            let v = self.problem.soles[s].vertices[i];
            let (t, u) = (v.velocity.xy(), v.direction);
            let (slow, reference) = (self.direction_speed(s), self.directions[s][i]);
            let step = SPAN * t.norm().max(1e-3 * slow);
            let turn = |d: Vector2<f64>| u.perp(&direction(&(t + d), &reference, slow));
            let slope = |d: Vector2<f64>| (turn(d * step) - turn(-d * step)) / (2.0 * step);
            // Truncation must not depend on the world's axes.
            let across = Vector2::new(-u.y, u.x);
            let gradient = u * slope(u) + across * slope(across);
            let turning = gradient.dot(&self.problem.vertex_motion(&self.solution.motion, s, i).xy());
            let axes = &self.reduced.axes[s];
            let gradient = axes * Vector3::new(gradient.x, gradient.y, 0.0);
            let point = self.reduced.reference[s] + axes * v.r;
            // The column is scratch for the row.
            let row = &mut *column;
            self.layout.configuration_rates(0, self.state.rotation.quaternion(), &self.state.v, row);
            for (o, object) in self.objects.list.iter().enumerate() {
                let (q, v) = (object.state.rotation.quaternion(), &object.state.v);
                self.layout.configuration_rates(1 + o, q, v, row);
            }
            let velocity_row = &mut row[velocities.clone()];
            reduced::add_point_row(
                self.objects.mechanisms(&self.ws),
                &self.reduced,
                s,
                &point,
                &gradient,
                velocity_row,
            );
            self.kinematic_paths.joints().iter().for_each(|j| self.layout.hold(*j, row));
            let by_velocity: f64 = row[velocities.clone()].iter().zip(&self.acceleration).map(|(v, a)| v * a).sum();
            let rates = &mut row[configuration.clone()];
            let square: f64 = rates.iter().map(|rate| rate * rate).sum();
            let factor = if square > 0.0 { (turning - by_velocity) / square } else { 0.0 };
            rates.iter_mut().for_each(|rate| *rate *= factor);
            entries.extend(row.iter().copied().enumerate().filter(|(_, x)| *x != 0.0));
            self.respond_with(s, i, u + across * TURN);
            column.fill(0.0);
            column[velocities.clone()].copy_from_slice(&self.acceleration);
            column[flows.clone()].copy_from_slice(&self.powers().0);
            self.respond_with(s, i, u);
            let powers = self.powers().0;
            let changes = column[velocities.clone()].iter_mut().zip(&self.acceleration);
            changes.for_each(|(c, a)| *c = (*c - a) / TURN);
            column[flows.clone()].iter_mut().zip(&powers).for_each(|(c, p)| *c = (*c - p) / TURN);
            self.kinematic_paths.joints().iter().for_each(|j| self.layout.hold(*j, column));
        }
    }

    /// Contact wrenches and accelerations with another direction of one vertex.
    fn respond_with(&mut self, s: usize, i: usize, direction: Vector2<f64>) {
        self.problem.soles[s].vertices[i].direction = direction;
        self.method.respond(&self.problem, &self.states, &mut self.solution);
        self.close();
    }
}
