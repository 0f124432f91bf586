//! Stiffness of motors that drive several joints, as part of the stiff part of a step.
//!
//! The torque of motor k depends on the states of all joints of its transmission, by its friction and, where a
//! limit acts on one of its motors, by the servos ([`crate::sim::actuation::coupled_motors`]):
//!
//! ```text
//! dm_k = -share_k sum_j (T^-1)_jk (kp_j dq_j + kd_j dv_j) - (slope_k + d_k) sum_j T_kj dv_j
//! A    = -sum_k r_k (dm_k by q and v)^T
//! ```
//!
//! r_k are the accelerations and powers that a unit torque of the motor causes, efforts T_kj of the joints, and d_k is
//! the slope of its friction. Where no limit acts, servos are those of `drive_stiffness.rs`.

use super::Plant;
use super::stiff_products::Evaluation;
use crate::integrate::StiffPart;
use crate::math;
use crate::sim::actuation::effort_slopes::DrivesAt;

/// Test torque of a response, relative to that of 1 rad/s^2 of the motor with one joint free.
const TEST: f64 = 1e-3;
/// Change of a speed in the difference quotient of friction.
const SPAN: f64 = 1e-6;

/// A motor whose torque depends on the state: its mechanism, the number of its transmission among those that
/// couple joints, and its own.
type StiffMotor = [usize; 3];

/// The motors of the stiff part.
#[derive(Clone, Debug, Default)]
pub(super) struct MotorStiffness {
    motors: Vec<StiffMotor>,
    present: Vec<StiffMotor>,
}

impl MotorStiffness {
    /// Most products, with all motors.
    pub fn most_products(&self, plant: &Plant) -> usize {
        (0..=plant.objects.list.len()).map(|m| motors_of(&plant.drives_at(m)).count()).sum()
    }

    /// Finds the motors. Returns whether others have become stiff.
    pub fn find(&mut self, plant: &Plant) -> bool {
        self.present.clear();
        for mechanism in 0..=plant.objects.list.len() {
            let drives = plant.drives_at(mechanism);
            let stiff = motors_of(&drives).filter(|(c, _)| drives.has_stiff_motors(*c));
            self.present.extend(stiff.map(|(c, k)| [mechanism, c, k]));
        }
        self.present != self.motors
    }

    /// Adds products with new responses for the motors found.
    pub fn renew(&mut self, plant: &mut Plant, before: &Evaluation, out: &mut StiffPart) {
        self.motors.clone_from(&self.present);
        for &motor in &self.motors {
            let Some((_, column)) = out.add() else { return };
            plant.respond_to_torque(motor, before, column);
            column.iter_mut().for_each(|x| *x = -*x);
        }
    }

    /// Writes the rows of the products from `product` on, at the plant's last evaluation. Returns the next product.
    pub fn write(&self, plant: &Plant, mut product: usize, out: &mut StiffPart) -> usize {
        for &[mechanism, c, k] in &self.motors {
            let at = plant.drives_at(mechanism);
            let motors = &at.drives.coupled[c];
            let of = &at.model.transmissions[motors.transmission];
            let (n, speed) = (of.number(), of.motor_speed(k, at.rates));
            let friction =
                of.friction.as_ref().map_or(0.0, |laws| (laws[k].effort(speed) - laws[k].effort(speed + SPAN)) / SPAN);
            let share = if motors.is_limited { motors.share[k] } else { 0.0 };
            let mut by_time = 0.0;
            let (row, column) = out.product(product);
            column[plant.layout.controlled()] = -speed;
            row.clear();
            for (j, id) in of.joints.iter().enumerate().filter(|(_, id)| plant.is_free(mechanism, id.0)) {
                let (q, v) = plant.layout.joint(mechanism, id.0);
                let [stiffness, damping] = at.gains(id.0).map(|gain| share * of.inverse[j * n + k] * gain);
                row.extend([(q, stiffness), (v, damping + (motors.slope[k] + friction) * of.ratio(k, j))]);
                let motion = plant.desired_motion(mechanism, id.0);
                by_time += motion.map_or(0.0, |motion| stiffness * motion.qd + damping * motion.qdd);
            }
            if by_time != 0.0 {
                out.add_by_time(product, -by_time);
            }
            product += 1;
        }
        product
    }
}

/// Number of the transmission and of the motor, for all motors that drive several joints.
fn motors_of<'a>(drives: &DrivesAt<'a>) -> impl Iterator<Item = (usize, usize)> + use<'a> {
    let model = drives.model;
    let of = drives.drives.coupled.iter().enumerate();
    of.flat_map(|(c, motors)| (0..model.transmissions[motors.transmission].number()).map(move |k| (c, k)))
}

impl Plant {
    /// Whether a joint has dynamics.
    fn is_free(&self, mechanism: usize, joint: usize) -> bool {
        mechanism != 0 || !self.kinematic_paths.joints().contains(&joint)
    }

    /// Change of accelerations and powers per unit torque of a motor, contact states held, from the evaluation
    /// `before`. Leaves the evaluation changed.
    fn respond_to_torque(&mut self, [m, c, k]: StiffMotor, before: &Evaluation, out: &mut [f64]) {
        let index = self.drives_at(m).drives.coupled[c].transmission;
        let model = if m == 0 { self.model.clone() } else { self.objects.list[m - 1].model.clone() };
        let of = &model.transmissions[index];
        let ws = self.objects.mechanisms(&self.ws).get(m);
        let nb = ws.nv() - model.nj();
        let mut torque = f64::INFINITY;
        for (j, id) in of.joints.iter().enumerate().filter(|(j, _)| of.ratio(k, *j) != 0.0) {
            torque = torque.min(TEST * ws.mass.get(nb + id.0, nb + id.0) / math::powi(of.ratio(k, j), 2));
        }
        // The joints are free or held as bits: the response changes the plant.
        let bit = |j: usize| 1_u64.checked_shl(j as u32).unwrap_or(0);
        let held = of.joints.iter().enumerate().filter(|(_, id)| !self.is_free(m, id.0));
        let held = held.fold(0, |bits, (j, _)| bits | bit(j));
        let efforts = of.joints.iter().enumerate().filter(|(j, _)| held & bit(*j) == 0);
        let efforts = efforts.map(|(j, id)| (nb + id.0, torque * of.ratio(k, j)));
        self.respond_to_efforts(m, efforts, before);
        before.write_change(self, torque, out);
        self.kinematic_paths.joints().iter().for_each(|j| self.layout.hold(*j, out));
    }
}
