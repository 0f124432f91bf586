//! Motors of transmissions that couple joints: limits and friction act on the motors.
//!
//! ```text
//! m     = clamp(T^-T u, -m_max, m_max)     u: efforts that the servos desire
//! tau   = T^T m                            where no motor is limited, tau = u
//! tau_f = T^T f(theta')                    f: friction of the motors, theta' = T q'
//! ```
//!
//! The speed limit of a motor reduces m along its speed-torque line as that of a joint
//! ([`super::effort_limits`]): `m share(theta')`.
//!
//! In a velocity-level step the efforts of servos fall by G dq', G = diag(dt kd + dt^2 kp), and the
//! torques of motors by `T^-T G T^-1 dtheta'`. Where motors are limited and for friction, M gets the symmetric
//! terms
//!
//! ```text
//! C = T^T [D T^-T G T^-1 D + dt diag(slope)] T     C_f = T^T dt diag(secant) T
//! ```
//!
//! D_k is 0 for a motor at its torque limit, sqrt(share) on its speed-torque line, else 1: the torque of a
//! motor that is not limited falls with its own change of speed, while the part due to limited ones is that before
//! the step, an error of first order in dt like that of the step.
//!
//! Commanded kinematic joints have no limits, nor have the motors of their transmission.

use super::effort_limits::BAND;
use super::{Drives, joint_efforts};
use crate::robot::{DriveMode, JointId, Model, Transmission};
use crate::task::Command;

/// The motors of one transmission at the last evaluation. Matrices are n x n, by rows.
#[derive(Clone, Debug)]
pub struct CoupledMotors {
    /// The transmission's index in the model.
    pub transmission: usize,
    /// Whether a limit acts on a motor.
    pub is_limited: bool,
    /// Factor of each motor's torque by its limits: 0 at its torque limit.
    pub share: Vec<f64>,
    /// Decrease of each motor's torque per speed, along its speed-torque line.
    pub slope: Vec<f64>,
    /// Side of the torque limit, 1 or -1, that a motor reaches within the velocity-level step; 0: none.
    saturated: Vec<f64>,
    /// Motors that a velocity-level step holds on their speed-torque line.
    on_speed_line: Vec<bool>,
    /// C of the servos, before lag.
    pub(super) input: Vec<f64>,
    /// C of the servos.
    servo: Vec<f64>,
    /// C of friction.
    passive: Vec<f64>,
    /// Scratch: of motors, of joints, and matrices.
    torque: Vec<f64>,
    effort: Vec<f64>,
    gain: Vec<f64>,
    product: Vec<f64>,
}

impl CoupledMotors {
    /// The motors of all transmissions that couple joints.
    pub(super) fn of(model: &Model) -> Vec<Self> {
        let coupled = model.transmissions.iter().enumerate().filter(|(_, of)| of.is_coupled());
        coupled.map(|(i, of)| CoupledMotors::new(i, of.number())).collect()
    }

    fn new(transmission: usize, n: usize) -> Self {
        let (list, matrix) = (vec![0.0; n], vec![0.0; n * n]);
        CoupledMotors {
            transmission,
            is_limited: false,
            share: vec![1.0; n],
            slope: list.clone(),
            saturated: list.clone(),
            on_speed_line: vec![false; n],
            input: matrix.clone(),
            servo: matrix.clone(),
            passive: matrix.clone(),
            torque: list.clone(),
            effort: list,
            gain: matrix.clone(),
            product: matrix,
        }
    }

    fn begin_evaluation(&mut self) {
        self.is_limited = false;
        self.share.fill(1.0);
        self.slope.fill(0.0);
        self.input.fill(0.0);
        self.servo.fill(0.0);
    }

