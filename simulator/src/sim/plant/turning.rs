//! Torsional and rolling friction of the plant's point contacts: their relative angular velocities, what is held
//! within a step, and their power. The law is that of [`crate::contact::model::turning`].

use super::sliding_directions::direction;
use super::{Plant, Polygon};
use crate::contact::model::turning::{TurningMode, moment};
use nalgebra::Vector3;

impl Plant {
    /// Sets the angular velocities of the point contacts and the biases of their rates. Those slower than the
    /// rest speed at a lever of a metre count as at rest.
    pub(super) fn update_turning_motion(&mut self) {
        for (s, sole) in self.problem.soles.iter_mut().enumerate() {
            // Also without friction: an event may begin it while the kinematics remain.
            if sole.vertices.len() != 1 {
                continue;
            }
            let m = &self.reduced.velocity[6 * s + 3..6 * s + 6];
            let turning = &mut sole.turning;
            turning.velocity = Vector3::new(m[0], m[1], m[2]);
            turning.bias = match &self.polygons[s] {
                Polygon::Floor(_) => Vector3::zeros(),
                Polygon::Pair(patch) => patch.axes().tr_mul(&patch.turning_bias(0)),
            };
            turning.spins = turning.velocity.z.abs() > self.rest;
            turning.rolls = turning.velocity.xy().norm() > self.rest;
        }
    }

    /// Sets modes and directions of a step within it: the roll turns with the velocity. A method that does not
    /// locate its events keeps those of its last choice.
    pub(super) fn update_turning_directions(&mut self) {
        let follows = self.method.locates_events();
        for s in 0..self.turning.len() {
            if self.problem.soles[s].turning().is_none() {
                continue;
            }
            let slow = self.direction_speed(s);
            let turning = &mut self.problem.soles[s].turning;
            turning.mode = self.turning[s];
            if follows && !turning.holds_roll() {
                let roll = direction(&turning.velocity.xy(), &self.turning[s].direction.xy(), slow);
                (turning.mode.direction.x, turning.mode.direction.y) = (roll.x, roll.y);
            }
        }
    }

    /// Makes the present rolling directions the references of the step that begins.
    pub(super) fn update_turning_references(&mut self) {
        for s in 0..self.turning.len() {
            if self.problem.soles[s].turning().is_none() {
                continue;
            }
            let slow = self.direction_speed(s);
            let (omega, d) = (self.problem.soles[s].turning.velocity.xy(), &mut self.turning[s].direction);
            if omega.norm() > slow && omega.dot(&d.xy()) > 0.0 {
                let t = omega.normalize();
                (d.x, d.y) = (t.x, t.y);
            }
        }
    }

    /// Makes the modes in the problem those of the steps that follow.
    pub fn adopt_turning(&mut self) {
        self.turning.iter_mut().zip(&self.problem.soles).for_each(|(mode, sole)| *mode = sole.turning.mode);
    }

    /// The modes of contacts that continue others, whose indices `former` gives, with axes that `turn` turns.
    pub fn carry_turning(
        &mut self,
        contacts: usize,
        former: impl Fn(usize) -> Option<(usize, nalgebra::Matrix3<f64>)>,
    ) {
        let carried = |s: usize| {
            former(s).map_or(TurningMode::default(), |(at, turn)| {
                let mode = self.turning[at];
                TurningMode { direction: turn * mode.direction, ..mode }
            })
        };
        self.turning = (0..contacts).map(carried).collect();
    }

    /// Power of the torsional and rolling moments, W, on these angular velocities.
    pub(super) fn turning_power(&self, velocity: impl Fn(usize) -> Vector3<f64>) -> f64 {
        let active = self.problem.turning(&self.states);
        active.map(|(s, _)| moment(&self.problem, s, &self.solution).dot(&velocity(s))).sum()
    }
}
