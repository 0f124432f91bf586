//! External forces on an object at one instant.

use super::implicit_dampers::ImplicitDampers;
use crate::dynamics::Workspace;
use crate::force::{AppliedForces, Force, ForceContext};
use nalgebra::Vector3;

/// Sums over the force models that act on an object.
#[derive(Clone)]
pub struct ObjectForces {
    /// Generalised force, nv.
    pub tau: Vec<f64>,
    /// Terms that a velocity-level step adds to the diagonal of M, nv.
    pub implicit: Vec<f64>,
    /// Dampers between points, which add to all of M.
    pub dampers: ImplicitDampers,
}

impl ObjectForces {
    /// None yet, for the object of a workspace.
    pub fn new(ws: &Workspace) -> Self {
        let nv = ws.mass.len();
        ObjectForces { tau: vec![0.0; nv], implicit: vec![0.0; nv], dampers: ImplicitDampers::new(ws) }
    }

    /// Removes all forces.
    pub fn clear(&mut self) {
        self.tau.fill(0.0);
        self.implicit.fill(0.0);
        self.dampers.clear();
    }

    /// Adds those of a model and its arrows, over a velocity-level step of size `dt` if given. The implicit
    /// terms lack the factor `dt`.
    pub fn add(
        &mut self,
        force: &mut dyn Force,
        context: &ForceContext,
        arrows: &mut Vec<(Vector3<f64>, Vector3<f64>)>,
        dt: Option<f64>,
    ) {
        force.evaluate(context, &mut AppliedForces::new(&mut self.tau, arrows));
        if let Some(dt) = dt {
            force.damping(context, &mut self.implicit);
            self.dampers.gather(force, context, dt);
        }
    }

    /// Work over a velocity-level step of size `dt` that changed the velocity to `v` by `dv`, J.
    pub fn step_work(&self, v: &[f64], dv: &[f64], dt: f64) -> f64 {
        let mean = |i: usize| v[i] - 0.5 * dv[i];
        let work = |i: usize| mean(i) * (dt * self.tau[i] - self.implicit[i] * dv[i]);
        let sum: f64 = (0..v.len()).map(work).sum();
        let damped = self.dampers.matrix().map_or(0.0, |m| m.between(v, dv) - 0.5 * m.between(dv, dv));
        sum - damped
    }
}
