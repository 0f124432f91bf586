//! Energies and powers of the plant.

use super::{EnergyFlows, Plant};
use crate::dynamics::body;

impl Plant {
    /// Kinetic and potential energy at the state of the last evaluation or refresh, J.
    pub fn energy(&self) -> f64 {
        let stored = self.stored().energy;
        let robot = body::kinetic_energy(&self.model, &self.ws) + body::potential_energy(&self.ws, &self.gravity);
        robot + stored + self.objects.energy(&self.gravity)
    }

    /// Powers at the last evaluation.
    pub fn powers(&self) -> EnergyFlows {
        let v = &self.state.v;
        let joints = &v[self.model.nb()..];
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        // Static soles do no work, except on a compliant floor.
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
        friction += self.turning_power(|s| self.problem.soles[s].turning.velocity);
        dampers -= self.stored().power;
        let (mut actuators, mut losses) = (dot(&self.drives.efforts, joints), -dot(&self.passive, joints));
        let mut external = dot(&self.external, v);
        for [drives, forces, joints] in self.objects.list.iter().map(|object| object.powers()) {
            actuators += drives;
            external += forces;
            losses += joints;
        }
        EnergyFlows([actuators, external, losses, -friction, dampers])
    }

    /// Energy flows of a velocity-level step of size `dt` that changed the velocity by `dv`, and
    /// the work of its contact impulses other than friction, J.
    ///
    /// Actuators and joints count with their implicit terms. All forces work on the mean of the
    /// velocities before and after, so the sum is exactly the change of kinetic energy less that
    /// due to the bias h. Needs the forces of all vertices, as impulses, and the state's velocity
    /// after the step.
    pub fn step_flows(&self, dv: &[f64], dt: f64) -> (EnergyFlows, f64) {
        let nb = self.model.nb();
        let mean = |i: usize| self.state.v[i] - 0.5 * dv[i];
        let (mut actuators, mut joints) = (0.0, 0.0);
        for (j, (servo, passive)) in self.drives.servo.iter().zip(&self.passive).enumerate() {
            actuators += mean(nb + j) * (dt * servo - self.drives.implicit[j] * dv[nb + j]);
            joints -= mean(nb + j) * (dt * passive - self.implicit_passive[j] * dv[nb + j]);
        }
        let [of_servos, of_friction] = self.drives.coupled_work(&self.model, &self.state.v[nb..], &dv[nb..]);
        (actuators, joints) = (actuators - of_servos, joints + of_friction);
        let mut on_objects = 0.0;
        for object in &self.objects.list {
            let [of_drives, of_forces, of_joints] = object.step_work(&dv[object.velocities.clone()], dt);
            actuators += of_drives;
            on_objects += of_forces;
            joints += of_joints;
        }
        let mut external: f64 = (0..self.state.v.len())
            .map(|i| mean(i) * (dt * self.external[i] - self.implicit_external[i] * dv[i]))
            .sum();
        if let Some(dampers) = self.dampers.matrix() {
            external -= dampers.between(&self.state.v, dv) - 0.5 * dampers.between(dv, dv);
        }
        external += on_objects;
        let mut friction = 0.0;
        for (s, sole) in self.problem.soles.iter().enumerate() {
            for (i, (vertex, t)) in sole.vertices.iter().zip(&self.solution.tangent[s]).enumerate() {
                let after = self.problem.vertex_motion(&self.solution.motion, s, i);
                friction += 0.5 * t.dot(&(vertex.velocity + after).xy());
            }
        }
        friction += self.turning_power(|s| {
            let turning = &self.problem.soles[s].turning;
            0.5 * (turning.velocity + self.problem.turning_motion(&self.solution.motion, s))
        });
        let pairs = self.reduced.velocity.iter().zip(&self.solution.motion);
        let contact: f64 = self.solution.wrench.iter().zip(pairs).map(|(w, (a, b))| 0.5 * w * (a + b)).sum();
        (EnergyFlows([actuators, external, joints, -friction, 0.0]), contact - friction)
    }
}
