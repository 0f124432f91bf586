//! Efforts against gravity.
//!
//! ```text
//! g(q) = dU/dq = -m J^T gravity        U = -m gravity . com,   J the Jacobian of the centre of mass
//! ```

use super::AugmentedData;
use crate::dynamics::body;

impl AugmentedData {
    /// Needs the Jacobian of the centre of mass.
    pub(super) fn find_gravity_effort(&mut self) {
        let weight = self.gravity * body::total_inertia(&self.workspace).mass;
        for (g, column) in self.gravity_effort.iter_mut().zip(self.com_jacobian.chunks_exact(3)) {
            *g = -(weight.x * column[0] + weight.y * column[1] + weight.z * column[2]);
        }
    }
}
