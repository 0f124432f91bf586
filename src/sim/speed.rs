//! Speed limits: no drive pushes a joint beyond its speed.
//!
//! ```text
//! tau = tau_asked (v_max - |qd|) / (b v_max)   where that is less and tau_asked points along qd, but not below 0;   b = 1/10
//! ```
//!
//! over the last tenth of the speed range the effort in the direction of motion falls to nothing, as along the
//! speed-torque line of a motor or the flow limit of a valve. Braking keeps its full effort, and what else acts on the joint
//! may push it faster. Desired velocities stay as they are.
//!
//! A velocity-level step takes the line at the velocity of its end. A joint that is about to come into the band within the
//! step is on the line from the start: the step is posed once more for it. So it is for a drive that is about to reach its
//! effort limit.

use super::plant::Plant;

/// Part of the greatest speed over which the effort falls.
pub const BAND: f64 = 0.1;

impl Plant {
    /// Takes from the drives' efforts what their speeds do not allow; for a velocity-level step of size `dt` with the slope.
    pub(super) fn limit_speeds(&mut self, dt: Option<f64>) {
        let nb = self.model.nb();
        for (j, joint) in self.model.joints.iter().enumerate() {
            let (qd, most) = (self.state.v[nb + j], joint.velocity_limit);
            let line = dt.is_some() && self.on_line[j];
            if !(line || qd.abs() >= most * (1.0 - BAND)) {
                continue;
            }
            // Along the effort's own direction. At a limit of zero no drive acts.
            let share = |effort: f64| if most > 0.0 { (most - qd * effort.signum()) / (BAND * most) } else { 0.0 };
            self.efforts[j] *= share(self.efforts[j]).clamp(0.0, 1.0);
            let share = share(self.servo[j]);
            if line || share < 1.0 {
                let slope = if share > 0.0 { self.servo[j].abs() / (BAND * most) } else { 0.0 };
                self.servo[j] *= share.max(0.0);
                self.drive_give[j] = self.drive_give[j] * share.max(0.0) + dt.unwrap_or(0.0) * slope;
            }
        }
    }

    /// Marks drives that a velocity-level step, posed without contact, brings to their effort limit, which they then hold
    /// all along; are there any? One that is at its limit when the step begins holds it anyway.
    pub(super) fn saturate(&mut self) -> bool {
        let nb = self.model.nb();
        let mut any = false;
        let mut lagging = self.lagging.iter().zip(&self.asked).peekable();
        for (j, joint) in self.model.joints.iter().enumerate() {
            // Of one that lags, what is asked has the limit.
            let (effort, give) = match lagging.next_if(|(l, _)| **l == j) {
                Some((_, asked)) => *asked,
                None => (self.servo[j], self.drive_give[j]),
            };
            let end = effort - give * self.reduced.free[nb + j];
            if end.abs() > joint.effort_limit && give > 0.0 && !self.on_line[j] {
                self.saturated[j] = end.signum();
                any = true;
            }
        }
        any
    }

    /// Efforts of the drives over a velocity-level step of size `dt` that changed the velocity by `dv`: their mean.
    pub(super) fn drive_over(&mut self, dv: &[f64], dt: f64) {
        let nb = self.model.nb();
        for (j, effort) in self.efforts.iter_mut().enumerate() {
            *effort = self.servo[j] - self.drive_give[j] * dv[nb + j] / dt;
        }
    }

    /// Marks joints that a velocity-level step of size `dt`, posed without contact, brings into the band; are there any?
    pub(super) fn enter_band(&mut self, dt: f64) -> bool {
        let nb = self.model.nb();
        let mut any = false;
        for (j, joint) in self.model.joints.iter().enumerate() {
            let (along, border) = (self.servo[j].signum(), joint.velocity_limit * (1.0 - BAND));
            let begin = self.state.v[nb + j] * along;
            let end = begin + dt * self.reduced.free[nb + j] * along;
            if end > border && begin <= border && self.servo[j] != 0.0 {
                self.on_line[j] = true;
                any = true;
            }
        }
        any
    }
}
