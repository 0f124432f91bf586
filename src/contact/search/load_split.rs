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
//! While the states last, w0 stays the same, so that the loads are continuous. Where the load is
//! determinate, w does not depend on w0.

use crate::contact::model::problem::Problem;
use crate::contact::model::solution::wrench_at;
use crate::contact::model::state::{SoleState, States};
use nalgebra::Vector3;

/// A split of the loads of some states.
#[derive(Clone, Debug)]
pub struct LoadSplit {
    states: Option<States>,
    /// w0, of static soles, 6F.
    wrench: Vec<f64>,
    /// W w0.
    motion: Vec<f64>,
}

impl LoadSplit {
    /// None, for problems of this size.
    pub fn new(p: &Problem) -> Self {
        LoadSplit { states: None, wrench: vec![0.0; p.dim()], motion: vec![0.0; p.dim()] }
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
        self.states = Some(states.clone());
        self.wrench.fill(0.0);
        for (s, i, force) in forces {
            let sole = &p.soles[s];
            if states[s].is_static() && states[s].clamps(i, sole.vertices.len()) {
                let wrench = wrench_at(&sole.vertices[i].r, &force);
                self.wrench[6 * s..6 * s + 6].iter_mut().zip(wrench).for_each(|(sum, x)| *sum += x);
            }
        }
    }

    /// Returns to the least norm.
    pub fn clear(&mut self) {
        self.states = None;
    }

    /// Updates W w0 to the problem.
    pub(super) fn update(&mut self, p: &Problem) {
        for (m, row) in self.motion.iter_mut().zip(p.w.chunks_exact(p.dim())) {
            *m = row.iter().zip(&self.wrench).map(|(w, x)| w * x).sum();
        }
    }

    /// w0 and W w0.
    pub(super) fn loads(&self) -> (&[f64], &[f64]) {
        (&self.wrench, &self.motion)
    }
}
