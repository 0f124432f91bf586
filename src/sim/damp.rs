//! External dampers in velocity-level steps: drag and the dampers of springs are taken at the end of the step.
//!
//! ```text
//! f(v + dv) = f(v) - c J dv        (M + dt sum c J^T J) dv = dt (tau - h) + J_c^T w
//! ```
//!
//! J the Jacobian of the point at which a force f acts, c the damper's coefficient at the velocity v before the step, J_c^T w
//! the contact impulses. What is added to M is the mass matrix of points of mass `dt c`: so a damper never turns a motion
//! round within a step, however strong it is.

use super::plant::Plant;
use crate::dynamics::{DynamicsError, TreeMatrix, Workspace, crba, factor};
use crate::force::{Damper, Force, ForceContext};
use crate::robot::LinkId;
use nalgebra::Vector3;

/// The dampers of one step.
pub(super) struct Dampers {
    /// Link, world point (m) and `dt c` (kg).
    points: Vec<(LinkId, Vector3<f64>, f64)>,
    /// `dt sum c J^T J`, when there are any.
    matrix: TreeMatrix,
}

impl Dampers {
    pub(super) fn new(ws: &Workspace) -> Self {
        Dampers { points: Vec::new(), matrix: TreeMatrix::zeros(ws.mass.pattern().clone()) }
    }

    pub(super) fn reserve(&mut self, number: usize) {
        self.points.reserve(number);
    }

    /// None, in continuous time.
    pub(super) fn clear(&mut self) {
        self.points.clear();
    }

    /// Those of all force models for a step of size `dt`.
    pub(super) fn gather(&mut self, forces: &[Box<dyn Force>], context: &ForceContext, dt: f64) {
        let mut add = |d: Damper| {
            if d.coefficient > 0.0 {
                self.points.push((d.link, d.point, dt * d.coefficient));
            }
        };
        forces.iter().for_each(|force| force.dampers(context, &mut add));
    }

    /// The matrix; none when there are no dampers.
    pub(super) fn matrix(&self) -> Option<&TreeMatrix> {
        (!self.points.is_empty()).then_some(&self.matrix)
    }
}

impl Plant {
    /// Factorises M with what the step adds to it. Needs M.
    pub(super) fn factorize(&mut self) -> Result<(), DynamicsError> {
        let prescribed = &self.reduced.prescribed;
        if !self.dampers.points.is_empty() {
            crba::point_masses(&mut self.ws, &self.dampers.points, &mut self.dampers.matrix);
            return factor::factorize_with(&mut self.ws, &self.dampers.matrix, &self.shift, prescribed);
        }
        if prescribed.is_empty() {
            factor::factorize_shifted(&mut self.ws, &self.shift)
        } else {
            factor::factorize_prescribed(&mut self.ws, &self.shift, prescribed)
        }
    }
}
