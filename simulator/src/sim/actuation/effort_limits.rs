//! Speed and effort limits of drives. No drive pushes a joint beyond its speed limit.
//!
//! ```text
//! tau = tau_cmd clamp((v_max - |qd|) / (b v_max), 0, 1)   where tau_cmd points along qd;   b = 1/10
//! ```
//!
//! Over the last tenth of the speed range the effort in the direction of motion falls to zero, as
//! along the speed-torque line of a motor or the flow limit of a valve. Braking keeps its full
//! effort, and other forces may push the joint faster. Desired velocities are not changed.
//!
//! A velocity-level step evaluates the line at the velocity of its end. When a joint enters the
//! band within the step, the step is set up again with the joint on the line from the start. The
//! same holds for a drive that reaches its effort limit within the step.
//!
//! Limits of motors that a transmission couples are those of `coupled_motors`.

use super::Drives;
use super::coupled_motors::limits_of_motors;
use crate::robot::Model;

/// Part of the greatest speed over which the effort falls.
pub const BAND: f64 = 0.1;

impl Drives {
    /// Reduces the efforts to what the joint velocities `qd` allow; with a step size also their
    /// slopes.
    pub(super) fn limit_speeds(&mut self, model: &Model, qd: &[f64], dt: Option<f64>) {
        for (j, joint) in model.joints.iter().enumerate() {
            let (qd, most) = (qd[j], joint.velocity_limit);
            let line = dt.is_some() && self.on_speed_line[j];
            if !(line || qd.abs() >= most * (1.0 - BAND)) || limits_of_motors(model, j)[1] {
                continue;
            }
            // Speed counts in the direction of the effort. At a limit of zero no drive acts.
            let share = |effort: f64| if most > 0.0 { (most - qd * effort.signum()) / (BAND * most) } else { 0.0 };
            self.efforts[j] *= share(self.efforts[j]).clamp(0.0, 1.0);
            let share = share(self.servo[j]);
            if line || share < 1.0 {
                let slope = if share > 0.0 { self.servo[j].abs() / (BAND * most) } else { 0.0 };
                self.servo[j] *= share.max(0.0);
                self.implicit[j] = self.implicit[j] * share.max(0.0) + dt.unwrap_or(0.0) * slope;
            }
        }
    }

    /// Marks the drives that a velocity-level step brings to their effort limit; they hold it over
    /// the whole step. `free` are the joint accelerations without contact. Returns whether there
    /// are any. A drive that is at its limit at the start of the step holds it without a mark.
    pub fn mark_saturated(&mut self, model: &Model, free: &[f64]) -> bool {
        let mut any = false;
        let mut lagging = self.lagging.iter().zip(&self.lag_input).peekable();
        for (j, joint) in model.joints.iter().enumerate() {
            // The limit applies to the input of a lagging actuator.
            let (effort, implicit) = match lagging.next_if(|(l, _)| **l == j) {
                Some((_, input)) => *input,
                None => (self.servo[j], self.implicit[j]),
            };
            let end = effort - implicit * free[j];
            let is_reached = end.abs() > joint.effort_limit && implicit > 0.0 && !self.on_speed_line[j];
            if is_reached && !limits_of_motors(model, j)[0] {
                self.saturated[j] = end.signum();
                any = true;
            }
        }
        self.mark_saturated_motors(model, free) | any
    }

    /// Marks the joints that a velocity-level step of size `dt` brings into the band of their speed
    /// limit. `free` are the joint accelerations without contact. Returns whether there are any.
    pub fn mark_entering_speed_band(&mut self, model: &Model, qd: &[f64], free: &[f64], dt: f64) -> bool {
        let mut any = false;
        for (j, joint) in model.joints.iter().enumerate() {
            let (along, border) = (self.servo[j].signum(), joint.velocity_limit * (1.0 - BAND));
            let begin = qd[j] * along;
            let end = begin + dt * free[j] * along;
            let is_entered = end > border && begin <= border && self.servo[j] != 0.0;
            if is_entered && !limits_of_motors(model, j)[1] {
                self.on_speed_line[j] = true;
                any = true;
            }
        }
        self.mark_motors_entering_speed_band(model, qd, free, dt) | any
    }
}
