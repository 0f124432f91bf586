//! The split of statically indeterminate loads over several contacts.
//!
//! Where static soles share a load (three edges of a fallen robot, the faces of a box in a corner), their
//! conditions are redundant, and any wrench of the null space of R W B may be added to a solution. The
//! solution of least norm may leave a friction cone although another split stays inside all of them. The
//! contact problem with every vertex as a point ([`super::point_forces`]) finds such a split, w0. The
//! candidate is then solved for the least departure from it:
//!
//! ```text
//! w = w0 + B x,     R W B x = target - R (b + c + W w0),     |x| least
//! ```
//!
//! Forces of sliding soles are no part of w0: their x counts as a hundredth.
//!
//! A robot file of 8 digits makes some of the conditions redundant up to these digits only. What w0 leaves of them
//! (1e-10 of gravity) may take forces outside the cones. Then they count as redundant too ([`LoadSplit::is_loose`]), for
//! as long as they leave no more than 1e-8 of the motion without contact.
//!
//! A split on the border of a cone would fail with the next change of the load. Where the states fail with it, one as
//! far inside the cones as there is takes its place.
//!
//! While the states last, the forces of w0 at the vertices stay the same, in the axes of their soles, so that the
//! loads are continuous. Where the load is determinate, w does not depend on w0.

use crate::contact::model::problem::Problem;
use crate::contact::model::solution::wrench_at;
use crate::contact::model::state::{SoleState, States};
use nalgebra::Vector3;

/// A split of the loads of some states.
#[derive(Clone, Debug)]
pub struct LoadSplit {
    states: Option<States>,
    /// Whether conditions that are nearly redundant count as redundant.
    pub is_loose: bool,
    /// Its forces at vertices of static soles: sole, vertex, N.
    forces: Vec<(usize, usize, Vector3<f64>)>,
    /// w0, 6F.
    wrench: Vec<f64>,
    /// W w0.
    motion: Vec<f64>,
}

impl LoadSplit {
    /// None, for problems of this size.
    pub fn new(p: &Problem) -> Self {
        let forces = Vec::with_capacity(p.vertex_indices().count());
        LoadSplit { states: None, is_loose: false, forces, wrench: vec![0.0; p.dim()], motion: vec![0.0; p.dim()] }
    }

    /// Whether loads of these states have a split.
    pub fn is_of(&self, states: &States) -> bool {
        self.states.as_ref() == Some(states)
    }

    /// Whether several soles of these states may share a load.
    pub fn may_apply(p: &Problem, states: &States) -> bool {
        let rests = |s: &usize| states[*s] != SoleState::FREE && states[*s].is_static();
        (0..p.soles.len()).filter(rests).count() > 1
    }

    /// Sets it from forces of vertices: sole, vertex, force, N.
    pub fn set(&mut self, p: &Problem, states: &States, forces: impl Iterator<Item = (usize, usize, Vector3<f64>)>) {
        (self.states, self.is_loose) = (Some(states.clone()), false);
        let is_held = |s: usize, i: usize| states[s].is_static() && states[s].clamps(i, p.soles[s].vertices.len());
        self.forces.clear();
        self.forces.extend(forces.filter(|&(s, i, _)| is_held(s, i)));
    }

    /// Returns to the least norm.
    pub fn clear(&mut self) {
        self.states = None;
    }

    /// Updates w0 and W w0 to the problem.
    pub(super) fn update(&mut self, p: &Problem) {
        self.wrench.fill(0.0);
        for (s, i, force) in &self.forces {
            let wrench = wrench_at(&p.soles[*s].vertices[*i].r, force);
            self.wrench[6 * s..6 * s + 6].iter_mut().zip(wrench).for_each(|(sum, x)| *sum += x);
        }
        for (m, row) in self.motion.iter_mut().zip(p.w.chunks_exact(p.dim())) {
            *m = row.iter().zip(&self.wrench).map(|(w, x)| w * x).sum();
        }
    }

    /// w0 and W w0.
    pub(super) fn loads(&self) -> (&[f64], &[f64]) {
        (&self.wrench, &self.motion)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::model::state::Pattern;

    /// A vertex that moves relative to the reference point of its sole keeps its force, not its moment: otherwise
    /// the load would turn the body about the vertex.
    #[test]
    fn forces_stay_at_their_vertices() {
        let mut p = Problem::new(&[3, 1]);
        let mut states = States::default();
        (0..2).for_each(|s| states[s] = SoleState::fixed(Pattern::Vertex(0)));
        let mut split = LoadSplit::new(&p);
        let force = Vector3::new(1.0, -2.0, 5.0);
        split.set(&p, &states, [(0, 0, force), (0, 1, force), (1, 0, -force)].into_iter());
        p.soles[0].vertices[0].r = Vector3::new(0.3, 0.1, -0.2);
        split.update(&p);
        let moment = p.soles[0].vertices[0].r.cross(&force);
        let wrenches = [force.as_slice(), moment.as_slice(), (-force).as_slice(), &[0.0; 3]].concat();
        assert_eq!(split.loads().0, wrenches);
    }
}
