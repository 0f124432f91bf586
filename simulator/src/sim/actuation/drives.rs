//! The drives of all joints: efforts at a state, or over a velocity-level step.

use super::coupled_motors::CoupledMotors;
use super::joint_efforts;
use crate::robot::Model;
use crate::task::Command;

/// Efforts of the drives at the last evaluation, by joint unless stated otherwise.
#[derive(Clone)]
pub struct Drives {
    /// Actuator efforts.
    pub efforts: Vec<f64>,
    /// Efforts as they enter the equations: in a velocity-level step referred to the velocity
    /// before the step.
    pub servo: Vec<f64>,
    /// Terms that a velocity-level step adds to the diagonal of M.
    pub implicit: Vec<f64>,
    /// Joints that a velocity-level step holds on the speed-torque line of their limit.
    pub(super) on_speed_line: Vec<bool>,
    /// Side of the effort limit, 1 or -1, which a drive reaches within the velocity-level step; 0:
    /// none.
    pub(super) saturated: Vec<f64>,
    /// Joints whose actuators lag.
    pub lagging: Vec<usize>,
    /// For each lagging actuator: effort and implicit term of its servo, before the lag.
    pub(super) lag_input: Vec<(f64, f64)>,
    /// Motors of transmissions that couple joints.
    pub coupled: Vec<CoupledMotors>,
}

impl Drives {
    /// Drives of a robot, without efforts yet.
    pub fn new(model: &Model) -> Self {
        let nj = model.nj();
        Drives {
            efforts: vec![0.0; nj],
            servo: vec![0.0; nj],
            implicit: vec![0.0; nj],
            on_speed_line: vec![false; nj],
            saturated: vec![0.0; nj],
            lagging: model.lagging().map(|j| j.0).collect(),
            lag_input: vec![(0.0, 0.0); model.lagging().count()],
            coupled: CoupledMotors::of(model),
        }
    }

    /// Begins a velocity-level step: no drive is saturated or on its speed limit yet.
    pub fn begin_step(&mut self) {
        self.on_speed_line.fill(false);
        self.saturated.fill(0.0);
        self.clear_motor_marks();
    }

    /// Evaluates all drives at joint positions `q`, velocities `qd` and actuator states `z`. With a
    /// step size the position servo is referred to the position that the present velocity leads to.
    pub fn evaluate(&mut self, model: &Model, q: &[f64], qd: &[f64], z: &[f64], command: &Command, dt: Option<f64>) {
        for (j, joint) in model.joints.iter().enumerate() {
            let (q, qd) = (q[j], qd[j]);
            let (effort, clipped) = match self.saturated[j] {
                _ if dt.is_none() => joint_efforts::servo(joint, j, q, qd, command),
                0.0 => joint_efforts::servo(joint, j, q, qd, command),
                side => (side * joint.effort_limit, true),
            };
            let (ahead, gain) = match dt {
                Some(dt) if !clipped => joint_efforts::implicit_servo(j, qd, command, dt),
                _ => (0.0, 0.0),
            };
            self.efforts[j] = effort;
            self.servo[j] = effort + ahead;
            self.implicit[j] = gain;
        }
        self.limit_torques(model, q, qd, command, dt);
        self.apply_lag(model, z, dt);
        self.limit_speeds(model, qd, dt);
        self.limit_motor_speeds(model, qd, command, dt);
    }

    /// Sets `efforts` to their mean over a velocity-level step of size `dt` that changed the joint
    /// velocities by `dv`.
    pub fn average_over_step(&mut self, model: &Model, dv: &[f64], dt: f64) {
        for (j, effort) in self.efforts.iter_mut().enumerate() {
            *effort = self.servo[j] - self.implicit[j] * dv[j] / dt;
        }
        self.subtract_coupled_terms(model, dv, dt);
    }
}
