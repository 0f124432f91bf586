//! Kinematic joints: their motion is prescribed; the rest of the robot obeys its dynamics.
//!
//! ```text
//! M_ff a_f = tau_f - h_f - M_fk a_k + J_f^T w        free velocities f, prescribed accelerations a_k
//! tau_k    = (M a + h - J^T w - G^T lambda - passive - external)_k    efforts of the prescribed joints' drives
//! ```
//!
//! This is a rheonomic constraint on the joint, by elimination: it adds no stiffness and works for
//! links of any mass. Velocity jumps do not change the prescribed velocities: the drives apply the
//! impulse `(M dv)_k - (J^T p)_k`, whose work counts as work of actuators, not of the impact.
//!
//! A velocity-level step of size dt takes `a_k = ((q_k(t + dt) - q_k) / dt - qd_k) / dt`: the step
//! ends at the prescribed position, and the velocity in the state is the mean of the step.

use super::Plant;
use crate::dynamics::reduced;
use crate::sim::actuation::kinematic_paths::Span;
use crate::task::Command;

/// Work of a velocity jump, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JumpWork {
    /// Work of the contact impulses; negative when they dissipate energy.
    pub contact: f64,
    /// Work of the drives of kinematic joints.
    pub drives: f64,
}

impl Plant {
    /// Reads a state from the integrator's vector, kinematic joints at their prescribed motion.
    pub fn unpack(&mut self, t: f64, y: &[f64]) {
        self.layout.unpack(0, t, y, &mut self.state);
        for (o, object) in self.objects.list.iter_mut().enumerate() {
            self.layout.unpack(1 + o, t, y, &mut object.state);
        }
        self.apply_prescribed_motion();
    }

    /// Sets kinematic joints to their prescribed motion at the state's time.
    pub fn apply_prescribed_motion(&mut self) {
        let nb = self.model.nb();
        for &j in self.kinematic_paths.joints() {
            let m = self.kinematic_paths.at(j, self.state.time, self.within);
            (self.state.joints[j], self.state.v[nb + j]) = (m.q, m.qd);
        }
    }

    /// Plans the paths of kinematic joints for a control tick of length `period` at the present
    /// time; the next command comes at `next`.
    pub fn plan_paths(&mut self, period: f64, next: Option<f64>) {
        self.kinematic_paths.plan(&self.model, &self.command, &self.state, period, next);
        self.prescribe_joints();
    }

    /// Plans paths along the commands `ahead`, from the present time on; see
    /// [`KinematicPaths::plan_ahead`](crate::sim::actuation::kinematic_paths::KinematicPaths::plan_ahead).
    pub fn plan_ahead(&mut self, span: &Span, ahead: &[Command; 7]) -> bool {
        let is_planned = self.kinematic_paths.plan_ahead((&self.model, &self.state), &self.command, span, ahead);
        if is_planned {
            self.prescribe_joints();
        }
        is_planned
    }

    fn prescribe_joints(&mut self) {
        let nb = self.model.nb();
        self.reduced.prescribed.clear();
        self.reduced.prescribed.extend(self.kinematic_paths.joints().iter().map(|j| nb + j));
    }

    /// Desired positions and velocities: those of the last tick, or of the state's time where ticks are left out.
    pub fn read_desired_motion(&self, q: &mut [f64], qd: &mut [f64]) {
        q.copy_from_slice(&self.command.position);
        qd.copy_from_slice(&self.command.velocity);
        let paths = &self.kinematic_paths;
        if paths.looks_ahead() {
            for &j in paths.joints().iter().chain(paths.tracked()) {
                let motion = paths.at(j, self.state.time, self.within);
                (q[j], qd[j]) = (motion.q, motion.qd);
            }
        }
    }

    /// The commands that the drives followed in the last evaluation.
    pub fn followed_command(&self) -> &Command {
        self.kinematic_paths.followed(&self.command, &self.interpolated)
    }

    /// Puts desired motions on their paths, `ahead` seconds after the state.
    pub(super) fn interpolate_command(&mut self, ahead: f64) {
        if self.kinematic_paths.tracked().is_empty() {
            return;
        }
        self.interpolated.copy_from(&self.command);
        for &j in self.kinematic_paths.tracked() {
            let motion = self.kinematic_paths.at(j, self.state.time + ahead, self.within);
            (self.interpolated.position[j], self.interpolated.velocity[j]) = (motion.q, motion.qd);
        }
    }

    /// Prescribed acceleration of each kinematic joint at the present state, or over a step of size
    /// `dt`.
    pub(super) fn prescribe_accelerations(&mut self, dt: Option<f64>) {
        let (nb, t) = (self.model.nb(), self.state.time);
        for &j in self.kinematic_paths.joints() {
            self.prescribed_acceleration[j] = match dt {
                None => self.kinematic_paths.at(j, t, self.within).qdd,
                Some(dt) => {
                    let end = self.kinematic_paths.at(j, t + dt, self.within).q;
                    ((end - self.state.joints[j]) / dt - self.state.v[nb + j]) / dt
                }
            };
        }
    }

