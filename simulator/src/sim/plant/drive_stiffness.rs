//! Stiffness of drives, joint friction and stops, as the stiff part of a step.
//!
//! The effort of joint j depends on its own position and velocity, and of a lagging actuator on the effort z
//! that follows the servo's u ([`crate::sim::actuation::lag`]):
//!
//! ```text
//! dtau_j = -(k dq_j + d dv_j) + dz        T dz' = -(k_u dq_j + d_u dv_j) - dz
//! A = -sum_j r_j (k e_q + d e_v - e_z)^T  - sum_j e_z (k_u e_q + d_u e_v + e_z)^T / T  + N
//! ```
//!
//! k and d are the slopes of servo, friction and stop, r_j the accelerations and powers that a unit effort of the
//! joint causes with the contact states held, `M^-1 e_j` less what the contacts react; N has the rates of joint
//! positions. Slopes are difference quotients at each step. Responses change slowly with the configuration and are
//! kept for some steps: W-methods need no exact derivative.

use super::Plant;
use super::stiff_products::Evaluation;
use crate::dynamics::reduced;
use crate::integrate::StiffPart;
use crate::robot::Model;
use crate::sim::actuation::effort_slopes::{DrivesAt, Slopes};
use crate::sim::actuation::kinematic_paths::JointMotion;

/// Test effort of a response, relative to that of 1 rad/s^2 or 1 m/s^2 of its joint alone.
const TEST: f64 = 1e-3;

/// A joint whose effort depends on its state.
#[derive(Clone, Copy, PartialEq, Debug)]
struct StiffJoint {
    mechanism: usize,
    joint: usize,
    /// Its lagging actuator, and the time constant, s.
    lag: Option<(usize, f64)>,
}

/// The joints of the stiff part.
#[derive(Clone, Debug, Default)]
pub(super) struct DriveStiffness {
    joints: Vec<StiffJoint>,
    present: Vec<StiffJoint>,
    slopes: Vec<[Slopes; 2]>,
}

impl DriveStiffness {
    /// Most products, with all joints.
    pub fn most_products(&self, plant: &Plant) -> usize {
        let of = |model: &Model| model.nj() + model.lagging().count();
        of(&plant.model) + plant.objects.list.iter().map(|object| of(&object.model)).sum::<usize>()
    }

    /// Writes the rows of the products from `product` on, at the plant's last evaluation. Returns the next product.
    pub fn write(&self, plant: &Plant, mut product: usize, out: &mut StiffPart) -> usize {
        for (at, [servo, passive]) in self.joints.iter().zip(&self.slopes) {
            let (q, v) = plant.layout.joint(at.mechanism, at.joint);
            let rate = plant.drives_at(at.mechanism).rates[at.joint];
            let (row, column) = out.product(product);
            let [k, d] = if at.lag.is_some() { *passive } else { std::array::from_fn(|i| servo[i] + passive[i]) };
            row.clear();
            row.extend([(q, k), (v, d)]);
            column[plant.layout.controlled()] = -rate;
            // Of the servo with its command along its path.
            let motion = plant.desired_motion(at.mechanism, at.joint);
            let by_time = motion.map_or(0.0, |motion| servo[0] * motion.qd + servo[1] * motion.qdd);
            if let Some((actuator, constant)) = at.lag {
                let z = plant.layout.actuator(at.mechanism, actuator);
                row.push((z, -1.0));
                product += 1;
                let row = out.product(product).0;
                row.clear();
                row.extend([(q, servo[0] / constant), (v, servo[1] / constant), (z, 1.0 / constant)]);
            }
            if by_time != 0.0 {
                out.add_by_time(product, -at.lag.map_or(by_time, |(_, constant)| by_time / constant));
            }
            product += 1;
        }
        product
    }

    /// Products of the flows of energy: the power of an effort depends on the velocity of its joint.
    pub fn add_powers(&self, plant: &Plant, out: &mut StiffPart) {
        let flows = plant.layout.controlled();
        for (flow, sign) in [(0, 1.0), (2, -1.0)] {
            let Some((row, column)) = out.add() else { return };
            column[flows + flow] = sign;
            for at in &self.joints {
                let drives = plant.drives_at(at.mechanism);
                let efforts = if flow == 0 { &drives.drives.efforts } else { drives.passive };
                row.push((plant.layout.joint(at.mechanism, at.joint).1, efforts[at.joint]));
            }
        }
    }

