//! Kinematic joints: their motion is prescribed, the rest of the robot obeys its dynamics.
//!
//! ```text
//! M_ff a_f = tau_f - h_f - M_fk a_k + J_f^T w        free velocities f, prescribed accelerations a_k
//! tau_k    = (M a + h - J^T w - passive - external)_k       what the drives of the prescribed joints have to do
//! ```
//!
//! a rheonomic constraint on the joint, by elimination: nothing stiff is added, and how light a link is does not matter.
//! Velocity jumps leave the prescribed velocities as they are; the drives hold them against `(M dv)_k - (J^T p)_k`, and what
//! that works is work of actuators, not the impact's.
//!
//! A velocity-level step of size dt takes `a_k = ((q_k(t + dt) - q_k) / dt - qd_k) / dt`: the step ends at the prescribed
//! position, and the velocity in the state is the mean of the step.

use super::plant::Plant;
use crate::dynamics::reduced;

/// What a velocity jump has worked, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Jump {
    /// The contact impulses; negative when they take energy.
    pub contact: f64,
    /// The drives of kinematic joints.
    pub drives: f64,
}

impl Plant {
    /// Reads a state out of the integrator's vector, kinematic joints where they are prescribed to be.
    pub(super) fn unpack(&mut self, t: f64, y: &[f64]) {
        self.layout.unpack(t, y, &mut self.state);
        self.follow();
    }

    /// Puts kinematic joints where they are prescribed to be at the state's time.
    pub(super) fn follow(&mut self) {
        let nb = self.model.nb();
        for &j in self.guide.joints() {
            let m = self.guide.at(j, self.state.time, self.within);
            (self.state.joints[j], self.state.v[nb + j]) = (m.q, m.qd);
        }
    }

    /// Takes up the command of a control tick at the present time, `period` seconds long; the next tick comes at `next`.
    pub(super) fn plan(&mut self, period: f64, next: Option<f64>) {
        self.guide.plan(&self.model, &self.command, &self.state, period, next);
        let nb = self.model.nb();
        self.reduced.prescribed.clear();
        self.reduced.prescribed.extend(self.guide.joints().iter().map(|j| nb + j));
    }

    /// Prescribed acceleration of each kinematic joint at the present state, or over a step of size `dt`.
    pub(super) fn demand(&mut self, dt: Option<f64>) {
        let (nb, t) = (self.model.nb(), self.state.time);
        for &j in self.guide.joints() {
            self.demanded[j] = match dt {
                None => self.guide.at(j, t, self.within).qdd,
                Some(dt) => {
                    let end = self.guide.at(j, t + dt, self.within).q;
                    ((end - self.state.joints[j]) / dt - self.state.v[nb + j]) / dt
                }
            };
        }
    }

    /// Turns the generalised force into that of the reduced problem with prescribed velocities, in `self.scratch`.
    pub(super) fn carry_over(&mut self) {
        let nb = self.model.nb();
        self.scratch.copy_from_slice(&self.tau);
        for &j in self.guide.joints() {
            self.ws.mass.add_column(nb + j, -self.demanded[j], &mut self.scratch);
            if let Some(dampers) = self.dampers.matrix() {
                dampers.add_column(nb + j, -self.demanded[j], &mut self.scratch);
            }
        }
        for &j in self.guide.joints() {
            self.scratch[nb + j] = self.ws.bias[nb + j] + self.demanded[j];
        }
    }

    /// Efforts of the drives of kinematic joints at the accelerations and wrenches of the last evaluation.
    pub(super) fn react(&mut self) {
        let nb = self.model.nb();
        self.ws.mass.multiply(&self.acceleration, &mut self.scratch);
        for &j in self.guide.joints() {
            let k = nb + j;
            let contact = self.contact_load(&self.solution.wrench, k);
            self.efforts[j] = self.scratch[k] + self.ws.bias[k] - contact - self.passive[j] - self.external[k];
            self.servo[j] = self.efforts[j];
        }
    }

    /// The same over a velocity-level step of size `dt` that changed the velocity by `dv`, the solution holding impulses.
    pub(super) fn react_to_step(&mut self, dv: &[f64], dt: f64) {
        if self.guide.joints().is_empty() {
            return;
        }
        let nb = self.model.nb();
        self.ws.mass.multiply(dv, &mut self.scratch);
        if let Some(dampers) = self.dampers.matrix() {
            dv.iter().enumerate().for_each(|(k, dv)| dampers.add_column(k, *dv, &mut self.scratch));
        }
        for &j in self.guide.joints() {
            let k = nb + j;
            let contact = self.contact_load(&self.solution.wrench, k);
            // Passive efforts as `step_flows` takes them: with what the implicit step adds.
            let give = self.give[j] + self.external_give[k];
            let others = self.external[k] + self.passive[j] - give * dv[k] / dt;
            self.efforts[j] = (self.scratch[k] - contact) / dt + self.ws.bias[k] - others;
            self.servo[j] = self.efforts[j];
        }
    }

    /// Brings kinematic joints to where the step's end has them, to the last bit.
    pub(super) fn arrive(&mut self) {
        for &j in self.guide.joints() {
            self.state.joints[j] = self.guide.at(j, self.state.time, self.within).q;
        }
    }

    /// Adds the velocity jump of sole impulses (6F, floor axes) to the state.
    pub fn kick(&mut self, impulses: &[f64]) -> Jump {
        self.add_impulse(impulses);
        let before = self.kinetic_energy();
        let held = self.held();
        reduced::apply(&self.model, &self.ws, &mut self.reduced, impulses, &mut self.state.v);
        let change = self.kinetic_energy() - before;
        let mut drives = self.held() - held;
        for &k in &self.reduced.prescribed {
            drives -= self.state.v[k] * self.contact_load(impulses, k);
        }
        Jump { contact: change - drives, drives }
    }

    /// `sum v_k (M v)_k` over the prescribed velocities, after [`Plant::kinetic_energy`].
    fn held(&self) -> f64 {
        self.reduced.prescribed.iter().map(|&k| self.state.v[k] * self.scratch[k]).sum()
    }

    fn contact_load(&self, wrenches: &[f64], k: usize) -> f64 {
        reduced::load(&self.model, &self.ws, &self.floor.rotation, &self.reduced, wrenches, k)
    }
}
