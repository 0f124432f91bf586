//! Data computed for tasks from the estimated state and the sensors, each part only if asked for.

use super::{Needs, Sensed};
use crate::dynamics::{State, Workspace, body, crba, jacobian, kinematics};
use crate::robot::Model;
use nalgebra::Vector3;

/// The parts last asked for; what was not asked for is stale.
#[derive(Clone, Debug)]
pub struct Augmented {
    /// Kinematics at the estimated state; `links` of it are link transforms ([`Needs::LINKS`]).
    pub workspace: Workspace,
    /// Centre of mass in the world, m ([`Needs::COM`]).
    pub com: Vector3<f64>,
    /// Its velocity, m/s ([`Needs::COM`]).
    pub com_velocity: Vector3<f64>,
    /// `com' = J v`, world axes, 3 x nv, column-major ([`Needs::COM_JACOBIAN`]).
    pub com_jacobian: Vec<f64>,
}

impl Augmented {
    /// Allocates for a robot.
    pub fn new(model: &Model) -> Self {
        Augmented {
            workspace: Workspace::new(model),
            com: Vector3::zeros(),
            com_velocity: Vector3::zeros(),
            com_jacobian: vec![0.0; 3 * model.nv()],
        }
    }

    /// Computes the parts in `needs`, and what they rest on.
    pub fn update(&mut self, model: &Model, state: &State, _sensed: &Sensed, needs: Needs) {
        if needs == Needs::NONE {
            return;
        }
        kinematics::update(model, state, &mut self.workspace);
        if needs.contains(Needs::COM) {
            self.com = body::center_of_mass(&self.workspace);
            self.com_velocity = body::center_of_mass_velocity(&self.workspace);
        }
        if needs.contains(Needs::COM_JACOBIAN) {
            crba::mass_matrix(model, &mut self.workspace);
            jacobian::center_of_mass(&self.workspace, &mut self.com_jacobian);
        }
    }
}