    /// Sets `gain` to `T^-T C T^-1` of the matrix in `product`.
    fn gain_of_motors(&mut self, of: &Transmission) {
        let n = of.number();
        for k in 0..n {
            for l in 0..n {
                let mut sum = 0.0;
                for i in 0..n {
                    for j in 0..n {
                        sum += of.inverse[i * n + k] * self.product[i * n + j] * of.inverse[j * n + l];
                    }
                }
                self.gain[k * n + l] = sum;
            }
        }
    }

    /// Sets `product` to `T^T K T` of the matrix K in `gain`.
    fn gain_of_joints(&mut self, of: &Transmission) {
        let n = of.number();
        for i in 0..n {
            for j in 0..=i {
                let mut sum = 0.0;
                for k in 0..n {
                    for l in 0..n {
                        sum += of.ratio(k, i) * self.gain[k * n + l] * of.ratio(l, j);
                    }
                }
                (self.product[i * n + j], self.product[j * n + i]) = (sum, sum);
            }
        }
    }

    /// `(C dv)_i` of the transmission's joint `i`, C one of its matrices.
    fn change(of: &Transmission, matrix: &[f64], i: usize, dv: &[f64]) -> f64 {
        let n = of.number();
        of.joints.iter().enumerate().map(|(j, id)| matrix[i * n + j] * dv[id.0]).sum()
    }
}

/// True where limits act on the motors of a transmission: no joint is kinematic.
fn has_servos(of: &Transmission, command: &Command) -> bool {
    of.joints.iter().all(|id| command.mode[id.0] != DriveMode::Kinematic)
}

/// Effort of the transmission's joint `i` within the torque limits of the motors. `desired` are the efforts of the
/// servos by joint of the model.
fn within_torques(of: &Transmission, i: usize, command: &Command, desired: impl Fn(usize) -> f64) -> f64 {
    let n = of.number();
    let own = desired(of.joints[i].0);
    let Some(most) = of.effort_limit.as_ref().filter(|_| has_servos(of, command)) else { return own };
    let (mut effort, mut is_limited) = (0.0, false);
    for (k, most) in most.iter().enumerate() {
        let torque: f64 = (0..n).map(|j| of.inverse[j * n + k] * desired(of.joints[j].0)).sum();
        let clamped = torque.clamp(-most, *most);
        is_limited |= clamped != torque;
        effort += of.ratio(k, i) * clamped;
    }
    if is_limited { effort } else { own }
}

impl Drives {
    /// Effort of a servo within its torque or effort limits, at positions and velocities by joint.
    pub fn servo_at(&self, model: &Model, j: usize, command: &Command, at: impl Fn(usize) -> (f64, f64)) -> f64 {
        for motors in &self.coupled {
            let of = &model.transmissions[motors.transmission];
            let i = of.joints.iter().position(|id| id.0 == j).filter(|_| of.effort_limit.is_some());
            let Some(i) = i else { continue };
            return within_torques(of, i, command, |l| {
                let (q, qd) = at(l);
                joint_efforts::desired_effort(l, q, qd, command)
            });
        }
        let (q, qd) = at(j);
        joint_efforts::servo(&model.joints[j], j, q, qd, command).0
    }

