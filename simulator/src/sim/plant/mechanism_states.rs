//! States of all mechanisms together: velocities and displacements stacked, the robot's first.

use super::{EnergyFlows, Plant};
use crate::dynamics::reduced;

impl Plant {
    /// Kinetic energy of the states' velocities at the configurations of the last evaluation, J.
    pub fn kinetic_energy(&mut self) -> f64 {
        self.ws.mass.multiply(&self.state.v, &mut self.scratch);
        let robot = 0.5 * self.scratch.iter().zip(&self.state.v).map(|(p, v)| p * v).sum::<f64>();
        robot + self.objects.kinetic_energy()
    }

    /// Adds the velocity changes that impulses on the contacts (6F) cause.
    pub fn add_impulses(&mut self, impulses: &[f64]) {
        let mut jump = std::mem::take(&mut self.jump);
        reduced::apply(self.objects.mechanisms(&self.ws), &mut self.reduced, impulses, &mut jump);
        self.add_velocity(&jump);
        self.jump = jump;
    }

    /// Adds changes of the velocities of all mechanisms.
    pub fn add_velocity(&mut self, dv: &[f64]) {
        self.state.v.iter_mut().zip(dv).for_each(|(v, dv)| *v += dv);
        self.objects.add_velocity(dv);
    }

    /// Moves all configurations by displacements of all mechanisms.
    pub fn displace(&mut self, d: &[f64]) {
        self.state.displace(&d[..self.state.v.len()]);
        self.objects.displace(d);
    }

    /// Velocities of all mechanisms.
    pub fn velocities(&self) -> Vec<f64> {
        let mut v = vec![0.0; self.acceleration.len()];
        self.write_velocities_times(1.0, &mut v);
        v
    }

    /// Sets the velocities of all mechanisms.
    pub fn set_velocities(&mut self, v: &[f64]) {
        let nv = self.state.v.len();
        self.state.v.copy_from_slice(&v[..nv]);
        for object in &mut self.objects.list {
            object.state.v.copy_from_slice(&v[object.velocities.clone()]);
        }
    }

    /// Velocities of all mechanisms, one after the other.
    pub fn each_velocity(&self) -> impl Iterator<Item = f64> + '_ {
        self.state.v.iter().chain(self.objects.list.iter().flat_map(|object| &object.state.v)).copied()
    }

    /// Velocities of all mechanisms times `dt`.
    pub fn write_velocities_times(&self, dt: f64, out: &mut [f64]) {
        self.each_velocity().zip(out).for_each(|(v, d)| *d = v * dt);
    }

    /// Writes the states and the energy flows into the integrator's vector.
    pub fn pack(&self, flows: &EnergyFlows, y: &mut [f64]) {
        self.layout.pack(0, &self.state, y);
        self.objects.list.iter().enumerate().for_each(|(o, object)| self.layout.pack(1 + o, &object.state, y));
        self.layout.pack_flows(flows, y);
    }

    /// Writes the derivative of the integrator's vector `y` from the last evaluation, which was at `y`.
    pub fn write_derivative(&self, y: &[f64], dy: &mut [f64]) {
        let layout = &self.layout;
        let set = |rates: &mut [f64], lag: &mut dyn Iterator<Item = f64>| {
            rates.iter_mut().zip(lag).for_each(|(rate, lag)| *rate = lag);
        };
        layout.configuration_derivative(0, y, &self.state.v, dy);
        set(layout.actuators(0, dy), &mut self.drives.lag_rates(&self.model, &self.state.actuators));
        for (o, object) in self.objects.list.iter().enumerate() {
            layout.configuration_derivative(1 + o, y, &object.state.v, dy);
            set(layout.actuators(1 + o, dy), &mut object.lag_rates());
        }
        dy[layout.velocities()].copy_from_slice(&self.acceleration);
        layout.pack_flows(&self.powers(), dy);
        // The motion of kinematic joints is prescribed, not integrated.
        self.hold_prescribed(dy);
    }

    /// Sets the entries of kinematic joints to zero, in a derivative or in a point whose joints take their path's
    /// positions when it is unpacked.
    pub fn hold_prescribed(&self, y: &mut [f64]) {
        self.kinematic_paths.joints().iter().for_each(|j| self.layout.hold(*j, y));
    }
}