    /// Finds the stiff joints and their slopes. Returns whether other joints have become stiff.
    pub fn find(&mut self, plant: &Plant) -> bool {
        self.present.clear();
        self.slopes.clear();
        for mechanism in 0..=plant.objects.list.len() {
            let drives = plant.drives_at(mechanism);
            for joint in 0..drives.model.nj() {
                if mechanism == 0 && plant.kinematic_paths.joints().contains(&joint) {
                    continue;
                }
                let slopes = drives.slopes(joint);
                let actuator = drives.drives.lagging.iter().position(|j| *j == joint);
                let lag = actuator.map(|i| (i, drives.model.joints[joint].lag));
                let has_slopes = slopes.as_flattened().iter().any(|x| *x != 0.0);
                if lag.is_some() || has_slopes || drives.has_stiff_motor(joint) {
                    self.present.push(StiffJoint { mechanism, joint, lag });
                    self.slopes.push(slopes);
                }
            }
        }
        self.present != self.joints
    }

    /// Adds products with new responses for the joints found, and the rates of their positions.
    pub fn renew(&mut self, plant: &mut Plant, before: &Evaluation, out: &mut StiffPart) {
        self.joints.clone_from(&self.present);
        for at in &self.joints {
            let (q, v) = plant.layout.joint(at.mechanism, at.joint);
            out.rates.push((q, v, 1.0));
            let Some((_, column)) = out.add() else { break };
            plant.respond_to_effort(at.mechanism, at.joint, before, column);
            column.iter_mut().for_each(|x| *x = -*x);
            let Some((actuator, _)) = at.lag else { continue };
            let z = plant.layout.actuator(at.mechanism, actuator);
            let Some((_, column)) = out.add() else { break };
            column[z] = -1.0;
        }
    }
}

impl Plant {
    pub(super) fn drives_at(&self, mechanism: usize) -> DrivesAt<'_> {
        match mechanism {
            0 => DrivesAt {
                model: &self.model,
                drives: &self.drives,
                passive: &self.passive,
                stops: self.stops.as_deref(),
                joints: &self.state.joints,
                rates: &self.state.v[self.model.nb()..],
                command: self.followed_command(),
            },
            _ => self.objects.list[mechanism - 1].drives_at(),
        }
    }

    /// The motion that a joint's command follows, if it is interpolated.
    pub(super) fn desired_motion(&self, mechanism: usize, joint: usize) -> Option<JointMotion> {
        let is_tracked = mechanism == 0 && self.kinematic_paths.tracked().contains(&joint);
        is_tracked.then(|| self.kinematic_paths.at(joint, self.state.time, self.within))
    }

    /// Change of accelerations and powers per unit effort of a joint, contact states held, from the evaluation
    /// `before`. Leaves the evaluation changed.
    pub(super) fn respond_to_effort(&mut self, m: usize, joint: usize, before: &Evaluation, out: &mut [f64]) {
        let ws = self.objects.mechanisms(&self.ws).get(m);
        let k = ws.nv() - self.drives_at(m).model.nj() + joint;
        let effort = TEST * ws.mass.get(k, k);
        self.respond_to_efforts(m, std::iter::once((k, effort)), before);
        before.write_change(self, effort, out);
    }

    /// Evaluates with additional efforts on velocities of mechanism `m`, contact states held, and `before` without.
    pub(super) fn respond_to_efforts(
        &mut self,
        m: usize,
        efforts: impl Iterator<Item = (usize, f64)>,
        before: &Evaluation,
    ) {
        self.problem.b.copy_from_slice(&before.motions);
        let mechanisms = self.objects.mechanisms(&self.ws);
        reduced::free(mechanisms, &self.reduced, &mut self.acceleration);
        let motions = (&mut self.acceleration[..], &mut self.problem.b[..]);
        reduced::add_efforts(mechanisms, &mut self.reduced, m, efforts, motions);
        self.method.respond(&self.problem, &self.states, &mut self.solution);
        reduced::apply(mechanisms, &mut self.reduced, &self.solution.wrench, &mut self.scratch);
        self.acceleration.iter_mut().zip(&self.scratch).for_each(|(a, x)| *a += x);
    }
}
