//! Friction of the vertices: each has the friction of its region of the floor, see
//! [`VertexRegion`], or that of its pair of bodies.

use super::Plant;
use crate::sim::floor::friction_regions::RegionId;
use crate::sim::floor::patch::border_width;
use crate::sim::floor::vertex_region::VertexRegion;
use nalgebra::Vector2;

impl Plant {
    /// A vertex seen from above: world x and y, m.
    pub fn seen_from_above(&self, s: usize, i: usize) -> Vector2<f64> {
        let r = self.reduced.axes[s] * self.problem.soles[s].vertices[i].r;
        (self.reduced.reference[s] + r).xy()
    }

    /// The region whose friction a vertex has.
    pub fn region(&self, s: usize, i: usize) -> RegionId {
        self.regions[s][i].region
    }

    /// Positive until a vertex has left its region, m.
    pub fn border(&self, s: usize, i: usize) -> f64 {
        if self.polygons[s].pair().is_some() {
            return f64::INFINITY;
        }
        let (vertex, p) = (&self.regions[s][i], self.seen_from_above(s, i));
        self.floor.inside(vertex.region, &p) + vertex.widths * border_width(&p)
    }

    /// Updates a vertex's friction. Returns whether its region changed. An unclamped vertex has no
    /// history.
    pub fn update_friction(&mut self, s: usize, i: usize) -> bool {
        if self.polygons[s].pair().is_some() {
            return false;
        }
        let clamped = self.states[s].clamps(i, self.problem.soles[s].vertices.len());
        let p = self.seen_from_above(s, i);
        // Event location ends where the border function is zero, up to rounding.
        if clamped && self.border(s, i) > 0.25 * border_width(&p) {
            return false;
        }
        let region = self.floor.region(&p);
        let vertex = &mut self.regions[s][i];
        let changed = region != vertex.region;
        if !clamped {
            *vertex = VertexRegion::new(region);
        } else if changed {
            vertex.enter(region, self.state.time);
        }
        let v = &mut self.problem.soles[s].vertices[i];
        (v.mu_s, v.mu_k) = self.floor.friction(region);
        changed
    }

    /// Gives a new vertex the friction of its region. Needs the vertices.
    pub fn begin_friction(&mut self, s: usize, i: usize) {
        if let Some(patch) = self.polygons[s].pair() {
            let v = &mut self.problem.soles[s].vertices[i];
            let friction = patch.friction(i);
            (v.mu_s, v.mu_k) = (friction.mu_s, friction.mu_k);
            return;
        }
        let region = self.floor.region(&self.seen_from_above(s, i));
        self.regions[s][i] = VertexRegion::new(region);
        let v = &mut self.problem.soles[s].vertices[i];
        (v.mu_s, v.mu_k) = self.floor.friction(region);
    }

    /// Assigns every vertex the friction of its region and forgets its history. Needs the vertices.
    pub fn reset_friction(&mut self) {
        for s in 0..self.problem.soles.len() {
            for i in 0..self.problem.soles[s].vertices.len() {
                self.begin_friction(s, i);
            }
        }
    }
}
