//! The energy balance of a run.
//!
//! ```text
//! E(t) - E(0) = W_actuators + W_external - L_joints - L_friction - L_impacts + error
//! ```
//!
//! - E: kinetic and potential energy, including that in the springs of a compliant method.
//! - W_actuators: work of the servos.
//! - W_external: work of external forces and of events that change the robot, gravity or the state.
//! - L_joints: dissipated by damping, friction and stops of the joints (a stop returns some).
//! - L_friction: dissipated by contact friction, from the vertex forces and velocities.
//! - L_impacts: dissipated by velocity jumps: impacts, jams, and the small normal motion and slip
//!   that a new contact state ends; with a compliant method, dissipated by the floor's dampers.
//!
//! Flows are integrated with the state; jumps are added when they happen. The remainder, including
//! drift projections and work of normal forces, is the error.

use crate::sim::plant::kinematic_joints::JumpWork;
use crate::sim::plant::{EnergyFlows, Plant};

/// The balance at one instant, J, in the module's order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnergyBalance {
    /// Kinetic and potential energy, less that at the start.
    pub change: f64,
    /// Work of the actuators.
    pub actuators: f64,
    /// Work of external forces.
    pub external: f64,
    /// Dissipated by damping, friction and stops of the joints.
    pub joint_loss: f64,
    /// Dissipated by friction at the soles.
    pub friction_loss: f64,
    /// Dissipated by velocity jumps, or by the dampers of a compliant floor.
    pub impact_loss: f64,
}

impl EnergyBalance {
    /// The residual of the balance.
    pub fn error(&self) -> f64 {
        let gains = self.actuators + self.external;
        self.change - gains + self.joint_loss + self.friction_loss + self.impact_loss
    }
}

/// Energies of a run since its start.
#[derive(Clone, Copy, Debug, Default)]
pub struct EnergyAccount {
    /// Energy at the start, J.
    pub start: f64,
    /// Integrated energy flows.
    pub flows: EnergyFlows,
    /// Work of velocity jumps, J: impacts, jams, and small velocities that a new contact state
    /// ends.
    pub jump_work: f64,
}

impl EnergyAccount {
    /// Adds the work of a velocity jump.
    pub fn add_jump(&mut self, jump: JumpWork) {
        self.jump_work += jump.contact;
        self.flows.0[0] += jump.drives;
    }

    /// The balance at the plant's present state. Needs kinematics at it.
    pub fn balance(&self, plant: &Plant) -> EnergyBalance {
        let [actuators, external, joint_loss, friction_loss, dampers] = self.flows.0;
        EnergyBalance {
            change: plant.energy() - self.start,
            actuators,
            external,
            joint_loss,
            friction_loss,
            // Not `-jump_work`, which is -0 when nothing was lost.
            impact_loss: dampers - self.jump_work,
        }
    }
}