    /// Writes to `self.scratch` the generalised force with the terms of the prescribed
    /// accelerations moved to the right-hand side.
    pub(super) fn move_prescribed_to_right(&mut self) {
        let nb = self.model.nb();
        self.scratch.copy_from_slice(&self.tau);
        for &j in self.kinematic_paths.joints() {
            self.ws.mass.add_column(nb + j, -self.prescribed_acceleration[j], &mut self.scratch);
            if let Some(dampers) = self.dampers.matrix() {
                dampers.add_column(nb + j, -self.prescribed_acceleration[j], &mut self.scratch);
            }
            let (scratch, acceleration) = (&mut self.scratch, self.prescribed_acceleration[j]);
            self.drives.coupled_terms(&self.model, |a, b, x| {
                if b == j {
                    scratch[nb + a] -= x * acceleration;
                }
            });
        }
        for &j in self.kinematic_paths.joints() {
            self.scratch[nb + j] = self.ws.bias[nb + j] + self.prescribed_acceleration[j];
        }
    }

    /// Efforts of the drives of kinematic joints at the accelerations and wrenches of the last
    /// evaluation.
    pub(super) fn drive_reactions(&mut self) {
        let nb = self.model.nb();
        self.update_multipliers();
        for &j in self.kinematic_paths.joints() {
            let k = nb + j;
            let reactions = self.contact_load(&self.solution.wrench, k) + self.condition_load(k);
            let inertial = self.ws.mass.row_times(k, &self.acceleration);
            self.drives.efforts[j] = inertial + self.ws.bias[k] - reactions - self.passive[j] - self.external[k];
            self.drives.servo[j] = self.drives.efforts[j];
        }
    }

    /// As `drive_reactions`, over a velocity-level step of size `dt` that changed the velocity by
    /// `dv`; the solution holds impulses.
    pub fn drive_reactions_over_step(&mut self, dv: &[f64], dt: f64) {
        if self.kinematic_paths.joints().is_empty() {
            return;
        }
        let nb = self.model.nb();
        self.ws.mass.multiply(dv, &mut self.scratch);
        if let Some(dampers) = self.dampers.matrix() {
            let of_robot = dv[..self.model.nv()].iter().enumerate();
            of_robot.for_each(|(k, dv)| dampers.add_column(k, *dv, &mut self.scratch));
        }
        let scratch = &mut self.scratch;
        self.drives.coupled_terms(&self.model, |a, b, x| scratch[nb + a] += x * dv[nb + b]);
        for &j in self.kinematic_paths.joints() {
            let k = nb + j;
            let contact = self.contact_load(&self.solution.wrench, k);
            // Passive efforts with the implicit terms of the step, as in `step_flows`.
            let implicit = self.implicit_passive[j] + self.implicit_external[k];
            let others = self.external[k] + self.passive[j] - implicit * dv[k] / dt + self.condition_load(k);
            self.drives.efforts[j] = (self.scratch[k] - contact) / dt + self.ws.bias[k] - others;
            self.drives.servo[j] = self.drives.efforts[j];
        }
    }

    /// Sets kinematic joints to their prescribed positions at the step's end, equal to the last
    /// bit.
    pub fn apply_prescribed_positions(&mut self) {
        for &j in self.kinematic_paths.joints() {
            self.state.joints[j] = self.kinematic_paths.at(j, self.state.time, self.within).q;
        }
    }

    /// Applies sole impulses (6F, floor axes) to the state's velocity.
    pub fn apply_impulses(&mut self, impulses: &[f64]) -> JumpWork {
        self.add_sole_impulses(impulses, 1.0);
        let before = self.kinetic_energy();
        let work_before = self.prescribed_momentum_work();
        self.add_impulses(impulses);
        let change = self.kinetic_energy() - before;
        let mut drives = self.prescribed_momentum_work() - work_before;
        for &k in &self.reduced.prescribed {
            drives -= self.state.v[k] * self.contact_load(impulses, k);
        }
        JumpWork { contact: change - drives, drives }
    }

    /// `sum v_k (M v)_k` over the prescribed velocities, after [`Plant::kinetic_energy`].
    fn prescribed_momentum_work(&self) -> f64 {
        self.reduced.prescribed.iter().map(|&k| self.state.v[k] * self.scratch[k]).sum()
    }

    /// Generalised force of couplings and loops in coordinate `k`.
    fn condition_load(&self, k: usize) -> f64 {
        if self.multipliers.is_empty() { 0.0 } else { self.ws.constraints.load(&self.multipliers, k) }
    }

    /// Generalised contact force in coordinate `k`.
    fn contact_load(&self, wrenches: &[f64], k: usize) -> f64 {
        reduced::load(&self.ws, &self.reduced, wrenches, k)
    }
}
