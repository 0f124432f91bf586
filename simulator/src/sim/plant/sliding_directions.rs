//! Sliding directions, which friction opposes. They approach a reference while a vertex is too slow
//! for its direction to be known.
//!
//! ```text
//! d = (t - 2 min(0, t . r) r) / |t|      (friction does not turn at zero speed, r: the reference)
//! u = d                                   for |t| >= v_d
//! u = ((1 - s) r + s d) / |...|           for |t| < v_d,   s = x^2 (3 - 2 x),  x = |t| / v_d
//! v_d = max(1e-7 m/s, sum over the speeds that move the sole of (absolute + relative |v_j|))
//! (of the base: over x and y together and z of its velocity and angular velocity)
//! ```
//!
//! with t the tangential velocity of the vertex and the tolerances of the integrator
//! (`docs/contact.md`, section 7). Where t opposes r, an event, d continues as the mirror image of t.
//! u is continuous in t. A jump at v_d would stop the error control of steps, and a jump at the event
//! that of its location: a vertex slower than v_d could remain at it.

use super::Plant;
use crate::contact::model::problem::Vertex;
use crate::dynamics::reduced::BodyId;
use nalgebra::Vector2;
use std::ops::Range;

/// Speed below which a sliding vertex keeps its reference direction, m/s. Rounding (1e-16 m/s)
/// turns the direction of a slower vertex by more than 1e-9 rad, while friction passes through such
/// speeds within 1e-7 / (mu g), some 1e-8 s.
pub const DIRECTION_SPEED: f64 = 1e-7;

/// Sliding direction of a vertex with tangential velocity `t`; the law of this module.
pub(super) fn direction(t: &Vector2<f64>, reference: &Vector2<f64>, slow: f64) -> Vector2<f64> {
    let speed = t.norm();
    // A vertex without reference has no direction until it is fast enough.
    if !(speed > 0.0) || speed < slow && *reference == Vector2::zeros() {
        return *reference;
    }
    let opposing = t.dot(reference).min(0.0);
    let own = (t - reference * (2.0 * opposing)) / speed;
    if speed >= slow {
        return own;
    }
    let x = speed / slow;
    let s = x * x * (3.0 - 2.0 * x);
    // At least 0.7 long: both are at most 90 degrees apart.
    (reference * (1.0 - s) + own * s).normalize()
}

impl Plant {
    /// Sets the sliding directions along the velocities. Where a vertex moves against its reference
    /// direction the direction is continued through zero, so that the equations stay continuous
    /// until the event is located.
    ///
    /// A method that does not locate its events holds the directions of its last choice: it could
    /// not stop in time when a vertex comes to rest.
    pub fn update_directions(&mut self) {
        let held = !self.method.locates_events();
        let mut greatest = None;
        for (s, references) in self.directions.iter().enumerate() {
            let vertices = &self.problem.soles[s].vertices;
            let speed = |v: &Vertex| v.velocity.xy().norm();
            // Vertices at rest, without a reference, keep none.
            let at_rest = |(v, reference): (&Vertex, &Vector2<f64>)| {
                *reference == Vector2::zeros() && !(speed(v) >= DIRECTION_SPEED)
            };
            let is_known = held || vertices.iter().zip(references).all(at_rest);
            // Most others are fast.
            let mut is_fast = || {
                let greatest = *greatest.get_or_insert_with(|| self.greatest_direction_speed());
                vertices.iter().all(|v| speed(v) >= greatest)
            };
            let slow = if is_known || is_fast() { DIRECTION_SPEED } else { self.direction_speed(s) };
            for (v, reference) in self.problem.soles[s].vertices.iter_mut().zip(references) {
                v.direction = if is_known { *reference } else { direction(&v.velocity.xy(), reference, slow) };
            }
        }
        self.update_turning_directions();
    }

    /// Speed of a sole's sliding vertex, m/s, up to which its direction depends on the reference.
    /// It is at least the error that a step may make in the speeds that move the sole (levers of a
    /// metre). Below that the direction would be that of the error.
    pub fn direction_speed(&self, sole: usize) -> f64 {
        let (absolute, relative) = self.step_error;
        let error = |speed: f64| absolute + relative * speed;
        let of_body = |body: BodyId| {
            let (nb, v, ws) = match body.mechanism.checked_sub(1) {
                None => (self.model.nb(), &self.state.v, &self.ws),
                Some(o) => (self.objects.list[o].model.nb(), &self.objects.list[o].state.v, &self.objects.ws[o]),
            };
            let moving = ws.support(body.link).iter().filter(|&&i| i >= nb);
            let joints: f64 = moving.map(|&i| error(v[i].abs())).sum();
            let norm = |group: Range<usize>| v[group].iter().map(|v| v * v).sum::<f64>().sqrt();
            let base: f64 = self.layout.base_velocity_groups(body.mechanism).map(|group| error(norm(group))).sum();
            base + joints
        };
        DIRECTION_SPEED.max(self.reduced.bodies(sole).map(of_body).sum())
    }

    /// A bound of the direction speeds of all soles.
    fn greatest_direction_speed(&self) -> f64 {
        let (absolute, relative) = self.step_error;
        let error = |v: &[f64]| v.len() as f64 * absolute + relative * v.iter().map(|v| v.abs()).sum::<f64>();
        let sum = error(&self.state.v) + self.objects.list.iter().map(|object| error(&object.state.v)).sum::<f64>();
        // Rounding.
        2.0 * DIRECTION_SPEED.max(sum)
    }

    /// Makes the present sliding directions the references of the step that begins. A direction
    /// that opposes its reference is an event and stays unchanged.
    pub fn update_reference_directions(&mut self) {
        if !self.method.locates_events() {
            return;
        }
        for s in 0..self.directions.len() {
            let slow = self.direction_speed(s);
            for (v, reference) in self.problem.soles[s].vertices.iter().zip(&mut self.directions[s]) {
                let t = v.velocity.xy();
                if t.norm() > slow && t.dot(reference) > 0.0 {
                    *reference = t.normalize();
                }
            }
        }
        self.update_turning_references();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_direction_does_not_jump_where_a_vertex_moves_across_its_reference() {
        let (reference, slow) = (Vector2::new(0.6, 0.8), DIRECTION_SPEED);
        let across = Vector2::new(-0.8, 0.6);
        let side = |along: f64, speed: f64| direction(&(reference * along + across * speed), &reference, slow);
        for speed in [-3.0, -1.0, -0.4, -1e-3, 1e-3, 0.4, 1.0, 3.0].map(|x| x * slow) {
            // The law has slopes of at most some 1 / |t|.
            let jump = side(1e-9 * speed.abs(), speed) - side(-1e-9 * speed.abs(), speed);
            assert!(jump.norm() < 1e-8, "{speed} {jump}");
        }
        // Against the reference it is that of the opposite velocity.
        assert!((side(-3.0 * slow, 0.0) - reference).norm() < 1e-15);
    }
}
