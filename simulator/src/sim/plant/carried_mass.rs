//! Changes of a link's inertia by carried objects.
//!
//! An object with a velocity u of its own is caught in a perfectly plastic impact, in which the
//! generalised momentum of both is preserved, except for impulses of the floor:
//!
//! ```text
//! M+ v+ = M- v- + J^T m u + J_c^T Lambda
//! ```
//!
//! M- and M+ are the mass matrices without and with the object, J the Jacobian of its centre of
//! mass, J_c^T Lambda the impulses of the contact method at the soles, computed from the velocities
//! that follow from the first two terms. Kinematic joints keep their motions, and couplings and loops hold.

use super::Plant;
use crate::dynamics::{self, DynamicsError, crba, factor};
use crate::robot::{LinkId, RigidInertia};
use nalgebra::Vector3;

/// Energies of catching an object, J.
pub struct CatchEnergy {
    /// Energy of the object before the impact.
    pub brought: f64,
    /// Work of the drives of kinematic joints.
    pub drives: f64,
    /// Energy lost in the impact.
    pub lost: f64,
}

impl Plant {
    /// Replaces the inertia of a link. Returns the change of energy, J.
    pub fn replace_inertia(&mut self, link: LinkId, body: &RigidInertia) -> f64 {
        self.update_kinematics();
        let before = self.energy();
        self.set_body(link, body);
        self.energy() - before
    }

    /// Attaches an object with a velocity to a link, whose inertia becomes `total`, in a perfectly
    /// plastic impact.
    pub fn catch(
        &mut self,
        link: LinkId,
        object: &RigidInertia,
        velocity: &Vector3<f64>,
        total: &RigidInertia,
    ) -> Result<CatchEnergy, DynamicsError> {
        self.update_kinematics();
        let mass = object.mass;
        let point = self.ws.point(link, &object.com);
        let brought = mass * (0.5 * velocity.norm_squared() - self.gravity.dot(&point));
        let before = self.energy() + brought;
        // Momentum of robot and object, less that of the robot with the object at the old velocity.
        let (mut excess, mut other) = (vec![0.0; self.model.nv()], vec![0.0; self.model.nv()]);
        crba::mass_matrix(&self.model, &mut self.ws);
        self.ws.mass.multiply(&self.state.v, &mut excess);
        let (momentum, none) = (velocity * mass, Vector3::zeros());
        dynamics::link_force::accumulate(&self.ws, link, &point, &momentum, &none, &mut excess);
        self.set_body(link, total);
        crba::mass_matrix(&self.model, &mut self.ws);
        self.ws.mass.multiply(&self.state.v, &mut other);
        excess.iter_mut().zip(&other).for_each(|(e, o)| *e -= o);
        // M+ dv = excess, but kinematic joints keep their velocities.
        let prescribed = &self.reduced.prescribed;
        let mut dv = excess.clone();
        prescribed.iter().for_each(|k| dv[*k] = 0.0);
        factor::factorize_prescribed(&mut self.ws, &vec![0.0; dv.len()], prescribed)?;
        factor::solve_coupled(&self.ws, &mut dv);
        self.ws.mass.multiply(&dv, &mut other);
        let drives = prescribed.iter().map(|&k| self.state.v[k] * (other[k] - excess[k])).sum();
        self.state.v.iter_mut().zip(&dv).for_each(|(v, dv)| *v += dv);
        self.update_kinematics();
        Ok(CatchEnergy { brought, drives, lost: before + drives - self.energy() })
    }
}