    /// Reduces the efforts to what the motors' torques allow; with a step size also the implicit terms.
    pub(super) fn limit_torques(&mut self, model: &Model, q: &[f64], qd: &[f64], command: &Command, dt: Option<f64>) {
        for motors in &mut self.coupled {
            motors.begin_evaluation();
            let of = &model.transmissions[motors.transmission];
            let Some(most) = of.effort_limit.as_ref().filter(|_| has_servos(of, command)) else { continue };
            let n = of.number();
            motors.product.fill(0.0);
            for (j, id) in of.joints.iter().enumerate() {
                let id = id.0;
                // The limits of joints do not act.
                let desired = joint_efforts::desired_effort(id, q[id], qd[id], command);
                let (ahead, gain) = dt.map_or((0.0, 0.0), |dt| joint_efforts::implicit_servo(id, qd[id], command, dt));
                (motors.effort[j], motors.product[j * n + j]) = (desired, gain);
                (self.efforts[id], self.servo[id], self.implicit[id]) = (desired, desired + ahead, gain);
            }
            for (k, most) in most.iter().enumerate() {
                let torque = of.motor_torque(k, &self.efforts);
                let within = torque.clamp(-most, *most);
                let side = if dt.is_some() { motors.saturated[k] } else { 0.0 };
                motors.torque[k] = if side == 0.0 { within } else { side * most };
                if within != torque || side != 0.0 {
                    (motors.share[k], motors.is_limited) = (0.0, true);
                }
            }
            if !motors.is_limited {
                continue;
            }
            for (j, id) in of.joints.iter().enumerate() {
                self.efforts[id.0] = of.joint_effort(j, &motors.torque);
            }
            for k in (0..n).filter(|k| dt.is_some() && motors.share[*k] > 0.0) {
                motors.torque[k] = of.motor_torque(k, &self.servo);
            }
            for (j, id) in of.joints.iter().enumerate() {
                motors.effort[j] = of.joint_effort(j, &motors.torque);
                self.implicit[id.0] = 0.0;
            }
            of.joints.iter().zip(&motors.effort).for_each(|(id, effort)| self.servo[id.0] = *effort);
            if dt.is_some() {
                motors.gain_of_motors(of);
                motors.scale_gain(n);
                motors.gain_of_joints(of);
                motors.input.copy_from_slice(&motors.product);
                motors.servo.copy_from_slice(&motors.product);
            }
        }
    }

    /// Applies the mean of a lag over a step to the matrices of servos.
    pub(super) fn lag_matrices(&mut self, model: &Model, mean: impl Fn(usize) -> f64) {
        for motors in self.coupled.iter_mut().filter(|motors| motors.is_limited) {
            let of = &model.transmissions[motors.transmission];
            let n = of.number();
            for (e, (servo, input)) in motors.servo.iter_mut().zip(&motors.input).enumerate() {
                // Symmetric also where the lags differ.
                let [a, b] = [e / n, e % n].map(|j| mean(of.joints[j].0));
                *servo = input * if a == b { a } else { (a * b).sqrt() };
            }
        }
    }

    /// Reduces the efforts to what the speeds of motors allow; with a step size also the implicit terms.
    pub(super) fn limit_motor_speeds(&mut self, model: &Model, qd: &[f64], command: &Command, dt: Option<f64>) {
        for motors in &mut self.coupled {
            let of = &model.transmissions[motors.transmission];
            let Some(most) = of.velocity_limit.as_ref().filter(|_| has_servos(of, command)) else { continue };
            let n = of.number();
            let is_line = |motors: &CoupledMotors, k: usize| dt.is_some() && motors.on_speed_line[k];
            let in_band = |k: usize| is_line(motors, k) || of.motor_speed(k, qd).abs() >= most[k] * (1.0 - BAND);
            if !(0..n).any(in_band) {
                continue;
            }
            let share = |k: usize, torque: f64| match most[k] {
                most if most > 0.0 => (most - of.motor_speed(k, qd) * torque.signum()) / (BAND * most),
                _ => 0.0,
            };
            // The efforts of this instant.
            let mut is_reduced = false;
            for k in 0..n {
                let torque = of.motor_torque(k, &self.efforts);
                let factor = share(k, torque).clamp(0.0, 1.0);
                is_reduced |= factor < 1.0;
                motors.torque[k] = torque * factor;
            }
            if is_reduced {
                for (j, id) in of.joints.iter().enumerate() {
                    self.efforts[id.0] = of.joint_effort(j, &motors.torque);
                }
            }
            // Those of the equations.
            is_reduced = false;
            motors.gain.fill(0.0);
            for (k, limit) in most.iter().enumerate() {
                let torque = of.motor_torque(k, &self.servo);
                let factor = share(k, torque);
                motors.torque[k] = torque;
                if is_line(motors, k) || factor < 1.0 {
                    is_reduced = true;
                    motors.slope[k] = if factor > 0.0 { torque.abs() / (BAND * limit) } else { 0.0 };
                    motors.torque[k] *= factor.max(0.0);
                    motors.share[k] *= factor.max(0.0);
                }
            }
            if !is_reduced {
                continue;
            }
            motors.product.copy_from_slice(&motors.servo);
            motors.is_limited = true;
            for (j, id) in of.joints.iter().enumerate() {
                self.servo[id.0] = of.joint_effort(j, &motors.torque);
                motors.product[j * n + j] += self.implicit[id.0];
                self.implicit[id.0] = 0.0;
            }
            if let Some(dt) = dt {
                motors.gain_of_motors(of);
                motors.scale_gain(n);
                for k in 0..n {
                    motors.gain[k * n + k] += dt * motors.slope[k];
                }
                motors.gain_of_joints(of);
                motors.servo.copy_from_slice(&motors.product);
            }
        }
    }

