//! Sliding vertices that come to rest faster than steps resolve.

use crate::contact::model::state::Mode;
use crate::sim::plant::sliding_directions::DIRECTION_SPEED;
use crate::sim::run::RunState;

/// Distance at which a slowing vertex misses zero velocity, relative to the speed up to which its
/// direction is held.
const MISS: f64 = 0.1;
/// Acceleration, relative to gravity, above which it may be due to friction.
const QUICK: f64 = 0.05;

/// Velocities, m/s or rad/s, relative to those of sliding vertices, up to which everything creeps.
const MOVES: f64 = 100.0;

impl RunState {
    /// Does a sole slide?
    pub(in crate::sim) fn is_sliding(&self) -> bool {
        (0..self.plant.problem.soles.len()).any(|s| self.plant.states[s].is_dynamic())
    }

    /// Does a vertex slide slower than `speed`, m/s?
    pub(in crate::sim) fn crawls(&self, speed: f64) -> bool {
        self.plant.problem.soles.iter().enumerate().any(|(s, sole)| {
            let (state, k) = (self.plant.states[s], sole.vertices.len());
            let slow = |i: usize| sole.vertices[i].velocity.xy().norm() <= speed;
            state.is_dynamic() && (0..k).any(|i| state.clamps(i, k) && slow(i))
        })
    }

    /// Whether no vertex slides faster than `speed`, m/s, and nothing moves much faster.
    pub(in crate::sim) fn creeps(&self, speed: f64) -> bool {
        let is_slow = self.plant.each_velocity().all(|v| v.abs() <= MOVES * speed);
        is_slow
            && self.plant.problem.soles.iter().enumerate().all(|(s, sole)| {
                let (state, k) = (self.plant.states[s], sole.vertices.len());
                let slow = |i: usize| sole.vertices[i].velocity.xy().norm() <= speed;
                (0..k).all(|i| !state.clamps(i, k) || slow(i))
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
    /// the error. One that begins to slide turns back to its direction by an acceleration that may
    /// look alike, so a vertex must have been faster first.
    pub(in crate::sim) fn slow_to_rest(&mut self) -> f64 {
        let soles = 0..self.plant.problem.soles.len();
        let stops = soles.map(|s| self.sole_to_rest(s)).fold(0.0, f64::max);
        if stops > 0.0 {
            self.plant.fast_slips.fill(0);
        }
        stops
    }

    /// [`slow_to_rest`](Self::slow_to_rest) of one sole.
    fn sole_to_rest(&mut self, s: usize) -> f64 {
        let plant = &mut self.plant;
        let (state, slow) = (plant.states[s], plant.direction_speed(s));
        let quick = QUICK * plant.gravity.norm();
        let vertices = &plant.problem.soles[s].vertices;
        let (mut fast, mut stops) = (0, 0.0);
        for (i, vertex) in vertices.iter().enumerate() {
            let slides = state.is_dynamic() && state.clamps(i, vertices.len()) && state.mode != Mode::Pivoting(i as u8);
            let v = vertex.velocity.xy();
            if !slides || v.norm() <= slow && plant.fast_slips[s] & 1 << i == 0 {
                continue;
            }
            fast |= 1 << i;
            if v.norm() <= slow && slow > DIRECTION_SPEED {
                let a = plant.problem.vertex_motion(&plant.solution.motion, s, i).xy();
                if a.norm() > quick && v.dot(&a) < 0.0 && v.perp(&a).abs() > MISS * slow * a.norm() {
                    stops = slow;
                }
            }
        }
        plant.fast_slips[s] = fast;
        if self.locates_events() { stops } else { 0.0 }
    }
}
