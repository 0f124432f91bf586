//! Vertices in the contact problem: those of patches by [`super::pair_vertices`], and those of soles on the floor,
//! which are fixed to their link:
//!
//! ```text
//! velocity = v + omega x r        bias = omega x (omega x r)        r from the sole's reference point
//! ```

use super::pair_vertices::set_vertices;
use super::{Plant, Polygon};
use crate::contact::model::problem::{Level, SoleProblem};
use crate::dynamics::reduced::Reduced;
use crate::robot::SoleId;
use crate::sim::floor::Floor;
use nalgebra::Vector3;

impl Plant {
    /// Copies the vertices into the contact problem, at the acceleration level.
    pub(super) fn update_vertices(&mut self) {
        let p = &mut self.problem;
        p.level = Level::Acceleration;
        p.step = 0.0;
        for (s, sole) in p.soles.iter_mut().enumerate() {
            sole.target = Vector3::zeros();
            match &self.polygons[s] {
                Polygon::Pair(patch) => {
                    self.pair_bias[s] = set_vertices(patch, &self.reduced, s, self.rest, sole);
                }
                Polygon::Floor(_) => set_floor_vertices(&self.floor, &self.reduced, s, self.rest, sole),
            }
        }
        self.update_turning_motion();
    }
}

/// Sets the vertices of sole `s`. Those slower than `rest`, m/s, count as at rest.
fn set_floor_vertices(floor: &Floor, reduced: &Reduced, s: usize, rest: f64, sole: &mut SoleProblem) {
    sole.position = floor.to_floor(&(reduced.reference[s] - floor.point));
    let m = &reduced.velocity[6 * s..6 * s + 6];
    let (linear, omega) = (Vector3::new(m[0], m[1], m[2]), Vector3::new(m[3], m[4], m[5]));
    let height = floor.gap(&reduced.reference[s]);
    for (v, arm) in sole.vertices.iter_mut().zip(reduced.vertices(SoleId(s))) {
        // Values just stored are not read again: the processor would wait for them.
        let r = *arm;
        let turn = omega.cross(&r);
        let velocity = linear + turn;
        (v.r, v.height, v.velocity) = (r, height + r.z, velocity);
        v.bias = omega.cross(&turn);
        v.moving = velocity.xy().norm_squared() > rest * rest;
        v.near = false;
    }
}
