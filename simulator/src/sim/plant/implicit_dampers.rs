//! External dampers in velocity-level steps: drag and the dampers of springs act at the end of the
//! step.
//!
//! ```text
//! f(v + dv) = f(v) - c J dv        (M + dt sum c J^T J) dv = dt (tau - h) + J_c^T w
//! ```
//!
//! J is the Jacobian of the point at which a force f acts, c the damper's coefficient at the
//! velocity v before the step, J_c^T w are the contact impulses. The term added to M is the mass
//! matrix of points of mass `dt c`, so a damper of any strength never reverses a motion in a step.

use crate::dynamics::{DynamicsError, TreeMatrix, Workspace, crba, factor};
use crate::force::{Damper, Force, ForceContext};
use crate::robot::{LinkId, Model};
use crate::sim::actuation::Drives;
use nalgebra::Vector3;

/// The dampers of one step.
#[derive(Clone)]
pub struct ImplicitDampers {
    /// Link, world point (m) and `dt c` (kg).
    points: Vec<(LinkId, Vector3<f64>, f64)>,
    /// `dt sum c J^T J`, when there are any.
    matrix: TreeMatrix,
}

impl ImplicitDampers {
    /// For the mechanism of a workspace.
    pub fn new(ws: &Workspace) -> Self {
        ImplicitDampers { points: Vec::new(), matrix: TreeMatrix::zeros(ws.mass.pattern().clone()) }
    }

    /// Reserves memory for `number` dampers.
    pub fn reserve(&mut self, number: usize) {
        self.points.reserve(number);
    }

    /// Removes all dampers, for an evaluation in continuous time.
    pub fn clear(&mut self) {
        self.points.clear();
    }

    /// Adds the dampers of a force model for a step of size `dt`.
    pub fn gather(&mut self, force: &dyn Force, context: &ForceContext, dt: f64) {
        let mut add = |d: Damper| {
            if d.coefficient > 0.0 {
                self.points.push((d.link, d.point, dt * d.coefficient));
            }
        };
        force.dampers(context, &mut add);
    }

    /// The matrix; none when there are no dampers.
    pub fn matrix(&self) -> Option<&TreeMatrix> {
        (!self.points.is_empty()).then_some(&self.matrix)
    }

    /// Factorises M with the dampers, terms of motors that drive several joints, and `diagonal` added.
    /// Needs M in the workspace.
    pub fn factorize(
        &mut self,
        ws: &mut Workspace,
        (model, drives): (&Model, &Drives),
        diagonal: &[f64],
        prescribed: &[usize],
    ) -> Result<(), DynamicsError> {
        let has_dampers = !self.points.is_empty();
        if has_dampers {
            crba::point_masses(ws, &self.points, &mut self.matrix);
        }
        if !(has_dampers || drives.has_coupled_terms()) {
            return factor::factorize_prescribed(ws, diagonal, prescribed);
        }
        let add = |sum: &mut TreeMatrix| {
            if has_dampers {
                sum.add(&self.matrix);
            }
            let nb = model.nb();
            drives.coupled_terms(model, |a, b, x| {
                if a >= b {
                    sum.add_entry(nb + a, nb + b, x);
                }
            });
        };
        factor::factorize_with(ws, add, diagonal, prescribed)
    }
}
