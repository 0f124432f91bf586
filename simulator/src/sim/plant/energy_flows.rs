//! Energies that flow with time; they are integrated with the state.

/// Number of flows.
pub const FLOWS: usize = 5;

/// Work of actuators and of external forces, losses in joints, by contact friction and in the
/// dampers of a compliant floor, since the start, J; or their powers, W.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnergyFlows(pub [f64; FLOWS]);

impl EnergyFlows {
    /// Net energy: inflows less losses.
    pub fn net(&self) -> f64 {
        let [actuators, external, joints, friction, dampers] = self.0;
        actuators + external - joints - friction - dampers
    }

    /// Adds external energy, J, to the work of external forces.
    pub fn add_external(&mut self, energy: f64) {
        self.0[1] += energy;
    }

    /// Adds the flows of a step.
    pub fn add(&mut self, more: &EnergyFlows) {
        self.0.iter_mut().zip(more.0).for_each(|(sum, x)| *sum += x);
    }
}
