//! Centre of mass, its velocity and its Jacobians.
//!
//! ```text
//! world   com' = J v
//! base    c = R^T (com - p),  c' = J_b q'     so   J_b = R^T J restricted to the joints,
//! ```
//!
//! because the base's own motion moves com, p and R together and leaves c unchanged.

use super::AugmentedData;
use crate::dynamics::{body, jacobian};
use nalgebra::Vector3;

impl AugmentedData {
    pub(super) fn find_com(&mut self) {
        self.com = body::center_of_mass(&self.workspace);
        self.com_velocity = body::center_of_mass_velocity(&self.workspace);
    }

    /// Needs the mass matrix' composite inertias.
    pub(super) fn find_com_jacobian(&mut self) {
        jacobian::center_of_mass(&self.workspace, &mut self.com_jacobian);
    }

    /// Needs the Jacobian in world axes.
    pub(super) fn find_com_jacobian_base(&mut self) {
        let base = &self.workspace.links[0].rotation;
        let nb = (self.com_jacobian.len() - self.com_jacobian_base.len()) / 3;
        let joints = self.com_jacobian[3 * nb..].chunks_exact(3);
        for (out, column) in self.com_jacobian_base.chunks_exact_mut(3).zip(joints) {
            out.copy_from_slice(base.tr_mul(&Vector3::from_column_slice(column)).as_slice());
        }
    }
}
