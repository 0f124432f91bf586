//! The energy balance of a run.
//!
//! ```text
//! E(t) - E(0) = W_actuators + W_external - L_joints - L_friction - L_impacts + error
//! ```
//!
//! E is kinetic and potential energy, that in the springs of a compliant method included. W_actuators is the work of the servos, W_external that of external forces and of events that change the robot, gravity or the state, L_joints
//! what damping, friction and stops of the joints take (a stop gives some back), L_friction what contact friction takes,
//! from the vertex forces and velocities themselves, and L_impacts what velocity jumps take: impacts, jams, and the
//! little normal motion and slip that a new contact state ends; with a compliant method it is what the floor takes out of
//! the normal motion and its springs do not hold. Flows are integrated with the state; jumps are added as
//! they happen. What is left, drift projections and work of normal forces included, is the error.

use super::prescribe::Jump;
use super::simulation::Simulation;
use crate::dynamics::body;

/// Energies that flow with time.
pub const FLOWS: usize = 5;

/// Work of actuators, of external forces, loss in joints, loss by contact friction, by the dampers of a compliant floor
/// since the start, J; or their powers, W.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Flows(pub [f64; FLOWS]);

impl Flows {
    /// What flowed in less what flowed out.
    pub fn net(&self) -> f64 {
        let [actuators, external, joints, friction, dampers] = self.0;
        actuators + external - joints - friction - dampers
    }

    /// Adds energy that came from outside, J.
    pub fn bring(&mut self, energy: f64) {
        self.0[1] += energy;
    }

    /// Adds the flows of a step.
    pub fn add(&mut self, more: &Flows) {
        self.0.iter_mut().zip(more.0).for_each(|(sum, x)| *sum += x);
    }
}

/// The balance at one instant, J, in the module's order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Balance {
    /// Kinetic and potential energy, now less at the start.
    pub change: f64,
    /// Work of the actuators.
    pub actuators: f64,
    /// Work of external forces.
    pub external: f64,
    /// Taken by damping, friction and stops of the joints.
    pub joint_loss: f64,
    /// Taken by friction at the soles.
    pub friction_loss: f64,
    /// Taken by velocity jumps, or by the dampers of a compliant floor.
    pub impact_loss: f64,
}

impl Balance {
    /// What does not add up.
    pub fn error(&self) -> f64 {
        let gains = self.actuators + self.external;
        self.change - gains + self.joint_loss + self.friction_loss + self.impact_loss
    }
}

impl Simulation {
    /// Adds what a velocity jump has worked.
    pub(super) fn take(&mut self, jump: Jump) {
        self.work += jump.contact;
        self.flows.0[0] += jump.drives;
    }

    /// The balance at the plant's present state. Needs kinematics at it.
    pub(super) fn balance(&self) -> Balance {
        let [actuators, external, joint_loss, friction_loss, dampers] = self.flows.0;
        Balance {
            change: self.plant.energy() - self.start_energy,
            actuators,
            external,
            joint_loss,
            friction_loss,
            // Not `-work`, which is -0 when nothing was lost.
            impact_loss: dampers - self.work,
        }
    }
}

impl super::plant::Plant {
    /// Kinetic and potential energy at the state of the last evaluation or refresh, J.
    pub fn energy(&self) -> f64 {
        let stored = self.stored().energy;
        body::kinetic_energy(&self.model, &self.ws) + body::potential_energy(&self.ws, &self.gravity) + stored
    }

    /// Powers at the last evaluation.
    pub fn powers(&self) -> Flows {
        let v = &self.state.v;
        let joints = &v[self.model.nb()..];
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        // What sticks does no work, unless it gives way.
        let (mut friction, mut dampers) = (0.0, 0.0);
        let compliant = self.is_compliant();
        for (s, sole) in
            self.problem.soles.iter().enumerate().filter(|(s, _)| compliant || self.states[*s].is_dynamic())
        {
            for (vertex, t) in sole.vertices.iter().zip(&self.solution.tangent[s]) {
                friction += t.dot(&vertex.velocity.xy());
            }
            if compliant {
                let normal = sole.vertices.iter().zip(&self.solution.normal[s]);
                dampers -= normal.map(|(vertex, n)| n * vertex.velocity.z).sum::<f64>();
            }
        }
        dampers -= self.stored().power;
        Flows([dot(&self.efforts, joints), dot(&self.external, v), -dot(&self.passive, joints), -friction, dampers])
    }

    /// Flows of a velocity-level step of size `dt` that changed the velocity by `dv`, and the work of its contact
    /// impulses that is not friction's, J. Actuators and joints are taken with their implicit terms, everything works on
    /// the mean of the velocities before and after: the sum is exactly the change of kinetic energy less that due to the
    /// bias h. Needs the forces of all vertices, as impulses, and the state's velocity after the step.
    pub fn step_flows(&self, dv: &[f64], dt: f64) -> (Flows, f64) {
        let nb = self.model.nb();
        let mean = |i: usize| self.state.v[i] - 0.5 * dv[i];
        let (mut actuators, mut joints) = (0.0, 0.0);
        for (j, (servo, passive)) in self.servo.iter().zip(&self.passive).enumerate() {
            actuators += mean(nb + j) * (dt * servo - self.drive_give[j] * dv[nb + j]);
            joints -= mean(nb + j) * (dt * passive - self.give[j] * dv[nb + j]);
        }
        let mut external: f64 =
            (0..dv.len()).map(|i| mean(i) * (dt * self.external[i] - self.external_give[i] * dv[i])).sum();
        if let Some(dampers) = self.dampers.matrix() {
            external -= dampers.between(&self.state.v, dv) - 0.5 * dampers.between(dv, dv);
        }
        let mut friction = 0.0;
        for (s, sole) in self.problem.soles.iter().enumerate() {
            for (i, (vertex, t)) in sole.vertices.iter().zip(&self.solution.tangent[s]).enumerate() {
                let after = self.problem.vertex_motion(&self.solution.motion, s, i);
                friction += 0.5 * t.dot(&(vertex.velocity + after).xy());
            }
        }
        let pairs = self.reduced.velocity.iter().zip(&self.solution.motion);
        let contact: f64 = self.solution.wrench.iter().zip(pairs).map(|(w, (a, b))| 0.5 * w * (a + b)).sum();
        (Flows([actuators, external, joints, -friction, 0.0]), contact - friction)
    }
}