    /// Adds the friction of motors to the efforts `tau` of joints with the velocities `qd`; with a step size also
    /// its implicit terms.
    pub fn add_motor_friction(&mut self, model: &Model, qd: &[f64], dt: Option<f64>, tau: &mut [f64]) {
        for motors in &mut self.coupled {
            let of = &model.transmissions[motors.transmission];
            let Some(laws) = &of.friction else { continue };
            motors.gain.fill(0.0);
            for (k, law) in laws.iter().enumerate() {
                let speed = of.motor_speed(k, qd);
                motors.torque[k] = law.effort(speed);
                motors.gain[k * laws.len() + k] = dt.map_or(0.0, |dt| dt * law.secant(speed));
            }
            for (j, id) in of.joints.iter().enumerate() {
                tau[id.0] += of.joint_effort(j, &motors.torque);
            }
            motors.gain_of_joints(of);
            motors.passive.copy_from_slice(&motors.product);
        }
    }

    /// Whether M has terms of coupled motors in this evaluation.
    pub fn has_coupled_terms(&self) -> bool {
        self.coupled.iter().any(|motors| motors.servo.iter().chain(&motors.passive).any(|x| *x != 0.0))
    }

    /// Calls `add` with each entry of C + C_f: its joints and value.
    pub fn coupled_terms(&self, model: &Model, mut add: impl FnMut(usize, usize, f64)) {
        for motors in &self.coupled {
            let joints = &model.transmissions[motors.transmission].joints;
            for (e, (servo, passive)) in motors.servo.iter().zip(&motors.passive).enumerate() {
                add(joints[e / joints.len()].0, joints[e % joints.len()].0, servo + passive);
            }
        }
    }

    /// Work of C and of C_f over a velocity-level step that changed the joint velocities by `dv` to `qd`.
    pub fn coupled_work(&self, model: &Model, qd: &[f64], dv: &[f64]) -> [f64; 2] {
        let mut work = [0.0; 2];
        for motors in &self.coupled {
            let of = &model.transmissions[motors.transmission];
            for (i, id) in of.joints.iter().enumerate() {
                let mean = qd[id.0] - 0.5 * dv[id.0];
                for (work, matrix) in work.iter_mut().zip([&motors.servo, &motors.passive]) {
                    *work += mean * CoupledMotors::change(of, matrix, i, dv);
                }
            }
        }
        work
    }

    /// Subtracts `C dv / dt` from the efforts of a step.
    pub(super) fn subtract_coupled_terms(&mut self, model: &Model, dv: &[f64], dt: f64) {
        for motors in &self.coupled {
            let of = &model.transmissions[motors.transmission];
            for (i, id) in of.joints.iter().enumerate() {
                self.efforts[id.0] -= CoupledMotors::change(of, &motors.servo, i, dv) / dt;
            }
        }
    }

