//! A polygon of the contact problem: fixed to a link over the floor, or the patch of a pair of bodies.

use crate::dynamics::reduced::ContactFrame;
use crate::robot::Sole;
use crate::sim::bodies::PairPatch;

/// A polygon of the contact problem.
#[derive(Clone, Debug)]
pub enum Polygon {
    /// Fixed to a link of the robot; it may touch the floor.
    Floor(Sole),
    /// The patch of a pair of bodies.
    Pair(PairPatch),
}

impl Polygon {
    /// Name in logs and messages.
    pub fn name(&self) -> &str {
        match self {
            Polygon::Floor(sole) => &sole.name,
            Polygon::Pair(patch) => &patch.name,
        }
    }

    /// Number of vertices.
    pub fn number_of_vertices(&self) -> usize {
        match self {
            Polygon::Floor(sole) => sole.vertices.len(),
            Polygon::Pair(patch) => patch.len(),
        }
    }

    /// Length that relates moments to forces, m.
    pub fn radius(&self) -> f64 {
        match self {
            Polygon::Floor(sole) => sole.radius(),
            Polygon::Pair(patch) => patch.radius(),
        }
    }

    /// Number that polygons have in common which cannot move relative to each other; `own` is that of no
    /// other polygon.
    pub fn rigid_group(&self, own: usize) -> usize {
        match self {
            Polygon::Floor(sole) => sole.link.0,
            Polygon::Pair(_) => own,
        }
    }

    /// The patch of a pair.
    pub fn pair(&self) -> Option<&PairPatch> {
        match self {
            Polygon::Floor(_) => None,
            Polygon::Pair(patch) => Some(patch),
        }
    }

    /// Whether both of its bodies move.
    pub fn is_between_mechanisms(&self) -> bool {
        self.pair().is_some_and(|patch| patch.parts[0].pair.links.1.is_some())
    }

    /// Its frame in the reduced problem.
    pub fn frame(&self) -> ContactFrame<'_> {
        match self {
            Polygon::Floor(sole) => ContactFrame::Sole(sole),
            Polygon::Pair(patch) => {
                let (a, b) = patch.parts[0].pair.links;
                ContactFrame::Pair(a, b)
            }
        }
    }
}
