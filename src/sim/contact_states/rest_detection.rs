//! Sliding vertices that come to rest faster than steps resolve.

use crate::contact::model::state::Mode;
use crate::sim::plant::sliding_directions::DIRECTION_SPEED;
use crate::sim::run::RunState;

/// Distance at which a slowing vertex misses zero velocity, relative to the speed up to which its
/// direction is held.
const MISS: f64 = 0.1;
/// Acceleration, relative to gravity, above which it may be due to friction.
const QUICK: f64 = 0.05;

impl RunState {
    /// Does a vertex slide slower than `speed`, m/s?
    pub(in crate::sim) fn crawls(&self, speed: f64) -> bool {
        self.plant.problem.soles.iter().enumerate().any(|(s, sole)| {
            let (state, k) = (self.plant.states[s], sole.vertices.len());
            let slow = |i: usize| sole.vertices[i].velocity.xy().norm() <= speed;
            state.is_dynamic() && (0..k).any(|i| state.clamps(i, k) && slow(i))
        })
    }

    /// Speed, m/s, up to which vertices are set to rest because steps do not resolve how they come
    /// to rest; 0 if they do.
    ///
    /// Where the friction of one vertex responds to that of others, its sliding direction is stiff
    /// near zero speed: it turns at a rate of many times acceleration over speed. Explicit steps
    /// follow it, each to a fraction of its initial speed, down to their own error in speed
    /// (`Plant::direction_speed`). Below that the direction is held, and may be that of the error.
    /// A vertex that then slows down as fast as friction allows, and misses zero, is at rest within
    /// the error.
    pub(in crate::sim) fn slow_to_rest(&self) -> f64 {
        let plant = &self.plant;
        let quick = QUICK * plant.gravity.norm();
        let of_sole = |s: usize| {
            let (state, vertices) = (plant.states[s], &plant.problem.soles[s].vertices);
            let slow = plant.direction_speed(s);
            let past = |i: usize| {
                let v = vertices[i].velocity.xy();
                let a = plant.problem.vertex_motion(&plant.solution.motion, s, i).xy();
                v.norm() <= slow && a.norm() > quick && v.dot(&a) < 0.0 && v.perp(&a).abs() > MISS * slow * a.norm()
            };
            let slides = |i: usize| state.clamps(i, vertices.len()) && state.mode != Mode::Pivoting(i as u8);
            let held = self.locates_events() && state.is_dynamic() && slow > DIRECTION_SPEED;
            if held && (0..vertices.len()).any(|i| slides(i) && past(i)) { slow } else { 0.0 }
        };
        (0..plant.problem.soles.len()).map(of_sole).fold(0.0, f64::max)
    }
}
