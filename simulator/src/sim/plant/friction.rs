//! Friction of the vertices: those on the floor have the friction of their region, see
//! [`VertexRegion`], those of pairs of bodies that of both ([`crate::sim::bodies::PairFriction`]).

use super::Plant;
use super::Polygon;
use crate::sim::bodies::{FLOOR, Friction, PairPatch};
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

    /// Finds the friction that rules give the present polygons on the floor.
    pub fn update_floor_rules(&mut self) {
        let rule = |polygon: &Polygon| match polygon {
            Polygon::Floor(sole) => self.pair_rules.friction(&sole.name, FLOOR),
            Polygon::Pair(_) => None,
        };
        self.floor_rules = self.polygons.iter().map(rule).collect();
    }

    /// Whether the friction of a vertex depends on its region of the floor.
    pub fn has_region(&self, s: usize, i: usize) -> bool {
        match &self.polygons[s] {
            Polygon::Floor(_) => self.floor_rules[s].is_none(),
            Polygon::Pair(patch) => patch.friction(i).has_regions(),
        }
    }

    /// Positive until a vertex has left its region, m.
    pub fn border(&self, s: usize, i: usize) -> f64 {
        if !self.has_region(s, i) {
            return f64::INFINITY;
        }
        let (vertex, p) = (&self.regions[s][i], self.seen_from_above(s, i));
        self.floor.inside(vertex.region, &p) + vertex.widths * border_width(&p)
    }

    /// Updates a vertex's friction. Returns whether its region changed. An unclamped vertex has no
    /// history.
    pub fn update_friction(&mut self, s: usize, i: usize) -> bool {
        if !self.has_region(s, i) {
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
        self.set_friction(s, i);
        changed
    }

    /// Gives a new vertex the friction of its region. Needs the vertices.
    pub fn begin_friction(&mut self, s: usize, i: usize) {
        let region = if self.has_region(s, i) { self.floor.region(&self.seen_from_above(s, i)) } else { None };
        self.regions[s][i] = VertexRegion::new(region);
        self.set_friction(s, i);
    }

    /// Gives a vertex that remains in other patches the friction of the pair to which it belongs now.
    pub fn continue_friction(&mut self, s: usize, i: usize) {
        if self.has_region(s, i) {
            self.set_friction(s, i);
        } else {
            self.begin_friction(s, i);
        }
    }

    /// Sets the coefficients of a vertex in its region.
    fn set_friction(&mut self, s: usize, i: usize) {
        let (mu_s, mu_k) = self.floor.friction(self.regions[s][i].region);
        let floor = Friction { mu_s, mu_k, extra: self.floor.extra(self.regions[s][i].region) };
        let with = |patch: &PairPatch| patch.friction(i).with(floor);
        let friction = self.polygons[s].pair().map_or(self.floor_rules[s].unwrap_or(floor), with);
        friction.assign(&mut self.problem.soles[s], i);
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