    /// `(C x)_j` of joint `j` of the model, with C of the servos before lag.
    pub(super) fn coupled_input(&self, model: &Model, j: usize, x: &[f64]) -> f64 {
        let mut sum = 0.0;
        for motors in &self.coupled {
            let of = &model.transmissions[motors.transmission];
            if let Some(i) = of.joints.iter().position(|id| id.0 == j) {
                sum += CoupledMotors::change(of, &motors.input, i, x);
            }
        }
        sum
    }

    /// Marks the motors that a velocity-level step brings to their torque limit, as
    /// [`mark_saturated`](Self::mark_saturated) marks joints.
    pub(super) fn mark_saturated_motors(&mut self, model: &Model, free: &[f64]) -> bool {
        let mut any = false;
        for m in 0..self.coupled.len() {
            let of = &model.transmissions[self.coupled[m].transmission];
            let Some(most) = &of.effort_limit else { continue };
            let n = of.number();
            self.coupled[m].product.fill(0.0);
            for (j, id) in of.joints.iter().enumerate() {
                let id = id.0;
                // The limit applies to the input of a lagging actuator.
                let (effort, implicit) = match self.lagging.iter().position(|l| *l == id) {
                    Some(lagging) => self.lag_input[lagging],
                    None => (self.servo[id], self.implicit[id]),
                };
                let end = effort - implicit * free[id] - self.coupled_input(model, id, free);
                let motors = &mut self.coupled[m];
                motors.effort[j] = end;
                motors.product[j * n + j] = implicit;
            }
            let motors = &mut self.coupled[m];
            motors.product.iter_mut().zip(&motors.input).for_each(|(sum, x)| *sum += x);
            motors.gain_of_motors(of);
            for (k, most) in most.iter().enumerate() {
                let torque: f64 = (0..n).map(|j| of.inverse[j * n + k] * motors.effort[j]).sum();
                let may_change = motors.share[k] > 0.0 && motors.gain[k * n + k] > 0.0;
                if torque.abs() > *most && may_change && !motors.on_speed_line[k] {
                    motors.saturated[k] = torque.signum();
                    any = true;
                }
            }
        }
        any
    }

    /// Marks the motors that a velocity-level step brings into the band of their speed limit, as
    /// [`mark_entering_speed_band`](Self::mark_entering_speed_band) marks joints.
    pub(super) fn mark_motors_entering_speed_band(&mut self, model: &Model, qd: &[f64], free: &[f64], dt: f64) -> bool {
        let mut any = false;
        for motors in &mut self.coupled {
            let of = &model.transmissions[motors.transmission];
            for (k, most) in of.velocity_limit.iter().flatten().enumerate() {
                let torque = of.motor_torque(k, &self.servo);
                let (along, border) = (torque.signum(), most * (1.0 - BAND));
                let begin = of.motor_speed(k, qd) * along;
                let end = begin + dt * of.motor_speed(k, free) * along;
                if end > border && begin <= border && torque != 0.0 {
                    motors.on_speed_line[k] = true;
                    any = true;
                }
            }
        }
        any
    }

    /// Begins a velocity-level step: no motor is marked.
    pub(super) fn clear_motor_marks(&mut self) {
        for motors in &mut self.coupled {
            motors.saturated.fill(0.0);
            motors.on_speed_line.fill(false);
        }
    }
}

impl CoupledMotors {
    /// Multiplies `gain` by D from both sides.
    fn scale_gain(&mut self, n: usize) {
        for (e, gain) in self.gain.iter_mut().enumerate() {
            let [a, b] = [e / n, e % n].map(|k| self.share[k]);
            *gain *= if a == b { a } else { (a * b).sqrt() };
        }
    }
}

/// True if the motors of a transmission, not the joint itself, have the limit of efforts (first) or speeds.
pub(super) fn limits_of_motors(model: &Model, j: usize) -> [bool; 2] {
    let of = model.coupled_transmission_of(JointId(j));
    [of.is_some_and(|of| of.effort_limit.is_some()), of.is_some_and(|of| of.velocity_limit.is_some())]
}
