//! A solution of the reduced contact problem: sole wrenches, sole motions, vertex forces.

use crate::contact::model::problem::Problem;
use crate::contact::model::state::MAX_SOLES;
use nalgebra::Vector2;

/// Wrenches, motions and vertex forces of a problem. The problem fixes the length of each list.
#[derive(Clone, Debug)]
pub struct Solution {
    /// Sole wrenches w, 6F, floor axes at the reference points.
    pub wrench: Vec<f64>,
    /// Sole motions m = b + W w, 6F.
    pub motion: Vec<f64>,
    /// Normal force of each vertex, by sole (N or N s).
    pub normal: Vec<Vec<f64>>,
    /// Tangential force of each vertex, by sole, x and y in floor axes. Within a static pattern the
    /// split is a rule (proportional to the normal forces), only the resultant is physics.
    pub tangent: Vec<Vec<Vector2<f64>>>,
    /// Did the pressure rule of every face find a centre of pressure inside its polygon?
    pub inside: [bool; MAX_SOLES],
}

impl Solution {
    /// A zero solution of the right size.
    pub fn new(p: &Problem) -> Self {
        Solution {
            wrench: vec![0.0; p.dim()],
            motion: vec![0.0; p.dim()],
            normal: p.soles.iter().map(|s| vec![0.0; s.vertices.len()]).collect(),
            tangent: p.soles.iter().map(|s| vec![Vector2::zeros(); s.vertices.len()]).collect(),
            inside: [true; MAX_SOLES],
        }
    }

    /// Copies another solution of the same size.
    pub fn copy_from(&mut self, other: &Solution) {
        self.wrench.copy_from_slice(&other.wrench);
        self.motion.copy_from_slice(&other.motion);
        self.normal.iter_mut().zip(&other.normal).for_each(|(to, from)| to.copy_from_slice(from));
        self.tangent.iter_mut().zip(&other.tangent).for_each(|(to, from)| to.copy_from_slice(from));
        self.inside = other.inside;
    }

    /// Scales wrenches and forces, to read impulses over a step as forces.
    pub fn scale(&mut self, factor: f64) {
        self.wrench.iter_mut().for_each(|w| *w *= factor);
        self.normal.iter_mut().flatten().for_each(|n| *n *= factor);
        self.tangent.iter_mut().flatten().for_each(|t| *t *= factor);
    }
}
